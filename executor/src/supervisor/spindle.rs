//! The spindle: what the operator states of it, and the switch of a controller that has one.
//!
//! Implements SR-25.
//!
//! The operator starts it with two commands in a row, because a start can hurt someone. The supervisor switches only
//! while the machine rests and no line is unanswered, and sends no motion before the switch is answered: so no answer
//! to a switch can count for a motion.

use std::time::Duration;

use keepout_guard::Time;

use super::event::Command;
use super::notice::Notice;
use super::{Fault, Phase, Supervisor};

/// Longest time between the two commands that start the spindle.
const SECOND_WITHIN: Duration = Duration::from_secs(3);

/// What the supervisor knows of the spindle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spindle {
    /// Whether it runs, as the operator stated, or as the controller confirmed.
    pub(super) runs: Option<bool>,
    /// Time of the first of the two commands that start it.
    asked_at: Option<Time>,
    /// A switch that waits until the machine rests, and until the switch before it is answered.
    wanted: Option<bool>,
    /// A switch that the controller has not answered, and the time when it left.
    sent: Option<(bool, Time)>,
}

impl Supervisor {
    /// Whether the spindle runs, as far as the operator stated or the controller confirmed.
    #[must_use]
    pub fn spindle_runs(&self) -> Option<bool> {
        self.operation.spindle.runs
    }

    /// Takes the operator's command about the spindle: a statement, or a switch where the session has one.
    pub(super) fn take_spindle(&mut self, runs: bool, now: Time) {
        let spindle = &mut self.operation.spindle;
        if !self.abilities.spindle {
            spindle.runs = Some(runs);
        } else if !self.state.phase().is_steered() {
            self.note(Notice::SpindleBusy);
        } else if runs && spindle.asked_at.take().is_none_or(|at| now.since(at) > SECOND_WITHIN) {
            spindle.asked_at = Some(now);
            self.note(Notice::SpindleAsksAgain);
        } else {
            spindle.asked_at = None;
            spindle.wanted = Some(runs);
            self.end_errand();
        }
    }

    /// Sends a switch that waits, once the machine rests. Returns whether a switch is under way: no motion is sent
    /// until it is answered.
    pub(super) fn switches_spindle(&mut self, now: Time, commands: &mut Vec<Command>) -> bool {
        let spindle = &mut self.operation.spindle;
        if spindle.wanted.is_none() && spindle.sent.is_none() {
            return false;
        }
        if let (Some(runs), None) = (spindle.wanted, spindle.sent)
            && self.guard.in_position()
            && self.guard.unacknowledged() == 0
            && self.guard.takes_lines()
        {
            commands.push(Command::Spindle { runs });
            (spindle.wanted, spindle.sent) = (None, Some((runs, now)));
        }
        true
    }

    /// Takes the controller's answer to a switch.
    pub(super) fn spindle_switched(&mut self) {
        if let Some((runs, _)) = self.operation.spindle.sent.take() {
            self.operation.spindle.runs = Some(runs);
            self.note(Notice::Spindle { runs });
        }
    }

    /// Notices a switch that the controller does not answer.
    pub(super) fn check_spindle(&self, now: Time) -> Result<(), Fault> {
        match self.operation.spindle.sent {
            Some((_, at)) if now.since(at) > self.options.answer_within => Err(Fault::LineLost),
            _ => Ok(()),
        }
    }

    /// After a fault the state of a switched spindle is not known.
    pub(super) fn forget_spindle(&mut self) {
        if self.abilities.spindle {
            self.operation.spindle = Spindle::default();
        }
    }

