//! The supervisor beside a machine that does what it is told, late, in part or twice, or says what it likes; with the witness of
//! the guard's invariant: whatever may still be executed leads nowhere near the part, and the tool never comes there.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::time::Duration;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::link::Abilities;
use keepout_executor::session::place_on_table;
use keepout_executor::supervisor::guard::{Motion, MotionShape};
use keepout_executor::supervisor::{
    Ask, Command, Event, Limits, Mode, Options, Phase, Reply, Report, Supervisor, Wish, text,
};
use keepout_executor::time::Time;
use keepout_kernel::curve::{nearest_point, xy};
use keepout_kernel::{Curve, Length, Point, Turn};
use keepout_planner::job::Progress;
use keepout_proofs::properties::Xy;
use keepout_proofs::soak::{segments_within, triangle_within};
use keepout_proofs::square::plain;

use crate::{job, witness};

/// Lines that the controller's receive buffer holds; what arrives beyond them is lost.
const BUFFER: usize = 3;
/// The last digit of a report, lattice units.
const DIGIT: i64 = 100;
/// Most steps of one session.
const STEPS_MAX: usize = 400;
/// Commands that one step may give.
const COMMANDS_MAX: usize = 64;

/// What goes wrong with the line or the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Arbitrary)]
enum Trouble {
    None,
    /// Lines and answers are lost.
    Loses,
    /// Lines and answers come twice.
    Doubles,
    /// It says what it likes.
    Lies,
}

/// Any bytes as a session: what the operator wishes, what the machine does and when, what goes wrong.
///
/// # Panics
/// When something is sent that is not certified, or the tool comes too near the part.
pub fn supervisor(bytes: &[u8]) {
    let _ = session(&mut Unstructured::new(bytes));
}

fn session(u: &mut Unstructured<'_>) -> Result<()> {
    let trouble = Trouble::arbitrary(u)?;
    let abilities = Abilities {
        shape: MotionShape::Line,
        contours: MotionShape::Line,
        arcs: bool::arbitrary(u)?,
        queues: true,
        cancels: true,
        flushes: false,
        holds: true,
        checked: bool::arbitrary(u)?,
    };
    let mut play = Play::begin(trouble, abilities, u)?;
    play.starts();
    for _ in 0..STEPS_MAX {
        if u.is_empty() {
            break;
        }
        play.goes_on(u)?;
    }
    Ok(())
}

/// Both sides, and what is known of the tool.
struct Play {
    supervisor: Supervisor,
    machine: Machine,
    trouble: Trouble,
    now: Time,
    walls: Vec<(Xy, Xy)>,
    /// The tool was, or was taken to be, nearer than roughing allows: it may stand where a contour led it.
    near: bool,
    wish: Wish,
}

/// A controller that takes lines into a queue and drives them in order.
struct Machine {
    tool: Xy,
    /// Where the tool was when it began the motion that it is at, and how much of that is done.
    begun: (Xy, f64),
    wire: VecDeque<Command>,
    received: VecDeque<Motion>,
    planner: VecDeque<Motion>,
    held: bool,
    answers: VecDeque<Reply>,
}

impl Play {
    fn begin(trouble: Trouble, abilities: Abilities, u: &mut Unstructured<'_>) -> Result<Self> {
        const STARTS_MM: [(i64, i64); 5] = [(-10, -10), (10, 40), (10, 30), (40, 5), (-4, 8)];
        let work = job::work();
        let walls = work.plan.part.edges().iter().map(|edge| (plain(edge.chord.from), plain(edge.chord.to)));
        let walls = walls.collect();
        let place =
            place_on_table(&work.plan, &work.plan.plan.machine, None).expect("the plate lies on the table");
        let (x, y) = *u.choose(&STARTS_MM)?;
        let options = Options {
            feed_mm_min: 900,
            home: false,
            stroke: place.stroke,
            answer_within: Duration::from_secs(5),
            progress: Progress::default(),
        };
        let machine = Machine {
            tool: (x * 100_000, y * 100_000),
            begun: ((x * 100_000, y * 100_000), 0.0),
            wire: VecDeque::new(),
            received: VecDeque::new(),
            planner: VecDeque::new(),
            held: false,
            answers: VecDeque::new(),
        };
        let supervisor = Supervisor::new(work, options, abilities);
        Ok(Self { supervisor, machine, trouble, now: Time::ZERO, walls, near: false, wish: Wish::default() })
    }

