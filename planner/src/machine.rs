//! Machine profiles: travel, dynamics and accuracy of a machine, as data.
//!
//! Implements SR-29.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use crate::contour_error::{ContourErrorSource, ContourErrorSourceError};
use crate::file::{FileError, FileKind};
use crate::text_file;

/// The file of a machine profile.
pub static MACHINE_PROFILE: FileKind = FileKind::new("machine profile");

/// Profile of a machine with two or three axes, and its controller. A figure holds for x and y each, except
/// where it states otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineProfile {
    /// Name of the machine.
    pub name: String,
    /// Full travel of x and y, mm. Where the controller reports its travel, a session compares the two.
    #[serde(deserialize_with = "text_file::pair")]
    pub travel_mm: [f64; 2],
    /// Rapid rate of an axis, mm/s.
    pub max_rate_mm_s: f64,
    /// Acceleration, mm/s².
    pub acceleration_mm_s2: f64,
    /// Steps per mm. The drive meets a commanded position to half a step.
    pub steps_per_mm: f64,
    /// Last digit of a reported position, mm.
    pub report_digit_mm: f64,
    /// Arc tolerance setting of the controller, mm (GRBL: `$12`). The controller's chords leave an arc by
    /// up to four times this.
    pub arc_tolerance_mm: f64,
    /// Half width of the band in which positions repeat, mm.
    pub repeatability_mm: f64,
    /// Largest distance of the true path from the commanded one in motion, mm.
    pub contour_error_mm: f64,
    /// How that figure was obtained.
    pub contour_error_source: ContourErrorSource,
    /// Speed at which the controller starts the spindle at the operator's command, rpm. Without it nobody but the
    /// operator switches the spindle.
    #[serde(default)]
    pub spindle_rpm: Option<u32>,
    /// The third axis. Without it the machine has two axes: nobody moves the tool up or down.
    #[serde(default)]
    pub z: Option<ZProfile>,
    /// Measured figures of the controller. `keepout doctor --conformance --store` writes them.
    #[serde(default)]
    pub controller: Option<ControllerProfile>,
}

/// The third axis: along the tool, upward.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZProfile {
    /// Full travel, mm.
    pub travel_mm: f64,
    /// Rapid rate, mm/s.
    pub max_rate_mm_s: f64,
    /// Acceleration, mm/s².
    pub acceleration_mm_s2: f64,
    /// Steps per mm.
    pub steps_per_mm: f64,
    /// Half width of the band in which heights repeat, mm.
    pub repeatability_mm: f64,
    /// Largest distance of the true height from the commanded one in motion, mm.
    pub following_error_mm: f64,
}

impl ZProfile {
    /// The third axis of the built-in simulated machine: 100 mm of travel.
    #[must_use]
    pub const fn simulated() -> Self {
        Self {
            travel_mm: 100.0,
            max_rate_mm_s: 50.0,
            acceleration_mm_s2: 400.0,
            steps_per_mm: 800.0,
            repeatability_mm: 0.004,
            following_error_mm: 0.005,
        }
    }

    /// Names, values and permitted ranges of its numbers.
    fn figures(&self) -> [(&'static str, f64, RangeInclusive<f64>); 6] {
        [
            ("z.travel_mm", self.travel_mm, 0.1..=5000.0),
            ("z.max_rate_mm_s", self.max_rate_mm_s, 1e-3..=1e5),
            ("z.acceleration_mm_s2", self.acceleration_mm_s2, 1e-3..=1e6),
            ("z.steps_per_mm", self.steps_per_mm, 0.1..=1e6),
            ("z.repeatability_mm", self.repeatability_mm, 0.0..=10.0),
            ("z.following_error_mm", self.following_error_mm, 0.0..=10.0),
        ]
    }
}

/// Figures of a controller, measured at the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerProfile {
    /// The firmware and its version, as the controller states them.
    #[serde(default)]
    pub firmware: String,
    /// Whether cancelled jogs stopped on their path. `false` makes a session assume that a cancel may
    /// leave the path. `true` only records a measurement, and no session relies on it.
    #[serde(default)]
    pub keeps_path_on_cancel: Option<bool>,
    /// Largest distance from the commanded path at a cancel, mm.
    #[serde(default)]
    pub largest_deviation_mm: Option<f64>,
    /// Longest time to an answer after a motion, ms.
    #[serde(default)]
    pub idle_delay_ms: Option<f64>,
    /// Number of blocks in the planner buffer.
    #[serde(default)]
    pub planner_blocks: Option<u32>,
    /// Size of the receive buffer, bytes.
    #[serde(default)]
    pub receive_buffer: Option<u32>,
    /// Median time from a status query to its answer, ms.
    #[serde(default)]
    pub report_latency_ms: Option<f64>,
}

