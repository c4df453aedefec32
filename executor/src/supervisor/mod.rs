//! The supervisor: a pure state machine between operator, guard and controller.
//!
//! Implements SR-22, SR-24.
//!
//! `step(event, now, commands)` takes one event and the time, and appends the commands to send. It reads no
//! clock, accesses no port and uses no random numbers. Motions come only from the [`keepout_guard`]. After
//! the start, the supervisor allocates no memory during jogging.

mod abilities;
mod contour_motions;
mod contouring;
mod errand;
mod event;
mod facts;
mod fault;
mod input;
mod jog;
mod notice;
mod options;
mod polling;
mod prepared_plan;
mod spindle;
mod start;
mod state;
mod stopping;
#[cfg(test)]
mod transitions;
mod watch;

use std::sync::Arc;

pub use abilities::Abilities;
pub use contouring::{Interrupted, JobRequest};
use errand::Errand;
pub use event::{Command, EncodeError, Event, Mode, Reply, Report, Text, Unfit, text};
pub use fault::Fault;
use input::Aged;
pub use input::{
    INPUT_STALE, OperatorCommand, OperatorInput, READING_STALE, Stick, StickError, StickSettings,
};
pub use jog::Limits;
use jog::{JogContext, JogPlanner, WallContact};
use keepout_guard::{FeedOverride, Guard, Time};
use keepout_kernel::{Height, Place};
use keepout_planner::Mm2;
use keepout_planner::job::{LoopNumber, Progress};
pub use notice::Notice;
pub use options::Options;
use polling::Polling;
pub use prepared_plan::PreparedPlan;
use prepared_plan::rules;
use spindle::Spindle;
pub use state::Phase;
use state::{State, Touch};

/// Counters for the report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Jogs sent.
    pub jogs: u64,
    /// Contour motions sent.
    pub contour_motions: u64,
    /// Jogs cancelled.
    pub cancels: u64,
    /// Jog inputs that were shortened or turned, or found no admissible target.
    pub clipped: u64,
    /// Queries sent.
    pub queries: u64,
}

/// Greatest number of notices kept.
const NOTICES_MAX: usize = 64;
/// Number of contour motions that one step certifies.
const CERTIFIED_AT_ONCE: usize = 32;

/// The supervisor of one session. See the documentation of this module.
#[derive(Debug)]
pub struct Supervisor {
    work: PreparedPlan,
    guard: Guard,
    options: Options,
    abilities: Abilities,
    state: State,
    polling: Polling,
    operation: Operation,
    contours: Contours,
    limits: Limits,
    /// Rapid rate of the third axis, mm/s.
    lift_mm_s: f64,
    notices: Vec<Notice>,
    counts: Counts,
    /// Position feedback: the last reported position, and the mode of the last report.
    position: Option<Place>,
    mode: Option<Mode>,
    /// Time of the last step of the start.
    start_step_at: Time,
    /// Whether the machine is homed before the tool is located.
    homes: bool,
    /// The fault from which the session has not recovered.
    unrecovered: Option<Fault>,
}

/// The operator's side: the jog input, the armed cycle, and jogs that the controller rejected.
#[derive(Debug, Default)]
struct Operation {
    input: Aged,
    /// Jogging already stopped because the input is stale.
    stopped_for_stale: bool,
    /// The cycle is armed: a contact starts the contour.
    armed: bool,
    /// Rejected jogs in a row, because the controller was still in motion.
    rejected: u8,
    /// What the tool does by itself along the third axis.
    errand: Option<Errand>,
    spindle: Spindle,
    feed: FeedOverride,
}

/// The progress of the contours, and the rest of an interrupted contour.
#[derive(Debug)]
struct Contours {
    /// The progress without the contour under way.
    progress: Progress,
    interrupted: Option<Interrupted>,
    /// Loops of the last job that no link move reaches.
    unreached: Vec<LoopNumber>,
}

