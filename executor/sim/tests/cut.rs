//! Material that counts as cut was cut, for any single damaged report and any path of the operator.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::session::{Going, NoEventLog, Session, VirtualClock, coverage, start_inside};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase, PreparedPlan};
use keepout_guard::Time;
use keepout_kernel::{Height, Place};
use keepout_planner::Mm2;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::point_mm;
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::session::{Scene, SimRun};
use keepout_sim::{PositioningError, SimMachine, SimSettings, operator, speaking};

fn work() -> PreparedPlan {
    let bytes = include_bytes!("../../cli/drawings/bracket.dxf");
    let plan =
        PlanRequest::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap();
    PreparedPlan::new(plan)
}

/// The damage to one report.
#[derive(Clone, Copy, Debug)]
enum Damage {
    /// It states another position, machine coordinates, mm.
    Place(f64, f64),
    /// A garbage line follows it.
    Noise,
}

/// The damage that is still to come.
type PendingDamage = Rc<RefCell<Option<Damage>>>;

/// GRBL at the end of a line that damages one report.
struct ImpairedLine {
    machine: SimMachine,
    damage: PendingDamage,
}

impl Port for ImpairedLine {
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError> {
        self.machine.host_writes(bytes, now);
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        self.machine.advance(now);
        let mut bytes = Vec::new();
        self.machine.host_reads(&mut bytes, now);
        let mut text = String::from_utf8(bytes).unwrap();
        if let Some((begin, rest)) = text.split_once("MPos:")
            && let Some((_, rest)) = rest.split_once(",0.000")
            && let Some(damage) = self.damage.take()
        {
            match damage {
                Damage::Place(x, y) => text = format!("{begin}MPos:{x:.3},{y:.3},0.000{rest}"),
                Damage::Noise => text.push_str("<#@!\r\n"),
            }
        }
        into.extend(text.bytes());
        Ok(())
    }

    fn next_event(&self) -> Time {
        self.machine.next_event()
    }
}

/// The result of one session: the cut paths, and the progress that it reports.
struct Cut {
    paths: Vec<Vec<Place>>,
    progress: Progress,
    finished: usize,
    phase: Phase,
    damaged: bool,
    notices: Vec<String>,
}

/// The time of the damage, seconds after the contour began, and its kind: noise, or else a position at the
/// end of the last sent motion.
#[derive(Clone, Copy)]
struct Trouble {
    after_s: f64,
    noise: bool,
}

/// An operator who starts a contour at a wall. After a fault it recovers, jogs `along_mm` along the part, and
/// presses cycle start. The part is at its left hand when `side` is positive. If the contour does not go on,
/// it leads the tool away and presses cycle start again.
struct Slider {
    cuts: Box<dyn Operator + Send>,
    along_mm: f64,
    side: f64,
    began: Option<(Time, Mm2)>,
    commanded: Option<Time>,
    command: Option<OperatorCommand>,
}

impl Slider {
    fn new(along_mm: f64, side: f64) -> Box<Self> {
        let cuts = operator::named("wall", 3.0, 1).unwrap();
        Box::new(Self { cuts, along_mm, side, began: None, commanded: None, command: None })
    }
}

impl Operator for Slider {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        let armed = OperatorInput { armed: true, ..OperatorInput::default() };
        let mut command = |command| {
            self.command = Some(command);
            armed
        };
        let push = |x: f64, y: f64| OperatorInput { velocity: Mm2::new(x, y), ..OperatorInput::default() };
        let past = |since: Time, seconds: f64| now.since(since).as_secs_f64() > seconds;
        match (view.phase, view.position_mm, view.wall_mm) {
            (Phase::Faulted, ..) => command(OperatorCommand::Recover),
            (Phase::Retracting, Some(at), Some(wall)) => {
                let (since, from) = *self.began.get_or_insert((now, at));
                let (x, y) = (wall.x - at.x, wall.y - at.y);
                let (x, y) = (x / x.hypot(y), y / x.hypot(y));
                let slides = at.distance(from) < self.along_mm && !past(since, 12.0);
                match self.commanded {
                    Some(commanded) if past(commanded, 1.0) => push(-x, -y),
                    None if slides => push(-y * self.side, x * self.side),
                    None if past(since, 12.5) || self.along_mm == 0.0 => {
                        self.commanded = Some(now);
                        command(OperatorCommand::CycleStart)
                    }
                    _ => OperatorInput::default(),
                }
            }
            (Phase::Manual, ..) if self.commanded.is_some_and(|commanded| past(commanded, 1.5)) => {
                if view.unacknowledged == 0 && self.commanded.is_some_and(|commanded| past(commanded, 4.0)) {
                    command(OperatorCommand::CycleStart)
                } else {
                    OperatorInput::default()
                }
            }
            (Phase::Touching | Phase::Contouring, ..) if self.commanded.is_some() => armed,
            _ => self.cuts.input(view, now),
        }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.command.take().or_else(|| self.cuts.command())
    }
}

