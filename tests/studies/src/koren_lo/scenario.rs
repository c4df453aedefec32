//! Scenarios as data: machine, path, feed and disturbances.

use keepout_drives::Axes;
use keepout_drives::path::{Path, PathPiece};
use keepout_drives::plant::Friction;
use keepout_drives::profile::{DriveProfile, DriveProfileError};
use keepout_drives::reference::{Ramp, Reference};
use keepout_drives::run::Task;
use keepout_planner::text_file;
use serde::Deserialize;

/// One row of the comparison.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveScenario {
    /// Short name.
    pub name: String,
    /// Description.
    pub title: String,
    /// Figure of the paper.
    pub figure: Option<String>,
    /// Profile of the machine.
    pub machine: String,
    /// The path to follow.
    pub path: PathShape,
    /// Feed, m/min.
    pub feed_m_min: f64,
    /// Transition to the feed.
    #[serde(default)]
    pub ramp: Ramp,
    /// Model of the machine's friction.
    #[serde(default)]
    pub friction: FrictionKind,
    /// Whether the cutting force acts.
    #[serde(default)]
    pub cutting: bool,
    /// Largest command, bits. It replaces the limit of the machine.
    pub limit_bits: Option<f64>,
}

/// A path, in mm.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum PathShape {
    /// A straight line from the origin.
    Line {
        /// End point.
        #[serde(deserialize_with = "text_file::pair")]
        to_mm: [f64; 2],
    },
    /// A circle through the origin about (radius, 0).
    Circle {
        /// Radius.
        radius_mm: f64,
        /// Counter-clockwise. The paper's circle is clockwise.
        #[serde(default)]
        counter_clockwise: bool,
        /// Number of turns.
        #[serde(default = "once")]
        turns: u32,
    },
    /// Two equal legs.
    Corner {
        /// Length of a leg.
        leg_mm: f64,
        /// Turn of the path to the left, degrees.
        angle_deg: f64,
    },
    /// An ellipse through the origin.
    Ellipse {
        /// Semi-axes along X and Y.
        #[serde(deserialize_with = "text_file::pair")]
        half_axes_mm: [f64; 2],
    },
    /// An Archimedean spiral about the origin, counter-clockwise, from the X axis on.
    Spiral {
        /// Radius at the start and at the end.
        #[serde(deserialize_with = "text_file::pair")]
        radii_mm: [f64; 2],
        /// Number of turns.
        turns: u32,
    },
    /// Lines and arcs, in mm: the finishing toolpath of a plan.
    #[serde(skip)]
    Given(Vec<PathPiece>),
}

fn once() -> u32 {
    1
}

impl PathShape {
    /// The path in pulses.
    #[must_use]
    pub fn path(&self, pulses_per_mm: f64) -> Path {
        match *self {
            Self::Given(ref pieces) => {
                Path::of(pieces.iter().map(|piece| piece.scaled(pulses_per_mm)).collect())
            }
            Self::Line { to_mm: [x, y] } => Path::line(Axes::new(x, y) * pulses_per_mm),
            Self::Circle { radius_mm, counter_clockwise, turns } => {
                Path::circle(radius_mm * pulses_per_mm, !counter_clockwise, turns)
            }
            Self::Corner { leg_mm, angle_deg } => {
                Path::corner(leg_mm * pulses_per_mm, angle_deg.to_radians())
            }
            Self::Spiral { radii_mm: [from, to], turns } => {
                Path::spiral(from * pulses_per_mm, to * pulses_per_mm, turns)
            }
            Self::Ellipse { half_axes_mm: [a, b] } => Path::ellipse(a * pulses_per_mm, b * pulses_per_mm),
        }
    }
}

/// Model of the machine's friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionKind {
    /// No friction.
    #[default]
    None,
    /// Friction against the direction of the reference.
    Reference,
    /// Friction against the motion of the axis, with sticking.
    Stick,
}

/// Longest run, s: ten million samples of 1 ms.
const LONGEST_S: f64 = 1e4;
/// Largest number of samples of a run.
const MOST_SAMPLES: f64 = 1e7;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rows {
    scenario: Vec<DriveScenario>,
}

