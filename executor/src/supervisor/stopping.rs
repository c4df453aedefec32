//! Coming to an end: as wanted, or on a fault.

use super::event::Command;
use super::state::{Phase, State};
use super::{Fault, Supervisor};

impl Supervisor {
    /// Brings the machine to rest and ends the session.
    pub fn halt(&mut self) -> Option<Command> {
        let stopping = State::Stopping { aborted: false, stale: self.queries.len() };
        match self.phase() {
            Phase::Stopping | Phase::Done => None,
            Phase::Faulted | Phase::Starting => {
                let homing = matches!(self.state, State::Homing);
                self.state = State::Done;
                // A search for the reference position would go on by itself.
                let stop = if self.abilities.holds { Command::Abort } else { Command::Cancel };
                (homing && (self.abilities.holds || self.abilities.cancels)).then_some(stop)
            }
            Phase::Holding => {
                self.interrupt();
                self.state = stopping;
                None
            }
            Phase::Touching => {
                self.guard.withdraw_contour();
                self.state = State::Done;
                None
            }
            Phase::Contouring => {
                self.interrupt();
                self.state = stopping;
                self.abilities.holds.then_some(Command::Hold)
            }
            Phase::Manual | Phase::Sliding | Phase::Escaping if self.guard.settled() => {
                self.state = State::Done;
                None
            }
            Phase::Manual | Phase::Sliding | Phase::Escaping => {
                self.state = stopping;
                self.abilities.cancels.then_some(Command::Cancel)
            }
        }
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
        let contouring = matches!(self.phase(), Phase::Contouring | Phase::Holding | Phase::Stopping);
        if contouring && self.abilities.holds {
            commands.push(Command::Hold);
        } else if !contouring && self.abilities.cancels {
            commands.push(Command::Cancel);
        }
        self.interrupt();
        self.guard.forget();
        self.queries.clear();
        self.state = State::Faulted { fault, warned: false };
    }
}
