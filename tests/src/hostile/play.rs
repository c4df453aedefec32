//! Playing one session.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use fastrand::Rng;
use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::operator::Operator;
use keepout_executor::session::log::{Header, LogError, LogWriter};
use keepout_executor::session::outcome::JobOutcome;
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::session::{Clock, EventLog, Going, NoEventLog, Sample, SessionSetup};
use keepout_executor::supervisor::{Abilities, Counts, Options, Supervisor};
use keepout_guard::Time;
use keepout_kernel::{Curve, Height, Segment, Vector};
use keepout_planner::job::{ContourJob, Progress};
use keepout_planner::machine::MachineProfile;
use keepout_planner::units::{mm, point_mm};
use keepout_planner::{Mm2, Mm3};
use keepout_sim::faults::Faults;
use keepout_sim::monitor::{CollisionMonitor, JoggingRule, Verdict};
use keepout_sim::{
    Disturbance, DocumentedGrbl, PositioningError, ServoDrive, SimMachine, SimSettings, SimulatedController,
    speaking,
};

use super::operator::Hostile;
use super::screens::HostileScreens;
use super::spec::{HostileFault, Spec};
use super::world::HostileWorld;

/// What came of a session.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What the judge found.
    pub verdict: Option<Verdict>,
    /// How it ended; `None` when the program itself failed.
    pub ended: Option<JobOutcome>,
    /// The last fault.
    pub fault: Option<String>,
    /// Simulated time, s.
    pub seconds: f64,
    /// The supervisor's counters.
    pub counts: Counts,
    /// Loops contoured.
    pub contoured: usize,
    /// Way of the tool, mm.
    pub way_mm: f64,
    /// Faults of the line that happened.
    pub faults: u64,
    /// Wishes that were given, replies that were heard, ticks: decisions that were taken.
    pub rounds: u64,
    /// How often the operator began anew after a fault.
    pub recoveries: u64,
}

/// The cable's end at the computer, whose clock can be ahead of the machine's.
#[derive(Clone)]
struct Cable {
    machine: Rc<RefCell<SimMachine>>,
    ahead: Rc<Cell<Duration>>,
}

impl Cable {
    fn machine_time(&self, now: Time) -> Time {
        Time::ZERO.after(now.since(Time::ZERO.after(self.ahead.get())))
    }
}

impl Port for Cable {
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError> {
        let now = self.machine_time(now);
        let mut machine = self.machine.borrow_mut();
        if !machine.is_connected() {
            return Err(unplugged());
        }
        machine.host_writes(bytes, now);
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        let now = self.machine_time(now);
        let mut machine = self.machine.borrow_mut();
        machine.advance(now);
        machine.host_reads(into, now);
        if machine.is_connected() { Ok(()) } else { Err(unplugged()) }
    }

    fn next_event(&self) -> Time {
        self.machine.borrow().next_event().after(self.ahead.get())
    }
}

fn unplugged() -> PortError {
    PortError::Lost { name: "simulated".into(), reason: "unplugged".into() }
}

/// A clock that can stand still for the program while the machine goes on, or be ahead of it.
#[derive(Debug, Default)]
struct HostClock {
    now: Time,
    /// When the program stands still or the clock jumps, and how far; latest first.
    breaks: Vec<(Time, Duration)>,
    /// The clock jumps: the machine's does not.
    jumps: bool,
    ahead: Rc<Cell<Duration>>,
}

impl Clock for HostClock {
    fn now(&mut self) -> Time {
        self.now
    }

    fn wait(&mut self, until: Time) {
        self.now = until.max(self.now.after(Duration::from_micros(1)));
        if let Some((_, span)) = self.breaks.pop_if(|(at, _)| *at <= self.now) {
            self.now = self.now.after(span);
            if self.jumps {
                self.ahead.set(self.ahead.get() + span);
            }
        }
    }

    fn is_real(&self) -> bool {
        false
    }
}

/// What happens to the machine, latest first.
enum Happening {
    Reset,
    BrownOut,
    Alarm,
    Unplug,
    Plug,
    Mistune(bool),
}

/// Plays the session in the world.
#[must_use]
pub fn play(world: &HostileWorld, spec: &Spec) -> Outcome {
    let none: Result<_, Infallible> = play_with(world, spec, |_| Ok(Box::new(NoEventLog)));
    match none {
        Ok(outcome) => outcome,
        Err(never) => match never {},
    }
}

