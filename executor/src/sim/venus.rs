//! A controller that speaks Venus-1, as far as a host can see.
//!
//! From descriptions, not from a controller: words before spaces work on a stack of numbers; a `move` while one is under way
//! locks the interpreter until that is done, and `abort` waits in the same line. `abort` lets each axis slow down by
//! itself: the most that it could do to the path.

use std::collections::VecDeque;
use std::time::Duration;

use super::controller::{Controller, Disturbance};
use super::grbl::SimSettings;
use super::motion::{Drives, Sample};
use super::plant::Plant;
use crate::time::Time;

/// The simulated controller.
#[derive(Clone, Debug)]
pub struct VenusSim {
    settings: SimSettings,
    plant: Plant,
    rx: VecDeque<u8>,
    word: String,
    stack: Vec<f64>,
    /// It starts up, and hears nothing.
    deaf_until: Time,
    tx: Vec<u8>,
    /// Length of a coordinate's unit, mm: µm until it is set.
    unit_mm: f64,
    feed: f64,
    error: u16,
    /// A target that waits for the motion under way.
    locked: Option<(f64, f64)>,
}

/// So long it takes to start up after a reset.
const BOOT: Duration = Duration::from_millis(1500);
/// Longest word, deepest stack, and most bytes that wait.
const WORD_MAX: usize = 32;
const STACK_MAX: usize = 99;
const RX_MAX: usize = 256;

impl VenusSim {
    /// A controller that was just switched on.
    #[must_use]
    pub fn new(settings: SimSettings) -> Self {
        let drives = Drives::of(&settings.machine, 0.0);
        Self {
            plant: Plant::new(drives, settings.start_mm),
            feed: settings.machine.max_rate_mm_s,
            settings,
            rx: VecDeque::new(),
            word: String::new(),
            stack: Vec::new(),
            deaf_until: Time::ZERO,
            tx: Vec::new(),
            unit_mm: 0.001,
            error: 0,
            locked: None,
        }
    }

    /// Reads words until one has to wait.
    fn interpret(&mut self) {
        while !self.is_locked() {
            let Some(byte) = self.rx.pop_front() else { break };
            match byte {
                b' ' | b'\r' | b'\n' => {
                    let word = std::mem::take(&mut self.word);
                    if !word.is_empty() && self.execute(&word).is_none() {
                        self.error = 1008;
                    }
                }
                _ if self.word.len() < WORD_MAX => self.word.push(char::from(byte)),
                _ => self.error = 1004,
            }
        }
    }

    fn is_locked(&self) -> bool {
        self.locked.is_some() || self.plant.is_homing()
    }

    fn say(&mut self, text: &str) {
        self.tx.extend(text.bytes());
        self.tx.extend(b"\r\n");
    }

    /// `None` when numbers are missing.
    fn execute(&mut self, word: &str) -> Option<()> {
        if let Ok(number) = word.parse::<f64>() {
            if self.stack.len() < STACK_MAX && number.is_finite() {
                self.stack.push(number);
            }
            return Some(());
        }
        match word {
            "st" => self.say(if self.plant.is_busy() { "1" } else { "0" }),
            "p" | "pos" => {
                let steps = self.settings.machine.steps_per_mm;
                let coordinate = |mm: f64| (mm * steps).round() / steps / self.unit_mm;
                let (x, y) = self.plant.position();
                let text = format!("{:.6} {:.6}", coordinate(x), coordinate(y));
                self.say(&text);
            }
            "ge" => {
                let error = std::mem::take(&mut self.error);
                self.say(&error.to_string());
            }
            "getvel" => self.say(&format!("{:.6}", self.feed)),
            "getaccel" => self.say(&format!("{:.6}", self.settings.machine.acceleration_mm_s2)),
            "setvel" => self.feed = self.stack.pop()?.clamp(0.001, self.settings.machine.max_rate_mm_s),
            "setdim" | "j" => drop(self.stack.pop()?),
            "setunit" => {
                let axis = self.stack.pop()?;
                let unit = self.stack.pop()?;
                if axis > 0.5 {
                    self.unit_mm = if unit > 1.5 { 1.0 } else { 0.001 };
                }
            }
            "setpos" => drop((self.stack.pop()?, self.stack.pop()?)),
            "cal" | "rm" => self.plant.home(self.settings.homing / 2),
            "clear" => self.stack.clear(),
            "abort" => self.plant.stop_apart(),
            "move" => {
                let (y, x) = (self.stack.pop()?, self.stack.pop()?);
                self.drive((x * self.unit_mm, y * self.unit_mm));
            }
            _ => self.error = 1004,
        }
        Some(())
    }

    fn drive(&mut self, to: (f64, f64)) {
        let [width, height] = self.settings.machine.stroke_mm;
        if !(-width..=0.0).contains(&to.0) || !(-height..=0.0).contains(&to.1) {
            self.error = 1003;
        } else if self.plant.is_busy() {
            self.locked = Some(to);
        } else {
            self.plant.push(to, self.feed);
        }
    }

    fn unlock(&mut self) {
        if !self.plant.is_busy()
            && let Some(to) = self.locked.take()
        {
            self.plant.push(to, self.feed);
        }
    }
}

impl Controller for VenusSim {
    fn receive(&mut self, byte: u8) {
        if self.rx.len() < RX_MAX && self.plant.now() >= self.deaf_until {
            self.rx.push_back(byte);
        }
        if self.minds(byte) {
            self.interpret();
        }
    }

    fn minds(&self, byte: u8) -> bool {
        matches!(byte, b' ' | b'\r' | b'\n')
    }

    fn advance(&mut self, now: Time) {
        while let Some(event) = self.plant.next_event().filter(|&event| event < now && self.is_locked()) {
            self.plant.advance(event);
            self.unlock();
            self.interpret();
        }
        self.plant.advance(now);
        self.unlock();
        self.interpret();
    }

    fn next_event(&self) -> Time {
        self.plant.next_event().filter(|_| self.is_locked()).unwrap_or(Time::NEVER)
    }

    fn transmit(&mut self, into: &mut Vec<u8>) {
        into.append(&mut self.tx);
    }

    fn take_samples(&mut self, into: &mut Vec<Sample>) {
        self.plant.take_samples(into);
    }

    fn disturb(&mut self, disturbance: Disturbance) {
        self.plant.kill();
        self.locked = None;
        self.rx.clear();
        self.word.clear();
        self.stack.clear();
        match disturbance {
            Disturbance::Reset => {
                self.unit_mm = 0.001;
                self.deaf_until = self.plant.now().after(BOOT);
            }
            Disturbance::Alarm => self.error = 1009,
        }
    }
}
