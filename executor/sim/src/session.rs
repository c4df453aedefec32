//! A whole session on the simulated machine, under the collision monitor.

use std::sync::Arc;
use std::time::Duration;

use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::operator::Operator;
#[cfg(unix)]
use keepout_executor::session::RealClock;
use keepout_executor::session::outcome::JobOutcome;
#[cfg(not(unix))]
use keepout_executor::session::port::ClosedPort;
use keepout_executor::session::port::Port;
use keepout_executor::session::port::PortError;
#[cfg(unix)]
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{
    Clock, EventLog, EventLogError, Going, PlaceError, RunFacts, Sample, SampleKind, Session, SessionSetup,
    VirtualClock, coverage, place_on_table, start_inside,
};
use keepout_executor::supervisor::{Options, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_kernel::{Height, Point, Vector};
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::units::{mm, point_mm, vector_mm};
use keepout_planner::{Mm2, Mm3};
use thiserror::Error;

use crate::monitor::CollisionMonitor;
use crate::start::{check_start, comes_from_home};
use crate::{SimMachine, SimSettings, VirtualPort};

/// The link to the simulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// In virtual time, as fast as the computer runs.
    Virtual,
    /// Behind a pty, opened like a serial port, in real time.
    Pty,
}

/// A run on the simulated machine.
#[derive(Clone, Debug, PartialEq)]
pub struct SimRun {
    /// The machine.
    pub machine: MachineProfile,
    /// The feed drives. Without them, the tool is always at its commanded position.
    pub servo: Option<DriveProfile>,
    /// The link.
    pub link: Link,
    /// The controller's dialect.
    pub dialect: DialectName,
    /// Baud rate of the line.
    pub baud: u32,
    /// Added delay each way.
    pub latency: Duration,
    /// Seed of the positioning error.
    pub seed: u64,
    /// Contour feed, mm/min.
    pub feed_mm_min: u32,
    /// Longest machine time.
    pub limit: Duration,
    /// Where the tool is lowered, drawing coordinates. `None` to come from the home position.
    pub start: Option<Point>,
    /// Machine coordinates of the drawing's origin, mm; `None` for the middle of the table.
    pub origin_mm: Option<Mm2>,
    /// Machine coordinate of the top of the part, mm; `None` for a place near the end of the travel.
    pub top_mm: Option<f64>,
    /// The progress of earlier sessions on the plan's contours.
    pub progress: Progress,
}

impl Default for SimRun {
    fn default() -> Self {
        Self {
            machine: MachineProfile::simulated(),
            servo: DriveProfile::simulated().ok(),
            link: Link::Virtual,
            dialect: DialectName::Grbl,
            baud: 115_200,
            latency: Duration::from_millis(1),
            seed: 1,
            feed_mm_min: 900,
            limit: Duration::from_secs(3600),
            start: None,
            origin_mm: None,
            top_mm: None,
            progress: Progress::default(),
        }
    }
}

/// The result of a simulated run.
#[derive(Debug)]
pub struct SimResult {
    /// The figures.
    pub facts: RunFacts,
    /// The true tool positions in motion, drawing coordinates.
    pub samples: Vec<Sample>,
    /// The plan.
    pub work: PreparedPlan,
    /// The number of positions that the monitor checked.
    pub watched: u64,
}

/// Why a simulated run failed.
#[derive(Debug, Error)]
pub enum SimError {
    /// The drawing does not fit on the table, or the tool cannot start.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The system provides no pty.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The log failed.
    #[error(transparent)]
    EventLog(#[from] EventLogError),
}

/// Height of the tool at the home position, machine coordinates, mm, below the end of travel.
const HOME_UP_MM: f64 = -1.0;

/// Most samples kept for the picture. Beyond this, every other one is dropped.
const SAMPLES_MAX: usize = 2_000_000;

/// The monitor continues for this time, plus the line's latency, after the session's end.
const SETTLE: Duration = Duration::from_millis(2500);

/// A callback after every round, with the supervisor, the monitor and the time.
pub type Watch<'a> = dyn FnMut(&Supervisor, &CollisionMonitor, Time) -> Going + 'a;

/// A simulated session before it begins.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The session.
    pub setup: SessionSetup,
    /// The machine.
    pub sim: SimSettings,
}