impl DriveScenario {
    /// The built-in rows: S1 to E3 of the paper, and some rows of ours.
    ///
    /// # Errors
    /// Only if the built-in file is invalid.
    pub fn built_in() -> Result<Vec<Self>, DriveProfileError> {
        Self::parse("scenarios.toml", include_str!("scenarios.toml"))
    }

    /// Reads the rows of a TOML file. Messages refer to it by `name`.
    ///
    /// # Errors
    /// [`DriveProfileError`] with the row and the field.
    pub fn parse(name: &str, text: &str) -> Result<Vec<Self>, DriveProfileError> {
        let rows: Rows = toml::from_str(text)
            .map_err(|error| DriveProfileError::Parse { name: name.into(), reason: error.to_string() })?;
        for (number, row) in rows.scenario.iter().enumerate() {
            if rows.scenario[..number].iter().any(|other| other.name == row.name) {
                let reason = format!("two scenarios are named {}", row.name);
                return Err(DriveProfileError::Parse { name: name.into(), reason });
            }
            if let Some((field, value, range)) = row.out_of_range() {
                let name = format!("{name}: {}", row.name);
                return Err(DriveProfileError::Figure { name, field, value, range });
            }
        }
        Ok(rows.scenario)
    }

    /// The first value that is out of range, with its field and the accepted range.
    fn out_of_range(&self) -> Option<(&'static str, f64, String)> {
        let length = match &self.path {
            PathShape::Line { to_mm: [x, y] } => x.hypot(*y),
            PathShape::Circle { radius_mm, turns, .. } => radius_mm * 6.3 * f64::from(*turns),
            PathShape::Corner { leg_mm, angle_deg } if angle_deg.abs() <= 180.0 => *leg_mm,
            PathShape::Corner { angle_deg, .. } => {
                return Some(("angle_deg", *angle_deg, "between -180 and 180".into()));
            }
            PathShape::Ellipse { half_axes_mm } => {
                // Check each axis, because min() ignores NaN.
                let wrong = half_axes_mm.iter().find(|axis| !(1e-3..=1e5).contains(*axis));
                if let Some(&axis) = wrong {
                    return Some(("half_axes_mm", axis, "between 0.001 and 100000".into()));
                }
                half_axes_mm[0].min(half_axes_mm[1])
            }
            PathShape::Spiral { radii_mm, turns } => {
                let wrong = radii_mm.iter().find(|radius| !(1e-3..=1e5).contains(*radius));
                if let Some(&radius) = wrong {
                    return Some(("radii_mm", radius, "between 0.001 and 100000".into()));
                }
                radii_mm[0].max(radii_mm[1]) * 6.3 * f64::from(*turns)
            }
            PathShape::Given(pieces) => pieces.iter().map(PathPiece::length).sum(),
        };
        let ramp = match self.ramp {
            Ramp::None => [1.0; 2],
            Ramp::RaisedCosine(seconds) => [seconds, 1.0],
            Ramp::LimitedJerk { acceleration, jerk } => [acceleration / 1e6, jerk / 1e6],
        };
        let figures = [
            ("the ramp's seconds, or acceleration in 10⁶ pulses/s²,", ramp[0], (1e-6, 60.0)),
            ("the ramp's jerk, 10⁶ pulses/s³,", ramp[1], (1e-6, 1e6)),
            ("the path's length, mm,", length, (1e-3, 1e5)),
            ("feed_m_min", self.feed_m_min, (1e-3, 1e3)),
            ("limit_bits", self.limit_bits.unwrap_or(1.0), (1e-6, 1e9)),
            ("the duration, s,", length / (self.feed_m_min / 0.06), (0.0, LONGEST_S)),
        ];
        let wrong = figures.into_iter().find(|(_, value, (least, most))| !(least..=most).contains(&value));
        wrong.map(|(field, value, (least, most))| (field, value, format!("between {least} and {most}")))
    }