    /// At the end of a session, stops the spindle that the session started. Nobody waits for the answer.
    pub(super) fn leave_spindle(&mut self, commands: &mut Vec<Command>) {
        if self.abilities.spindle && self.phase() == Phase::Done {
            let spindle = std::mem::take(&mut self.operation.spindle);
            let last = spindle.sent.map(|(runs, _)| runs).or(spindle.runs);
            commands.extend((last == Some(true)).then_some(Command::Spindle { runs: false }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::transitions::{ABILITIES, NOW, STATES, supervisor, work};
    use super::super::{Abilities, Event, OperatorCommand, Reply, State};
    use super::*;
    use crate::supervisor::jog::JogPlanner;

    const SWITCHES: Abilities = Abilities { spindle: true, ..ABILITIES };

    fn ask(runs: bool) -> Event {
        Event::Command(OperatorCommand::Spindle { runs })
    }

    fn after(ms: u64) -> Time {
        NOW.after(Duration::from_millis(ms))
    }

    fn steered() -> Supervisor {
        let mut supervisor = supervisor(&work(), "Manual", State::Manual(JogPlanner::default()));
        supervisor.abilities = SWITCHES;
        supervisor
    }

    /// The switches among the commands of an event.
    fn switches(supervisor: &mut Supervisor, event: Event, at: Time) -> Vec<bool> {
        let mut commands = Vec::new();
        supervisor.step(event, at, &mut commands);
        let switch =
            |command: &Command| if let Command::Spindle { runs } = command { Some(*runs) } else { None };
        commands.iter().filter_map(switch).collect()
    }

    // Evidence for SR-25.
    #[test]
    fn spindle_starts_at_the_second_command_and_stops_at_the_first() {
        let mut supervisor = steered();
        let answer = || Event::Reply(Reply::SpindleSwitched);
        assert!(switches(&mut supervisor, ask(true), after(0)).is_empty());
        assert!(switches(&mut supervisor, ask(true), after(3001)).is_empty(), "the first one is too old");
        assert_eq!(switches(&mut supervisor, ask(true), after(4000)), [true]);
        assert_eq!(supervisor.spindle_runs(), None, "it is not answered");
        // A stop waits for the answer.
        assert!(switches(&mut supervisor, ask(false), after(4010)).is_empty());
        assert_eq!(switches(&mut supervisor, answer(), after(4020)), [false]);
        assert_eq!(supervisor.spindle_runs(), Some(true));
        assert!(switches(&mut supervisor, answer(), after(4030)).is_empty());
        assert_eq!(supervisor.spindle_runs(), Some(false));
        assert!(switches(&mut supervisor, answer(), after(4040)).is_empty());
    }

    // Evidence for SR-25.
    #[test]
    fn switch_without_an_answer_is_a_fault_and_the_spindle_is_then_unknown() {
        let mut supervisor = steered();
        for at in [0, 10] {
            switches(&mut supervisor, ask(true), after(at));
        }
        supervisor.polling.heard_at = after(5000);
        switches(&mut supervisor, Event::Tick, after(5000));
        assert_eq!(supervisor.fault(), None);
        supervisor.polling.heard_at = after(5020);
        switches(&mut supervisor, Event::Tick, after(5020));
        assert_eq!((supervisor.fault(), supervisor.spindle_runs()), (Some(&Fault::LineLost), None));
        let quit = Event::Command(OperatorCommand::Stop);
        assert!(switches(&mut supervisor, quit, after(5030)).is_empty(), "nothing is sent after a fault");
    }

    // Evidence for SR-25.
    #[test]
    fn spindle_that_the_session_started_stops_with_it() {
        for answered in [false, true] {
            let mut supervisor = steered();
            for at in [0, 10] {
                switches(&mut supervisor, ask(true), after(at));
            }
            if answered {
                switches(&mut supervisor, Event::Reply(Reply::SpindleSwitched), after(20));
            }
            let quit = || Event::Command(OperatorCommand::Stop);
            assert_eq!(switches(&mut supervisor, quit(), after(30)), [false], "{answered}");
            assert!(switches(&mut supervisor, quit(), after(40)).is_empty());
        }
    }

    // Evidence for SR-25.
    #[test]
    fn nothing_is_switched_without_the_ability_or_while_a_contour_runs() {
        let work = work();
        for (name, state) in STATES {
            for spindle in [false, true] {
                let mut supervisor = supervisor(&work, name, state());
                supervisor.abilities.spindle = spindle;
                let sent: usize =
                    [0, 10].map(|at| switches(&mut supervisor, ask(true), after(at)).len()).iter().sum();
                let steered = ["Manual", "Sliding", "Retracting"].contains(&name);
                assert_eq!(sent, usize::from(steered && spindle), "{name}");
                assert_eq!(supervisor.spindle_runs(), (!spindle).then_some(true), "{name}");
            }
        }
    }
}
