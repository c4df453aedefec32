//! The paper's controller (sections 5 and 6): command where the tool is, check for an invasion with tolerance T, and then stop.
//!
//! It drives the modules of this study and nothing else: it makes no command of the product's, and knows no port.
//!
//! ```text
//! joystick ──> velocity ──> motion of a fixed length ──────────────┐
//!    position query ── line ──> answer ── line ──> check ──> stop ── line ──> modules
//! ```
//!
//! The flow chart (Fig. 7) is lost. What is read into it: one round asks for the position, checks it, and then sends either a
//! stop or, when the stick is tilted and the controller's queue has room, one "unitary movement" (section 3.1) in the stick's
//! velocity (section 3.3: velocity, no speed).

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::{Sample, SampleKind};
use keepout_executor::supervisor::{OperatorInput, Phase};
use keepout_guard::Time;
use keepout_kernel::{ProhibitedRegion, Vector};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanParameters;
use keepout_planner::units::nearest_on_mm;
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::operator::{Model, ModelKind};

use super::attempt::{Attempt, PEOPLE, operator_of, seed_of};
use super::delays::Delays;
use super::invasion::{Classified, Intervals, prohibited};
use super::modules::{Modules, STEP_S, distance};
use super::scenario::{Mm, Shape, StudyError};

/// The tool starts with its edge so far from the part, mm.
pub const START_MM: (f64, f64) = (8.0, 30.0);
/// An attempt is begun anew so often at most.
pub const BEGINNINGS: u32 = 1000;
/// A stick tilted by less says nothing.
const TILTED: f64 = 0.3;
/// Steps between two inputs of the operator.
const WISH_STEPS: u64 = 10;
/// Steps between two looks of the monitor.
const LOOK_STEPS: u64 = 5;
/// The same where the tool is farther from the part than this, mm.
const LOOK_STEPS_FAR: u64 = 50;
const FAR_MM: f64 = 8.0;
/// Nobody drives longer without coming to the part, s.
const LIMIT_S: f64 = 60.0;
/// No roughing takes longer, s.
const SESSION_S: f64 = 7200.0;
/// The modules rest within this, s.
const REST_S: f64 = 20.0;

/// A profile as the paper's controller knows it, and the part as the monitor does.
#[derive(Debug)]
pub struct Ground<'a> {
    /// The profile.
    pub shape: &'a Shape,
    part: ProhibitedRegion,
    radius_mm: f64,
    /// The profile grown by the radius, as the paper makes it.
    polygon: Vec<Mm>,
    check: Intervals,
}

impl<'a> Ground<'a> {
    /// The profile grown by the tool's radius (section 5.3), and its segments in intervals (section 5.2).
    ///
    /// # Errors
    /// [`StudyError`] when the construction fails, or the part is none.
    pub fn new(shape: &'a Shape, tool_diameter_mm: f64, classified: Classified) -> Result<Self, StudyError> {
        let radius_mm = tool_diameter_mm / 2.0;
        let polygon = prohibited(&shape.corners, radius_mm, shape.side())
            .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })?;
        let job = PlanParameters { tool_diameter_mm, ..PlanParameters::default() };
        let part = shape.plan(&MachineProfile::simulated(), job)?.part;
        let check = Intervals::new(&polygon, classified);
        Ok(Self { shape, part, radius_mm, polygon, check })
    }

    /// Radius of the tool, mm.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Whether the check has an invasion where there is none: by the prolongation of a segment.
    fn is_false_alarm(&self, at: Mm, tolerance_mm: f64) -> bool {
        let closed = self.polygon.iter().copied().zip(self.polygon.iter().copied().cycle().skip(1));
        let mut far = closed.map(|(from, to)| distance(at, nearest_on_mm(at, from, to)));
        far.all(|far| far > tolerance_mm)
    }

    /// How far the tool's edge is from the part, mm; negative within.
    fn clearance(&self, at: Mm) -> f64 {
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
    /// What delays it.
    pub delays: Delays,
}

impl<'a> Paper<'a> {
    /// One attempt. An operator who is stopped by a false alarm, or does not come to the part, begins anew from another place.
    ///
    /// # Errors
    /// [`StudyError`] when the tool fits nowhere, or nobody ever comes to the part.
    pub fn attempt(&self, kind: ModelKind, seed: u64) -> Result<Attempt, StudyError> {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut false_alarms = 0;
        for _ in 0..BEGINNINGS {
            let start = self.ground.shape.start(self.ground.radius_mm, START_MM, &mut random)?;
            let model = Model::new(kind, f64::INFINITY, random.u64(..));
            let mut scene = Scene::new(self, start, Box::new(model), Going::ToTheFirstStop);
            match scene.drive(&mut random) {
                End::Stopped => return Ok(Attempt { false_alarms, ..scene.attempt() }),
                End::FalseAlarm => false_alarms += 1,
                End::Over => {}
            }
        }
        let what = format!("{}, the paper's controller, {kind:?}, seed {seed}", self.ground.shape.name);
        Err(StudyError::Ended { what, reason: format!("not at the part in {BEGINNINGS} beginnings") })
    }

