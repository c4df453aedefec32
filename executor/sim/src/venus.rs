//! A simulated Venus-1 controller, as far as a host can observe it.
//!
//! It follows descriptions, not a controller. Words end with spaces and work on a stack of numbers. A `move`
//! during another one locks the interpreter until the first is done, and `abort` then waits in the same line.
//! `abort` slows down each axis independently, which is the largest possible deviation from the path.
//!
//! A reset restores the saved settings: µm, three dimensions, full speed. The tool's present position becomes
//! zero, and the axes are not calibrated. The controller still moves when it receives as many numbers as it
//! has dimensions.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_drives::interpolator::Drives;
use keepout_executor::session::Sample;
use keepout_guard::Time;
use keepout_planner::Mm2;

use super::controller::{Disturbance, SimulatedController};
use super::grbl::SimSettings;
use super::plant::Plant;

/// The simulated controller.
#[derive(Clone, Debug)]
pub struct VenusSim {
    settings: SimSettings,
    plant: Plant,
    rx: VecDeque<u8>,
    word: String,
    stack: Vec<f64>,
    /// The controller starts up and reads no byte until this time.
    deaf_until: Time,
    tx: Vec<u8>,
    memory: Memory,
    error: u16,
    /// A target that waits for the end of the present motion.
    locked: Option<Mm2>,
    /// Machine coordinates of its zero, mm.
    zero: Mm2,
    /// The ends that homing found, equal for both axes: see [`NEAR`] and [`FAR`].
    calibrated: u8,
    /// The end that homing searches.
    searches: Option<u8>,
    /// The end where homing stopped. The simulated tool does not move there.
    stands: Option<Mm2>,
}

/// The settings that the controller can save and restores after a reset.
#[derive(Clone, Copy, Debug)]
struct Memory {
    /// Numbers per position.
    dimensions: usize,
    /// Units of velocities and of the two axes: 1 is µm, 2 mm.
    units: [u8; 3],
    /// mm/s.
    feed: f64,
}

impl Memory {
    /// The saved settings.
    fn saved(settings: &SimSettings) -> Self {
        Self { dimensions: 3, units: [1; 3], feed: settings.machine.max_rate_mm_s }
    }

    /// The unit of velocities or of an axis, mm.
    fn unit_mm(&self, index: usize) -> f64 {
        if self.units.get(index) == Some(&2) { 1.0 } else { 0.001 }
    }
}

/// `cal` found the near end.
const NEAR: u8 = 1;
/// `rm` found the far end.
const FAR: u8 = 2;