/// Plays the session in the world, and writes its event log.
///
/// # Errors
/// [`LogError`] when the log cannot be created.
pub fn play_logged(world: &HostileWorld, spec: &Spec, path: &Path) -> Result<Outcome, LogError> {
    play_with(world, spec, |setup| {
        let header = Header {
            drawing: world.name.clone(),
            operator: format!("{:?}", spec.style),
            simulated: true,
            setting: format!("hostile session {}:{}", world.seed, spec.seed),
            ..setup.header().unwrap_or_default()
        };
        Ok(Box::new(LogWriter::create(path, &header)?))
    })
}

fn play_with<E>(
    world: &HostileWorld,
    spec: &Spec,
    log: impl FnOnce(&SessionSetup) -> Result<Box<dyn EventLog>, E>,
) -> Result<Outcome, E> {
    let mut random = Rng::with_seed(spec.seed ^ 0x5e55_1011);
    let abilities = world.language.dialect(config(world)).abilities();
    let start_mm = start_mm(world, spec, &mut random);
    let height = world.start_height(start_mm, &mut Rng::with_seed(spec.seed ^ 0x4e16));
    let up_mm = mm(height.units()) + mm(world.zero_height().units());
    let machine = machine(world, spec, start_mm.at_height(up_mm), abilities);
    let cable = Cable { machine: Rc::new(RefCell::new(machine)), ahead: Rc::new(Cell::new(Duration::ZERO)) };
    let setup = SessionSetup {
        work: world.work.clone(),
        options: options(world, spec, &mut random),
        dialect: world.language.clone(),
        config: config(world),
    };
    let log = log(&setup)?;
    let person = Hostile::new(spec.style, spec.automatic, random.u64(..));
    let operator: Box<dyn Operator + Send> =
        if spec.at_panel { Box::new(HostileScreens::new(person, spec.seed)) } else { Box::new(person) };
    let again = cable.clone();
    let reopen =
        move || if again.machine.borrow().is_connected() { Ok(again.clone()) } else { Err(unplugged()) };
    let mut session = setup.session(cable.clone(), operator, log).recovering(Box::new(reopen));
    if spec.suffers(HostileFault::Planner) {
        let mut wrong = Rng::with_seed(spec.seed ^ 0x0091_a77e);
        session = session.planned_by(Box::new(move |request, plan| {
            request.work_out(plan).map(|job| spoilt(job, &mut wrong))
        }));
    }
    let mut clock = HostClock {
        now: Time::ZERO,
        breaks: breaks(spec, &mut random),
        jumps: spec.suffers(HostileFault::Clock),
        ahead: Rc::clone(&cable.ahead),
    };
    let mut watcher = Watcher::new(world, spec, cable, &mut random);
    let ended = session.run(&mut clock, spec.limit, |session, now| watcher.watch(session.supervisor(), now));
    Ok(watcher.outcome(session.supervisor(), ended.ok(), spec))
}

fn options(world: &HostileWorld, spec: &Spec, random: &mut Rng) -> Options {
    Options {
        feed_mm_min: [300, 900, 3000][random.usize(0..3)],
        home: false,
        travel: world.place.travel,
        heights: world.place.heights(),
        // Where one thing is asked at a time a report takes two exchanges, behind up to three that stop.
        answer_within: Duration::from_secs(5) + spec.latency * 10,
        baud: spec.baud,
        progress: Progress::default(),
    }
}

/// Where the tool begins, machine coordinates.
fn start_mm(world: &HostileWorld, spec: &Spec, random: &mut Rng) -> Mm2 {
    let inside = spec.begins_inside && !world.inside.is_empty();
    let places = if inside { &world.inside } else { &world.starts };
    let start = places[random.usize(0..places.len())];
    start.translated(world.place.offset).map_or(Mm2::new(-1.0, -1.0), point_mm)
}

/// What watches the machine while a session is played, and lets things happen to it.
struct Watcher {
    cable: Cable,
    monitor: CollisionMonitor,
    happenings: Vec<(Time, Happening)>,
    samples: Vec<Sample>,
    calm: bool,
    rounds: u64,
    last: Time,
    recoveries: u64,
    faulted: bool,
}

impl Watcher {
    fn new(world: &HostileWorld, spec: &Spec, cable: Cable, random: &mut Rng) -> Self {
        let radius = world.work.plan.plan.tool_radius;
        let rule = JoggingRule { clearance: world.by_hand, outside: world.outside };
        Self {
            cable,
            monitor: CollisionMonitor::new(
                Arc::clone(&world.levels),
                radius,
                (world.place.offset, world.zero_height()),
            )
            .with_rule(rule),
            happenings: happenings(spec, random),
            samples: Vec::new(),
            calm: spec.faults.is_empty(),
            rounds: 0,
            last: Time::ZERO,
            recoveries: 0,
            faulted: false,
        }
    }

