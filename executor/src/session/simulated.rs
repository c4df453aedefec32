//! A whole session on the simulated machine, watched by the witness.

use std::time::Duration;

use keepout_kernel::Point;
use keepout_planner::job::contour_job;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{mm, point_mm};
use thiserror::Error;

use super::coverage::coverage;
use super::log::{Log, LogError};
use super::place::{PlaceError, place_on_table, start_inside};
use super::report::RunFacts;
use super::run::{Clock, Ended, RealClock, Session, VirtualClock};
use crate::link::dialect::Grbl;
use crate::link::port::{Port, PortError};
use crate::link::serial::Serial;
use crate::operator::Operator;
use crate::sim::witness::Witness;
use crate::sim::{Sample, SampleKind, SimMachine, SimSettings, VirtualPort};
use crate::supervisor::{Options, Supervisor};
use crate::time::Time;

/// How the simulated machine is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// In virtual time, as fast as the computer goes.
    Virtual,
    /// Behind a pty opened like a serial port, in real time.
    Pty,
}

/// A run on the simulated machine.
#[derive(Clone, Debug, PartialEq)]
pub struct SimRun {
    /// The machine.
    pub machine: MachineProfile,
    /// How it is reached.
    pub link: Link,
    /// Baud rate of the line.
    pub baud: u32,
    /// Added delay each way.
    pub latency: Duration,
    /// Seed of the tool's error.
    pub seed: u64,
    /// Feed of the contour, mm/min.
    pub feed_mm_min: u32,
    /// Longest duration, machine time.
    pub limit: Duration,
    /// Where the tool is let down, drawing coordinates, when it does not come from the home position.
    pub start: Option<Point>,
    /// Machine coordinates of the drawing's origin, mm; the middle of the table when not given.
    pub origin_mm: Option<(f64, f64)>,
}

impl Default for SimRun {
    fn default() -> Self {
        Self {
            machine: MachineProfile::simulated(),
            link: Link::Virtual,
            baud: 115_200,
            latency: Duration::from_millis(1),
            seed: 1,
            feed_mm_min: 900,
            limit: Duration::from_secs(3600),
            start: None,
            origin_mm: None,
        }
    }
}

/// What came of a simulated run.
#[derive(Debug)]
pub struct SimResult {
    /// The figures.
    pub facts: RunFacts,
    /// The true tool positions while it moved, drawing coordinates.
    pub samples: Vec<Sample>,
    /// The plan.
    pub plan: CertifiedPlan,
    /// Positions that the witness watched.
    pub watched: u64,
}