    /// Attempts of people, from the stream of a row.
    pub fn attempts(
        self,
        (row, attempts, study): (u64, u64, u64),
    ) -> impl Iterator<Item = Result<Attempt, StudyError>> + use<'a> {
        (0..attempts)
            .map(move |number| self.attempt(operator_of(&PEOPLE, number), seed_of(study, row, number)))
    }

    /// Roughing until the operator inputs to end. After a stop only motions that lead away from the segment are sent.
    #[must_use]
    pub fn session(&self, start: Mm, operator: Box<dyn Operator>, seed: u64) -> Attempt {
        let mut scene = Scene::new(self, start, operator, Going::OnAfterStops);
        scene.drive(&mut fastrand::Rng::with_seed(seed));
        scene.attempt()
    }
}

/// How long a scene is played.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Going {
    ToTheFirstStop,
    OnAfterStops,
}

/// How it ended.
enum End {
    /// By a stop, or in the part.
    Stopped,
    /// By a stop that was not called for.
    FalseAlarm,
    /// The operator had enough.
    Over,
}

/// An attempt under way.
struct Scene<'a> {
    paper: &'a Paper<'a>,
    modules: Modules,
    operator: Box<dyn Operator>,
    going: Going,
    seen: OperatorView,
    input: OperatorInput,
    monitor: CollisionMonitor,
    /// At the last look, and the least of all, mm.
    clearance_mm: f64,
    closest_mm: f64,
    path: Vec<Mm>,
    steps: u64,
    /// Time that has not been stepped yet, s.
    owed_s: f64,
}

impl<'a> Scene<'a> {
    fn new(paper: &'a Paper<'a>, start: Mm, operator: Box<dyn Operator>, going: Going) -> Self {
        let offset = Vector { dx: 0, dy: 0 };
        let radius = keepout_planner::units::length_up_from_mm(paper.ground.radius_mm);
        let radius = radius.unwrap_or(keepout_kernel::Length::ZERO);
        let mut scene = Self {
            paper,
            modules: Modules::new(start, paper.feed_mm_s, paper.delays.inertia_s),
            operator,
            going,
            seen: OperatorView {
                position_mm: Some(start),
                wall_mm: Some(paper.ground.shape.nearest(start)),
                part_box_mm: paper.ground.shape.box_mm(),
                end_mm: None,
                unacknowledged: 0,
                phase: Phase::Manual,
                contoured: false,
            },
            input: OperatorInput::default(),
            monitor: CollisionMonitor::new(paper.ground.part.clone(), radius, offset),
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

    /// Lets time pass.
    fn pass(&mut self, seconds: f64) {
        self.owed_s += seconds;
        while self.owed_s >= STEP_S {
            self.owed_s -= STEP_S;
            if self.steps.is_multiple_of(WISH_STEPS) {
                self.input = self.operator.input(&self.seen, self.now());
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
        let sample = Sample { at: self.now(), position_mm: tool, kind: SampleKind::Jog };
        self.monitor.watch(&sample);
        self.clearance_mm = self.paper.ground.clearance(tool);
        self.closest_mm = self.closest_mm.min(self.clearance_mm);
        self.path.push(tool);
    }

    /// Round after round: command, check, then stop or send a motion.
    fn drive(&mut self, random: &mut fastrand::Rng) -> End {
        let delays = self.paper.delays;
        let limit_s = if self.going == Going::OnAfterStops { SESSION_S } else { LIMIT_S };
        while self.seconds() < limit_s && self.input.command.is_none() {
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
                // Past the band and unnoticed: the tool is in the part.
                return End::Stopped;
            }
            if queued <= usize::try_from(delays.ahead).unwrap_or(usize::MAX) {
                self.send(position, invades);
            }
        }
        End::Over
    }

    /// Sends a motion in the stick's velocity, when that is tilted, and allowed.
    fn send(&mut self, position: Mm, invades: bool) {
        let delays = self.paper.delays;
        let stick = self.input.velocity;
        let tilt = distance(stick, (0.0, 0.0));
        let way = (stick.0 / tilt * delays.unit_mm, stick.1 / tilt * delays.unit_mm);
        let end = (position.0 + way.0, position.1 + way.1);
        let far = |at: Mm| self.paper.ground.check.nearest(at).map_or(f64::INFINITY, |(_, far)| far);
        if tilt > TILTED && !(invades && far(end) <= far(position)) {
            self.pass(delays.line_s(delays.motion_bytes) + delays.controller_s);
            self.modules.go(way);
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