impl Scene {
    /// Places the drawing on the table, and the tool at its start.
    ///
    /// # Errors
    /// [`PlaceError`] if the job does not fit, or if the tool cannot start at the given point.
    pub fn of(work: PreparedPlan, run: &SimRun) -> Result<Self, PlaceError> {
        let plan = &*work.plan;
        let place = place_on_table(plan, &run.machine, run.origin_mm)?.with_top(plan, run.top_mm)?;
        place.moved_by(&run.dialect)?;
        let home = Mm2::new(-1.0, -1.0);
        let start = match run.start {
            Some(point) => Some(point),
            // From above the tool reaches every place.
            None if plan.plan.relief.is_some() => None,
            None if comes_from_home(plan, &place, home) => None,
            None => Some(start_inside(plan)?),
        };
        if let Some(at) = start {
            check_start(plan, &place, at)?;
        }
        let up_mm = if run.machine.z.is_some() { HOME_UP_MM } else { 0.0 };
        let start_mm = match start {
            Some(point) => point_mm(point.translated(place.offset)?),
            None => home,
        };
        let sim = SimSettings {
            homed: start.is_some(),
            ..SimSettings::of(run.machine.clone(), start_mm.at_height(up_mm))
        };
        let options = Options {
            feed_mm_min: run.feed_mm_min,
            home: start.is_none(),
            travel: place.travel,
            heights: place.heights(),
            answer_within: Duration::from_secs(5) + run.latency * 4,
            baud: run.baud,
            progress: run.progress.clone(),
        };
        let config =
            DialectConfig { travel_mm: Some(run.machine.travel_mm), ..place.config(&plan.plan.machine) };
        let setup = SessionSetup { work, options, dialect: run.dialect.clone(), config };
        Ok(Self { setup, sim })
    }

    /// The machine coordinates of the drawing's origin.
    #[must_use]
    pub fn offset(&self) -> Vector {
        self.setup.config.offset
    }

    /// The simulated machine of the run. Its positioning error follows from the run's seed.
    #[must_use]
    pub fn machine(&self, run: &SimRun) -> SimMachine {
        let line = (run.baud, run.latency);
        SimMachine::wandering(self.sim.clone(), &run.dialect, line, run.seed, run.servo.as_ref())
    }

    /// A collision monitor for the part and the tool.
    #[must_use]
    pub fn monitor(&self) -> CollisionMonitor {
        let plan = &self.setup.work.plan;
        CollisionMonitor::new(
            Arc::clone(self.setup.work.levels()),
            plan.plan.tool_radius,
            (self.offset(), self.zero_height()),
        )
    }

    /// The machine's height where the drawing's height is zero.
    fn zero_height(&self) -> Height {
        self.setup.config.z.map_or(Height::ZERO, |z| z.zero)
    }
}

/// Runs a whole session on the simulated machine.
///
/// # Errors
/// [`SimError`] if the job does not fit the table, the system provides no pty, or the log cannot be written.
pub fn run_simulated(
    work: PreparedPlan,
    run: &SimRun,
    operator: Box<dyn Operator + Send>,
    event_log: Box<dyn EventLog>,
    watch: &mut Watch<'_>,
) -> Result<SimResult, SimError> {
    run_scene(run, Scene::of(work, run)?, operator, event_log, watch)
}

/// Runs a whole session, as [`run_simulated`], in a given scene.
///
/// # Errors
/// [`SimError`] if the system provides no pty, or the log cannot be written.
pub fn run_scene(
    run: &SimRun,
    scene: Scene,
    operator: Box<dyn Operator + Send>,
    event_log: Box<dyn EventLog>,
    watch: &mut Watch<'_>,
) -> Result<SimResult, SimError> {
    let offset = vector_mm(scene.offset()).at_height(mm(scene.zero_height().units()));
    let mut monitored =
        MonitoredSamples { monitor: scene.monitor(), samples: Vec::new(), every: 1, seen: 0, offset };
    let machine = scene.machine(run);
    let setup = scene.setup;
    let (ended, seconds, supervisor) = match run.link {
        Link::Virtual => {
            let mut session = setup.session(VirtualPort { machine }, operator, event_log);
            let take = |session: &mut Session<'_, VirtualPort>, into: &mut Vec<Sample>| {
                if let Some(port) = session.port() {
                    port.machine.take_samples(into);
                }
            };
            let (ended, seconds) =
                drive(&mut session, &mut VirtualClock::default(), run, &mut monitored, take, watch)?;
            (ended, seconds, session.into_supervisor())
        }
        Link::Pty => on_pty(setup, operator, event_log, machine, run, &mut monitored, watch)?,
    };
    Ok(result_of(supervisor, ended, seconds, run, monitored))
}