impl ControllerProfile {
    /// Names, values and permitted ranges of its numbers.
    fn figures(&self) -> [(&'static str, Option<f64>, RangeInclusive<f64>); 5] {
        [
            ("largest_deviation_mm", self.largest_deviation_mm, 0.0..=5000.0),
            ("idle_delay_ms", self.idle_delay_ms, 0.0..=60_000.0),
            ("planner_blocks", self.planner_blocks.map(f64::from), 1.0..=1e6),
            ("receive_buffer", self.receive_buffer.map(f64::from), 1.0..=1e9),
            ("report_latency_ms", self.report_latency_ms, 0.0..=60_000.0),
        ]
    }
}

/// Source of the simulated machine's contour error. A test of the executor computes the figure again.
const SIMULATED_CONTOUR: &str = "drives budget: drives of the simulated machine, contouring MPC with observer, 3600 \
    mm/min, 12000 by hand, speeding up by 1000 mm/s², gain ±5 %, time constant ±5 %, up to 0 samples late";

/// Reason why a machine profile is refused.
#[derive(Debug, Error)]
pub enum MachineError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file does not hold a machine profile.
    #[error("{} is no machine profile: {reason}. Correct the file.", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Place in the file, and the fault there.
        reason: String,
    },
    /// A text has control characters.
    #[error("machine profile: {field} must be one line of printable characters. Correct the profile.")]
    Text {
        /// The field.
        field: &'static str,
    },
    /// A figure is out of range.
    #[error(
        "machine profile: {field} is {value}, it must be between {} and {}. Correct the profile.",
        range.start(), range.end()
    )]
    Figure {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Accepted range.
        range: RangeInclusive<f64>,
    },
}

impl MachineProfile {
    /// Built-in profile of the simulated machine: a 400 mm × 350 mm table under a GRBL 1.1 controller.
    #[must_use]
    pub fn simulated() -> Self {
        Self {
            name: "simulated GRBL 1.1 table".into(),
            travel_mm: [400.0, 350.0],
            max_rate_mm_s: 200.0,
            acceleration_mm_s2: 1000.0,
            steps_per_mm: 400.0,
            report_digit_mm: 0.001,
            arc_tolerance_mm: 0.000_5,
            repeatability_mm: 0.004,
            contour_error_mm: 0.009_5,
            contour_error_source: ContourErrorSource::Modelled(SIMULATED_CONTOUR.into()),
            spindle_rpm: None,
            z: None,
            controller: None,
        }
    }

    /// The same machine with a third axis.
    #[must_use]
    pub fn simulated_three_axes() -> Self {
        Self { z: Some(ZProfile::simulated()), ..Self::simulated() }
    }

    /// Reads a profile from a TOML file.
    ///
    /// # Errors
    /// [`MachineError`] that names the file and the field.
    pub fn load(path: &Path) -> Result<Self, MachineError> {
        Self::parse(path, &MACHINE_PROFILE.read_text(path)?)
    }

    /// The profile that `text` holds. Messages name `path`.
    ///
    /// # Errors
    /// [`MachineError`] that names the field.
    pub fn parse(path: &Path, text: &str) -> Result<Self, MachineError> {
        let profile: Self = toml::from_str(text).map_err(|error| MachineError::Parse {
            path: path.to_path_buf(),
            reason: text_file::reason(&error),
        })?;
        profile.checked()
    }

