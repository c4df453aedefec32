//! What of a device's reading may move the tool.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_executor::operator::Panel;
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};

use super::reader::Reading;
use crate::input::stick::Stick;

/// A reading older than this counts as none: the thread that reads the device does not answer.
pub const STALE_AFTER: Duration = Duration::from_millis(100);
/// Asks that wait for their input.
const ASKS_MAX: usize = 8;

/// From readings to inputs. The stick counts only once it was seen centred with the dead-man released, since the
/// device was plugged in, lost events, or fell silent: a stick that is held meanwhile does not move the tool.
#[derive(Clone, Debug)]
pub struct EnablingInterlock {
    stick: Stick,
    panel: Panel,
    /// The connection for which the stick was seen at rest.
    rested: Option<u64>,
    asks: VecDeque<OperatorCommand>,
    /// What the last input commanded for.
    commanded: Option<OperatorCommand>,
    quit: bool,
}

impl EnablingInterlock {
    /// A hand at a stick of that shape, not yet seen at rest.
    #[must_use]
    pub fn new(stick: Stick, panel: Panel) -> Self {
        Self { stick, panel, rested: None, asks: VecDeque::new(), commanded: None, quit: false }
    }

    /// The input for what was read `age` ago. Handwheel turns and asks must not be in the same reading twice.
    ///
    /// Without a device nothing moves, and a contour is paused: who watches it could not stop it.
    pub fn input(&mut self, reading: &Reading, age: Duration, phase: Phase) -> OperatorInput {
        self.keep(&reading.asks);
        let stale = age > STALE_AFTER;
        if stale || !reading.known {
            if stale && self.rested.is_some() {
                self.panel
                    .say("the device does not answer in time: centre the stick, let go of the dead-man");
            }
            self.rested = None;
            let pause = (phase == Phase::Contouring).then_some(OperatorCommand::FeedHold);
            let command = self.next_ask().or(pause);
            return OperatorInput { command, ..OperatorInput::default() };
        }
        if self.stick.rests(reading.axes) && !reading.dead_man {
            self.rested = Some(reading.connection);
        }
        let mut input = OperatorInput {
            automatic: reading.automatic,
            command: self.next_ask(),
            ..OperatorInput::default()
        };
        if self.rested == Some(reading.connection) {
            input.velocity = self.stick.deflection(reading.axes, reading.dead_man);
            input.turned_mm = reading.turned_mm;
        }
        input
    }

    fn keep(&mut self, asks: &[OperatorCommand]) {
        for &command in asks {
            self.quit |= command == OperatorCommand::Stop;
            if self.asks.len() < ASKS_MAX {
                self.asks.push_back(command);
            }
        }
    }

    /// One command at a time; the same one twice has a input without it between. The input to quit stays.
    fn next_ask(&mut self) -> Option<OperatorCommand> {
        let repeated = self.commanded.is_some() && self.asks.front() == self.commanded.as_ref();
        let next = if repeated { None } else { self.asks.pop_front() };
        self.commanded = if self.quit { Some(OperatorCommand::Stop) } else { next };
        self.commanded
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::stick::StickSettings;

    const FRESH: Duration = Duration::from_millis(5);

    fn hand() -> EnablingInterlock {
        let settings = StickSettings { dead_zone: 0.1, expo: 0.0, top: 1.0 };
        EnablingInterlock::new(Stick::new(settings).unwrap(), Panel::default())
    }

    fn reading(x: f64, dead_man: bool) -> Reading {
        Reading { connection: 1, known: true, axes: (x, 0.0), dead_man, ..Reading::default() }
    }

    fn velocity(hand: &mut EnablingInterlock, reading: &Reading) -> (f64, f64) {
        hand.input(reading, FRESH, Phase::Manual).velocity
    }

    #[test]
    fn a_stick_held_while_plugged_in_moves_nothing_until_it_was_at_rest() {
        let mut hand = hand();
        let turned = Reading { turned_mm: (1.0, 0.0), ..reading(1.0, true) };
        assert_eq!(hand.input(&turned, FRESH, Phase::Manual), OperatorInput::default());
        assert_eq!(velocity(&mut hand, &reading(0.0, true)), (0.0, 0.0), "centred, but the dead-man is held");
        assert_eq!(velocity(&mut hand, &reading(1.0, true)), (0.0, 0.0));
        assert_eq!(velocity(&mut hand, &reading(1.0, false)), (0.0, 0.0), "released, but not centred");
        assert_eq!(velocity(&mut hand, &reading(1.0, true)), (0.0, 0.0));
        assert_eq!(velocity(&mut hand, &reading(0.05, false)), (0.0, 0.0));
        assert_eq!(velocity(&mut hand, &reading(1.0, true)), (1.0, 0.0));
        assert_eq!(hand.input(&turned, FRESH, Phase::Manual).turned_mm, (1.0, 0.0));
        let again = Reading { connection: 2, ..reading(1.0, true) };
        assert_eq!(velocity(&mut hand, &again), (0.0, 0.0), "unplugged and plugged in between two wishes");
    }

    #[test]
    fn a_held_stick_is_not_stale_but_a_silent_reader_is() {
        let mut hand = hand();
        velocity(&mut hand, &reading(0.0, false));
        let held = reading(1.0, true);
        for _ in 0..10_000 {
            assert_eq!(hand.input(&held, STALE_AFTER, Phase::Manual).velocity, (1.0, 0.0));
        }
        let late = STALE_AFTER + Duration::from_millis(1);
        assert_eq!(hand.input(&held, late, Phase::Manual), OperatorInput::default());
        assert_eq!(velocity(&mut hand, &held), (0.0, 0.0), "not again before it was at rest");
    }

    #[test]
    fn without_a_device_a_contour_is_paused() {
        let mut hand = hand();
        let gone = Reading { known: false, automatic: true, ..reading(1.0, true) };
        let input = hand.input(&gone, FRESH, Phase::Contouring);
        assert_eq!(
            input,
            OperatorInput { command: Some(OperatorCommand::FeedHold), ..OperatorInput::default() }
        );
        assert_eq!(hand.input(&gone, FRESH, Phase::Manual), OperatorInput::default());
    }

    #[test]
    fn asks_come_one_by_one_and_quit_stays() {
        let mut hand = hand();
        let asks = vec![OperatorCommand::FeedHold, OperatorCommand::FeedHold, OperatorCommand::CycleStart];
        let all = Reading { asks, ..reading(0.0, false) };
        let mut said = vec![hand.input(&all, FRESH, Phase::Manual).command];
        said.extend((0..4).map(|_| hand.input(&reading(0.0, false), FRESH, Phase::Manual).command));
        assert_eq!(
            said,
            [
                Some(OperatorCommand::FeedHold),
                None,
                Some(OperatorCommand::FeedHold),
                Some(OperatorCommand::CycleStart),
                None
            ]
        );
        let quit = Reading { asks: vec![OperatorCommand::Stop], ..reading(0.0, false) };
        hand.input(&quit, FRESH, Phase::Manual);
        assert_eq!(
            hand.input(&reading(0.0, false), FRESH, Phase::Manual).command,
            Some(OperatorCommand::Stop)
        );
    }
}
