//! The keyboard: held keys, steps and operator commands. Independent of terminals and clocks.
//!
//! | key | does |
//! |---|---|
//! | arrows; home, page up, end, page down | jog, straight and diagonally |
//! | +, - | up, down, in a session with three axes |
//! | u | raise the tool to the safe height |
//! | c, digits, enter | cross to a contour |
//! | m | the spindle runs, or stands |
//! | 1–4 | speed, or the step's size in step mode |
//! | s | step mode: each press is one step |
//! | space | stop at once |
//! | a | cycle armed, on or off |
//! | p, r, f | pause (feed hold), resume (cycle start), recover after a fault |
//! | t | take the present place, while the program aligns the part |
//! | ?, h | help, on or off |
//! | q, Ctrl-C | quit |

use std::collections::VecDeque;
use std::time::Duration;

use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;

use super::handwheel::{Handwheel, StepSize, WheelAxis};
pub use super::key::{Key, Stroke};

/// Time that a push lasts after the last event of its key.
pub const HELD: Duration = Duration::from_millis(150);
/// Longest time until the first repeat of a key, for terminals that report releases. After it a push ends.
pub const FIRST_REPEAT: Duration = Duration::from_millis(700);
/// Shares of full speed of the keys 1 to 4.
pub const SPEEDS: [f64; 4] = [0.05, 0.2, 0.5, 1.0];
/// Most commands that wait for an input.
const COMMANDS_MAX: usize = 8;

/// State of the keyboard: held keys, selections and waiting commands.
///
/// Most terminals do not report releases. A push then lasts [`HELD`] beyond the last press or repeat. Of two
/// held keys the terminal repeats only the later one. With release events, a push lasts until the release. It
/// also ends when a repeat is overdue, because a lost connection must not leave a key held.
#[derive(Clone, Debug)]
pub struct Keys {
    /// Whether the terminal reports releases.
    releases: bool,
    /// The held jog keys, each with the end of its push.
    held: Vec<(Push, Time)>,
    speed: usize,
    stepping: bool,
    wheel: Handwheel,
    armed: bool,
    stopped: bool,
    help: bool,
    /// Places that the operator took and the program has not read.
    taken: usize,
    /// The digits of a contour's number that is being typed.
    crossing: Option<String>,
    /// The last statement about the spindle.
    spindle: bool,
    commands: VecDeque<OperatorCommand>,
}

/// A direction of a jog key: −1, 0 or 1 in x, y and upward.
type Push = (i8, i8, i8);

/// Most digits of a contour's number.
const DIGITS_MAX: usize = 6;

impl Keys {
    /// A keyboard with no key held, speed 2 of 4 and steps of 0.1 mm. `releases`: whether the terminal
    /// reports releases.
    #[must_use]
    pub fn new(releases: bool) -> Self {
        Self {
            releases,
            held: Vec::new(),
            speed: 1,
            stepping: false,
            wheel: Handwheel::default(),
            armed: false,
            stopped: false,
            help: false,
            taken: 0,
            crossing: None,
            spindle: false,
            commands: VecDeque::new(),
        }
    }

    /// Takes a key event of the time `at`.
    pub fn take(&mut self, key: Key, stroke: Stroke, at: Time) {
        match (key, stroke) {
            (Key::Jog(x, y), Stroke::Up) => self.release((x, y, 0), at),
            (Key::Lift(up), Stroke::Up) => self.release((0, 0, up), at),
            (_, Stroke::Up) => {}
            (Key::Jog(x, y), Stroke::Down) => self.press((x, y, 0), at),
            (Key::Lift(up), Stroke::Down) => self.press((0, 0, up), at),
            (Key::Jog(..) | Key::Lift(_), Stroke::Repeat) => self.repeat(at),
            // A repeated character has no further effect. The stop of the space key stays set without it.
            (_, Stroke::Repeat) => {}
            (key, Stroke::Down) => self.select(key),
        }
    }

    /// The input at `now`.
    pub fn input(&mut self, phase: Phase, now: Time) -> OperatorInput {
        self.held.retain(|held| now < held.1);
        // A contact start disarms the cycle: the next contour needs a new key.
        self.armed &= !matches!(phase, Phase::Touching | Phase::Contouring);
        if self.stopped {
            // Space stops a contour with a feed hold.
            if phase == Phase::Contouring && self.commands.is_empty() {
                self.commands.push_back(OperatorCommand::FeedHold);
            }
            return OperatorInput { armed: self.armed, ..OperatorInput::default() };
        }
        let (turned, (velocity, up)) = (self.wheel.take_mm(), self.velocity());
        OperatorInput { velocity, turned_mm: turned.plane(), up, turned_up_mm: turned.z, armed: self.armed }
    }