    /// Nothing goes wrong before the tool is steered.
    fn starts(&mut self) {
        for _ in 0..40 {
            if self.supervisor.phase().is_steered() {
                return;
            }
            self.passes(Duration::from_millis(100));
            self.hears_all();
        }
    }

    fn hears_all(&mut self) {
        while !self.machine.wire.is_empty() {
            self.machine.hears();
        }
        while let Some(reply) = self.machine.answers.pop_front() {
            self.step(Event::Reply(reply));
        }
    }

    fn goes_on(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        match u.int_in_range(0..=15_u8)? {
            0 | 1 => self.machine.hears(),
            2 | 3 => self.moves(f64::from(u8::arbitrary(u)?) / 128.0),
            4 | 5 => {
                if let Some(reply) = self.machine.answers.pop_front() {
                    self.step(Event::Reply(reply));
                }
            }
            6 | 7 => {
                self.wish = wish(u)?;
                self.step(Event::Operator(self.wish));
            }
            8 => self.passes(Duration::from_millis(u64::from(u16::arbitrary(u)?) / 16)),
            9 => self.suffers(u)?,
            10 => {
                if let Some(wanted) = self.supervisor.wanted_job() {
                    let worked_out = wanted.work_out(&job::work().plan);
                    self.step(Event::Job(Box::new(worked_out)));
                }
            }
            // As it goes when nothing is late, for a while.
            rounds => {
                for _ in 10..rounds {
                    self.step(Event::Operator(self.wish));
                    self.passes(Duration::from_millis(50));
                    self.moves(0.6);
                    self.hears_all();
                }
            }
        }
        Ok(())
    }

    fn passes(&mut self, span: Duration) {
        self.now = self.now.after(span);
        self.step(Event::Tick);
    }

    fn step(&mut self, event: Event) {
        let mut commands = Vec::new();
        self.supervisor.step(event, self.now, &mut commands);
        assert!(commands.len() <= COMMANDS_MAX, "{} commands at once", commands.len());
        let inside = self.supervisor.guard().stands_inside();
        self.near |= inside || matches!(self.supervisor.phase(), Phase::Contouring | Phase::Holding);
        for command in commands {
            if let Command::Move(certified) = &command {
                match certified.motion() {
                    Motion::Jog { .. } => self.watch_set(inside),
                    Motion::Contour { curve, .. } => self.watch_contour(curve),
                }
            }
            self.machine.wire.push_back(command);
        }
    }

    fn is_near(&self, [a, b, c]: [Xy; 3], r: i64) -> bool {
        let corners = [a, b, c];
        self.walls.iter().any(|&(d, e)| {
            if b == c { segments_within(a, b, d, e, r) } else { triangle_within(corners, d, e, r) }
        })
    }

    /// The hull of all that may be executed is clear: each triangle of it is, by big integers over all edges.
    fn watch_set(&self, inside: bool) {
        if inside {
            return;
        }
        let guard = self.supervisor.guard();
        let kept = i64::from(guard.rules().manual.units()) - 1;
        let set: Vec<Xy> = guard.in_flight().map(plain).collect();
        for (i, &a) in set.iter().enumerate() {
            for (j, &b) in set.iter().enumerate().skip(i) {
                for &c in &set[j..] {
                    let near = self.is_near([a, b, c], kept);
                    assert!(!near, "{a:?} {b:?} {c:?} of what may be executed come nearer than {kept}");
                }
            }
        }
    }

    fn watch_contour(&self, curve: &Curve) {
        let kept = f64::from(self.supervisor.guard().rules().finishing.units()) - 4.0;
        let plan = &job::work().plan;
        for place in witness::places(curve) {
            let left = witness::distance(place, witness::walls(plan));
            assert!(left > kept, "{curve:?} of a contour comes to {left}, not {kept}");
        }
    }