    /// Text of the profile as a TOML file.
    ///
    /// # Panics
    /// Never: every field has a form in TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("numbers and texts are TOML")
    }

    /// Checks that every figure is possible for a machine.
    ///
    /// # Errors
    /// [`MachineError::Figure`] for the first figure that is out of range; [`MachineError::Text`] for a
    /// text with control characters.
    pub fn checked(self) -> Result<Self, MachineError> {
        let firmware = self.controller.as_ref().map(|controller| controller.firmware.as_str());
        for (field, text) in [
            ("name", Some(self.name.as_str())),
            ("contour_error_source", Some(self.contour_error_source.details())),
            ("firmware", firmware),
        ] {
            if text.is_some_and(|text| text.contains(char::is_control)) {
                return Err(MachineError::Text { field });
            }
        }
        let sizes = [
            ("travel_mm", self.travel_mm[0], 0.1..=5000.0),
            ("travel_mm", self.travel_mm[1], 0.1..=5000.0),
            ("max_rate_mm_s", self.max_rate_mm_s, 1e-3..=1e5),
            ("acceleration_mm_s2", self.acceleration_mm_s2, 1e-3..=1e6),
            ("steps_per_mm", self.steps_per_mm, 0.1..=1e6),
            ("arc_tolerance_mm", self.arc_tolerance_mm, 0.000_5..=1.0),
            ("report_digit_mm", self.report_digit_mm, 0.0..=10.0),
            ("repeatability_mm", self.repeatability_mm, 0.0..=10.0),
            ("contour_error_mm", self.contour_error_mm, 0.0..=10.0),
        ];
        let of_z = self.z.iter().flat_map(ZProfile::figures);
        let of_spindle = self.spindle_rpm.map(|rpm| ("spindle_rpm", f64::from(rpm), 1.0..=500_000.0));
        for (field, value, range) in sizes.into_iter().chain(of_z).chain(of_spindle) {
            if !range.contains(&value) {
                return Err(MachineError::Figure { field, value, range });
            }
        }
        let figures = self.controller.iter().flat_map(ControllerProfile::figures);
        for (field, value, range) in figures.filter_map(|(field, value, range)| Some((field, value?, range)))
        {
            if !range.contains(&value) {
                return Err(MachineError::Figure { field, value, range });
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_is_read_as_it_was_written() {
        let details = "drives budget: \"drives\", 900 mm/min".to_string();
        for source in [ContourErrorSource::Measured, ContourErrorSource::Modelled, ContourErrorSource::Stated]
        {
            let source = source(details.clone());
            let profile =
                MachineProfile { contour_error_source: source, ..MachineProfile::simulated_three_axes() };
            assert_eq!(toml::from_str::<MachineProfile>(&profile.to_toml()).unwrap(), profile);
        }
    }

    #[test]
    fn contour_error_without_its_source_is_refused() {
        let text = MachineProfile::simulated().to_toml();
        let without: String = text
            .lines()
            .filter(|line| !line.starts_with("contour_error_source"))
            .map(|line| format!("{line}\n"))
            .collect();
        for text in [without.clone(), format!("{without}contour_error_source = \"a guess\"\n")] {
            let error = MachineProfile::parse(Path::new("any.toml"), &text).expect_err("nobody said how");
            assert!(error.to_string().contains("contour_error_source"), "{error}");
        }
    }

    /// Found by the fuzzer: a profile with a step of a million kilometres was accepted.
    // Evidence for SR-29.
    #[test]
    fn impossible_figures_are_refused() {
        let usual = MachineProfile::simulated().to_toml();
        for (from, to) in [
            ("steps_per_mm = 400.0", "steps_per_mm = 1e-12"),
            ("acceleration_mm_s2 = 1000.0", "acceleration_mm_s2 = 1e-300"),
            ("max_rate_mm_s = 200.0", "max_rate_mm_s = nan"),
            ("[400.0, 350.0]", "[400.0, 1e-9]"),
        ] {
            assert!(usual.contains(from), "{from}");
            let error = MachineProfile::parse(Path::new("any.toml"), &usual.replace(from, to)).expect_err(to);
            assert!(error.to_string().contains("must be between"), "{error}");
        }
    }

    #[test]
    fn impossible_figures_of_the_controller_are_refused() {
        for wrong in ["idle_delay_ms = -1.0", "planner_blocks = 0", "largest_deviation_mm = inf", "speed = 1"]
        {
            let text = format!("{}\n[controller]\n{wrong}\n", MachineProfile::simulated().to_toml());
            assert!(MachineProfile::parse(Path::new("any.toml"), &text).is_err(), "{wrong}");
        }
    }

    /// The program prints the name beside its proofs: a second line could look like one.
    #[test]
    fn name_with_a_line_break_is_refused() {
        let text = MachineProfile::simulated().to_toml().replace("GRBL 1.1 table", "table\\nproved  yes");
        let error = MachineProfile::parse(Path::new("two.toml"), &text).expect_err("it has two lines");
        assert!(error.to_string().contains("name must be"), "{error}");
    }

    #[test]
    fn travel_of_three_axes_is_refused() {
        let text = MachineProfile::simulated().to_toml().replace("350.0]", "350.0, 120.0]");
        let error = MachineProfile::parse(Path::new("three.toml"), &text).expect_err("it has two axes");
        let error = error.to_string();
        assert!(
            error.contains("travel_mm = [400.0, 350.0, 120.0]") && error.contains("an array of two"),
            "{error}"
        );
    }
}