    /// Takes the next command that the operator gave.
    pub fn command(&mut self) -> Option<OperatorCommand> {
        self.commands.pop_front()
    }

    /// Number of places that the operator took since the last call.
    pub fn take_taken(&mut self) -> usize {
        std::mem::take(&mut self.taken)
    }

    /// Whether the keys are to be explained.
    #[must_use]
    pub fn help(&self) -> bool {
        self.help
    }

    /// Whether space was the last key pressed.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Status line: speed or step size, whether the cycle is armed, and whether space stopped the motion.
    #[must_use]
    pub fn status(&self) -> String {
        let mut status = if self.stepping {
            format!("step {}", self.wheel.step().text())
        } else {
            format!("speed {:.0} %", SPEEDS[self.speed] * 100.0)
        };
        if self.armed {
            status += ", ARMED";
        }
        if let Some(digits) = &self.crossing {
            status = format!("cross to contour {digits}_: digits, then enter");
        }
        if self.stopped {
            status += ", stopped: press a key";
        }
        status
    }

    /// The velocity in the plane, and upward.
    fn velocity(&self) -> (Mm2, f64) {
        let along =
            |axis: fn(Push) -> i8| f64::from(self.held.iter().map(|held| axis(held.0)).sum::<i8>().signum());
        let plane = Mm2::new(along(|push| push.0), along(|push| push.1));
        let share = SPEEDS[self.speed];
        (plane * (share / plane.length().max(1.0)), along(|push| push.2) * share)
    }

    fn press(&mut self, towards: Push, at: Time) {
        self.stopped = false;
        self.crossing = None;
        if self.stepping {
            self.wheel.turn_axis(WheelAxis::X, towards.0.into());
            self.wheel.turn_axis(WheelAxis::Y, towards.1.into());
            self.wheel.turn_axis(WheelAxis::Z, towards.2.into());
            return;
        }
        self.held.retain(|held| held.0 != towards && at < held.1);
        let until = if self.releases { FIRST_REPEAT } else { HELD };
        self.held.push((towards, at.after(until)));
        if self.releases {
            self.hold_all(at.after(until));
        }
    }

    /// Extends the push of every held key. Only the last key repeats, but its repeat shows that the
    /// connection is alive. The terminal would have reported a release of the other keys.
    fn repeat(&mut self, at: Time) {
        self.held.retain(|held| at < held.1);
        self.hold_all(at.after(HELD));
    }

    fn release(&mut self, towards: Push, at: Time) {
        self.held.retain(|held| held.0 != towards && at < held.1);
        // The other held keys do not repeat any more. They last until a first repeat would be overdue.
        self.hold_all(at.after(FIRST_REPEAT));
    }

    fn hold_all(&mut self, until: Time) {
        for held in &mut self.held {
            held.1 = held.1.max(until);
        }
    }

    fn stop(&mut self) {
        self.held.clear();
        self.wheel.forget();
        self.stopped = true;
    }

    /// Acts on a key that does not jog.
    fn select(&mut self, key: Key) {
        self.stopped = false;
        if let Some(mut digits) = self.crossing.take() {
            match key {
                Key::Character(digit @ '0'..='9') if digits.len() < DIGITS_MAX => {
                    digits.push(digit);
                    self.crossing = Some(digits);
                    return;
                }
                Key::Character('\n') => {
                    if let Ok(contour) = digits.parse() {
                        self.give(OperatorCommand::Cross { contour });
                    }
                    return;
                }
                _ => {}
            }
        }
        match key {
            Key::Character('u') => self.give(OperatorCommand::Raise),
            Key::Character('c') => self.crossing = Some(String::new()),
            Key::Character('m') => {
                self.spindle = !self.spindle;
                self.give(OperatorCommand::Spindle { runs: self.spindle });
            }
            Key::Interrupt | Key::Character('q') => self.give(OperatorCommand::Stop),
            Key::Character(' ') => self.stop(),
            Key::Character('a') => self.armed = !self.armed,
            Key::Character('t') => self.taken += 1,
            Key::Character('?' | 'h') => self.help = !self.help,
            Key::Character('p') => self.give(OperatorCommand::FeedHold),
            Key::Character('r') => self.give(OperatorCommand::CycleStart),
            Key::Character('f') => self.give(OperatorCommand::Recover),
            Key::Character('s') => {
                self.stop();
                self.stopped = false;
                self.stepping = !self.stepping;
            }
            Key::Character(digit @ '1'..='4') => {
                let index = usize::try_from(u32::from(digit) - u32::from('1')).unwrap_or(0);
                if self.stepping {
                    self.wheel.set_step(StepSize::ALL[index]);
                } else {
                    self.speed = index;
                }
            }
            _ => {}
        }
    }

