//! The response of a stick: converts raw axes to the jog velocity.
//!
//! Implements SR-21.

use keepout_planner::Mm2;
use thiserror::Error;

/// Parameters of a stick's response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickSettings {
    /// Radius of the dead zone, as a share of the full throw: 0 to 0.9.
    pub dead_zone: f64,
    /// Share of the cubic term in the response, 0 (linear) to 1. A larger share is finer near the centre.
    pub expo: f64,
    /// Deflection at full throw, as a share of full speed: above 0, up to 1.
    pub top: f64,
}

impl Default for StickSettings {
    /// A dead zone for worn gamepads, a fine response near the centre, and full speed at full throw.
    fn default() -> Self {
        Self { dead_zone: 0.12, expo: 0.5, top: 1.0 }
    }
}

/// A stick setting that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum StickError {
    /// The dead zone.
    #[error("a dead zone of {value} is out of range: choose 0 to 0.9 of the throw, such as 0.12")]
    DeadZone {
        /// The given value.
        value: f64,
    },
    /// The response.
    #[error("an expo of {value} is out of range: choose 0 (linear) to 1 (cubic), such as 0.5")]
    Expo {
        /// The given value.
        value: f64,
    },
    /// The top.
    #[error("a top of {value} is out of range: choose more than 0, up to 1, as a share of full speed")]
    Top {
        /// The given value.
        value: f64,
    },
}

/// A stick with its response.
///
/// With a dead zone of 0.5, no expo and a top of 1, the raw axes (0.75, 0) give (0.5, 0). They give (0, 0) if
/// the operator does not hold the dead-man button.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stick {
    settings: StickSettings,
}

impl Stick {
    /// A stick with this response.
    ///
    /// # Errors
    /// [`StickError`] with the setting that is out of range.
    pub fn new(settings: StickSettings) -> Result<Self, StickError> {
        let StickSettings { dead_zone, expo, top } = settings;
        if !(0.0..=0.9).contains(&dead_zone) {
            return Err(StickError::DeadZone { value: dead_zone });
        }
        if !(0.0..=1.0).contains(&expo) {
            return Err(StickError::Expo { value: expo });
        }
        if !(top > 0.0 && top <= 1.0) {
            return Err(StickError::Top { value: top });
        }
        Ok(Self { settings })
    }

    /// The deflection for raw axes in −1 to 1. It is zero unless the operator holds the dead-man button.
    ///
    /// Its length is at most the top, so the corners of a square gate are no faster than its sides. Axes that
    /// are not finite give zero.
    #[must_use]
    pub fn deflection(&self, raw: Mm2, dead_man: bool) -> Mm2 {
        let throw = raw.length();
        if !dead_man || !throw.is_finite() || self.rests(raw) {
            return Mm2::ZERO;
        }
        let StickSettings { dead_zone, expo, top } = self.settings;
        let beyond = (throw.min(1.0) - dead_zone) / (1.0 - dead_zone);
        let length = top * ((1.0 - expo) * beyond + expo * beyond.powi(3));
        raw / throw * length
    }

    /// Whether the stick is in its dead zone. False for axes that are NaN or infinite.
    #[must_use]
    pub fn rests(&self, raw: Mm2) -> bool {
        let throw = raw.length();
        throw <= self.settings.dead_zone || throw == 0.0
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Sticks with many responses.
    fn sticks() -> Vec<Stick> {
        let mut all = Vec::new();
        for dead_zone in [0.0, 0.03, 0.12, 0.5, 0.9] {
            for expo in [0.0, 0.3, 1.0] {
                for top in [0.1, 0.5, 1.0] {
                    all.push(Stick::new(StickSettings { dead_zone, expo, top }).unwrap());
                }
            }
        }
        all
    }

    #[test]
    fn response_is_odd_and_bounded_and_keeps_the_direction() {
        let mut random = fastrand::Rng::with_seed(5);
        for stick in sticks() {
            for _ in 0..500 {
                let raw = Mm2::new(4.0 * random.f64() - 2.0, 4.0 * random.f64() - 2.0);
                let out = stick.deflection(raw, true);
                let back = stick.deflection(-raw, true);
                assert_eq!(out, -back);
                assert!(out.length() <= stick.settings.top * (1.0 + 1e-12), "{raw:?} {out:?}");
                let cross = raw.cross(out);
                assert!(cross.abs() < 1e-12 && out.x * raw.x >= 0.0, "{raw:?} {out:?}");
            }
        }
    }

    #[test]
    fn response_grows_with_the_throw_from_zero_to_the_top() {
        for stick in sticks() {
            for turn in 0..16 {
                let phi = TAU * f64::from(turn) / 16.0;
                let at = |throw: f64| stick.deflection(Mm2::unit(phi) * throw, true).length();
                let zone = stick.settings.dead_zone;
                assert!(at(zone * 0.999) == 0.0 && at(zone + 1e-9) < 1e-6, "no jump at the zone's edge");
                let throws: Vec<f64> = (0..=200).map(|i| at(f64::from(i) / 200.0)).collect();
                assert!(throws.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12));
                assert!((at(1.0) - stick.settings.top).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn diagonal_is_no_faster_than_a_side() {
        for stick in sticks() {
            let side = stick.deflection(Mm2::new(1.0, 0.0), true).length();
            assert!(stick.deflection(Mm2::new(1.0, 1.0), true).length() <= side * (1.0 + 1e-12));
        }
    }

    // Evidence for SR-21.
    #[test]
    fn tool_stays_still_without_the_dead_man_button_or_for_axes_that_are_not_finite() {
        let stick = Stick::new(StickSettings::default()).unwrap();
        assert_eq!(stick.deflection(Mm2::new(1.0, 1.0), false), Mm2::ZERO);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(stick.deflection(Mm2::new(bad, 0.3), true), Mm2::ZERO);
            assert!(!stick.rests(Mm2::new(bad, 0.0)), "an axis that is not finite does not count as centred");
        }
    }

    #[test]
    fn wrong_settings_are_refused() {
        let with = |dead_zone, expo, top| Stick::new(StickSettings { dead_zone, expo, top });
        assert!(matches!(with(0.95, 0.0, 1.0), Err(StickError::DeadZone { .. })));
        assert!(matches!(with(f64::NAN, 0.0, 1.0), Err(StickError::DeadZone { .. })));
        assert!(matches!(with(0.1, 1.1, 1.0), Err(StickError::Expo { .. })));
        assert!(matches!(with(0.1, 0.0, 0.0), Err(StickError::Top { .. })));
        assert!(matches!(with(0.1, 0.0, f64::NAN), Err(StickError::Top { .. })));
    }
}
