//! The keyboard: keys that are held, steps, and words to the supervisor; free of terminals and clocks.
//!
//! | key | does |
//! |---|---|
//! | arrows; home, page up, end, page down | steer, straight and diagonally |
//! | 1–4 | speed, or the step's size in step mode |
//! | s | step mode: each press is one step |
//! | space | stop at once |
//! | a | automatic mode on or off |
//! | p, r, f | pause, resume, recover after a fault |
//! | q, Ctrl-C | quit |

use std::collections::VecDeque;
use std::time::Duration;

use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;

use super::handwheel::{Handwheel, StepSize, WheelAxis};

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// One of the keys that steer; −1, 0 or 1 in x and y, up is +y.
    Steer(i8, i8),
    /// A letter, digit or space; letters in lower case.
    Character(char),
    /// Ctrl-C.
    Interrupt,
    /// Any other key.
    Other,
}

/// What happened to a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// It went down; where the terminal can not tell, it repeated.
    Down,
    /// It is still held.
    Repeat,
    /// It went up.
    Up,
}

/// A push outlasts the last sign of its key by this time.
pub const HELD: Duration = Duration::from_millis(150);
/// A key whose release will be told is believed to be held until its first repeat is overdue.
pub const FIRST_REPEAT: Duration = Duration::from_millis(700);
/// Shares of full speed, keys 1 to 4.
pub const SPEEDS: [f64; 4] = [0.05, 0.2, 0.5, 1.0];
/// Asks that wait for their input.
const ASKS_MAX: usize = 8;

/// The keys that are held, and what else was typed.
///
/// Most terminals tell no releases: a push then lasts [`HELD`] beyond the last press or repeat, and of two keys held
/// only the later one is repeated. Where releases are told a push lasts until its release, but not beyond an overdue
/// repeat: a lost connection must not leave a key held.
#[derive(Clone, Debug)]
pub struct Keys {
    releases: bool,
    /// The keys that steer and are held, each with the end of its push.
    held: Vec<((i8, i8), Time)>,
    speed: usize,
    stepping: bool,
    wheel: Handwheel,
    automatic: bool,
    stopped: bool,
    quit: bool,
    asks: VecDeque<OperatorCommand>,
    commanded: Option<OperatorCommand>,
}

impl Keys {
    /// No key held; speed 2 of 4, steps of 0.1 mm. `releases`: whether the terminal tells of releases.
    #[must_use]
    pub fn new(releases: bool) -> Self {
        Self {
            releases,
            held: Vec::new(),
            speed: 1,
            stepping: false,
            wheel: Handwheel::default(),
            automatic: false,
            stopped: false,
            quit: false,
            asks: VecDeque::new(),
            commanded: None,
        }
    }

    /// Takes a stroke that happened at `at`.
    pub fn take(&mut self, key: Key, stroke: Stroke, at: Time) {
        match (key, stroke) {
            (Key::Steer(x, y), Stroke::Up) => self.release((x, y), at),
            (_, Stroke::Up) => {}
            (Key::Steer(x, y), Stroke::Down) => self.press((x, y), at),
            (Key::Steer(..), Stroke::Repeat) => self.repeat(at),
            // A character that repeats says nothing more; space holds on to its stop by itself.
            (_, Stroke::Repeat) => {}
            (key, Stroke::Down) => self.word(key),
        }
    }

    /// The input at `now`.
    pub fn input(&mut self, phase: Phase, now: Time) -> OperatorInput {
        if self.quit {
            return OperatorInput::STOP;
        }
        self.held.retain(|held| now < held.1);
        let command = self.next_ask(phase);
        if self.stopped {
            return OperatorInput { automatic: self.automatic, command, ..OperatorInput::default() };
        }
        OperatorInput {
            velocity: self.velocity(),
            turned_mm: self.wheel.take_mm(),
            automatic: self.automatic,
            command,
        }
    }

    /// Whether space was pressed, and nothing since.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Speed or step size, and what is switched on, to be shown.
    #[must_use]
    pub fn status(&self) -> String {
        let mut status = if self.stepping {
            format!("step {}", self.wheel.step().text())
        } else {
            format!("speed {:.0} %", SPEEDS[self.speed] * 100.0)
        };
        if self.automatic {
            status += ", automatic";
        }
        if self.stopped {
            status += ", stopped: press a key";
        }
        status
    }

    fn velocity(&self) -> (f64, f64) {
        let sum = self.held.iter().fold((0, 0), |sum, held| (sum.0 + held.0.0, sum.1 + held.0.1));
        let (x, y) = (f64::from(sum.0.signum()), f64::from(sum.1.signum()));
        let scale = SPEEDS[self.speed] / x.hypot(y).max(1.0);
        (x * scale, y * scale)
    }

