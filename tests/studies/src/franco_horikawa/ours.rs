//! Keepout in the paper's experiment: sessions of the supervisor with the modules of the paper's Table 1,
//! over a serial line with the paper's baud rate.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::DialectName;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::{Going, NoEventLog, Sample, SampleKind};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_kernel::Point;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanParameters;
use keepout_planner::units::{mm, point_from_mm};
use keepout_sim::operator::{Model, ModelKind};
use keepout_sim::session::{Scene, SimResult, SimRun, Watch, run_scene};

use super::attempt::Attempt;
use super::paper::{BEGINNINGS, START_MM};
use super::scenario::{MachinedProfile, StudyError, machine};

/// Upper bound on the distance between tool and part on this machine, mm.
const FARTHEST_MM: f64 = 1000.0;
/// Baud rate of the paper's prototype, bits per second.
const BAUD: u32 = 9600;
/// Longest time of a trial without contact, s. A hundred delays of the line are added.
const LIMIT_S: f64 = 60.0;
/// Longest duration of roughing.
const SESSION: Duration = Duration::from_secs(7200);
/// Longest silence of the controller. Ten delays of the line are added, because commands wait behind motions
/// and their answers.
const ANSWER: Duration = Duration::from_secs(5);
/// Time without motion after which the tool counts as at rest at the wall, s. Sixteen delays of the line are
/// added: a change of velocity takes a cancel, its answer, two reports at rest, and the new motion.
const REST_S: f64 = 1.0;
/// Speed up to which attempts begin as near to the part as the paper's, mm/s.
const NEAR_MM_S: f64 = 20.0;
/// Largest start distance at higher speeds, mm.
const FAR_START_MM: f64 = 90.0;
/// Time for which the model continues after the guard first clips a jog, s: a random time in this range. Four
/// delays of the line are added. Then the model pushes against the wall.
const HAND_S: (f64, f64) = (1.0, 6.0);
/// Largest difference of two positions that count as equal, lattice units (10 µm).
const STILL: i32 = 1000;

/// The supervisor with the plan of a profile.
#[derive(Debug)]
pub struct Ours<'a> {
    /// The profile.
    pub shape: &'a MachinedProfile,
    /// The plan, ready for a session.
    pub work: PreparedPlan,
    machine: MachineProfile,
}

impl<'a> Ours<'a> {
    /// Plans the profile for the modules at a top speed of `speed_mm_s`.
    ///
    /// The plan has the smallest possible stock to leave. In jog mode the tool stays out of the part by the
    /// margin budget plus this stock.
    ///
    /// # Errors
    /// [`StudyError`] if no plan can be made.
    pub fn new(
        shape: &'a MachinedProfile,
        tool_diameter_mm: f64,
        speed_mm_s: f64,
    ) -> Result<Self, StudyError> {
        let machine = machine(speed_mm_s)?;
        let job = PlanParameters { tool_diameter_mm, stock_to_leave_mm: 0.0, ..PlanParameters::default() };
        let work = PreparedPlan::new(shape.plan(&machine, job)?);
        Ok(Self { shape, work, machine })
    }

    /// Distance that jogging keeps between the tool's edge and the part, mm: the margin budget and the
    /// smallest stock to leave.
    #[must_use]
    pub fn tolerance_mm(&self) -> f64 {
        let plan = &self.work.plan;
        mm(plan.roughing.units()) - mm(plan.plan.tool_radius.units())
    }