    /// The tool moves on; where nobody lied it comes nowhere near the part.
    fn moves(&mut self, share: f64) {
        let rules = self.supervisor.guard().rules();
        let off = 3 * i64::from(rules.resolution.units()) + 4;
        let kept = |threshold: Length| i64::from(threshold.units()) - off;
        let kept = if self.near { kept(rules.finishing) } else { kept(rules.manual) };
        let mut left = share;
        while left > 0.0 && !self.machine.held {
            let from = self.machine.tool;
            let Some(used) = self.machine.moves(left) else { break };
            left -= used;
            let near = self.is_near([from, self.machine.tool, self.machine.tool], kept);
            let to = self.machine.tool;
            assert!(
                !near || self.trouble == Trouble::Lies,
                "the tool comes nearer than {kept}: {from:?} to {to:?}"
            );
        }
    }

    fn suffers(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let (there, machine) = (bool::arbitrary(u)?, &mut self.machine);
        match self.trouble {
            Trouble::None => {}
            Trouble::Loses if there => drop(machine.wire.pop_front()),
            Trouble::Loses => drop(machine.answers.pop_front()),
            Trouble::Doubles if there => {
                machine.wire.extend(machine.wire.front().copied().filter(|_| machine.wire.len() == 1))
            }
            Trouble::Doubles => {
                if let Some(&reply) = machine.answers.front() {
                    machine.answers.push_front(reply);
                }
            }
            Trouble::Lies => {
                let event = lie(u)?;
                self.step(event);
            }
        }
        Ok(())
    }
}

impl Machine {
    /// The next line arrives.
    fn hears(&mut self) {
        let Some(command) = self.wire.pop_front() else { return };
        match command {
            Command::Query => {
                let report = self.report();
                self.answers.push_back(Reply::Report(report));
            }
            Command::Cancel => {
                if let Some(Motion::Jog { .. }) = self.planner.front() {
                    self.planner.clear();
                    self.begun = (self.tool, 0.0);
                }
            }
            Command::Hold => self.held = !self.planner.is_empty(),
            Command::Continue => self.held = false,
            Command::Abort => {
                self.received.clear();
                self.planner.clear();
                self.held = false;
                self.begun = (self.tool, 0.0);
                self.answers.push_back(Reply::Restarted);
            }
            Command::Prepare => {
                let limits = Limits { speed_mm_s: 200.0, acceleration_mm_s2: 1000.0 };
                self.answers.push_back(Reply::Prepared(limits));
            }
            Command::Home => self.answers.push_back(Reply::Homed),
            Command::Arm => self.answers.push_back(Reply::Armed),
            Command::Move(certified) if self.received.len() < BUFFER => {
                self.received.push_back(*certified.motion());
            }
            Command::Move(_) => {}
        }
        // What was received is planned as long as there is room; nothing is read while it holds.
        while !self.held && self.planner.len() < 15 {
            let Some(motion) = self.received.pop_front() else { break };
            if self.begins_elsewhere(&motion) {
                self.answers.push_back(Reply::Refused { code: 33, meaning: "", transient: false });
            } else {
                self.planner.push_back(motion);
                self.answers.push_back(Reply::Accepted);
            }
        }
    }

    /// An arc is given by its radius: where it does not begin at the end of what is planned, it is refused.
    fn begins_elsewhere(&self, motion: &Motion) -> bool {
        let Motion::Contour { curve: Curve::Arc(arc), .. } = motion else { return false };
        let end = self.planner.back().map_or(self.tool, |last| match last {
            Motion::Jog { to, .. } => plain(*to),
            Motion::Contour { curve, .. } => plain(curve.to()),
        });
        let from = plain(arc.from());
        (from.0 - end.0).abs().max((from.1 - end.1).abs()) > 4 * DIGIT
    }

    fn report(&self) -> Report {
        let digit = |c: i64| (c + DIGIT / 2).div_euclid(DIGIT) * DIGIT;
        let mode = match (self.held, self.planner.is_empty()) {
            (true, _) => Mode::Held,
            (false, false) => Mode::Moving,
            (false, true) => Mode::Idle,
        };
        Report {
            mode,
            position: Point::from_units(digit(self.tool.0), digit(self.tool.1)).ok(),
            queued: Some(self.planner.len()),
            waiting: Some(!self.received.is_empty()),
        }
    }

