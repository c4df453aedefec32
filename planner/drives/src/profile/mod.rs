//! Machine profiles of feed drives, as TOML.

mod axis;

use std::path::Path as FilePath;

use keepout_planner::file::{FileError, FileKind};
use keepout_planner::text_file;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::controllers::Belief;
use super::controllers::kind::{Kind, Setting};
use super::controllers::selection::Environment;
use super::drive::Drive;
use super::gains::Gains;
use super::plant::{MOST_DELAY, PlantModel};
use super::run::Cutting;
pub use axis::{AxisProfile, ResonanceProfile};
use axis::{X_FIELDS, Y_FIELDS};

/// Two feed drives with their amplifiers, encoders, loads and controller gains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveProfile {
    /// Name of the machine.
    pub name: String,
    /// Origin of the values.
    pub source: String,
    /// Encoder pulses per mm of travel: Ke of the paper, where one BLU is one pulse.
    pub pulses_per_mm: f64,
    /// T, the sampling period, s.
    pub period_s: f64,
    /// Largest command, bits. Without it, commands have no limit.
    pub limit_bits: Option<f64>,
    /// Whether encoders count whole pulses and commands are whole bits.
    #[serde(default)]
    pub whole_numbers: bool,
    /// Delay of the commands, samples.
    #[serde(default)]
    pub delay_samples: usize,
    /// The X drive.
    pub x: AxisProfile,
    /// The Y drive.
    pub y: AxisProfile,
    /// The cutting force. Without it, no force acts.
    pub cutting: Option<CuttingProfile>,
    /// The controller that the drives really run, with the gains below. Without it nobody knows, and no margin
    /// can be computed.
    pub controller: Option<Kind>,
    /// Gains of the controllers.
    pub gains: Gains,
    /// Uncertainty of the gains and time constants.
    #[serde(default)]
    pub uncertainty: Uncertainty,
    /// Limits of the interpolator that makes the reference. Without it, the feed is constant, as in the
    /// paper.
    pub interpolator: Option<Interpolator>,
}

/// The cutting force of eqs. (2) to (4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CuttingProfile {
    /// Force at the feed `at_feed_mm_min`, bits.
    pub bits: f64,
    /// Feed at which the force was stated, mm/min. At other feeds it follows eq. (2).
    pub at_feed_mm_min: f64,
    /// Angle between force and tangent, degrees.
    pub angle_deg: f64,
}

/// Largest deviation of the drives from the model, as shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// Deviation of the gains.
    pub gain: f64,
    /// Deviation of the time constants.
    pub time_constant: f64,
    /// Largest delay that the controller does not know, samples. One by default: a command is computed while the
    /// sample goes on.
    #[serde(default = "one_sample")]
    pub delay_samples: f64,
}

fn one_sample() -> f64 {
    1.0
}

impl Uncertainty {
    /// The larger of the two.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.gain.max(self.time_constant)
    }
}

impl Default for Uncertainty {
    /// "Modeling errors of 2% to 5% or even higher in some parameters are more realistic" (section 7.1).
    fn default() -> Self {
        Self { gain: 0.05, time_constant: 0.05, delay_samples: one_sample() }
    }
}

/// Limits of an interpolator that slows down for corners and ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interpolator {
    /// Acceleration of an axis, mm/s².
    pub acceleration_mm_s2: f64,
    /// Top speed of an axis, mm/s.
    pub max_rate_mm_s: f64,
    /// Junction deviation, mm (GRBL `$11`).
    pub junction_deviation_mm: f64,
}

/// Reasons for which a profile is rejected.
#[derive(Debug, Error)]
pub enum DriveProfileError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is not a profile.
    #[error("{name} is not a feed-drive profile: {reason}. Correct the file.")]
    Parse {
        /// The file.
        name: String,
        /// The place and the problem.
        reason: String,
    },
    /// A value is out of range.
    #[error("{name}: {field} is {value}, it must be {range}. Correct the profile.")]
    Figure {
        /// The file.
        name: String,
        /// The field.
        field: &'static str,
        /// The value of the field.
        value: f64,
        /// The accepted range.
        range: String,
    },
}

static DRIVE_PROFILE: FileKind = FileKind {
    unreadable: "Check the path, or take one of the built-in profiles: koren-lo-table-1, \
                 koren-lo-table-1-mismatched, koren-lo-table-2, nsk-modules, simulated.",
    ..FileKind::new("drive profile")
};

/// The built-in profiles, as names and TOML texts.
pub const BUILT_IN: [(&str, &str); 5] = [
    ("koren-lo-table-1", include_str!("../machines/koren-lo-table-1.toml")),
    ("koren-lo-table-1-mismatched", include_str!("../machines/koren-lo-table-1-mismatched.toml")),
    ("koren-lo-table-2", include_str!("../machines/koren-lo-table-2.toml")),
    ("nsk-modules", include_str!("../machines/nsk-modules.toml")),
    ("simulated", include_str!("../machines/simulated.toml")),
];

