//! Replies, reports and silence of the controller.
//!
//! Implements SR-22.

use std::time::Duration;

use keepout_guard::{ContourMotion, PositionFeedback, QueryStamp, Time};

use super::event::{Command, Mode, Reply, Report};
use super::notice::Notice;
use super::state::{Phase, State};
use super::{Fault, Supervisor};

/// Longest permitted silence during homing.
const HOMING_MAX: Duration = Duration::from_secs(90);
/// Time limit for a step of the start, unless the longest permitted silence requires a longer one. A slower
/// step counts as a lost line.
const START_WITHIN: Duration = Duration::from_secs(20);
/// Greatest number of exchanges in a step of the start. The GRBL dialect wakes the controller, identifies it, reads
/// its settings and startup lines, stores up to two settings, one after the other, and reads them all again.
const START_EXCHANGES: u32 = 8;
/// Greatest number of tolerated rejections in a row. The next rejection is a fault.
const REFUSED_MAX: u8 = 20;

/// The operator gets a notice when the controller states motion for this time without a change of position. The
/// slowest jog goes 1 mm/s, and an override of 10 % makes it a tenth of that.
const STANDS_FOR: Duration = Duration::from_secs(5);

impl Supervisor {
    pub(super) fn hear(&mut self, reply: Reply, now: Time, commands: &mut Vec<Command>) -> Result<(), Fault> {
        // An unreadable line does not end the silence.
        if !matches!(reply, Reply::Garbled(_)) {
            self.polling.heard_at = now;
        }
        match reply {
            Reply::Report(report) => self.take_report(&report, now, commands),
            // The controller acknowledges a line from before a fault.
            Reply::Accepted if matches!(self.state, State::Connecting { .. }) => Ok(()),
            Reply::Accepted => {
                self.guard.acknowledged()?;
                self.operation.rejected = 0;
                self.polling.acknowledged(&self.guard);
                Ok(())
            }
            Reply::Refused { code, meaning, transient } => self.refused(code, meaning, transient),
            Reply::Alarm { code, meaning } => Err(Fault::Alarm { code, meaning }),
            Reply::Garbled(line) => match &mut self.state {
                // Bytes from before the connection may arrive first. They are not a fault.
                State::Connecting { garbled } => {
                    *garbled = Some(line);
                    Ok(())
                }
                _ => Err(Fault::Garbled { line }),
            },
            Reply::Restarted => match self.state {
                State::Connecting { .. } | State::Stopping { aborted: true, .. } => Ok(()),
                _ => Err(Fault::WasReset),
            },
            Reply::NotHomed => Err(Fault::NotHomed),
            Reply::Displaced => Err(Fault::OffsetChanged),
            Reply::Unfit(unfit) => Err(Fault::Unfit(unfit)),
            Reply::Message(text) => {
                self.note(Notice::Controller(text));
                Ok(())
            }
            Reply::SpindleSwitched => {
                self.spindle_switched();
                Ok(())
            }
            Reply::Prepared(..) | Reply::Homed | Reply::Armed => {
                self.start_step_at = now;
                self.start_on(&reply, commands);
                Ok(())
            }
        }
    }

    fn refused(&mut self, code: u16, meaning: &'static str, transient: bool) -> Result<(), Fault> {
        let again = transient && self.operation.rejected < REFUSED_MAX;
        match &mut self.state {
            State::Connecting { .. } => Ok(()),
            // The controller rejects a jog that was in flight when the session began to stop.
            State::Stopping { .. } if again && self.guard.refused() => Ok(()),
            State::Manual(steering) | State::Sliding(steering) | State::Retracting(steering)
                if again && self.guard.refused() =>
            {
                self.operation.rejected += 1;
                steering.wait_for_rest();
                Ok(())
            }
            _ => Err(Fault::Refused { code, meaning }),
        }
    }

    fn take_report(&mut self, report: &Report, now: Time, commands: &mut Vec<Command>) -> Result<(), Fault> {
        self.watch_standstill(report, now);
        self.position = report.position.or(self.position);
        self.mode = Some(report.mode);
        let stamp = self.polling.answered(now, self.options.answer_within);
        match &self.state {
            State::Connecting { .. } => self.connected(report, now, commands),
            State::Locating { .. } => self.take_place(report),
            State::Preparing | State::Homing | State::Arming | State::Done | State::Faulted { .. } => Ok(()),
            _ => {
                self.check_mode(report)?;
                match stamp {
                    Some(stamp) => self.take_sighting(report, stamp, now, commands),
                    None => Ok(()),
                }
            }
        }
    }

    /// Tells the operator that the controller states motion, and its position has stood still for long.
    fn watch_standstill(&mut self, report: &Report, now: Time) {
        let stands =
            report.mode == Mode::Moving && report.position.is_none_or(|at| self.position == Some(at));
        if !stands {
            self.polling.moved_at = now;
        } else if now.since(self.polling.moved_at) > STANDS_FOR {
            self.note(Notice::StandsStill);
        }
    }

    fn check_mode(&self, report: &Report) -> Result<(), Fault> {
        let holds = matches!(self.state, State::Stopping { .. } | State::Holding(_) | State::Contouring(_));
        match report.mode {
            Mode::Idle | Mode::Moving => Ok(()),
            Mode::Held | Mode::Slowing if holds => Ok(()),
            Mode::Alarm => Err(Fault::Alarm { code: 0, meaning: "" }),
            mode => Err(Fault::Unexpected { mode }),
        }
    }

