//! The paper's controller (sections 5 and 6): query the position, check for an invasion with tolerance T, and
//! then stop.
//!
//! It drives the simulated modules of this study only. It makes no command of Keepout and has no access to a
//! port.
//!
//! ```text
//! joystick ──> direction ──> motion of a fixed length ─────────────┐
//!    position query ── line ──> answer ── line ──> check ──> stop ── line ──> modules
//! ```
//!
//! We do not have the flow chart (Fig. 7). We read one round as follows: query the position, check it, then
//! send a stop. If no stop is necessary, the stick is tilted and the controller's queue has room, send one
//! "unitary movement" (section 3.1) in the direction of the stick (section 3.3: a direction, no speed).

use std::sync::Arc;

use keepout_drives::profile::DriveProfile;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::{Sample, SampleKind};
use keepout_executor::supervisor::{OperatorInput, Phase};
use keepout_guard::Time;
use keepout_kernel::{Height, Levels, ProhibitedRegion, Vector};
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanParameters;
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::operator::{Model, ModelKind};

use super::attempt::{Attempt, PEOPLE, operator_of, seed_of};
use super::delays::Delays;
use super::invasion::{Classified, Intervals, prohibited};
use super::modules::{Modules, STEP_S, SimulatedModules, Tables};
use super::scenario::{MachinedProfile, StudyError};

/// Range of distances between the tool's edge and the part at the start, mm.
pub const START_MM: (f64, f64) = (8.0, 30.0);
/// Largest number of starts of an attempt.
pub const BEGINNINGS: u32 = 1000;
/// Tilt above which the stick gives a direction.
const TILTED: f64 = 0.3;
/// Steps between two inputs of the operator.
const INPUT_STEPS: u64 = 10;
/// Steps between two samples of the collision monitor.
const LOOK_STEPS: u64 = 5;
/// Steps between two samples if the tool is farther from the part than [`FAR_MM`].
const LOOK_STEPS_FAR: u64 = 50;
/// Distance for the lower sample rate of the collision monitor, mm.
const FAR_MM: f64 = 8.0;
/// Longest time of a trial without contact, s.
const LIMIT_S: f64 = 60.0;
/// Longest duration of roughing, s.
const SESSION_S: f64 = 7200.0;
/// Longest time that the modules take to stop, s.
const REST_S: f64 = 20.0;

/// A profile in the form for the paper's controller, and the part for the collision monitor.
#[derive(Debug)]
pub struct Ground<'a> {
    /// The profile.
    pub shape: &'a MachinedProfile,
    part: ProhibitedRegion,
    radius_mm: f64,
    /// The profile enlarged by the radius, with the paper's construction.
    polygon: Vec<Mm2>,
    check: Intervals,
}

impl<'a> Ground<'a> {
    /// Enlarges the profile by the tool's radius (section 5.3), and sorts its segments by intervals (section
    /// 5.2).
    ///
    /// # Errors
    /// [`StudyError`] if the construction fails, or the part is invalid.
    pub fn new(
        shape: &'a MachinedProfile,
        tool_diameter_mm: f64,
        classified: Classified,
    ) -> Result<Self, StudyError> {
        let radius_mm = tool_diameter_mm / 2.0;
        let polygon = prohibited(&shape.corners, radius_mm, shape.side())
            .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })?;
        let job = PlanParameters { tool_diameter_mm, ..PlanParameters::default() };
        let part = ProhibitedRegion::clone(&shape.plan(&MachineProfile::simulated(), job)?.part);
        let check = Intervals::new(&polygon, classified);
        Ok(Self { shape, part, radius_mm, polygon, check })
    }

    /// Radius of the tool, mm.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Whether an invasion at `at` is a false alarm, caused by the extension of a segment: all segments are
    /// farther than the tolerance.
    fn is_false_alarm(&self, at: Mm2, tolerance_mm: f64) -> bool {
        let closed = self.polygon.iter().copied().zip(self.polygon.iter().copied().cycle().skip(1));
        let mut far = closed.map(|(from, to)| at.distance(at.nearest_on(from, to)));
        far.all(|far| far > tolerance_mm)
    }

    /// Whether a motion leads away from the nearest segment with the tool in its interval: to the tool's side, which
    /// the construction of the prohibited region knows (eq. (8)), or to a place where the check finds no invasion.
    /// Behind the line of the segment every motion does: the tool may come back, and around an outside corner it is
    /// not in the part.
    fn leads_away(&self, from: Mm2, motion: Mm2, tolerance_mm: f64) -> bool {
        let Some((segment, _)) = self.check.nearest(from) else { return true };
        let begin = self.polygon[segment];
        let outward = (self.polygon[(segment + 1) % self.polygon.len()] - begin).left();
        let behind = (from - begin).dot(outward) < 0.0;
        behind || motion.dot(outward) > 0.0 || !self.check.invades(from + motion, tolerance_mm)
    }

    /// Distance of the tool's edge from the part, mm. Negative in the part.
    fn clearance(&self, at: Mm2) -> f64 {
        self.shape.clearance(at) - self.radius_mm
    }
}