    /// Drives a share of its motion, or what is left of it; answers how much that was.
    fn moves(&mut self, share: f64) -> Option<f64> {
        let motion = *self.planner.front()?;
        let (from, done) = self.begun;
        // So little of an arc that its chord is the arc, to a unit or two.
        let most = if matches!(motion, Motion::Contour { curve: Curve::Arc(_), .. }) { 0.005 } else { 1.0 };
        let used = share.min(1.0 - done).min(most).max(0.0);
        let at = done + used;
        self.tool = match motion {
            Motion::Contour { curve: Curve::Arc(arc), .. } if at < 1.0 => {
                let (centre, start) = (xy(arc.centre()), xy(arc.from()));
                let angle = |p: (f64, f64)| (p.1 - centre.1).atan2(p.0 - centre.0);
                let left = arc.turn() == Turn::Left;
                let turned = angle(xy(arc.to())) - angle(start);
                let swept = if left { turned.rem_euclid(TAU) } else { -(-turned).rem_euclid(TAU) };
                let (r, phi) = ((start.0 - centre.0).hypot(start.1 - centre.1), angle(start) + swept * at);
                nearest((centre.0 + r * phi.cos(), centre.1 + r * phi.sin()))
            }
            Motion::Jog { to, .. } => between(from, to, at),
            Motion::Contour { curve, .. } => between(from, curve.to(), at),
        };
        self.begun.1 = at;
        if at >= 1.0 {
            self.planner.pop_front();
            self.begun = (self.tool, 0.0);
        }
        Some(used.max(1e-3))
    }
}

#[expect(clippy::cast_precision_loss, reason = "coordinates have 30 bits")]
fn between(from: Xy, to: Point, share: f64) -> Xy {
    let (a, b) = ((from.0 as f64, from.1 as f64), xy(to));
    nearest((a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share))
}

fn nearest((x, y): (f64, f64)) -> Xy {
    plain(nearest_point(x, y).expect("it is between places of the table"))
}

fn wish(u: &mut Unstructured<'_>) -> Result<Wish> {
    let share = |u: &mut Unstructured<'_>| Ok(f64::from(i8::arbitrary(u)?) / 100.0);
    let direction = (share(u)?, share(u)?);
    let turned = if u.int_in_range(0..=7_u8)? == 0 { (share(u)?, share(u)?) } else { (0.0, 0.0) };
    let ask = match u.int_in_range(0..=31_u8)? {
        0 => Some(Ask::Pause),
        1 | 2 => Some(Ask::Resume),
        3 => Some(Ask::Recover),
        4 => Some(Ask::Quit),
        _ => None,
    };
    Ok(Wish { direction, turned_mm: turned, automatic: u.int_in_range(0..=2_u8)? == 0, ask })
}

/// Anything that a controller may say, or a port do.
fn lie(u: &mut Unstructured<'_>) -> Result<Event> {
    const MODES: [Mode; 7] =
        [Mode::Idle, Mode::Moving, Mode::Slowing, Mode::Held, Mode::Homing, Mode::Alarm, Mode::Other];
    let reply = match u.int_in_range(0..=19_u8)? {
        0..=8 => {
            let place = (i64::from(i32::arbitrary(u)? >> 6), i64::from(i32::arbitrary(u)? >> 6));
            Reply::Report(Report {
                mode: *u.choose(&MODES)?,
                position: if u.int_in_range(0..=7_u8)? == 0 {
                    None
                } else {
                    Point::from_units(place.0, place.1).ok()
                },
                queued: Option::<u8>::arbitrary(u)?.map(usize::from),
                waiting: Option::<bool>::arbitrary(u)?,
            })
        }
        9 | 10 => Reply::Accepted,
        11 => Reply::Refused { code: 8, meaning: "", transient: bool::arbitrary(u)? },
        12 => Reply::Restarted,
        13 => Reply::Alarm { code: 1, meaning: "" },
        14 => Reply::Homed,
        15 => Reply::Armed,
        16 => Reply::Prepared(Limits {
            speed_mm_s: f64::from(u8::arbitrary(u)?),
            acceleration_mm_s2: f64::from(u8::arbitrary(u)?),
        }),
        17 => Reply::Garbled(text("?")),
        18 => return Ok(Event::PortLost(text("pulled"))),
        _ => return Ok(Event::PortFound),
    };
    Ok(Event::Reply(reply))
}