    fn watch(&mut self, supervisor: &Supervisor, now: Time) -> Going {
        self.rounds += 1;
        self.last = now;
        let at = self.cable.machine_time(now);
        while let Some((_, happening)) = self.happenings.pop_if(|(at, _)| *at <= now) {
            happen(&mut self.cable.machine.borrow_mut(), &happening, at);
        }
        self.look();
        let faulted = supervisor.fault().is_some();
        self.recoveries += u64::from(self.faulted && !faulted);
        self.faulted = faulted;
        let over = self.monitor.verdict().is_some() || faulted && self.calm;
        if over { Going::Halt } else { Going::On }
    }

    fn look(&mut self) {
        self.cable.machine.borrow_mut().take_samples(&mut self.samples);
        self.samples.drain(..).for_each(|sample| self.monitor.watch(&sample));
    }

    /// What came of it, once all that is still under way was watched to its end.
    fn outcome(mut self, supervisor: &Supervisor, ended: Option<JobOutcome>, spec: &Spec) -> Outcome {
        let rest = self.cable.machine_time(self.last).after(spec.latency + Duration::from_secs(30));
        self.cable.machine.borrow_mut().connect(true);
        self.cable.machine.borrow_mut().advance(rest);
        self.look();
        Outcome {
            verdict: self.monitor.verdict(),
            ended,
            fault: supervisor.fault().map(ToString::to_string),
            seconds: self.last.elapsed().as_secs_f64(),
            counts: supervisor.counts(),
            contoured: supervisor.finished().len(),
            way_mm: self.monitor.way_mm(),
            faults: self.cable.machine.borrow_mut().faults(),
            rounds: self.rounds,
            recoveries: self.recoveries,
        }
    }
}

/// A job with a corner or heights moved, a motion left out, or one turned around.
fn spoilt(mut job: ContourJob, random: &mut Rng) -> ContourJob {
    let count = job.legs.len().max(1);
    let Some(leg) = job.legs.get_mut(random.usize(0..count)) else { return job };
    let index = random.usize(0..leg.curves.len().max(1));
    if !leg.heights.is_empty() && random.bool() {
        move_heights(&mut leg.heights, random);
        return job;
    }
    match random.u8(0..4) {
        0 if leg.curves.len() > 2 && index > 0 && index + 1 < leg.curves.len() => {
            // Straight on past what was left out.
            let from = leg.curves[index - 1].to();
            leg.curves.remove(index);
            let to = leg.curves[index].to();
            if from != to {
                leg.curves[index] = Curve::Line(Segment { from, to });
            }
        }
        1 => {
            if let Some(curve) = leg.curves.get_mut(index)
                && let Some(reversed) = curve.reversed()
            {
                *curve = reversed;
            }
        }
        _ => move_corner(&mut leg.curves, index, random),
    }
    job
}

/// Moves one height, or all of them, by up to a few mm, or exchanges two.
fn move_heights(heights: &mut [Height], random: &mut Rng) {
    let reach = 10_i64.pow(random.u32(2..6));
    let step = random.i64(-reach..=reach);
    let moved = |height: Height| Height::from_units(i64::from(height.units()) + step).unwrap_or(height);
    let (one, other) = (random.usize(0..heights.len()), random.usize(0..heights.len()));
    match random.u8(0..3) {
        0 => heights[one] = moved(heights[one]),
        1 => heights.iter_mut().for_each(|height| *height = moved(*height)),
        _ => heights.swap(one, other),
    }
}

/// Moves the corner between a line and the line behind it by up to a few mm.
fn move_corner(curves: &mut [Curve], index: usize, random: &mut Rng) {
    let reach = 10_i32.pow(random.u32(1..6));
    let step = Vector { dx: random.i32(-reach..=reach), dy: random.i32(-reach..=reach) };
    let Some([Curve::Line(a), Curve::Line(b)]) = curves.get_mut(index..index + 2) else { return };
    if let Ok(corner) = a.to.translated(step) {
        a.to = corner;
        b.from = corner;
    }
}

fn config(world: &HostileWorld) -> DialectConfig {
    world.place.config(&world.machine)
}

