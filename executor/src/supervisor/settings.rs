//! Controller settings that safety and steering rest on.

use super::manual::Limits;
use super::{Fault, Options};

/// Controller settings that the supervisor uses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Settings {
    report_mask: Option<f64>,
    arc_tolerance_mm: Option<f64>,
    inches: Option<f64>,
    homing: Option<f64>,
    steps_per_mm: [Option<f64>; 2],
    max_rate_mm_min: [Option<f64>; 2],
    acceleration_mm_s2: [Option<f64>; 2],
}

impl Settings {
    pub(super) fn take(&mut self, number: u16, value: f64) {
        match number {
            10 => self.report_mask = Some(value),
            12 => self.arc_tolerance_mm = Some(value),
            13 => self.inches = Some(value),
            22 => self.homing = Some(value),
            100 | 101 => self.steps_per_mm[usize::from(number - 100)] = Some(value),
            110 | 111 => self.max_rate_mm_min[usize::from(number - 110)] = Some(value),
            120 | 121 => self.acceleration_mm_s2[usize::from(number - 120)] = Some(value),
            _ => {}
        }
    }

    pub(super) fn check(&self, options: &Options) -> Result<(), Fault> {
        let steps_per_mm = options.steps_per_mm;
        let missing =
            |number| Fault::Setting { number, value: f64::NAN, needed: "reported by the controller" };
        let homing = self.homing.ok_or(missing(22))?;
        if homing < 1.0 {
            let needed = "1: without homing the position is not known";
            return Err(Fault::Setting { number: 22, value: homing, needed });
        }
        let inches = self.inches.ok_or(missing(13))?;
        if inches.abs() > 0.0 {
            return Err(Fault::Setting { number: 13, value: inches, needed: "0: positions are read in mm" });
        }
        for (number, value) in [(100, self.steps_per_mm[0]), (101, self.steps_per_mm[1])] {
            let value = value.ok_or(missing(number))?;
            if value.is_nan() || value < steps_per_mm * 0.999 {
                let needed = "at least the steps per mm that the plan's margin was made for";
                return Err(Fault::Setting { number, value, needed });
            }
        }
        Ok(())
    }

    /// Whether reports carry machine positions (bit 0) and planner blocks (bit 1).
    pub(super) fn reports_blocks(&self) -> bool {
        self.report_mask.is_some_and(|mask| mask.rem_euclid(4.0) >= 3.0)
    }

    /// Whether the arc tolerance is provably no more than `mm`: it is reported with three decimals.
    pub(super) fn follows_arcs(&self, mm: f64) -> bool {
        self.arc_tolerance_mm.is_some_and(|reported| reported >= 0.001 && reported + 0.0005 <= mm)
    }

    pub(super) fn limits(&self, fallback: Limits) -> Limits {
        let least = |values: [Option<f64>; 2], scale: f64, fallback: f64| {
            let known = values.into_iter().flatten().filter(|value| *value > 0.0);
            known.map(|value| value * scale).fold(fallback, f64::min)
        };
        Limits {
            speed_mm_s: least(self.max_rate_mm_min, 1.0 / 60.0, fallback.speed_mm_s),
            acceleration_mm_s2: least(self.acceleration_mm_s2, 1.0, fallback.acceleration_mm_s2),
        }
    }
}
