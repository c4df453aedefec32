//! Whole sessions with a third axis: a part with an outline, two through holes and a pocket, from solid stock.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::{Going, NoEventLog, Sample};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_planner::depth::{DepthParameters, EntryMove, FaceChoice, FaceDepth};
use keepout_planner::job::Progress;
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::plan::PlanParameters;
use keepout_planner::request::PlanRequest;
use keepout_planner::stock::StockMap;
use keepout_planner::units::point_mm;
use keepout_planner::{Box2, Mm2};
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimResult, SimRun, run_simulated};

/// A dialect description with a third axis.
const DESCRIBED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/described/three-axes.toml");

fn machine() -> MachineProfile {
    MachineProfile { z: Some(ZProfile::simulated()), ..MachineProfile::simulated() }
}

/// A cover of 6 mm: two holes go through, the pocket is 3 mm deep, and a pass takes 2 mm at most.
fn work(entry: EntryMove) -> PreparedPlan {
    work_on(&machine(), entry)
}

fn work_on(machine: &MachineProfile, entry: EntryMove) -> PreparedPlan {
    let bytes = include_bytes!("../../cli/drawings/cover.dxf");
    let pocket = FaceDepth { of: FaceChoice::Layer("POCKET".into()), depth_mm: Some(3.0) };
    let depth =
        DepthParameters { faces: vec![pocket], step_down_mm: Some(2.0), entry, ..DepthParameters::of(6.0) };
    let job = PlanParameters { depth: Some(depth), ..PlanParameters::default() };
    let request = PlanRequest { job, ..PlanRequest::default() };
    PreparedPlan::new(request.plan("cover", bytes, machine, &mut |_| {}).unwrap())
}

fn run(dialect: DialectName, seed: u64) -> SimRun {
    SimRun {
        machine: machine(),
        dialect,
        seed,
        baud: 38_400,
        latency: Duration::from_millis(20),
        ..SimRun::default()
    }
}

fn session(entry: EntryMove, dialect: DialectName, seed: u64) -> SimResult {
    let run = run(dialect, seed);
    let operator = operator::named("wall", 20.0, seed).unwrap();
    run_simulated(work(entry), &run, operator, Box::new(NoEventLog), &mut |_, _, _| Going::On).unwrap()
}

#[test]
fn dialect_of_two_axes_is_refused() {
    let run = SimRun { machine: machine(), dialect: DialectName::Venus, ..SimRun::default() };
    let refused = Scene::of(work(EntryMove::Plunge), &run).unwrap_err().to_string();
    assert!(refused.starts_with("the plan has depths, and the dialect venus moves two axes"), "{refused}");
}

#[test]
fn plan_for_two_axes_is_refused_by_a_dialect_whose_lines_state_a_height() {
    let bytes = include_bytes!("../../cli/drawings/cover.dxf");
    let flat = PlanRequest::default().plan("cover", bytes, &machine(), &mut |_| {}).unwrap();
    let dialect = DialectName::named(DESCRIBED).unwrap();
    let run = SimRun { machine: machine(), dialect, ..SimRun::default() };
    let refused = Scene::of(PreparedPlan::new(flat), &run).unwrap_err().to_string();
    assert!(refused.starts_with("each motion of the dialect"), "{refused}");
}

#[test]
fn whole_part_is_cut_from_solid_stock_by_a_plunging_operator() {
    let (ramp, plunge) = (EntryMove::default(), EntryMove::Plunge);
    let sessions = [("grbl", ramp), ("grblhal", plunge), ("zaber", plunge), (DESCRIBED, plunge)];
    for (dialect, entry) in sessions {
        let result = session(entry, DialectName::named(dialect).unwrap(), 3);
        let facts = &result.facts;
        assert_eq!(facts.deepest_mm, Some(0.0), "{dialect}: {facts:?}");
        assert_eq!(facts.outcome.to_string(), "complete: 4 of 4 contours cut", "{dialect}: {facts:?}");
        check_stock(&[result.samples]);
    }
}

/// The controller starts the spindle before the tool goes into the stock, and no answer to a switch counts for a
/// motion: the part is complete.
#[test]
fn spindle_is_switched_by_the_controller() {
    for dialect in [DialectName::Grbl, DialectName::GrblHal] {
        let machine = MachineProfile { spindle_rpm: Some(10_000), ..machine() };
        let work = work_on(&machine, EntryMove::default());
        let run = SimRun { machine, ..run(dialect, 5) };
        let mut contours = 0;
        let mut watch = |supervisor: &Supervisor, _: &CollisionMonitor, _: Time| {
            let low = supervisor.height_mm().is_some_and(|height| height < 0.0);
            assert!(!low || supervisor.spindle_runs() == Some(true), "{:?}", supervisor.height_mm());
            contours += u32::from(supervisor.phase() == Phase::Contouring);
            Going::On
        };
        let operator = operator::named("wall", 10.0, 5).unwrap();
        let facts = run_simulated(work, &run, operator, Box::new(NoEventLog), &mut watch).unwrap().facts;
        assert_eq!(facts.outcome.to_string(), "complete: 4 of 4 contours cut", "{facts:?}");
        assert!(facts.deepest_mm == Some(0.0) && contours > 0, "{facts:?}");
    }
}