#[cfg(unix)]
fn on_pty(
    setup: SessionSetup,
    operator: Box<dyn Operator + Send>,
    event_log: Box<dyn EventLog>,
    machine: SimMachine,
    run: &SimRun,
    monitored: &mut MonitoredSamples,
    watch: &mut Watch<'_>,
) -> Result<(JobOutcome, f64, Supervisor), SimError> {
    let pty = crate::pty::PtyMachine::start(machine)?;
    let port = Serial::open(pty.name(), run.baud)?;
    let mut session = setup.session(port, operator, event_log);
    let take = |_: &mut Session<'_, Serial>, into: &mut Vec<Sample>| into.append(&mut pty.take_samples());
    let (outcome, seconds) = drive(&mut session, &mut RealClock::default(), run, monitored, take, watch)?;
    Ok((outcome, seconds, session.into_supervisor()))
}

#[cfg(not(unix))]
fn on_pty(
    _: SessionSetup,
    _: Box<dyn Operator + Send>,
    _: Box<dyn EventLog>,
    _: SimMachine,
    _: &SimRun,
    _: &mut MonitoredSamples,
    _: &mut Watch<'_>,
) -> Result<(JobOutcome, f64, Supervisor), SimError> {
    Err(PortError::Open {
        name: "pty".into(),
        reason: "this system has no ptys".into(),
        closed: ClosedPort::Other,
    }
    .into())
}

/// The monitor, and the samples for the picture.
struct MonitoredSamples {
    monitor: CollisionMonitor,
    samples: Vec<Sample>,
    every: usize,
    seen: usize,
    offset: Mm3,
}

impl MonitoredSamples {
    fn take(&mut self, samples: &mut Vec<Sample>) {
        for sample in samples.drain(..) {
            self.monitor.watch(&sample);
            if sample.kind == SampleKind::Rest {
                continue;
            }
            self.seen += 1;
            if !self.seen.is_multiple_of(self.every) {
                continue;
            }
            self.samples.push(Sample { position_mm: sample.position_mm - self.offset, ..sample });
            if self.samples.len() >= SAMPLES_MAX {
                let mut keep = false;
                self.samples.retain(|_| {
                    keep = !keep;
                    keep
                });
                self.every *= 2;
            }
        }
    }
}

fn drive<P: Port>(
    session: &mut Session<'_, P>,
    clock: &mut impl Clock,
    run: &SimRun,
    monitored: &mut MonitoredSamples,
    take: impl Fn(&mut Session<'_, P>, &mut Vec<Sample>),
    watch: &mut Watch<'_>,
) -> Result<(JobOutcome, f64), EventLogError> {
    let mut last = Time::ZERO;
    let mut samples = Vec::new();
    let outcome = session.run(clock, run.limit, |session, now| {
        take(session, &mut samples);
        monitored.take(&mut samples);
        last = now;
        watch(session.supervisor(), &monitored.monitor, now)
    })?;
    // The monitor watches the motion to its end: the last commands arrive, and the tool comes to rest.
    let rest = last.after(run.latency + SETTLE);
    loop {
        let now = clock.now();
        session.drain(now);
        take(session, &mut samples);
        monitored.take(&mut samples);
        if now >= rest {
            return Ok((outcome, last.elapsed().as_secs_f64()));
        }
        clock.wait(rest);
    }
}

fn result_of(
    supervisor: Supervisor,
    outcome: JobOutcome,
    seconds: f64,
    run: &SimRun,
    monitored: MonitoredSamples,
) -> SimResult {
    let monitor = monitored.monitor;
    let finished = !supervisor.finished().is_empty();
    let coverage = finished.then(|| coverage(supervisor.plan(), monitor.cut_paths()));
    let setting = format!(
        "{}, {} baud, {} ms added each way, {}",
        run.machine.name,
        run.baud,
        run.latency.as_millis(),
        if run.link == Link::Pty { "pty" } else { "virtual time" }
    );
    let facts = RunFacts {
        deepest_mm: Some(monitor.deepest().map_or(0.0, |gouge| gouge.depth_mm)),
        closest_mm: monitor.closest_mm(),
        closest_by_hand_mm: monitor.closest_by_hand_mm(),
        coverage,
        setting,
        ..RunFacts::of(&supervisor, outcome, seconds)
    };
    let watched = monitor.watched();
    SimResult { facts, samples: monitored.samples, work: supervisor.work().clone(), watched }
}