    /// Radius of the tool, mm.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        mm(self.work.plan.plan.tool_radius.units())
    }

    /// Top speed, mm/s.
    #[must_use]
    pub fn speed_mm_s(&self) -> f64 {
        self.machine.max_rate_mm_s
    }

    /// Path of the tool in the automatic finishing contour after some jogging, drawing coordinates, mm.
    ///
    /// # Errors
    /// [`StudyError`] if the session ends with a fault.
    pub fn contour(&self, seed: u64) -> Result<Vec<Mm2>, StudyError> {
        let mut random = fastrand::Rng::with_seed(seed);
        let start = self.shape.start(self.radius_mm(), START_MM, &mut random)?;
        let run = SimRun { limit: SESSION, ..self.run(start, Duration::from_millis(1), seed, None) };
        let operator = Model::new(ModelKind::Calm, 1.0, seed);
        let result = self.play(&run, Box::new(operator), &mut |_, _, _| Going::On)?;
        let cut = result.samples.iter().filter(|sample| sample.kind == SampleKind::Run);
        Ok(cut.map(|sample| sample.position_mm.plane()).collect())
    }

    /// Runs roughing until the operator ends the session.
    ///
    /// # Errors
    /// [`StudyError`] if the session ends for another reason.
    pub fn session(
        &self,
        start: Mm2,
        operator: Box<dyn Operator + Send>,
        (seed, latency): (u64, Duration),
        servo: Option<&DriveProfile>,
    ) -> Result<Attempt, StudyError> {
        let run = SimRun { limit: SESSION, ..self.run(start, latency, seed, servo) };
        let result = self.play(&run, operator, &mut |_, _, _| Going::On)?;
        if !result.facts.outcome.is_by_operator() {
            let what = format!("{}, roughing, {latency:?}, seed {seed}", self.shape.name);
            return Err(StudyError::Ended { what, reason: result.facts.outcome.to_string() });
        }
        Ok(self.attempt_of(&result, false, result.facts.seconds))
    }

    /// Runs one attempt over a line with the delay `latency` each way. An operator who does not reach the
    /// part starts again from another place.
    ///
    /// # Errors
    /// [`StudyError`] if no start is free, a session ends with a fault, or no operator reaches the part.
    pub fn attempt(
        &self,
        kind: ModelKind,
        (seed, latency): (u64, Duration),
        servo: Option<&DriveProfile>,
    ) -> Result<Attempt, StudyError> {
        let mut random = fastrand::Rng::with_seed(seed);
        for _ in 0..BEGINNINGS {
            let start = self.shape.start(self.radius_mm(), self.start_mm(), &mut random)?;
            let at_wall = Arc::new(AtomicBool::new(false));
            let model = Model::new(kind, f64::INFINITY, random.u64(..));
            let operator = Insistent { model, at_wall: Arc::clone(&at_wall) };
            let on_s = HAND_S.0 + (HAND_S.1 - HAND_S.0) * random.f64();
            let run = self.run(start, latency, random.u64(..), servo);
            let mut rest = Rest::new(at_wall, latency, on_s);
            let result =
                self.play(&run, Box::new(operator), &mut |supervisor, _, now| rest.watch(supervisor, now))?;
            if rest.rests || result.facts.deepest_mm != Some(0.0) {
                return Ok(self.attempt_of(&result, servo.is_some(), rest.since.elapsed().as_secs_f64()));
            }
        }
        let what = format!("{}, {kind:?}, {latency:?}, seed {seed}", self.shape.name);
        Err(StudyError::Ended {
            what,
            reason: format!("the tool did not reach the part in {BEGINNINGS} starts"),
        })
    }

    /// The attempt by the results of the collision monitor. The monitor does not measure large distances.
    /// Then the nearest sample gives the distance.
    fn attempt_of(&self, result: &SimResult, driven: bool, seconds: f64) -> Attempt {
        let jogs = result.samples.iter().filter(|sample| sample.kind == SampleKind::Jog);
        let path: Vec<Mm2> = jogs.map(|sample| sample.position_mm.plane()).collect();
        let clearance = |at: &Mm2| self.shape.clearance(*at) - self.radius_mm();
        // Without simulated drives the tool jumps from sample to sample, so its speed has no meaning.
        let fastest_mm_s = driven.then(|| fastest(&result.samples));
        let nearest = || path.iter().map(clearance).fold(FARTHEST_MM, f64::min);
        Attempt {
            depth_mm: result.facts.deepest_mm.unwrap_or(0.0),
            closest_mm: result.facts.closest_mm.unwrap_or_else(nearest),
            seconds,
            path,
            false_alarms: 0,
            fastest_mm_s,
        }
    }

    fn play(
        &self,
        run: &SimRun,
        operator: Box<dyn Operator + Send>,
        watch: &mut Watch<'_>,
    ) -> Result<SimResult, StudyError> {
        let mut scene = Scene::of(self.work.clone(), run)?;
        scene.setup.options.answer_within = ANSWER + run.latency * 10;
        let _work = self.work.clone();
        let result = run_scene(run, scene, operator, Box::new(NoEventLog), watch)?;
        if result.facts.outcome.fault().is_some() {
            let what = format!("{}, {:?}, seed {}", self.shape.name, run.latency, run.seed);
            let reason = result.facts.outcome.fault().unwrap_or_default().into();
            return Err(StudyError::Ended { what, reason });
        }
        Ok(result)
    }

    /// Range of the start distances from the part, mm: as in the paper's system, and larger for a fast tool.
    fn start_mm(&self) -> (f64, f64) {
        if self.speed_mm_s() > NEAR_MM_S { (START_MM.0, FAR_START_MM) } else { START_MM }
    }

    /// The settings of a session that begins at `start`, at the paper's baud rate.
    fn run(&self, start: Mm2, latency: Duration, seed: u64, servo: Option<&DriveProfile>) -> SimRun {
        SimRun {
            machine: self.machine.clone(),
            servo: servo.cloned(),
            dialect: DialectName::Grbl,
            baud: BAUD,
            latency,
            seed,
            limit: Duration::from_secs_f64(LIMIT_S) + latency * 100,
            start: point_from_mm(start).ok(),
            ..SimRun::default()
        }
    }
}

