//! Coming to an end: as wanted, or on a fault.

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
            Phase::Manual | Phase::Sliding | Phase::Escaping if self.guard.in_position() => {
                self.state = State::Done;
                None
            }
            Phase::Manual | Phase::Sliding | Phase::Escaping => {
                self.state = stopping;
                self.cancel()
            }
        }
    }

    /// A cancel of the jogs in flight, where the guard certifies one; else they run to their targets.
    fn cancel(&mut self) -> Option<Command> {
        self.guard.cancel().ok().map(Command::Cancel)
    }

    /// What stops whatever moves, should nothing else work any more, as far as the tool then stays where it was certified. A contour
    /// runs to the end of its queued motions.
    pub fn last_stop(&mut self) -> Option<Command> {
        if self.guard.contour_progress().is_some() { None } else { self.cancel() }
    }

    /// What ends a search for the reference position: it would go on by itself.
    fn stops_homing(&self) -> Option<Command> {
        matches!(self.state, State::Homing).then_some(Command::EndHoming)
    }

    /// Stops on a fault: motions that were about to be sent are not, and what moves is stopped where that keeps it on its
    /// certified way.
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
            // What was sent before an earlier fault may still be on its way: a contour must not be cancelled.
            Phase::Starting => self.stops_homing(),
            _ => self.cancel(),
        });
        self.interrupt();
        self.guard.forget();
        self.polling.drop_queries();
        self.state = State::Faulted { fault, warned: false };
    }
}