impl DriveProfile {
    /// The drives of the built-in simulated machine.
    ///
    /// # Errors
    /// [`DriveProfileError`] if the built-in profile is invalid.
    pub fn simulated() -> Result<Self, DriveProfileError> {
        Self::load("simulated")
    }

    /// Loads a built-in profile by its name, or a profile from a TOML file.
    ///
    /// # Errors
    /// [`DriveProfileError`] with the file and the field.
    pub fn load(name: &str) -> Result<Self, DriveProfileError> {
        if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
            return Self::parse(name, text);
        }
        Self::parse(name, &DRIVE_PROFILE.read_text(FilePath::new(name))?)
    }

    /// The profile as TOML, which [`DriveProfile::parse`] reads.
    ///
    /// # Errors
    /// [`DriveProfileError`] if a value is out of range.
    pub fn to_toml(&self) -> Result<String, DriveProfileError> {
        let text = toml::to_string(self).map_err(|error| DriveProfileError::Parse {
            name: self.name.clone(),
            reason: error.to_string(),
        })?;
        Self::parse(&self.name, &text)?;
        Ok(text)
    }

    /// Reads a profile from `text`. Messages refer to it by `name`.
    ///
    /// # Errors
    /// [`DriveProfileError`] with the field.
    pub fn parse(name: &str, text: &str) -> Result<Self, DriveProfileError> {
        let profile: Self = toml::from_str(text).map_err(|error| DriveProfileError::Parse {
            name: name.into(),
            reason: text_file::reason(&error),
        })?;
        match profile.out_of_range() {
            None => Ok(profile),
            Some((field, value, range)) => {
                Err(DriveProfileError::Figure { name: name.into(), field, value, range })
            }
        }
    }

    /// The first value that is out of range, with its field and the accepted range.
    fn out_of_range(&self) -> Option<(&'static str, f64, String)> {
        #[expect(clippy::cast_precision_loss, reason = "a few samples")]
        let delay = self.delay_samples as f64;
        let mut figures = vec![
            ("pulses_per_mm", self.pulses_per_mm, (0.1, 1e6)),
            ("period_s", self.period_s, (1e-5, 1.0)),
            ("limit_bits", self.limit_bits.unwrap_or(1.0), (1e-6, 1e9)),
            ("delay_samples", delay, (0.0, MOST_DELAY_F)),
            ("uncertainty.gain", self.uncertainty.gain, (0.0, 0.9)),
            ("uncertainty.time_constant", self.uncertainty.time_constant, (0.0, 0.9)),
            ("uncertainty.delay_samples", self.uncertainty.delay_samples, (0.0, 1.0)),
        ];
        for (axis, names) in [(self.x, X_FIELDS), (self.y, Y_FIELDS)] {
            figures.extend(axis.figures(&names, self.period_s));
        }
        let gains = self.gains.figures().into_iter();
        figures.extend(gains.map(|each| (each.field, each.value, each.range.into_inner())));
        if let Some(cutting) = self.cutting {
            figures.push(("cutting.bits", cutting.bits, (0.0, 1e9)));
            figures.push(("cutting.at_feed_mm_min", cutting.at_feed_mm_min, (1.0, 600_000.0)));
            figures.push(("cutting.angle_deg", cutting.angle_deg, (-360.0, 360.0)));
        }
        if let Some(interpolator) = self.interpolator {
            figures.push(("acceleration_mm_s2", interpolator.acceleration_mm_s2, (1e-3, 1e6)));
            figures.push(("max_rate_mm_s", interpolator.max_rate_mm_s, (1e-3, 1e5)));
            figures.push(("junction_deviation_mm", interpolator.junction_deviation_mm, (0.0, 10.0)));
        }
        let wrong = figures.into_iter().find(|(_, value, (least, most))| !(least..=most).contains(&value));
        wrong.map(|(field, value, (least, most))| (field, value, format!("between {least} and {most}")))
    }

    /// The two drives.
    #[must_use]
    pub fn drives(&self) -> [Drive; 2] {
        [self.x, self.y].map(|axis| Drive { gain: axis.gain, time_constant_s: axis.time_constant_s })
    }

    /// The plant, with sticking friction.
    #[must_use]
    pub fn plant(&self) -> PlantModel {
        PlantModel {
            axes: [self.x, self.y].map(|axis| axis.axis(self.pulses_per_mm)),
            period_s: self.period_s,
            limit: self.limit_bits,
            whole_numbers: self.whole_numbers,
            delay_samples: self.delay_samples,
            delay_share: 0.0,
        }
    }

    /// The drive model of a controller that knows these drives.
    #[must_use]
    pub fn belief(&self) -> Belief {
        let Self { period_s, limit_bits: limit, delay_samples, .. } = *self;
        // The middle of the range in which the delay lies.
        let delay_share = (self.uncertainty.delay_samples / 2.0).clamp(0.0, 0.999);
        let friction = [self.x, self.y].map(|axis| axis.axis(self.pulses_per_mm).friction_belief());
        Belief { drives: self.drives(), period_s, limit, delay_samples, delay_share, friction }
    }

    /// The settings of a controller that knows these drives exactly.
    #[must_use]
    pub fn setting(&self, environment: Environment) -> Setting {
        Setting { belief: self.belief(), gains: self.gains, environment, round: None }
    }

    /// The cutting force in the plant's units.
    #[must_use]
    pub fn cutting(&self) -> Option<Cutting> {
        self.cutting.map(|cutting| Cutting {
            bits: cutting.bits,
            at_feed: self.feed(cutting.at_feed_mm_min / 1000.0),
            up_to_feed: f64::INFINITY,
            angle: cutting.angle_deg.to_radians(),
        })
    }

    /// Length of a pulse, µm.
    #[must_use]
    pub fn um(&self) -> f64 {
        1000.0 / self.pulses_per_mm
    }

    /// Converts a feed from m/min to pulses/s.
    #[must_use]
    pub fn feed(&self, m_min: f64) -> f64 {
        m_min * 1000.0 / 60.0 * self.pulses_per_mm
    }
}

