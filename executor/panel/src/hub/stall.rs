//! A panel that stalls for a minute while a contour is cut: the session loop does not wait for it.

use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

use keepout_executor::session::{Going, NoEventLog, VirtualClock};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::drawing::read_file;
use keepout_planner::plan::PlanParameters;
use keepout_planner::request::PlanRequest;
use keepout_sim::VirtualPort;
use keepout_sim::operator::{Model, ModelKind};
use keepout_sim::session::{Scene, SimRun};

use super::*;
use crate::gate::{MessageOrder, Steer};

/// A thread that keeps every lock of the panel until it is told to let go.
struct Stall(Sender<()>, JoinHandle<()>);

impl Stall {
    fn of(hub: &Hub) -> Self {
        let ((held, holds), (end, ended)) = (channel(), channel());
        let hub = hub.clone();
        let keep = move || {
            let _desk = hub.desk();
            let _slot = hub.0.session.hold();
            held.send(()).unwrap();
            // A session loop that waits for these locks would never end the stall.
            ended.recv_timeout(Duration::from_secs(60)).expect("the session loop waits for the panel");
        };
        let thread = std::thread::spawn(keep);
        holds.recv().unwrap();
        Self(end, thread)
    }

    fn end(self) {
        self.0.send(()).unwrap();
        self.1.join().unwrap();
    }
}

/// A person at a screen, who touches the part for a contour. Then the panel stalls for a while.
struct AtScreen {
    person: Model,
    clock: Arc<AtomicU64>,
    hub: Hub,
    operator: PanelOperator,
    client: ClientId,
    sequence: u64,
    contouring: Option<Time>,
    stall: Option<Stall>,
    stalls_for: Duration,
    /// How often the contour was held.
    holds: Arc<AtomicU64>,
}

impl AtScreen {
    fn says(&mut self, action: impl FnOnce(MessageOrder) -> PanelAction, now: Time) {
        self.sequence += 1;
        let order = MessageOrder { sequence: self.sequence, seen_us: now.micros() };
        self.hub.act(self.client, action(order), now).unwrap();
    }
}

impl Operator for AtScreen {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        self.clock.store(now.micros(), Ordering::Relaxed);
        let wish = self.person.input(view, now);
        if view.phase == Phase::Contouring && self.contouring.is_none() {
            self.contouring = Some(now);
            self.stall = Some(Stall::of(&self.hub));
        }
        let over = self.contouring.is_some_and(|since| now.since(since) > self.stalls_for);
        if over && let Some(stall) = self.stall.take() {
            stall.end();
        }
        if self.stall.is_none() {
            let held = wish.velocity != keepout_planner::Mm2::ZERO;
            let steer = Steer { held, velocity: wish.velocity, armed: wish.armed, ..Steer::default() };
            self.says(|order| PanelAction::Steer { order, steer }, now);
            if view.phase == Phase::Holding {
                let command = OperatorCommand::CycleStart;
                self.says(|order| PanelAction::Command { order, command }, now);
            }
        }
        self.operator.input(view, now)
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        let command = self.operator.command();
        self.holds.fetch_add(u64::from(command == Some(OperatorCommand::FeedHold)), Ordering::Relaxed);
        command
    }
}

/// Cuts the outline of a plate. Returns how often the contour was held, how many contours were cut, and the time, s.
fn cut(stalls_for: Duration) -> (u64, usize, f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/drawings/rounded_plate.dxf");
    let run = SimRun { feed_mm_min: 200, servo: None, ..SimRun::default() };
    let job = PlanParameters { tool_diameter_mm: 6.0, ..PlanParameters::default() };
    let request = PlanRequest { job, ..PlanRequest::default() };
    let plan = request.plan("plate", &read_file(&path).unwrap(), &run.machine, &mut |_| {}).unwrap();
    let scene = Scene::of(PreparedPlan::new(plan), &run).unwrap();
    let (clock, holds) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
    let hub = Hub::told(Arc::clone(&clock));
    let screen = AtScreen {
        person: Model::new(ModelKind::Calm, 1.0, 5),
        clock,
        operator: hub.operator(),
        client: hub.join(Time::ZERO),
        hub: hub.clone(),
        sequence: 0,
        contouring: None,
        stall: None,
        stalls_for,
        holds: Arc::clone(&holds),
    };
    let port = VirtualPort { machine: scene.machine(&run) };
    let mut session = scene.setup.session(port, Box::new(screen), Box::new(NoEventLog));
    let (mut window, mut last) = (hub.window(), Time::ZERO);
    let limit = Duration::from_secs(1200);
    let ran = session.run(&mut VirtualClock::default(), limit, |session, now| {
        window.show(session.supervisor());
        last = now;
        if session.supervisor().finished().is_empty() { Going::On } else { Going::Halt }
    });
    ran.unwrap();
    (holds.load(Ordering::Relaxed), session.supervisor().finished().len(), last.elapsed().as_secs_f64())
}

// Evidence for SR-28.
/// The loop goes on through a minute without the panel. After ten seconds of it the contour is held, and goes on when
/// the person says so.
#[test]
fn panel_that_stalls_for_a_minute_does_not_stop_the_session_loop() {
    let (holds, cut_all, took) = cut(Duration::ZERO);
    assert_eq!((holds, cut_all), (0, 1));
    let (holds, cut_short, as_long) = cut(Duration::from_secs(9));
    assert_eq!((holds, cut_short), (0, 1));
    assert!((as_long - took).abs() < 0.5, "{as_long} s, and {took} s without a stall");
    let (holds, cut_all, longer) = cut(Duration::from_secs(60));
    assert_eq!((holds, cut_all), (1, 1));
    let waited = longer - took;
    assert!((45.0..55.0).contains(&waited), "{waited} s longer: held from the tenth second to the sixtieth");
}
