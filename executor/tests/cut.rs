//! What counts as cut was cut, whatever one report says.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use keepout_executor::link::dialect::Language;
use keepout_executor::link::port::{Port, PortError};
use keepout_executor::operator;
use keepout_executor::session::{
    Engine, Going, NoTape, Scene, Session, SimRun, VirtualClock, coverage, start_inside,
};
use keepout_executor::sim::witness::Witness;
use keepout_executor::sim::{SimMachine, SimSettings, Slip, speaking};
use keepout_executor::supervisor::{Phase, Supervisor, Workpiece};
use keepout_executor::time::Time;
use keepout_kernel::Point;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::order::Order;
use keepout_planner::units::point_mm;

fn work() -> Workpiece {
    let bytes = include_bytes!("../drawings/bracket.dxf");
    let plan = Order::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap();
    Workpiece::new(plan)
}

/// A place that one report names instead of its own, machine coordinates, mm; `None` while there is nothing to be named.
type Lie = Rc<RefCell<Option<(f64, f64)>>>;

/// GRBL at the end of a line that changes the place in one report.
struct LyingLine {
    machine: SimMachine,
    lie: Lie,
}

impl Port for LyingLine {
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
            && let Some((x, y)) = self.lie.take()
        {
            text = format!("{begin}MPos:{x:.3},{y:.3},0.000{rest}");
        }
        into.extend(text.bytes());
        Ok(())
    }

    fn next_event(&self) -> Time {
        self.machine.next_event()
    }
}

/// What one session has cut, and what it says that it has.
struct Cut {
    paths: Vec<Vec<Point>>,
    progress: Progress,
    finished: usize,
    phase: Phase,
    lied: bool,
}

/// One session at GRBL. So many seconds after its contour began, one report names the end of the motion that was sent last.
fn session(work: &Workpiece, progress: Progress, lie_after_s: Option<f64>) -> Cut {
    let start = start_inside(&work.plan).unwrap();
    let run = SimRun { start: Some(start), progress, feed_mm_min: 3000, ..SimRun::default() };
    let scene = Scene::of(&work.plan, &run).unwrap();
    let offset = scene.setting.offset;
    let on_machine = |point: Point| point_mm(point.translated(offset).unwrap());
    let sim = SimSettings {
        machine: run.machine.clone(),
        start_mm: on_machine(start),
        homed: true,
        homing: Duration::from_secs(1),
        work_offset_mm: (-3.0, -4.0),
    };
    let slip = Slip::wandering(0.0, run.machine.steps_per_mm, 1);
    let machine = SimMachine::new(speaking(&Language::Grbl, sim), run.baud, run.latency, slip);
    let mut witness = Witness::new(work.plan.part.clone(), work.plan.plan.tool_radius, offset);
    let lie = Lie::default();
    let dialect = run.language.dialect(scene.setting);
    let supervisor = Supervisor::new(work.clone(), scene.options, dialect.abilities());
    let operator = operator::named("wall", 3.0, 1).unwrap();
    let line = LyingLine { machine, lie: Rc::clone(&lie) };
    let mut session = Session::new(Engine::new(supervisor, dialect), line, operator, Box::new(NoTape));
    let (mut began, mut told, mut samples) = (None, false, Vec::new());
    let limit = Duration::from_secs(200);
    let mut watch = |session: &mut Session<'_, LyingLine>, now: Time| {
        session.port().unwrap().machine.take_samples(&mut samples);
        samples.drain(..).for_each(|sample| witness.watch(&sample));
        if session.supervisor().phase() == Phase::Contouring && !told {
            let began = *began.get_or_insert(now);
            let guard = session.supervisor().guard();
            let (sent, _) = guard.contour_progress().unwrap();
            let ahead = sent.saturating_sub(guard.contour_at().unwrap() + 1);
            if lie_after_s.is_some_and(|after| now.since(began).as_secs_f64() > after) {
                told = true;
                *lie.borrow_mut() = Some(on_machine(guard.contour_left()[ahead].0.to()));
            }
        }
        Going::On
    };
    session.run(&mut VirtualClock::default(), limit, &mut watch).unwrap();
    session.drain(Time::from_micros(220_000_000));
    session.port().unwrap().machine.take_samples(&mut samples);
    samples.drain(..).for_each(|sample| witness.watch(&sample));
    assert!(witness.deepest().is_none());
    let supervisor = session.supervisor();
    Cut {
        paths: witness.cut_paths().map(<[Point]>::to_vec).collect(),
        progress: supervisor.progress(),
        finished: supervisor.finished().len(),
        phase: supervisor.phase(),
        lied: told && lie.borrow().is_none(),
    }
}

/// A report on a line without a checksum can lose a digit and still name a place of the contour, far ahead of the tool. The
/// session ends by the next one; what was not cut must not be left standing by the session that takes it up.
#[test]
fn a_report_from_further_along_leaves_nothing_standing() {
    let work = work();
    let mut stopped = 0;
    for tenths in 5..35_u32 {
        let first = session(&work, Progress::default(), Some(f64::from(tenths) / 5.0));
        assert!(first.lied, "{tenths}: no report was changed");
        stopped += u32::from(first.phase == Phase::Faulted);
        let second = session(&work, first.progress.clone(), None);
        assert_eq!((second.phase, second.finished), (Phase::Done, 1), "{tenths}: {:?}", first.progress);
        let whole = coverage(&work.plan, first.paths.iter().chain(&second.paths).map(Vec::as_slice));
        assert!(whole.missed == 0 && whole.worst_mm < 0.03, "{tenths}: {whole:?}, {:?}", first.progress);
    }
    assert!(stopped > 20, "only {stopped} sessions were stopped by a wrong place");
}