impl Supervisor {
    /// A supervisor for a certified plan, over a controller of these abilities.
    #[must_use]
    pub fn new(work: PreparedPlan, options: Options, abilities: Abilities) -> Self {
        let plan = &work.plan;
        let machine = &plan.plan.machine;
        let rules = rules(plan, (options.travel, options.heights), abilities);
        let limits = Limits::of(machine.max_rate_mm_s, machine.acceleration_mm_s2);
        let lift_mm_s = machine.z.as_ref().map_or(0.0, |z| z.max_rate_mm_s);
        Self {
            guard: Guard::new(Arc::clone(&work.levels), Arc::clone(&work.simplified), rules),
            work,
            homes: options.home,
            abilities,
            state: State::Connecting { garbled: None },
            polling: Polling::default(),
            operation: Operation::default(),
            contours: Contours {
                progress: options.progress.clone(),
                interrupted: None,
                unreached: Vec::new(),
            },
            limits,
            lift_mm_s,
            notices: Vec::with_capacity(NOTICES_MAX),
            counts: Counts::default(),
            position: None,
            mode: None,
            unrecovered: None,
            start_step_at: Time::ZERO,
            options,
        }
    }

    /// Takes one event, and appends the commands to send, in order.
    pub fn step(&mut self, event: Event, now: Time, commands: &mut Vec<Command>) {
        let first = commands.len();
        let jogs = !matches!(event, Event::Tick | Event::Command(_));
        let outcome = match event {
            Event::Reply(reply) => self.hear(reply, now, commands),
            Event::Input(input) => {
                self.take_input(input, now);
                Ok(())
            }
            Event::Command(command) => {
                self.commanded(command, now, commands);
                Ok(())
            }
            Event::Tick => self.check_silence(now).and_then(|()| self.check_spindle(now)),
            Event::Job(job) => {
                self.take_job(*job);
                Ok(())
            }
            Event::PortLost(reason) => Err(Fault::PortLost(reason)),
            Event::NotSent(error) => Err(Fault::NotSent(error)),
            Event::PortFound => {
                self.polling.heard_at = now;
                Ok(())
            }
        };
        let outcome = outcome.and_then(|()| self.act(jogs, now, commands));
        if let Err(fault) = outcome {
            self.stop(fault, first, commands);
        }
        self.leave_spindle(commands);
    }

    fn take_input(&mut self, input: OperatorInput, now: Time) {
        let before = self.operation.input.replace(input, now);
        // The operator arms the cycle, and a contour disarms it.
        self.operation.armed = input.armed && (self.operation.armed || !before.armed);
        self.operation.stopped_for_stale = false;
        if !self.operation.input.is_centred() || input.turns() {
            self.end_errand();
        }
        if let Some(steering) = self.state.steering() {
            steering.turn(input.turned_mm, input.turned_up_mm);
        }
    }

    fn commanded(&mut self, command: OperatorCommand, now: Time, commands: &mut Vec<Command>) {
        match (command, self.phase()) {
            (OperatorCommand::Stop, _) => commands.extend(self.halt()),
            (OperatorCommand::FeedHold, Phase::Contouring) => self.pause(),
            (OperatorCommand::CycleStart, Phase::Holding) => self.go_on(),
            (OperatorCommand::CycleStart, phase) if phase.is_steered() => self.resume(),
            (OperatorCommand::Recover, Phase::Faulted) => self.recover(now),
            (OperatorCommand::Spindle { runs }, _) => self.take_spindle(runs, now),
            (OperatorCommand::Feed { percent }, _) => {
                self.operation.feed = FeedOverride::of_percent(percent);
            }
            (OperatorCommand::Raise, phase) if phase.is_steered() => self.begin_raise(),
            (OperatorCommand::Cross { contour }, phase) if phase.is_steered() => self.begin_crossing(contour),
            _ => {}
        }
    }

