//! The keyboard: held keys, steps and operator commands. Independent of terminals and clocks.
//!
//! Implements SR-21, SR-24.
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
    /// Whether the spindle runs, as the session knows it.
    spindle_runs: bool,
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
            spindle_runs: false,
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

    /// Takes note of whether the spindle runs, as the session knows it. The key of the spindle asks for the other.
    pub fn see_spindle(&mut self, runs: bool) {
        self.spindle_runs = runs;
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
            Key::Character('m') => self.give(OperatorCommand::Spindle { runs: !self.spindle_runs }),
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
mod tests;