/// [`MOST_DELAY`] as a real number.
#[expect(clippy::cast_precision_loss, reason = "a few samples")]
const MOST_DELAY_F: f64 = MOST_DELAY as f64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_profiles_are_read() {
        for (name, _) in BUILT_IN {
            let profile = DriveProfile::load(name).unwrap();
            assert!(!profile.source.is_empty(), "{name}");
        }
    }

    #[test]
    fn profiles_are_written_as_they_were_read() {
        for (name, _) in BUILT_IN {
            let profile = DriveProfile::load(name).unwrap();
            assert_eq!(DriveProfile::parse(name, &profile.to_toml().unwrap()).unwrap(), profile, "{name}");
        }
    }

    /// Pre-sliding and resonance of one axis, as a machinist writes them.
    #[test]
    fn physics_of_an_axis_is_optional() {
        let physics = "coulomb_bits = 100.0\nstiction_bits = 120.0\npresliding_mm = 0.02\nstribeck_mm_s = 2.0\n\
                       backlash_mm = 0.01\nresonance = { frequency_hz = 40.0, damping = 0.05, table_share = 0.4 }";
        let text = BUILT_IN[0].1.replacen("coulomb_bits = 100.0", physics, 1);
        let profile = DriveProfile::parse("x.toml", &text).unwrap();
        assert_eq!(DriveProfile::parse("x.toml", &profile.to_toml().unwrap()).unwrap(), profile);
        let [x, y] = profile.plant().axes;
        let presliding = x.presliding.unwrap();
        assert!((presliding.stiffness - 50.0).abs() < 1e-9 && (presliding.stribeck - 200.0).abs() < 1e-9);
        assert!((x.resonance.unwrap().angular - 251.327).abs() < 1e-3);
        assert!((profile.belief().friction[0].presliding - 2.0).abs() < 1e-9);
        assert!(y.presliding.is_none() && y.resonance.is_none());
    }

    #[test]
    fn out_of_range_values_are_rejected_with_their_field() {
        let text = BUILT_IN[0].1;
        for (from, to, says) in [
            ("gain = 10.0", "gain = -1.0", "x.gain is -1"),
            ("gain = 10.0", "gain = nan", "x.gain is NaN"),
            ("period_s = 0.004", "period_s = 0.0", "period_s is 0"),
            ("coulomb_bits = 100.0", "coulomb_bits = 100.0\nstiction_bits = 3.0", "x.stiction_bits is 3"),
            ("coulomb_bits = 100.0", "presliding_mm = 0.01", "x.coulomb_bits is 0"),
            ("coulomb_bits = 100.0", "coulomb_bits = 100.0\npresliding_mm = 0.0", "x.presliding_mm is 0"),
            (
                "coulomb_bits = 100.0",
                "resonance = { frequency_hz = 40.0, damping = 0.05, table_share = 1.0 }",
                "x.resonance.table_share is 1",
            ),
            ("[x]", "[z]", "z"),
            ("period_s", "delay_samples = 99\nperiod_s", "delay_samples is 99"),
        ] {
            let error = DriveProfile::parse("x.toml", &text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains(says) && error.contains("x.toml"), "{error}");
        }
    }

    #[test]
    fn missing_profile_is_refused_with_all_built_in_names() {
        let error = DriveProfile::load("/none/at/all").unwrap_err().to_string();
        let names = error.rsplit_once(": ").map(|(_, names)| names);
        assert_eq!(names, Some(&*format!("{}.", BUILT_IN.map(|(name, _)| name).join(", "))));
    }
}