/// The paper's controller over a profile.
#[derive(Clone, Copy, Debug)]
pub struct Paper<'a> {
    /// The profile.
    pub ground: &'a Ground<'a>,
    /// Feed V, mm/s.
    pub feed_mm_s: f64,
    /// Tolerance T, mm.
    pub tolerance_mm: f64,
    /// Delay model.
    pub delays: Delays,
    /// The simulated modules that it moves. `None` for tables that follow with the lag of the delay model.
    pub machine: Option<(&'a MachineProfile, &'a DriveProfile)>,
}

impl<'a> Paper<'a> {
    /// Runs one attempt. After a false alarm, or if the operator does not reach the part, the operator starts
    /// again from another place.
    ///
    /// # Errors
    /// [`StudyError`] if no start is free, or no operator reaches the part.
    pub fn attempt(&self, kind: ModelKind, seed: u64) -> Result<Attempt, StudyError> {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut false_alarms = 0;
        for _ in 0..BEGINNINGS {
            let start = self.ground.shape.start(self.ground.radius_mm, START_MM, &mut random)?;
            let model = Model::new(kind, f64::INFINITY, random.u64(..));
            let tables = self.tables(start, seed);
            let mut scene = Scene::new(self, (start, tables), Box::new(model), Going::ToTheFirstStop);
            match scene.drive(&mut random) {
                End::Stopped => return Ok(Attempt { false_alarms, ..scene.attempt() }),
                End::FalseAlarm => false_alarms += 1,
                End::Over => {}
            }
        }
        let what = format!("{}, the paper's controller, {kind:?}, seed {seed}", self.ground.shape.name);
        Err(StudyError::Ended {
            what,
            reason: format!("the tool did not reach the part in {BEGINNINGS} starts"),
        })
    }

    /// Attempts with models of people. The row selects the random stream.
    pub fn attempts(
        self,
        (row, attempts, study): (u64, u64, u64),
    ) -> impl Iterator<Item = Result<Attempt, StudyError>> + use<'a> {
        (0..attempts)
            .map(move |number| self.attempt(operator_of(&PEOPLE, number), seed_of(study, row, number)))
    }

    /// The modules at rest at `start`.
    fn tables(&self, start: Mm2, seed: u64) -> Box<dyn Tables> {
        match self.machine {
            None => Box::new(Modules::new(start, self.feed_mm_s, self.delays.inertia_s)),
            Some((machine, drives)) => {
                Box::new(SimulatedModules::new(start, self.feed_mm_s, machine, drives, seed))
            }
        }
    }

    /// Runs roughing until the operator ends it. After a stop, the controller sends only motions away from the segment:
    /// as in section 2, where the brake is released "only if the operator tries to move the table backward".
    #[must_use]
    pub fn session(&self, start: Mm2, operator: Box<dyn Operator>, seed: u64) -> Attempt {
        let mut scene = Scene::new(self, (start, self.tables(start, seed)), operator, Going::OnAfterStops);
        scene.drive(&mut fastrand::Rng::with_seed(seed));
        scene.attempt()
    }
}

/// When a scene ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Going {
    ToTheFirstStop,
    OnAfterStops,
}

/// How a scene ended.
enum End {
    /// A stop ended it, or the tool entered the part.
    Stopped,
    /// A false stop ended it.
    FalseAlarm,
    /// The operator or the time limit ended it.
    Over,
}

/// The state of an attempt.
struct Scene<'a> {
    paper: &'a Paper<'a>,
    modules: Box<dyn Tables>,
    operator: Box<dyn Operator>,
    going: Going,
    seen: OperatorView,
    input: OperatorInput,
    /// Whether the operator ended the session.
    over: bool,
    monitor: CollisionMonitor,
    /// Distance from the part at the last sample, mm.
    clearance_mm: f64,
    /// Smallest distance from the part, mm.
    closest_mm: f64,
    path: Vec<Mm2>,
    steps: u64,
    /// Elapsed time that is not simulated yet, s.
    owed_s: f64,
}