#[test]
fn interrupted_part_is_finished_at_the_depth_where_it_stopped() {
    let mut progress = Progress::default();
    let mut sessions = Vec::new();
    for part in 0..4_u64 {
        let last = part == 3;
        let run = SimRun { progress, ..run(DialectName::Grbl, 11 + part) };
        let operator = operator::named("wall", 5.0, 11 + part).unwrap();
        let mut contouring = 0;
        // Each session but the last stops in a contour, later than the one before it.
        let mut watch = |supervisor: &Supervisor, _: &CollisionMonitor, _: Time| {
            contouring += u64::from(supervisor.phase() == Phase::Contouring);
            if last || contouring < 1500 * (part + 1) { Going::On } else { Going::Halt }
        };
        let result =
            run_simulated(work(EntryMove::default()), &run, operator, Box::new(NoEventLog), &mut watch)
                .unwrap();
        assert_eq!(result.facts.deepest_mm, Some(0.0), "{:?}", result.facts);
        let outcome = result.facts.outcome.to_string();
        assert_eq!(outcome.starts_with("complete"), last, "{part}: {outcome}");
        progress = result.facts.progress;
        sessions.push(result.samples);
    }
    check_stock(&sessions);
}

/// Distance of a point from a rectangle with rounded corners, mm: negative inside.
fn beside([x0, y0, x1, y1]: [f64; 4], corner: f64, at: Mm2) -> f64 {
    let low = Mm2::new(x0 + corner, y0 + corner) - at;
    let high = at - Mm2::new(x1 - corner, y1 - corner);
    let out = low.max(high);
    let outside = out.max(Mm2::ZERO).length();
    outside + out.x.max(out.y).min(0.0) - corner
}

/// Cuts solid stock along the true ways of the tool in some sessions, and compares each cell with the drawing's
/// shapes. Nothing here comes from the plan but the tool.
fn check_stock(sessions: &[Vec<Sample>]) {
    let bounds = Box2 { low: Mm2::new(-4.0, -4.0), high: Mm2::new(84.0, 54.0) };
    let mut stock = StockMap::solid(bounds, 3.0);
    for pair in sessions.iter().flat_map(|samples| samples.windows(2)) {
        stock.cut([pair[0].position_mm, pair[1].position_mm], 3.0);
    }
    // A cell this far from every wall is on one side of it, and the finishing contour passed over it.
    let near = 2.0 * stock.cell_mm();
    let (mut cut, mut kept) = (0, 0);
    for (at, height_mm) in stock.cells() {
        let outline = beside([0.0, 0.0, 80.0, 50.0], 6.0, at);
        let hole = (at.distance(Mm2::new(15.0, 25.0)) - 6.0).min(at.distance(Mm2::new(66.0, 25.0)) - 5.0);
        let pocket = beside([28.0, 12.0, 54.0, 38.0], 5.0, at);
        if [outline, hole, pocket].iter().any(|distance| distance.abs() < near) {
            continue;
        }
        let through = outline > 0.0 || hole < 0.0;
        if through && outline < 5.5 {
            assert!(height_mm <= -6.0, "{at} stands at {height_mm}");
            cut += 1;
        } else if !through && pocket < 0.0 {
            assert!(height_mm >= -3.0, "{at} was cut to {height_mm}");
            // The contour along the wall of the pocket is as wide as the tool.
            assert!(pocket < -5.5 || height_mm < -2.9, "{at} stands at {height_mm}");
            kept += 1;
        } else if !through {
            assert!(height_mm >= 0.0, "{at} was cut to {height_mm}");
            kept += 1;
        }
    }
    assert!(cut > 10_000 && kept > 50_000, "{cut} cells cut and {kept} kept");
}

/// An operator who crosses to a contour, and gives inputs at these intervals.
struct Errand {
    every: Duration,
    /// The session lets the operator steer.
    steers: bool,
    given: bool,
}

impl Operator for Errand {
    fn input(&mut self, view: &OperatorView, _now: Time) -> OperatorInput {
        self.steers = view.phase.is_steered();
        OperatorInput::default()
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        let gives = self.steers && !std::mem::replace(&mut self.given, self.steers);
        gives.then_some(OperatorCommand::Cross { contour: 3 })
    }

    fn every(&self) -> Duration {
        self.every
    }
}

/// The way of the tool in the plane, in 20 s, mm.
fn crossed_mm(every: Duration) -> f64 {
    let run = SimRun { machine: machine(), ..SimRun::default() };
    let mut places = Vec::new();
    let mut watch = |supervisor: &Supervisor, _: &CollisionMonitor, now: Time| {
        if supervisor.phase().is_steered()
            && let Some(at) = supervisor.position()
        {
            places.push(point_mm(at.point));
        }
        if now.elapsed().as_secs() < 20 { Going::On } else { Going::Halt }
    };
    let operator = Box::new(Errand { every, steers: false, given: false });
    run_simulated(work(EntryMove::Plunge), &run, operator, Box::new(NoEventLog), &mut watch).unwrap();
    (*places.last().unwrap() - places[0]).length()
}

#[test]
fn errand_goes_on_only_while_the_operator_gives_inputs() {
    let (crossed, stopped) = (crossed_mm(Duration::from_millis(10)), crossed_mm(Duration::from_secs(60)));
    assert!(crossed > 30.0 && stopped < 10.0, "{crossed} mm, and {stopped} mm without inputs");
}
