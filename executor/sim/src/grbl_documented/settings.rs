//! What the firmware keeps in its EEPROM: settings, work offsets and startup lines. A reset and a power failure
//! leave it as it is.
//!
//! Source: `doc/markdown/settings.md`, "Grbl's `$x=val` settings and what they mean".

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::axes::{Triple, each, triple};
use super::words::LineErrorCode;
use crate::SimSettings;

/// Highest work coordinate system: G54 to G59 are 0 to 5.
pub(super) const SYSTEMS: usize = 6;

/// The stored content.
#[derive(Clone, Debug)]
pub(super) struct EepromContent {
    values: BTreeMap<u16, f64>,
    /// The startup lines `$N0` and `$N1`.
    pub startup: [String; 2],
    /// The user's text of `$I`.
    pub build_text: String,
    /// The offsets of G54 to G59, machine coordinates, mm.
    pub systems: [Triple; SYSTEMS],
    /// The places of G28 and G30, machine coordinates, mm.
    pub parked: [Triple; 2],
}

/// Settings that are whole numbers.
const WHOLE: [u16; 17] = [0, 1, 2, 3, 4, 5, 6, 10, 13, 20, 21, 22, 23, 26, 30, 31, 32];
/// Travel, rate, acceleration and steps of a third axis that the machine profile does not describe.
const Z_TRAVEL_MM: f64 = 100.0;
const Z_RATE_MM_S: f64 = 50.0;
const Z_ACCELERATION: f64 = 400.0;
const Z_STEPS: f64 = 400.0;
/// Distance that homing leaves between the tool and the switches, mm: the default of `$27`.
const PULL_OFF_MM: f64 = 1.0;

impl EepromContent {
    /// The content for a machine: soft limits, hard limits and homing are on.
    pub fn of(sim: &SimSettings) -> Self {
        let machine = &sim.machine;
        let [width, height] = machine.travel_mm;
        let z = machine.z.as_ref();
        let idle =
            if sim.quirks.idle_delay.is_zero() { 255.0 } else { sim.quirks.idle_delay.as_secs_f64() * 1e3 };
        let mut values: BTreeMap<u16, f64> = BTreeMap::from([
            (0, 10.0),
            (1, idle),
            (2, 0.0),
            (3, 0.0),
            (4, 0.0),
            (5, 0.0),
            (6, 0.0),
            (10, 1.0),
            (11, 0.010),
            (12, machine.arc_tolerance_mm),
            (13, 0.0),
            (20, 1.0),
            (21, 1.0),
            (22, 1.0),
            (23, 0.0),
            (24, 25.0),
            (25, 500.0),
            (26, 250.0),
            (27, PULL_OFF_MM),
            (30, 10_000.0),
            (31, 0.0),
            (32, 0.0),
        ]);
        let rows = [
            (100, [machine.steps_per_mm; 2], z.map_or(Z_STEPS, |z| z.steps_per_mm)),
            (110, [machine.max_rate_mm_s * 60.0; 2], z.map_or(Z_RATE_MM_S, |z| z.max_rate_mm_s) * 60.0),
            (120, [machine.acceleration_mm_s2; 2], z.map_or(Z_ACCELERATION, |z| z.acceleration_mm_s2)),
            (130, [width, height], z.map_or(Z_TRAVEL_MM, |z| z.travel_mm)),
        ];
        for (first, [x, y], z) in rows {
            values.extend([(first, x), (first + 1, y), (first + 2, z)]);
        }
        let mut systems = [[0.0; 3]; SYSTEMS];
        systems[0] = triple(sim.work_offset_mm);
        Self {
            values,
            startup: sim.quirks.startup.clone(),
            build_text: String::new(),
            systems,
            parked: [[0.0; 3]; 2],
        }
    }

    /// The value of a setting; zero for an unknown one.
    pub fn value(&self, number: u16) -> f64 {
        self.values.get(&number).copied().unwrap_or(0.0)
    }

    /// Whether a setting with the meaning of a switch is on.
    pub fn is_on(&self, number: u16) -> bool {
        self.value(number) != 0.0
    }

    /// The three values of `$100`, `$110`, `$120` or `$130` and the two settings after it.
    pub fn axes(&self, first: u16) -> Triple {
        let values = [first, first + 1, first + 2].map(|number| self.value(number));
        each(|axis| values[axis])
    }

    /// Stores a value.
    pub fn store(&mut self, number: u16, value: f64) -> Result<(), LineErrorCode> {
        if value < 0.0 {
            return Err(LineErrorCode::NEGATIVE);
        }
        match number {
            0 if value < 3.0 => return Err(LineErrorCode::SHORT_PULSE),
            20 if value != 0.0 && !self.is_on(22) => return Err(LineErrorCode::SOFT_LIMITS_WITHOUT_HOMING),
            _ => {}
        }
        let stored = self.values.get_mut(&number).ok_or(LineErrorCode::STATEMENT)?;
        *stored = if WHOLE.contains(&number) { value.trunc() } else { value };
        // Soft limits need homing.
        if number == 22 && value == 0.0 {
            self.values.insert(20, 0.0);
        }
        Ok(())
    }

    /// The answer to `$$`.
    pub fn listing(&self) -> String {
        let mut text = String::new();
        for (number, value) in &self.values {
            // Writing to a string does not fail.
            let _ = if WHOLE.contains(number) {
                write!(text, "${number}={value:.0}\r\n")
            } else {
                write!(text, "${number}={value:.3}\r\n")
            };
        }
        text
    }

    /// The answer to `$N`.
    pub fn startup_listing(&self) -> String {
        format!("$N0={}\r\n$N1={}\r\n", self.startup[0], self.startup[1])
    }
}