/// Why a simulated run could not begin or go on.
#[derive(Debug, Error)]
pub enum SimError {
    /// The drawing does not lie on the table.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// There is no pty.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The log failed.
    #[error(transparent)]
    Log(#[from] LogError),
}

/// Most samples that are kept for the picture; beyond it every other one is dropped.
const SAMPLES_MAX: usize = 2_000_000;

/// After the session's end the machine is watched for this long, and the line's latency.
const SETTLE: Duration = Duration::from_millis(2500);

/// Called after every round with the supervisor, the witness and the time.
pub type Watch<'a> = dyn FnMut(&Supervisor, &Witness, Time) + 'a;

/// Runs a whole session on the simulated machine. `prepare` may touch the supervisor before the start.
///
/// # Errors
/// [`SimError`] when the job does not fit the table, there is no pty, or the log can not be written on.
pub fn run_simulated(
    plan: CertifiedPlan,
    run: &SimRun,
    operator: Box<dyn Operator + Send>,
    log: Log,
    prepare: impl FnOnce(&mut Supervisor),
    watch: &mut Watch<'_>,
) -> Result<SimResult, SimError> {
    let place = place_on_table(&plan, &run.machine, run.origin_mm)?;
    let home = (-1.0, -1.0);
    let start = match run.start {
        Some(point) => Some(point),
        None if comes_from_home(&plan, &place, home) => None,
        None => Some(start_inside(&plan)?),
    };
    if let Some(at) = start {
        if !place.stroke.holds(at) {
            return Err(PlaceError::Start { at, reason: "it is beyond the machine's travel".into() }.into());
        }
        plan.part
            .free_point(at, plan.roughing)
            .map_err(|blocked| PlaceError::Start { at, reason: blocked.to_string() })?;
    }
    let start_mm = match start {
        Some(point) => point_mm(point.translated(place.offset).map_err(PlaceError::from)?),
        None => home,
    };
    let settings = SimSettings {
        machine: run.machine.clone(),
        start_mm,
        homed: start.is_some(),
        homing: Duration::from_secs(1),
        work_offset_mm: (-37.25, -21.5),
    };
    let options = Options {
        feed_mm_min: run.feed_mm_min,
        home: start.is_none(),
        stroke: place.stroke,
        answer_within: Duration::from_secs(5) + run.latency * 4,
        steps_per_mm: plan.plan.machine.steps_per_mm,
        arc_tolerance_mm: plan.plan.machine.arc_tolerance_mm,
    };
    let witness = Witness::new(plan.part.clone(), plan.plan.tool_radius, place.offset);
    let mut eye = Eye { witness, samples: Vec::new(), every: 1, seen: 0, offset: point_mm_of(place.offset) };
    let mut supervisor = Supervisor::new(plan, options);
    prepare(&mut supervisor);
    let machine = SimMachine::new(settings, run.baud, run.latency, run.seed);
    let dialect = Grbl::new(place.offset);
    let (ended, seconds, supervisor) = match run.link {
        Link::Virtual => {
            let mut session = Session::new(supervisor, dialect, VirtualPort { machine }, operator, log);
            let take = |session: &mut Session<'_, VirtualPort>| session.port().machine.take_samples();
            drive(&mut session, &mut VirtualClock::default(), run, &mut eye, take, watch)
                .map(|(ended, seconds)| (ended, seconds, session.supervisor))?
        }
        Link::Pty => on_pty(supervisor, dialect, operator, log, machine, run, &mut eye, watch)?,
    };
    Ok(result_of(supervisor, ended, seconds, run, eye))
}

#[cfg(unix)]
#[expect(clippy::too_many_arguments, reason = "the pieces of one session, handed over once")]
fn on_pty(
    supervisor: Supervisor,
    dialect: Grbl,
    operator: Box<dyn Operator + Send>,
    log: Log,
    machine: SimMachine,
    run: &SimRun,
    eye: &mut Eye,
    watch: &mut Watch<'_>,
) -> Result<(Ended, f64, Supervisor), SimError> {
    let pty = crate::sim::pty::PtyMachine::start(machine)?;
    let port = Serial::open(pty.name(), run.baud)?;
    let mut session = Session::new(supervisor, dialect, port, operator, log);
    let take = |_: &mut Session<'_, Serial>| pty.take_samples();
    let (ended, seconds) = drive(&mut session, &mut RealClock::default(), run, eye, take, watch)?;
    Ok((ended, seconds, session.supervisor))
}

#[cfg(not(unix))]
#[expect(clippy::too_many_arguments, reason = "the pieces of one session, handed over once")]
fn on_pty(
    _: Supervisor,
    _: Grbl,
    _: Box<dyn Operator + Send>,
    _: Log,
    _: SimMachine,
    _: &SimRun,
    _: &mut Eye,
    _: &mut Watch<'_>,
) -> Result<(Ended, f64, Supervisor), SimError> {
    Err(PortError::Open { name: "pty".into(), reason: "this system has no ptys".into() }.into())
}

fn point_mm_of(v: keepout_kernel::Vector) -> (f64, f64) {
    (mm(v.dx), mm(v.dy))
}

/// Whether the tool can stand at the home position, and finds something to finish from there.
fn comes_from_home(plan: &CertifiedPlan, place: &super::place::Placement, home: (f64, f64)) -> bool {
    let back = keepout_kernel::Vector { dx: -place.offset.dx, dy: -place.offset.dy };
    let Ok(point) = keepout_planner::units::point_from_mm(home).and_then(|point| point.translated(back))
    else {
        return false;
    };
    plan.part.free_point(point, plan.roughing).is_ok() && contour_job(plan, point, place.stroke).is_ok()
}

/// The witness, and what is kept for the picture.
struct Eye {
    witness: Witness,
    samples: Vec<Sample>,
    every: usize,
    seen: usize,
    offset: (f64, f64),
}

impl Eye {
    fn take(&mut self, samples: Vec<Sample>) {
        for sample in samples {
            self.witness.watch(&sample);
            if sample.kind == SampleKind::Rest {
                continue;
            }
            self.seen += 1;
            if !self.seen.is_multiple_of(self.every) {
                continue;
            }
            let (x, y) = sample.position_mm;
            self.samples.push(Sample { position_mm: (x - self.offset.0, y - self.offset.1), ..sample });
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
    eye: &mut Eye,
    take: impl Fn(&mut Session<'_, P>) -> Vec<Sample>,
    watch: &mut Watch<'_>,
) -> Result<(Ended, f64), LogError> {
    let mut last = Time::ZERO;
    let ended = session.run(clock, run.limit, |session, now| {
        let samples = take(session);
        eye.take(samples);
        watch(&session.supervisor, &eye.witness, now);
        last = now;
    })?;
    // What is still under way is watched to its end: the last commands arrive, and the tool comes to rest.
    let rest = last.after(run.latency + SETTLE);
    loop {
        let now = clock.now();
        session.drain(now);
        let samples = take(session);
        eye.take(samples);
        if now >= rest {
            return Ok((ended, last.seconds()));
        }
        clock.wait();
    }
}

fn result_of(supervisor: Supervisor, ended: Ended, seconds: f64, run: &SimRun, eye: Eye) -> SimResult {
    let witness = eye.witness;
    let finished = supervisor.finished().len();
    let coverage = (finished > 0).then(|| coverage(supervisor.plan(), witness.cut_paths()));
    let setting = format!(
        "{}, {} baud, {} ms added each way, {}",
        run.machine.name,
        run.baud,
        run.latency.as_millis(),
        if run.link == Link::Pty { "pty" } else { "virtual time" }
    );
    let facts = RunFacts {
        ended,
        fault: supervisor.fault().map(ToString::to_string),
        seconds,
        counts: supervisor.counts(),
        loops: (finished, supervisor.plan().plan.loop_count()),
        unreached: supervisor.unreached(),
        deepest_mm: Some(witness.deepest().map_or(0.0, |incursion| incursion.depth_mm)),
        closest_mm: witness.closest_mm(),
        closest_by_hand_mm: witness.closest_by_hand_mm(),
        coverage,
        setting,
        notices: supervisor.notices().to_vec(),
    };
    let watched = witness.watched();
    SimResult { facts, samples: eye.samples, plan: supervisor.into_plan(), watched }
}