    fn press(&mut self, towards: (i8, i8), at: Time) {
        self.stopped = false;
        if self.stepping {
            self.wheel.turn_axis(WheelAxis::X, towards.0.into());
            self.wheel.turn_axis(WheelAxis::Y, towards.1.into());
            return;
        }
        self.held.retain(|held| held.0 != towards && at < held.1);
        let until = if self.releases { FIRST_REPEAT } else { HELD };
        self.held.push((towards, at.after(until)));
        if self.releases {
            self.hold_all(at.after(until));
        }
    }

    /// Only the last key repeats; that it does shows that the others' releases would have been told, too.
    fn repeat(&mut self, at: Time) {
        self.held.retain(|held| at < held.1);
        self.hold_all(at.after(HELD));
    }

    fn release(&mut self, towards: (i8, i8), at: Time) {
        self.held.retain(|held| held.0 != towards && at < held.1);
        // The keys that are still held do not repeat any more: they last until that is overdue.
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

    fn word(&mut self, key: Key) {
        self.stopped = false;
        match key {
            Key::Interrupt | Key::Character('q') => self.quit = true,
            Key::Character(' ') => self.stop(),
            Key::Character('a') => self.automatic = !self.automatic,
            Key::Character('p') => self.command(OperatorCommand::FeedHold),
            Key::Character('r') => self.command(OperatorCommand::CycleStart),
            Key::Character('f') => self.command(OperatorCommand::Recover),
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

    fn command(&mut self, command: OperatorCommand) {
        if self.asks.len() < ASKS_MAX {
            self.asks.push_back(command);
        }
    }

    /// One command at a time; the same one twice has a input without it between. Space stops a contour by pausing it.
    fn next_ask(&mut self, phase: Phase) -> Option<OperatorCommand> {
        let repeated = self.commanded.is_some() && self.asks.front() == self.commanded.as_ref();
        self.commanded = if repeated { None } else { self.asks.pop_front() };
        self.commanded.or((self.stopped && phase == Phase::Contouring).then_some(OperatorCommand::FeedHold))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGHT: Key = Key::Steer(1, 0);
    const UP: Key = Key::Steer(0, 1);

    fn ms(millis: u64) -> Time {
        Time::from_micros(millis * 1000)
    }

    fn velocity(keys: &mut Keys, at: u64) -> (f64, f64) {
        keys.input(Phase::Manual, ms(at)).velocity
    }

    fn fast(releases: bool) -> Keys {
        let mut keys = Keys::new(releases);
        keys.take(Key::Character('4'), Stroke::Down, ms(0));
        keys
    }

    #[test]
    fn a_push_outlasts_its_last_sign_by_a_moment() {
        let mut keys = fast(false);
        keys.take(RIGHT, Stroke::Down, ms(100));
        assert_eq!(velocity(&mut keys, 100), (1.0, 0.0));
        assert_eq!(velocity(&mut keys, 249), (1.0, 0.0));
        assert_eq!(velocity(&mut keys, 250), (0.0, 0.0));
        for at in (300..2000).step_by(30) {
            keys.take(RIGHT, Stroke::Down, ms(at));
            assert_eq!(velocity(&mut keys, at + 29), (1.0, 0.0));
        }
        assert_eq!(velocity(&mut keys, 2150), (0.0, 0.0));
    }

    #[test]
    fn a_press_that_is_read_late_does_not_move() {
        let mut keys = fast(false);
        keys.take(RIGHT, Stroke::Down, ms(100));
        assert_eq!(velocity(&mut keys, 5000), (0.0, 0.0));
    }

    #[test]
    fn opposite_keys_cancel_and_diagonals_are_no_faster() {
        let mut keys = fast(false);
        keys.take(RIGHT, Stroke::Down, ms(0));
        keys.take(UP, Stroke::Down, ms(10));
        let (x, y) = velocity(&mut keys, 20);
        assert!((x.hypot(y) - 1.0).abs() < 1e-12 && x == y);
        keys.take(Key::Steer(-1, 0), Stroke::Down, ms(20));
        assert_eq!(velocity(&mut keys, 30), (0.0, 1.0));
        keys.take(Key::Steer(1, 1), Stroke::Down, ms(400));
        assert!((velocity(&mut keys, 401).0 - 0.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn where_releases_are_told_a_key_moves_until_its_release_or_a_missing_repeat() {
        let mut keys = fast(true);
        keys.take(RIGHT, Stroke::Down, ms(0));
        assert_eq!(velocity(&mut keys, 500), (1.0, 0.0), "before the first repeat");
        (500..3000).step_by(30).for_each(|at| keys.take(RIGHT, Stroke::Repeat, ms(at)));
        assert_eq!(velocity(&mut keys, 3050), (1.0, 0.0));
        keys.take(RIGHT, Stroke::Up, ms(3060));
        assert_eq!(velocity(&mut keys, 3060), (0.0, 0.0));
        keys.take(RIGHT, Stroke::Repeat, ms(3070));
        assert_eq!(velocity(&mut keys, 3070), (0.0, 0.0), "a repeat presses nothing");
        keys.take(RIGHT, Stroke::Down, ms(4000));
        keys.take(RIGHT, Stroke::Repeat, ms(4690));
        assert_eq!(velocity(&mut keys, 4830), (1.0, 0.0));
        assert_eq!(velocity(&mut keys, 4841), (0.0, 0.0), "the connection is lost");
    }

    #[test]
    fn a_key_held_below_another_goes_on_while_releases_are_told() {
        let mut keys = fast(true);
        keys.take(RIGHT, Stroke::Down, ms(0));
        keys.take(UP, Stroke::Down, ms(100));
        (600..2000).step_by(30).for_each(|at| keys.take(UP, Stroke::Repeat, ms(at)));
        let (x, y) = velocity(&mut keys, 2010);
        assert!(x > 0.7 && y > 0.7);
        keys.take(UP, Stroke::Up, ms(2020));
        assert_eq!(velocity(&mut keys, 2030), (1.0, 0.0));
        assert_eq!(velocity(&mut keys, 2800), (0.0, 0.0), "no sign of the keyboard for long");
    }

    #[test]
    fn steps_are_counted_and_bounded() {
        let mut keys = Keys::new(false);
        for key in ['s', '2'] {
            keys.take(Key::Character(key), Stroke::Down, ms(0));
        }
        keys.take(RIGHT, Stroke::Down, ms(1));
        keys.take(RIGHT, Stroke::Down, ms(2));
        keys.take(Key::Steer(0, -1), Stroke::Down, ms(3));
        let input = keys.input(Phase::Manual, ms(10));
        assert_eq!((input.velocity, input.turned_mm), ((0.0, 0.0), (0.02, -0.01)));
        assert_eq!(keys.input(Phase::Manual, ms(20)).turned_mm, (0.0, 0.0));
        (0..1000).for_each(|_| keys.take(RIGHT, Stroke::Down, ms(30)));
        assert_eq!(keys.input(Phase::Manual, ms(40)).turned_mm, (0.1, 0.0));
        assert_eq!(keys.status(), "step 0.01 mm");
    }

    #[test]
    fn space_stops_at_once_until_the_next_key() {
        for releases in [false, true] {
            let mut keys = fast(releases);
            keys.take(RIGHT, Stroke::Down, ms(0));
            keys.take(Key::Character(' '), Stroke::Down, ms(10));
            assert!(keys.stopped() && velocity(&mut keys, 11) == (0.0, 0.0));
            keys.take(RIGHT, Stroke::Repeat, ms(20));
            keys.take(RIGHT, Stroke::Up, ms(25));
            assert!(keys.stopped() && velocity(&mut keys, 26) == (0.0, 0.0));
            assert_eq!(keys.input(Phase::Contouring, ms(27)).command, Some(OperatorCommand::FeedHold));
            keys.take(UP, Stroke::Down, ms(30));
            assert!(!keys.stopped() && velocity(&mut keys, 31) == (0.0, 1.0));
        }
    }

    #[test]
    fn words_are_asked_once_and_quit_stays() {
        let mut keys = Keys::new(false);
        for key in ['p', 'p', 'f', 'a'] {
            keys.take(Key::Character(key), Stroke::Down, ms(0));
        }
        let said: Vec<_> = (0..5).map(|i| keys.input(Phase::Manual, ms(10 * i)).command).collect();
        assert_eq!(
            said,
            [
                Some(OperatorCommand::FeedHold),
                None,
                Some(OperatorCommand::FeedHold),
                Some(OperatorCommand::Recover),
                None
            ]
        );
        assert!(keys.input(Phase::Manual, ms(60)).automatic);
        keys.take(Key::Interrupt, Stroke::Down, ms(70));
        assert_eq!(keys.input(Phase::Manual, ms(80)), OperatorInput::STOP);
        assert_eq!(keys.input(Phase::Manual, ms(90)), OperatorInput::STOP);
    }
}