/// Start-up time after a reset.
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
            memory: Memory::saved(&settings),
            zero: if settings.homed { Mm2::ZERO } else { settings.start_mm.plane() },
            calibrated: if settings.homed { NEAR | FAR } else { 0 },
            searches: None,
            stands: None,
            settings,
            rx: VecDeque::new(),
            word: String::new(),
            stack: Vec::new(),
            deaf_until: Time::ZERO,
            tx: Vec::new(),
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

    /// Executes a word. `None` when numbers are missing on the stack.
    fn execute(&mut self, word: &str) -> Option<()> {
        if let Ok(number) = word.parse::<f64>() {
            if self.stack.len() < STACK_MAX && number.is_finite() {
                self.stack.push(number);
            }
            return Some(());
        }
        match word {
            "st" => self.say(if self.plant.is_busy() { "1" } else { "0" }),
            "p" | "pos" => self.say_place(),
            "ge" => {
                let error = std::mem::take(&mut self.error);
                self.say(&error.to_string());
            }
            "getvel" => self.say(&format!("{:.6}", self.memory.feed / self.memory.unit_mm(0))),
            "getaccel" => {
                let acceleration = self.settings.machine.acceleration_mm_s2;
                self.say(&format!("{:.6}", acceleration / self.memory.unit_mm(0)));
            }
            "getdim" => self.say(&self.memory.dimensions.to_string()),
            "getunit" => {
                let unit = self.index().and_then(|index| self.memory.units.get(index).copied())?;
                self.say(&unit.to_string());
            }
            "getcaldone" => {
                self.index()?;
                self.say(&self.calibrated.to_string());
            }
            "setvel" => {
                let feed = self.stack.pop()? * self.memory.unit_mm(0);
                self.memory.feed = feed.clamp(0.001, self.settings.machine.max_rate_mm_s);
            }
            "setdim" => self.memory.dimensions = self.index().filter(|count| (1..=3).contains(count))?,
            "setunit" => {
                let (index, unit) = (self.index()?, self.index()?);
                *self.memory.units.get_mut(index)? = u8::try_from(unit).ok()?;
            }
            "restore" => self.memory = Memory::saved(&self.settings),
            "j" => drop(self.stack.pop()?),
            "setpos" => {
                let place = self.pop_place()?;
                self.zero = self.stands.unwrap_or(self.plant.position().plane()) - place;
            }
            "cal" => self.search(NEAR),
            "rm" => self.search(FAR),
            "clear" => self.stack.clear(),
            "abort" => self.plant.stop_apart(),
            "move" => {
                let place = self.pop_place()?;
                self.drive(self.zero + place);
            }
            _ => self.error = 1004,
        }
        Some(())
    }

    fn say_place(&mut self) {
        let steps = self.settings.machine.steps_per_mm;
        let coordinate = |mm: f64, unit_mm: f64| (mm * steps).round() / steps / unit_mm;
        let Mm2 { x, y } = self.plant.position().plane();
        let x = coordinate(x - self.zero.x, self.memory.unit_mm(1));
        let y = coordinate(y - self.zero.y, self.memory.unit_mm(2));
        let text = match self.memory.dimensions {
            1 => format!("{x:.6}"),
            2 => format!("{x:.6} {y:.6}"),
            _ => format!("{x:.6} {y:.6} 0.000000"),
        };
        self.say(&text);
    }

    /// A small whole number from the stack.
    fn index(&mut self) -> Option<usize> {
        let number = self.stack.pop()?;
        (0..4_u8).find(|&index| number == f64::from(index)).map(usize::from)
    }

    /// Takes a position from the stack, mm from zero. If numbers are missing, the others stay on the stack.
    fn pop_place(&mut self) -> Option<Mm2> {
        let first = self.stack.len().checked_sub(self.memory.dimensions)?;
        let numbers: Vec<f64> = self.stack.drain(first..).collect();
        let of = |index: usize| numbers.get(index).map(|number| number * self.memory.unit_mm(index + 1));
        Some(Mm2::new(of(0)?, of(1).unwrap_or(self.plant.position().y - self.zero.y)))
    }

    fn search(&mut self, end: u8) {
        self.calibrated &= !end;
        self.searches = Some(end);
        self.plant.home(self.settings.homing / 2);
    }

    /// Moves to a position in machine coordinates. Before both ends are found the controller has no soft
    /// limits, and the axes stop at their switches.
    fn drive(&mut self, to: Mm2) {
        let [width, height] = self.settings.machine.travel_mm;
        let within = Mm2::new(to.x.clamp(-width, 0.0), to.y.clamp(-height, 0.0));
        self.stands = None;
        if self.calibrated == NEAR | FAR && within != to {
            self.error = 1003;
        } else if self.plant.is_busy() {
            self.locked = Some(within);
        } else {
            self.plant.push(within.at_height(0.0), self.memory.feed);
        }
    }

    fn unlock(&mut self) {
        if !self.plant.is_busy()
            && let Some(to) = self.locked.take()
        {
            self.plant.push(to.at_height(0.0), self.memory.feed);
        }
        if !self.plant.is_homing()
            && let Some(end) = self.searches.take()
        {
            let [width, height] = self.settings.machine.travel_mm;
            let at = if end == NEAR { Mm2::new(-width, -height) } else { Mm2::ZERO };
            self.calibrated |= end;
            self.stands = Some(at);
            // `cal` sets zero at the near end.
            self.zero = if end == NEAR { at } else { self.zero };
        }
    }
}