fn machine(world: &HostileWorld, spec: &Spec, start_mm: Mm3, abilities: Abilities) -> SimMachine {
    let settings =
        SimSettings { quirks: spec.quirks.clone(), ..SimSettings::of(world.machine.clone(), start_mm) };
    let (band, steps) = (world.machine.repeatability_mm, world.machine.steps_per_mm);
    let slip = if spec.suffers(HostileFault::LostSteps) {
        PositioningError::sudden(band, steps, spec.seed)
    } else {
        PositioningError::wandering(band, steps, spec.seed)
    }
    .of_three_axes(world.machine.z.as_ref());
    let controller: Box<dyn SimulatedController> = match world.language {
        DialectName::Grbl if spec.second_model => second_model(spec, settings),
        _ => speaking(&world.language, settings),
    };
    let there = Faults::new(spec.rates(false, abilities), spec.seed ^ 0x7e0);
    let here = Faults::new(spec.rates(true, abilities), spec.seed ^ 0x4e1);
    // Their budget is for a machine that speeds up no faster.
    let suits = world.machine.acceleration_mm_s2 <= MachineProfile::simulated().acceleration_mm_s2;
    let servo = (spec.driven && suits).then(DriveProfile::simulated).and_then(Result::ok);
    let drives = servo.and_then(|servo| ServoDrive::new(&servo, start_mm.plane()));
    SimMachine::new(controller, spec.baud, spec.latency, slip).hurt(there, here).driven(drives)
}

/// Raises GRBL's feed override by 10 %.
const INCREASE_FEED: u8 = 0x91;

/// The second model, with the feed override that an earlier host left. Sessions with faults may have one that leaves
/// steps: it ends a contour with a fault.
fn second_model(spec: &Spec, settings: SimSettings) -> Box<dyn SimulatedController> {
    let mut random = Rng::with_seed(spec.seed ^ 0x510e);
    let slowness = [1, 3, 6][random.usize(0..3)];
    let model = DocumentedGrbl::new(settings).homing_in_place().slower(slowness);
    let leaves = random.u8(0..4) == 0 && !spec.faults.is_empty();
    let model = if leaves { model.leaving_steps(spec.seed) } else { model };
    let late = spec.suffers(HostileFault::Doubling) && random.bool();
    let mut model = if late { model.repeating_late(spec.seed) } else { model };
    (0..random.u8(0..11)).for_each(|_| model.receive(INCREASE_FEED));
    Box::new(model)
}

fn happenings(spec: &Spec, random: &mut Rng) -> Vec<(Time, Happening)> {
    let mut list = Vec::new();
    let at = |random: &mut Rng| Time::ZERO.after(spec.limit.mul_f64(random.f64()));
    for fault in &spec.faults {
        let when = at(random);
        match fault {
            HostileFault::Reset => {
                let more = if random.bool() { 0 } else { random.usize(1..8) };
                let happening = || if spec.power_fails { Happening::BrownOut } else { Happening::Reset };
                list.extend((0..more).map(|_| (at(random), happening())));
                list.push((when, happening()));
            }
            HostileFault::Alarm => list.push((when, Happening::Alarm)),
            HostileFault::PortLoss => {
                let back = when.after(Duration::from_millis(random.u64(1..8000)));
                list.extend([(when, Happening::Unplug), (back, Happening::Plug)]);
            }
            HostileFault::Baud => {
                let back = when.after(Duration::from_millis(random.u64(1..8000)));
                list.extend([(when, Happening::Mistune(true)), (back, Happening::Mistune(false))]);
            }
            _ => {}
        }
    }
    list.sort_by_key(|each| std::cmp::Reverse(each.0));
    list
}

fn happen(machine: &mut SimMachine, happening: &Happening, now: Time) {
    match happening {
        Happening::Reset => machine.disturb(Disturbance::Reset, now),
        Happening::BrownOut => machine.disturb(Disturbance::BrownOut, now),
        Happening::Alarm => machine.disturb(Disturbance::Alarm, now),
        Happening::Unplug => machine.connect(false),
        Happening::Plug => machine.connect(true),
        Happening::Mistune(wrong) => machine.mistune(*wrong),
    }
}

fn breaks(spec: &Spec, random: &mut Rng) -> Vec<(Time, Duration)> {
    if !spec.suffers(HostileFault::Clock) && !spec.suffers(HostileFault::Stall) {
        return Vec::new();
    }
    // A few of any length, or again and again what lets blocks pass for executed.
    let often = random.u8(0..3) == 0;
    let count = if often { random.usize(30..200) } else { random.usize(1..12) };
    let mut list: Vec<(Time, Duration)> = (0..count)
        .map(|_| {
            let seconds = if often { 0.5 + 0.2 * random.f64() } else { 0.01 * 1000.0_f64.powf(random.f64()) };
            let span = Duration::from_secs_f64(seconds);
            (Time::ZERO.after(spec.limit.mul_f64(random.f64())), span)
        })
        .collect();
    list.sort_by_key(|each| std::cmp::Reverse(each.0));
    list
}