    /// The phase of the session.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.state.phase()
    }

    fn note(&mut self, notice: Notice) {
        if self.notices.len() < NOTICES_MAX && self.notices.last() != Some(&notice) {
            self.notices.push(notice);
        }
    }

    /// Acts as the state requires. Without `jogs`, the jog planner runs only when the input becomes stale.
    fn act(&mut self, jogs: bool, now: Time, commands: &mut Vec<Command>) -> Result<(), Fault> {
        if self.wants_query(now) {
            self.query(now, commands);
        }
        let motions = self.guard.sent();
        let switches = self.phase().is_steered() && self.switches_spindle(now, commands);
        match &mut self.state {
            _ if switches => {}
            State::Manual(_) | State::Sliding(_) | State::Retracting(_) => {
                let stale = self.operation.input.is_stale(now);
                if jogs || stale && !self.operation.stopped_for_stale {
                    self.operation.stopped_for_stale = stale;
                    if stale {
                        self.end_errand();
                    }
                    self.touch_or_steer(self.operation.input.jog_velocity(now), now, commands);
                }
            }
            State::Touching(Touch::Certifying(_)) => self.certify_on(),
            State::Contouring(_) => self.contour_on(commands),
            State::Stopping { .. } if self.guard.in_position() => self.state = State::Done,
            _ => {}
        }
        if self.guard.sent() > motions {
            self.polling.owed = self.abilities.queues && !self.abilities.checked;
        }
        if self.polling.owed && self.wants_query(now) {
            self.query(now, commands);
        }
        Ok(())
    }

    fn touch_or_steer(&mut self, input: Option<Mm2>, now: Time, commands: &mut Vec<Command>) {
        if self.operation.armed
            && self.guard.in_position()
            && !self.guard.is_inside_jogging_clearance()
            && self.touches()
            && self.spindle_is_stated()
        {
            self.operation.armed = false;
            self.state = State::Touching(Touch::Asked { in_place: false });
            return;
        }
        let jogs = self.counts.jogs;
        if self.lifts(now, commands) {
            self.led_away(jogs);
            return;
        }
        let (state, mut context) = self.jogging(Height::LOWEST, now, commands);
        let contact = match state {
            State::Manual(steering) | State::Sliding(steering) => steering.steer(input, &mut context),
            State::Retracting(steering) => {
                steering.retract(input, &mut context);
                WallContact::Unknown
            }
            _ => return,
        };
        self.led_away(jogs);
        self.state = match (std::mem::replace(&mut self.state, State::Done), contact) {
            (State::Manual(steering), WallContact::Wall) => State::Sliding(steering),
            (State::Sliding(steering), WallContact::Free) => State::Manual(steering),
            (state, _) => state,
        };
    }

    /// The state, and the context of a jog that does not lower the tool below a height.
    fn jogging<'a>(
        &'a mut self,
        lowest: Height,
        now: Time,
        commands: &'a mut Vec<Command>,
    ) -> (&'a mut State, JogContext<'a>) {
        let context = JogContext {
            guard: &mut self.guard,
            counts: &mut self.counts,
            commands,
            limits: self.limits,
            lift_mm_s: self.lift_mm_s,
            lowest,
            abilities: self.abilities,
            round_trip: self.polling.round_trip,
            now,
        };
        (&mut self.state, context)
    }

    /// Takes note that the operator jogged since there were so many jogs.
    fn led_away(&mut self, jogs: u64) {
        if let Some(interrupted) = self.contours.interrupted.as_mut().filter(|_| self.counts.jogs > jogs) {
            interrupted.led_away = true;
        }
    }

    /// Changes the state after the tool has come to rest.
    fn at_rest(&mut self) {
        let inside = self.guard.is_inside_jogging_clearance();
        self.state = match std::mem::replace(&mut self.state, State::Done) {
            State::Retracting(_) if !inside => State::Manual(JogPlanner::default()),
            State::Manual(mut steering) => {
                steering.settle();
                State::Manual(steering)
            }
            State::Sliding(mut steering) => {
                steering.settle();
                State::Sliding(steering)
            }
            State::Retracting(mut steering) => {
                steering.settle();
                State::Retracting(steering)
            }
            State::Contouring(run) | State::Holding(run) => {
                self.contours.progress = run.done;
                self.contours.interrupted = None;
                State::Manual(JogPlanner::default())
            }
            State::Stopping { .. } => State::Done,
            state => state,
        };
    }
}