/// One session with a simulated GRBL controller.
fn session(
    work: &PreparedPlan,
    progress: Progress,
    trouble: Option<Trouble>,
    operator: Box<dyn Operator + Send>,
) -> Cut {
    let start = start_inside(&work.plan).unwrap();
    let run = SimRun { start: Some(start), progress, feed_mm_min: 3000, ..SimRun::default() };
    let scene = Scene::of(work.clone(), &run).unwrap();
    let offset = scene.offset();
    let on_machine = |point: keepout_kernel::Point| point_mm(point.translated(offset).unwrap());
    let sim = SimSettings {
        work_offset_mm: Mm2::new(-3.0, -4.0).at_height(0.0),
        ..SimSettings::of(run.machine.clone(), on_machine(start).at_height(0.0))
    };
    let positioning_error = PositioningError::wandering(0.0, run.machine.steps_per_mm, 1);
    let machine =
        SimMachine::new(speaking(&DialectName::Grbl, sim), run.baud, run.latency, positioning_error);
    let mut monitor =
        CollisionMonitor::new(work.levels().clone(), work.plan.plan.tool_radius, (offset, Height::ZERO));
    let damage = PendingDamage::default();
    let line = ImpairedLine { machine, damage: Rc::clone(&damage) };
    let mut session = scene.setup.session(line, operator, Box::new(NoEventLog));
    if trouble.is_some_and(|trouble| trouble.noise) {
        session = session.recovering(Box::new(|| unreachable!("the port stays open")));
    }
    let (mut began, mut requested, mut samples) = (None, false, Vec::new());
    let limit = Duration::from_secs(200);
    let mut watch = |session: &mut Session<'_, ImpairedLine>, now: Time| {
        session.port().unwrap().machine.take_samples(&mut samples);
        samples.drain(..).for_each(|sample| monitor.watch(&sample));
        if session.supervisor().phase() == Phase::Contouring && !requested {
            let began = *began.get_or_insert(now);
            let guard = session.supervisor().guard();
            let (sent, _) = guard.contour_progress().unwrap();
            let ahead = sent.saturating_sub(guard.contour_at().unwrap() + 1);
            if let Some(Trouble { after_s, noise }) = trouble
                && now.since(began).as_secs_f64() > after_s
            {
                requested = true;
                let Mm2 { x, y } = on_machine(guard.contour_left()[ahead].curve.to());
                *damage.borrow_mut() = Some(if noise { Damage::Noise } else { Damage::Place(x, y) });
            }
        }
        Going::On
    };
    session.run(&mut VirtualClock::default(), limit, &mut watch).unwrap();
    session.drain(Time::from_micros(220_000_000));
    session.port().unwrap().machine.take_samples(&mut samples);
    samples.drain(..).for_each(|sample| monitor.watch(&sample));
    assert!(monitor.deepest().is_none());
    let supervisor = session.supervisor();
    Cut {
        paths: monitor.cut_paths().map(<[Place]>::to_vec).collect(),
        progress: supervisor.progress(),
        finished: supervisor.finished().len(),
        phase: supervisor.phase(),
        damaged: requested && damage.borrow().is_none(),
        notices: supervisor.notices().iter().map(ToString::to_string).collect(),
    }
}

fn wall() -> Box<dyn Operator + Send> {
    operator::named("wall", 3.0, 1).unwrap()
}

// Evidence for SR-23.
/// A report on a line without a checksum can lose a digit, and still state a position on the contour, far
/// ahead of the tool. The next report ends the session. The session that resumes must cut all the remaining
/// contour.
#[test]
fn damaged_position_ahead_leaves_no_material_uncut() {
    let work = work();
    let (mut stopped, mut uncut) = (0, 0);
    for tenths in 10..70_u32 {
        let trouble = Trouble { after_s: f64::from(tenths) / 10.0, noise: false };
        let first = session(&work, Progress::default(), Some(trouble), wall());
        assert!(first.damaged, "{tenths}: no report was changed");
        stopped += u32::from(first.phase == Phase::Faulted);
        let alone = coverage(&work.plan, first.paths.iter().map(Vec::as_slice));
        assert!(alone.missed == 0 || first.finished == 0, "{tenths}: {alone:?}");
        uncut += u32::from(alone.missed > 0);
        let second = session(&work, first.progress.clone(), None, wall());
        assert_eq!((second.phase, second.finished), (Phase::Done, 1), "{tenths}: {:?}", first.progress);
        let whole = coverage(&work.plan, first.paths.iter().chain(&second.paths).map(Vec::as_slice));
        assert!(whole.missed == 0 && whole.worst_mm < 0.03, "{tenths}: {whole:?}, {:?}", first.progress);
    }
    assert!(stopped > 20, "a wrong position stopped only {stopped} sessions");
    assert!(uncut > 20, "only {uncut} sessions left material that the next one cut");
}

/// After a fault the operator may jog along the part, as near as the contour is. The tool does not cut there
/// by hand, and the jogged stretch must not count as cut where the contour resumes.
#[test]
fn jogging_along_the_part_does_not_count_as_cutting() {
    let work = work();
    let (mut led, mut clear) = (0, 0);
    for (along_mm, side) in [(0.0, 1.0), (9.0, 1.0), (9.0, -1.0), (0.3, 1.0), (0.3, -1.0)] {
        for after_s in [2.5, 3.5, 4.0, 5.0, 6.0, 7.0] {
            let case = (along_mm, side, after_s);
            let trouble = Some(Trouble { after_s, noise: true });
            let cut = session(&work, Progress::default(), trouble, Slider::new(along_mm, side));
            assert!(cut.damaged, "{case:?}: there was no noise");
            assert_eq!(cut.finished, 1, "{case:?}: {:?}, {:?}", cut.phase, cut.notices);
            let whole = coverage(&work.plan, cut.paths.iter().map(Vec::as_slice));
            assert!(whole.missed == 0 && whole.worst_mm < 0.03, "{case:?}: {whole:?}, {:?}", cut.notices);
            let refused = cut.notices.iter().any(|notice| notice.contains("you jogged the tool there"));
            led += u32::from(refused);
            clear += u32::from(along_mm == 0.0 && !refused);
        }
    }
    assert!(led > 8 && clear == 6, "{led} sessions jogged along the part, {clear} resumed in place");
}