/// Highest jog speed of the tool, mm/s, over intervals of at least 0.01 s.
fn fastest(samples: &[Sample]) -> f64 {
    let mut fastest = 0.0_f64;
    let Some(mut since) = samples.first() else { return fastest };
    for sample in samples {
        let seconds = sample.at.since(since.at).as_secs_f64();
        if seconds >= 0.01 {
            if sample.kind == SampleKind::Jog && since.kind == SampleKind::Jog {
                fastest = fastest.max(sample.position_mm.distance(since.position_mm) / seconds);
            }
            since = sample;
        }
    }
    fastest
}

/// A model that pushes against the wall after it has jogged there for a while.
struct Insistent {
    model: Model,
    at_wall: Arc<AtomicBool>,
}

impl Operator for Insistent {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        let input = self.model.input(view, now);
        let (true, Some(at), Some(wall)) =
            (self.at_wall.load(Ordering::Relaxed), view.position_mm, view.wall_mm)
        else {
            return input;
        };
        OperatorInput { velocity: at.direction_to(wall), ..input }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.model.command()
    }
}

/// Decides when the operator pushes against the wall, and detects when the tool is at rest there.
struct Rest {
    at_wall: Arc<AtomicBool>,
    on_s: f64,
    for_s: f64,
    kept: Option<Time>,
    at: Option<Point>,
    since: Time,
    rests: bool,
}

impl Rest {
    fn new(at_wall: Arc<AtomicBool>, latency: Duration, on_s: f64) -> Self {
        let latency_s = latency.as_secs_f64();
        Self {
            at_wall,
            on_s: on_s + 4.0 * latency_s,
            for_s: REST_S + 16.0 * latency_s,
            kept: None,
            at: None,
            since: Time::ZERO,
            rests: false,
        }
    }

    fn watch(&mut self, supervisor: &Supervisor, now: Time) -> Going {
        if supervisor.counts().clipped == 0 {
            return Going::On;
        }
        let kept = *self.kept.get_or_insert(now);
        if now.since(kept).as_secs_f64() < self.on_s {
            return Going::On;
        }
        self.at_wall.store(true, Ordering::Relaxed);
        let here = supervisor.position().map(|place| place.point);
        let moved = self.at.zip(here).is_none_or(|(before, here)| {
            let step = here.minus(before);
            step.dx.abs().max(step.dy.abs()) > STILL
        });
        if moved {
            (self.at, self.since) = (here, now);
        }
        self.rests = now.since(self.since).as_secs_f64() > self.for_s;
        if self.rests { Going::Halt } else { Going::On }
    }
}