    fn take_sighting(
        &mut self,
        report: &Report,
        stamp: QueryStamp,
        now: Time,
        commands: &mut Vec<Command>,
    ) -> Result<(), Fault> {
        let Some(position) = report.position else { return Ok(()) };
        let feedback = PositionFeedback {
            position,
            in_position: report.mode == Mode::Idle,
            queued: report.queued,
            waiting: report.waiting.unwrap_or(false),
        };
        self.check_answers(&feedback, now)?;
        self.guard.reported(&feedback, stamp, now)?;
        if let State::Contouring(run) | State::Holding(run) = &mut self.state
            && let (Some(motion), Some(ContourMotion { curve, .. })) =
                (self.guard.contour_at(), self.guard.contour_left().first())
        {
            run.see(position.point, motion, curve);
        }
        if let State::Stopping { stale: stale @ 1.., .. } = &mut self.state {
            *stale -= 1;
        } else if let State::Stopping { aborted, rested, .. } = &mut self.state {
            // Two reports must agree, because one may be damaged or repeated.
            let rests = feedback.rests() && self.guard.unacknowledged() == 0;
            let agreed = rests && *rested;
            *rested = rests;
            match report.mode {
                // Someone else put the controller on hold. Drop its queue, so that its motions cannot start
                // later.
                Mode::Held if !*aborted => {
                    *aborted = true;
                    commands.push(Command::Abort);
                }
                Mode::Idle if *aborted || agreed => self.state = State::Done,
                _ => {}
            }
        }
        if self.guard.in_position() {
            self.at_rest();
        }
        Ok(())
    }

    /// Detects a lost line: the controller stays at rest with an empty queue, and a line is unacknowledged.
    fn check_answers(&mut self, feedback: &PositionFeedback, now: Time) -> Result<(), Fault> {
        let open = self.guard.unacknowledged() > 0;
        let idle = open && feedback.in_position && feedback.queued.is_none_or(|queued| queued == 0);
        if self.polling.unacknowledged_for(idle, now) <= self.options.answer_within {
            return Ok(());
        }
        // A line that is lost at the end of the session is not a fault.
        if let State::Stopping { .. } = self.state {
            self.state = State::Done;
            return Ok(());
        }
        Err(Fault::LineLost)
    }

    /// Longest permitted silence of the controller in this state.
    fn allowed(&self) -> Duration {
        match self.state {
            State::Homing => HOMING_MAX,
            // The dialect reads the answers of this step itself.
            State::Preparing => self.start_within(),
            _ => self.options.answer_within,
        }
    }

    /// Time limit for a step of the start.
    fn start_within(&self) -> Duration {
        START_WITHIN.max(self.options.answer_within * START_EXCHANGES / 2)
    }

    pub(super) fn check_silence(&self, now: Time) -> Result<(), Fault> {
        let silent = now.since(self.polling.heard_at);
        let over = matches!(self.state, State::Done | State::Faulted { .. });
        let starts = matches!(self.state, State::Preparing | State::Arming | State::Locating { .. });
        if starts && now.since(self.start_step_at) > self.start_within() {
            return Err(Fault::LineLost);
        }
        if silent <= self.allowed() || over {
            return Ok(());
        }
        match &self.state {
            State::Connecting { garbled: Some(line) } => Err(Fault::Garbled { line: *line }),
            _ => Err(Fault::Silent { seconds: silent.as_secs_f64() }),
        }
    }

    fn asks(&self) -> bool {
        !matches!(self.state, State::Done | State::Faulted { .. } | State::Homing | State::Preparing)
    }

    /// Time at which the next query is due.
    fn query_due(&self) -> Time {
        let stops =
            self.phase().is_steered() && !self.guard.in_position() && self.operation.input.is_centred();
        let soon = stops || self.guard.awaits_reading();
        self.polling.due(self.options.answer_within, self.options.baud, soon)
    }

    pub(super) fn wants_query(&self, now: Time) -> bool {
        self.asks() && now >= self.query_due() && self.polling.has_room()
    }

    pub(super) fn query(&mut self, now: Time, commands: &mut Vec<Command>) {
        self.polling.ask(self.guard.stamp(now), now);
        self.counts.queries += 1;
        commands.push(Command::Query);
    }

    /// Latest time of the next tick.
    #[must_use]
    pub fn due(&self) -> Time {
        let step = Duration::from_micros(1);
        if self.phase() == Phase::Touching && !self.wants_job() {
            return Time::ZERO;
        }
        let silence = self.polling.heard_at.after(self.allowed()).after(step);
        let over = matches!(self.state, State::Done | State::Faulted { .. });
        let mut due = if over { Time::NEVER } else { silence };
        if matches!(self.state, State::Preparing | State::Arming | State::Locating { .. }) {
            due = due.min(self.start_step_at.after(self.start_within()).after(step));
        }
        if self.asks() && self.polling.has_room() {
            due = due.min(self.query_due());
        }
        match self.operation.input.stale_at() {
            Some(at) if self.phase().is_steered() && !self.operation.stopped_for_stale => {
                due.min(at.after(step))
            }
            _ => due,
        }
    }
}