    /// Keeps a command until the session takes it. Stop is never dropped.
    fn give(&mut self, command: OperatorCommand) {
        if self.commands.len() < COMMANDS_MAX || command == OperatorCommand::Stop {
            self.commands.truncate(COMMANDS_MAX - 1);
            self.commands.push_back(command);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGHT: Key = Key::Jog(1, 0);
    const UP: Key = Key::Jog(0, 1);

    fn ms(millis: u64) -> Time {
        Time::from_micros(millis * 1000)
    }

    fn velocity(keys: &mut Keys, at: u64) -> Mm2 {
        keys.input(Phase::Manual, ms(at)).velocity
    }

    fn fast(releases: bool) -> Keys {
        let mut keys = Keys::new(releases);
        keys.take(Key::Character('4'), Stroke::Down, ms(0));
        keys
    }

    #[test]
    fn push_outlasts_its_last_key_event_by_150_ms() {
        let mut keys = fast(false);
        keys.take(RIGHT, Stroke::Down, ms(100));
        assert_eq!(velocity(&mut keys, 100), Mm2::new(1.0, 0.0));
        assert_eq!(velocity(&mut keys, 249), Mm2::new(1.0, 0.0));
        assert_eq!(velocity(&mut keys, 250), Mm2::ZERO);
        for at in (300..2000).step_by(30) {
            keys.take(RIGHT, Stroke::Down, ms(at));
            assert_eq!(velocity(&mut keys, at + 29), Mm2::new(1.0, 0.0));
        }
        assert_eq!(velocity(&mut keys, 2150), Mm2::ZERO);
    }

    #[test]
    fn press_that_is_read_late_does_not_move() {
        let mut keys = fast(false);
        keys.take(RIGHT, Stroke::Down, ms(100));
        assert_eq!(velocity(&mut keys, 5000), Mm2::ZERO);
    }

    #[test]
    fn opposite_keys_cancel_and_diagonals_are_no_faster() {
        let mut keys = fast(false);
        keys.take(RIGHT, Stroke::Down, ms(0));
        keys.take(UP, Stroke::Down, ms(10));
        let Mm2 { x, y } = velocity(&mut keys, 20);
        assert!((x.hypot(y) - 1.0).abs() < 1e-12 && x == y);
        keys.take(Key::Jog(-1, 0), Stroke::Down, ms(20));
        assert_eq!(velocity(&mut keys, 30), Mm2::new(0.0, 1.0));
        keys.take(Key::Jog(1, 1), Stroke::Down, ms(400));
        assert!((velocity(&mut keys, 401).x - 0.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn with_release_events_a_key_moves_until_its_release_or_a_missing_repeat() {
        let mut keys = fast(true);
        keys.take(RIGHT, Stroke::Down, ms(0));
        assert_eq!(velocity(&mut keys, 500), Mm2::new(1.0, 0.0), "before the first repeat");
        (500..3000).step_by(30).for_each(|at| keys.take(RIGHT, Stroke::Repeat, ms(at)));
        assert_eq!(velocity(&mut keys, 3050), Mm2::new(1.0, 0.0));
        keys.take(RIGHT, Stroke::Up, ms(3060));
        assert_eq!(velocity(&mut keys, 3060), Mm2::ZERO);
        keys.take(RIGHT, Stroke::Repeat, ms(3070));
        assert_eq!(velocity(&mut keys, 3070), Mm2::ZERO, "a repeat without a press does not move");
        keys.take(RIGHT, Stroke::Down, ms(4000));
        keys.take(RIGHT, Stroke::Repeat, ms(4690));
        assert_eq!(velocity(&mut keys, 4830), Mm2::new(1.0, 0.0));
        assert_eq!(velocity(&mut keys, 4841), Mm2::ZERO, "the connection is lost");
    }

    #[test]
    fn with_release_events_an_earlier_held_key_keeps_moving() {
        let mut keys = fast(true);
        keys.take(RIGHT, Stroke::Down, ms(0));
        keys.take(UP, Stroke::Down, ms(100));
        (600..2000).step_by(30).for_each(|at| keys.take(UP, Stroke::Repeat, ms(at)));
        let Mm2 { x, y } = velocity(&mut keys, 2010);
        assert!(x > 0.7 && y > 0.7);
        keys.take(UP, Stroke::Up, ms(2020));
        assert_eq!(velocity(&mut keys, 2030), Mm2::new(1.0, 0.0));
        assert_eq!(velocity(&mut keys, 2800), Mm2::ZERO, "no key event for too long");
    }

    #[test]
    fn contact_start_disarms_the_cycle() {
        let mut keys = Keys::new(false);
        keys.take(Key::Character('a'), Stroke::Down, ms(0));
        assert!(keys.input(Phase::Manual, ms(1)).armed && keys.status().contains("ARMED"));
        keys.input(Phase::Touching, ms(2));
        assert!(!keys.input(Phase::Manual, ms(3)).armed && !keys.status().contains("ARMED"));
    }

    #[test]
    fn question_mark_explains_the_keys() {
        let mut keys = Keys::new(false);
        keys.take(Key::Character('?'), Stroke::Down, ms(0));
        assert!(keys.help());
        keys.take(Key::Character('h'), Stroke::Down, ms(1));
        assert!(!keys.help());
    }

    #[test]
    fn steps_are_counted_and_bounded() {
        let mut keys = Keys::new(false);
        for key in ['s', '2'] {
            keys.take(Key::Character(key), Stroke::Down, ms(0));
        }
        keys.take(RIGHT, Stroke::Down, ms(1));
        keys.take(RIGHT, Stroke::Down, ms(2));
        keys.take(Key::Jog(0, -1), Stroke::Down, ms(3));
        let input = keys.input(Phase::Manual, ms(10));
        assert_eq!((input.velocity, input.turned_mm), (Mm2::ZERO, Mm2::new(0.02, -0.01)));
        assert_eq!(keys.input(Phase::Manual, ms(20)).turned_mm, Mm2::ZERO);
        (0..1000).for_each(|_| keys.take(RIGHT, Stroke::Down, ms(30)));
        assert_eq!(keys.input(Phase::Manual, ms(40)).turned_mm, Mm2::new(0.1, 0.0));
        assert_eq!(keys.status(), "step 0.01 mm");
    }

    #[test]
    fn space_stops_at_once_until_the_next_key() {
        for releases in [false, true] {
            let mut keys = fast(releases);
            keys.take(RIGHT, Stroke::Down, ms(0));
            keys.take(Key::Character(' '), Stroke::Down, ms(10));
            assert!(keys.stopped() && velocity(&mut keys, 11) == Mm2::ZERO);
            keys.take(RIGHT, Stroke::Repeat, ms(20));
            keys.take(RIGHT, Stroke::Up, ms(25));
            assert!(keys.stopped() && velocity(&mut keys, 26) == Mm2::ZERO);
            assert_eq!(keys.command(), None);
            keys.input(Phase::Contouring, ms(27));
            assert_eq!(keys.command(), Some(OperatorCommand::FeedHold));
            keys.take(UP, Stroke::Down, ms(30));
            assert!(!keys.stopped() && velocity(&mut keys, 31) == Mm2::new(0.0, 1.0));
        }
    }

    #[test]
    fn plus_and_minus_move_the_third_axis_and_c_crosses() {
        let mut keys = fast(false);
        keys.take(Key::Lift(-1), Stroke::Down, ms(0));
        keys.take(RIGHT, Stroke::Down, ms(10));
        let input = keys.input(Phase::Manual, ms(20));
        assert_eq!((input.velocity, input.up), (Mm2::new(1.0, 0.0), -1.0));
        assert_eq!(keys.input(Phase::Manual, ms(170)).up, 0.0);
        for key in ['c', '1', '2', '\n', 'u', 'm', 'm', 'c', '3', 'p', '\n', 'c', '\n'] {
            keys.take(Key::Character(key), Stroke::Down, ms(200));
        }
        let given: Vec<_> = std::iter::from_fn(|| keys.command()).collect();
        let spindle = |runs| OperatorCommand::Spindle { runs };
        let cross = OperatorCommand::Cross { contour: 12 };
        assert_eq!(
            given,
            [cross, OperatorCommand::Raise, spindle(true), spindle(false), OperatorCommand::FeedHold]
        );
        keys.take(Key::Character('s'), Stroke::Down, ms(300));
        keys.take(Key::Lift(1), Stroke::Down, ms(301));
        assert_eq!(keys.input(Phase::Manual, ms(302)).turned_up_mm, 0.1);
    }

    #[test]
    fn each_command_key_gives_one_command_and_quit_is_never_dropped() {
        let mut keys = Keys::new(false);
        for key in ['p', 'p', 'f', 'a'] {
            keys.take(Key::Character(key), Stroke::Down, ms(0));
        }
        let given: Vec<_> = (0..4).map(|_| keys.command()).collect();
        let (hold, recover) = (Some(OperatorCommand::FeedHold), Some(OperatorCommand::Recover));
        assert_eq!(given, [hold, hold, recover, None]);
        assert!(keys.input(Phase::Manual, ms(60)).armed);
        (0..100).for_each(|_| keys.take(Key::Character('p'), Stroke::Down, ms(65)));
        keys.take(Key::Interrupt, Stroke::Down, ms(70));
        let given: Vec<_> = std::iter::from_fn(|| keys.command()).collect();
        assert_eq!((given.len(), given.last()), (COMMANDS_MAX, Some(&OperatorCommand::Stop)));
    }
}
