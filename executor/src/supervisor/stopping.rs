//! The end of a session: on a command, or on a fault.
//!
//! Implements SR-22.

use super::event::Command;
use super::state::{Phase, State};
use super::{Fault, Supervisor};

impl Supervisor {
    /// Brings the machine to rest and ends the session.
    pub fn halt(&mut self) -> Option<Command> {
        let stopping = State::Stopping { aborted: false, rested: false, stale: self.polling.open() };
        match self.phase() {
            Phase::Stopping | Phase::Done => None,
            Phase::Faulted | Phase::Starting => {
                let stop = self.stops_homing();
                self.unrecovered = self.fault().copied().or(self.unrecovered);
                self.state = State::Done;
                stop
            }
            Phase::Touching => {
                self.guard.withdraw_contour();
                self.state = State::Done;
                None
            }
            Phase::Contouring | Phase::Holding => {
                self.interrupt();
                self.state = stopping;
                None
            }
            Phase::Manual | Phase::Sliding | Phase::Retracting if self.guard.in_position() => {
                self.state = State::Done;
                None
            }
            Phase::Manual | Phase::Sliding | Phase::Retracting => {
                self.state = stopping;
                self.cancel()
            }
        }
    }

    /// A cancel of the jogs in flight, if the guard certifies one. Otherwise they run to their targets.
    fn cancel(&mut self) -> Option<Command> {
        self.guard.cancel().ok().map(Command::Cancel)
    }

    /// The last command of a session that cannot continue: a certified cancel of the jogs in flight. `None`
    /// for a contour, which runs to the end of its queued motions.
    pub fn last_stop(&mut self) -> Option<Command> {
        if self.guard.contour_progress().is_some() { None } else { self.cancel() }
    }

    /// The command that ends homing. Without it the controller would go on with the search for its reference
    /// position.
    fn stops_homing(&self) -> Option<Command> {
        matches!(self.state, State::Homing).then_some(Command::EndHoming)
    }

    /// Stops on a fault. The motions of this step are not sent. Jogs in flight are cancelled if the guard
    /// certifies the cancel.
    pub(super) fn stop(&mut self, fault: Fault, first: usize, commands: &mut Vec<Command>) {
        if matches!(self.phase(), Phase::Faulted | Phase::Done) {
            return;
        }
        let mut index = 0;
        commands.retain(|command| {
            index += 1;
            index <= first || !matches!(command, Command::Move(_))
        });
        commands.extend(match self.phase() {
            Phase::Contouring | Phase::Holding => None,
            Phase::Stopping => self.last_stop(),
            // Motions from before an earlier fault may still run. A contour among them must not be cancelled.
            Phase::Starting => self.stops_homing(),
            _ => self.cancel(),
        });
        self.interrupt();
        self.forget_spindle();
        self.guard.forget();
        self.polling.drop_queries();
        self.state = State::Faulted { fault, warned: false };
    }
}