    /// Approximate number of samples on `machine`.
    #[must_use]
    pub fn samples(&self, machine: &DriveProfile) -> f64 {
        let feed = machine.feed(self.feed_m_min);
        let seconds = self.path.path(machine.pulses_per_mm).length() / feed + 2.0 * self.ramp.lasts(feed);
        seconds / machine.period_s
    }

    /// Checks that the values are in range, and that a run on `machine` has at most ten million samples.
    ///
    /// # Errors
    /// [`DriveProfileError`] with the row and the field.
    pub fn checked(&self, machine: &DriveProfile) -> Result<(), DriveProfileError> {
        let samples = self.samples(machine);
        let wrong = match self.out_of_range() {
            None if samples > MOST_SAMPLES => {
                Some(("the number of samples of its period_s", samples, "ten million at most".to_string()))
            }
            wrong => wrong,
        };
        wrong.map_or(Ok(()), |(field, value, range)| {
            let name = format!("{} on {}", self.name, machine.name);
            Err(DriveProfileError::Figure { name, field, value, range })
        })
    }

    /// Samples per round on `machine`, if the path is a circle of more than one turn.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a checked count of samples")]
    pub fn round(&self, machine: &DriveProfile) -> Option<usize> {
        let PathShape::Circle { radius_mm, turns: 2.., .. } = self.path else { return None };
        let seconds = std::f64::consts::TAU * radius_mm / (self.feed_m_min / 0.06);
        Some((seconds / machine.period_s).round() as usize)
    }

    /// The task for `machine`, which need not be the machine of the scenario.
    #[must_use]
    pub fn task(&self, machine: &DriveProfile) -> Task {
        let mut plant = machine.plant();
        for (axis, profile) in plant.axes.iter_mut().zip([machine.x, machine.y]) {
            axis.friction = match self.friction {
                FrictionKind::None => Friction::None,
                FrictionKind::Reference => Friction::Reference(profile.coulomb_bits),
                FrictionKind::Stick => profile.stick(),
            };
        }
        plant.limit = self.limit_bits.or(plant.limit);
        let feed = machine.feed(self.feed_m_min);
        let cutting = machine.cutting().filter(|_| self.cutting);
        let path = self.path.path(machine.pulses_per_mm);
        let reference = Reference::along(&path, feed, plant.period_s, self.ramp).samples;
        Task { plant, path, feed, reference, cutting }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_rows_are_read() {
        let rows = DriveScenario::built_in().unwrap();
        assert_eq!(rows.len(), 18);
        for row in rows {
            let machine = DriveProfile::load(&row.machine).unwrap();
            assert!(row.task(&machine).path.length() > 0.0);
        }
    }

    #[test]
    fn invalid_rows_are_rejected_with_their_field() {
        let text = include_str!("scenarios.toml");
        for (from, to, says) in [
            ("feed_m_min = 0.754", "feed_m_min = 0", "S1: feed_m_min is 0"),
            ("radius_mm = 20.0", "radius_mm = inf", "S1: the path's length"),
            ("{ circle", "{ square", "square"),
            (
                "{ circle = { radius_mm = 20.0",
                "{ ellipse = { half_axes_mm = [nan, 1.0]",
                "S1: half_axes_mm is NaN",
            ),
            (
                "{ circle = { radius_mm = 20.0",
                "{ ellipse = { half_axes_mm = [1.0, inf]",
                "S1: half_axes_mm is inf",
            ),
            ("name = \"S2\"", "name = \"S1\"", "two scenarios are named S1"),
            (
                "feed_m_min = 0.754",
                "feed_m_min = 0.754\nramp = { raised-cosine = nan }",
                "S1: the ramp's seconds",
            ),
            (
                "feed_m_min = 0.754",
                "feed_m_min = 0.754\nramp = { raised-cosine = 1e9 }",
                "S1: the ramp's seconds",
            ),
            (
                "feed_m_min = 0.754",
                "feed_m_min = 0.754\nramp = { limited-jerk = { acceleration = 2e4, jerk = 0 } }",
                "jerk",
            ),
        ] {
            let error =
                DriveScenario::parse("rows.toml", &text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