impl SimulatedController for VenusSim {
    fn receive(&mut self, byte: u8) {
        if self.rx.len() < RX_MAX && self.plant.now() >= self.deaf_until {
            self.rx.push_back(byte);
        }
        if self.is_realtime(byte) {
            self.interpret();
        }
    }

    fn is_realtime(&self, byte: u8) -> bool {
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

    fn is_moving(&self) -> bool {
        self.plant.is_moving()
    }

    fn disturb(&mut self, disturbance: Disturbance) {
        self.plant.kill();
        self.locked = None;
        self.searches = None;
        self.rx.clear();
        self.word.clear();
        self.stack.clear();
        match disturbance {
            Disturbance::Reset | Disturbance::BrownOut => {
                self.memory = Memory::saved(&self.settings);
                (self.calibrated, self.error, self.stands) = (0, 0, None);
                self.zero = self.plant.position().plane();
                self.deaf_until = self.plant.now().after(BOOT);
            }
            Disturbance::Alarm => self.error = 1009,
        }
    }
}

#[cfg(test)]
mod tests {
    use keepout_planner::machine::MachineProfile;

    use super::*;

    fn controller() -> VenusSim {
        let mut venus = VenusSim::new(SimSettings {
            work_offset_mm: Mm2::ZERO.at_height(0.0),
            ..SimSettings::of(MachineProfile::simulated(), Mm2::new(-20.0, -30.0).at_height(0.0))
        });
        hear(&mut venus, b"restore 2 0 setunit 2 1 setunit 2 2 setunit 2 setdim ");
        venus
    }

    fn hear(venus: &mut VenusSim, bytes: &[u8]) -> String {
        venus.tx.clear();
        bytes.iter().for_each(|&byte| venus.receive(byte));
        String::from_utf8_lossy(&venus.tx).into_owned()
    }

    fn wait(venus: &mut VenusSim, seconds: u64) {
        venus.advance(venus.plant.now().after(Duration::from_secs(seconds)));
    }

    /// A reset cuts a line and its copy at every byte.
    #[test]
    fn motion_of_two_numbers_is_not_executed_after_a_reset() {
        let line = b"10.000 setvel clear clear clear clear -19.5 -31 move st ".repeat(2);
        let whole = line.len() / 2;
        for cut in 0..line.len() {
            let mut venus = controller();
            hear(&mut venus, &line[..cut]);
            venus.advance(venus.plant.now().after(Duration::from_millis(20)));
            venus.disturb(Disturbance::Reset);
            let stopped = venus.plant.position();
            assert!(stopped == Mm2::new(-20.0, -30.0).at_height(0.0) || cut > whole / 2, "{cut}");
            wait(&mut venus, 2);
            hear(&mut venus, &line[cut..]);
            wait(&mut venus, 5);
            assert_eq!(venus.plant.position(), stopped, "{cut}");
            assert_eq!(
                hear(&mut venus, b"p "),
                "0.000000 0.000000 0.000000\r\n",
                "the controller counts from there"
            );
        }
    }

    #[test]
    fn motion_of_three_numbers_is_executed_from_the_new_zero_after_a_reset() {
        let mut venus = controller();
        venus.disturb(Disturbance::Reset);
        wait(&mut venus, 2);
        assert_eq!(hear(&mut venus, b"1 getcaldone "), "0\r\n");
        hear(&mut venus, b"-500 -1000 0 move ");
        wait(&mut venus, 5);
        assert_eq!(venus.plant.position(), Mm2::new(-20.5, -31.0).at_height(0.0));
    }

    #[test]
    fn homing_finds_both_ends_and_the_far_one_becomes_zero() {
        let mut venus = controller();
        venus.disturb(Disturbance::Reset);
        wait(&mut venus, 2);
        hear(&mut venus, b"2 1 setunit 2 2 setunit 2 setdim cal rm 0 0 setpos ");
        wait(&mut venus, 2);
        assert_eq!(hear(&mut venus, b"1 getcaldone p "), "3\r\n-20.000000 -30.000000\r\n");
    }
}