impl<'a> Scene<'a> {
    fn new(
        paper: &'a Paper<'a>,
        (start, modules): (Mm2, Box<dyn Tables>),
        operator: Box<dyn Operator>,
        going: Going,
    ) -> Self {
        let offset = Vector { dx: 0, dy: 0 };
        let radius = keepout_planner::units::length_up_from_mm(paper.ground.radius_mm);
        let radius = radius.unwrap_or(keepout_kernel::Length::ZERO);
        let levels = Arc::new(Levels::flat(Arc::new(paper.ground.part.clone())));
        let mut scene = Self {
            paper,
            modules,
            operator,
            going,
            seen: OperatorView {
                position_mm: Some(start),
                wall_mm: Some(paper.ground.shape.nearest(start)),
                part_box: paper.ground.shape.bounds(),
                height_mm: None,
                end_mm: None,
                unacknowledged: 0,
                spindle_runs: false,
                phase: Phase::Manual,
                contoured: false,
            },
            input: OperatorInput::default(),
            over: false,
            monitor: CollisionMonitor::new(levels, radius, (offset, Height::ZERO)),
            clearance_mm: 0.0,
            closest_mm: f64::INFINITY,
            path: Vec::new(),
            steps: 0,
            owed_s: 0.0,
        };
        scene.look();
        scene
    }

    fn now(&self) -> Time {
        Time::from_micros(self.steps * 1000)
    }

    fn seconds(&self) -> f64 {
        self.now().elapsed().as_secs_f64()
    }

    /// Simulates the next `seconds`.
    fn pass(&mut self, seconds: f64) {
        self.owed_s += seconds;
        while self.owed_s >= STEP_S {
            self.owed_s -= STEP_S;
            if self.steps.is_multiple_of(INPUT_STEPS) {
                self.input = self.operator.input(&self.seen, self.now());
                self.over |= self.operator.command().is_some();
            }
            self.modules.step();
            self.steps += 1;
            let every = if self.clearance_mm > FAR_MM { LOOK_STEPS_FAR } else { LOOK_STEPS };
            if self.steps.is_multiple_of(every) {
                self.look();
            }
        }
    }

    fn look(&mut self) {
        let tool = self.modules.tool();
        if self.path.last() == Some(&tool) {
            return;
        }
        let sample = Sample { at: self.now(), position_mm: tool.at_height(0.0), kind: SampleKind::Jog };
        self.monitor.watch(&sample);
        self.clearance_mm = self.paper.ground.clearance(tool);
        self.closest_mm = self.closest_mm.min(self.clearance_mm);
        self.path.push(tool);
    }

    /// Runs rounds: query, check, then stop or send a motion.
    fn drive(&mut self, random: &mut fastrand::Rng) -> End {
        let delays = self.paper.delays;
        let limit_s = if self.going == Going::OnAfterStops { SESSION_S } else { LIMIT_S };
        while self.seconds() < limit_s && !self.over {
            self.pass(delays.line_s(delays.query_bytes) + delays.controller_s);
            let (position, queued) = (self.modules.tool(), self.modules.queued());
            self.pass(delays.line_s(delays.answer_bytes));
            self.seen.position_mm = Some(position);
            self.seen.wall_mm = Some(self.paper.ground.shape.nearest(position));
            self.pass(delays.computation_s(random));
            let invades = self.paper.ground.check.invades(position, self.paper.tolerance_mm);
            if invades && (self.modules.queued() > 0 || self.going == Going::ToTheFirstStop) {
                self.pass(delays.line_s(delays.stop_bytes) + delays.controller_s);
                self.modules.stop(delays.stop_cuts);
                if self.going == Going::ToTheFirstStop {
                    self.settle();
                    let called_for = self.monitor.deepest().is_some()
                        || !self.paper.ground.is_false_alarm(position, self.paper.tolerance_mm);
                    return if called_for { End::Stopped } else { End::FalseAlarm };
                }
                continue;
            }
            if self.going == Going::ToTheFirstStop && self.monitor.deepest().is_some() {
                // The check did not detect the tool in the band, and the tool is in the part.
                return End::Stopped;
            }
            if queued <= usize::try_from(delays.ahead).unwrap_or(usize::MAX) {
                self.send(position, invades);
            }
        }
        End::Over
    }

    /// Sends a motion in the direction of the stick, if the stick is tilted and the motion is allowed.
    fn send(&mut self, position: Mm2, invades: bool) {
        let delays = self.paper.delays;
        let stick = self.input.velocity;
        let tilt = stick.distance(Mm2::new(0.0, 0.0));
        let motion = stick / tilt * delays.unit_mm;
        if tilt > TILTED
            && (!invades || self.paper.ground.leads_away(position, motion, self.paper.tolerance_mm))
        {
            self.pass(delays.line_s(delays.motion_bytes) + delays.controller_s);
            self.modules.go(motion);
        }
    }

    fn settle(&mut self) {
        let until = self.seconds() + REST_S;
        while !self.modules.rests() && self.seconds() < until {
            self.pass(0.02);
        }
        self.look();
    }

    fn attempt(self) -> Attempt {
        Attempt {
            depth_mm: self.monitor.deepest().map_or(0.0, |gouge| gouge.depth_mm),
            closest_mm: self.monitor.closest_mm().unwrap_or(self.closest_mm),
            seconds: self.seconds(),
            path: self.path,
            false_alarms: 0,
            fastest_mm_s: None,
        }
    }
}
