//! One axis of a drive profile.

use serde::{Deserialize, Serialize};

use crate::drive::Drive;
use crate::plant::{Axis, Friction, Presliding, Resonance};

/// One drive of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisProfile {
    /// K, pulses/(s·bit).
    pub gain: f64,
    /// tau, s.
    pub time_constant_s: f64,
    /// Coulomb friction, bits.
    #[serde(default)]
    pub coulomb_bits: f64,
    /// Command above which an axis at rest starts to move, bits. Without it, the Coulomb friction.
    pub stiction_bits: Option<f64>,
    /// Distance that the Coulomb friction gives elastically before the axis slides, mm. Without it, the friction holds
    /// an axis at rest where it is.
    pub presliding_mm: Option<f64>,
    /// Speed at which the friction has fallen almost to the Coulomb friction, mm/s. It only matters with pre-sliding.
    #[serde(default = "one_mm_s", skip_serializing_if = "is_one_mm_s")]
    pub stribeck_mm_s: f64,
    /// Play between motor and table, mm.
    #[serde(default)]
    pub backlash_mm: f64,
    /// The spring between motor and table. Without it, the table is rigid.
    pub resonance: Option<ResonanceProfile>,
}

/// The speed of Canudas de Wit et al. 1995, Table 1.
fn one_mm_s() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_one_mm_s(speed: &f64) -> bool {
    *speed == one_mm_s()
}

/// A structural resonance of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResonanceProfile {
    /// Frequency at which the table swings while the motor is held, Hz.
    pub frequency_hz: f64,
    /// Damping ratio of this swing.
    pub damping: f64,
    /// Share of the table in the inertia of the axis.
    pub table_share: f64,
}

/// Fields of the two axes.
pub(super) const X_FIELDS: [&str; 10] = [
    "x.gain",
    "x.time_constant_s",
    "x.coulomb_bits",
    "x.stiction_bits",
    "x.presliding_mm",
    "x.stribeck_mm_s",
    "x.backlash_mm",
    "x.resonance.frequency_hz",
    "x.resonance.damping",
    "x.resonance.table_share",
];
pub(super) const Y_FIELDS: [&str; 10] = [
    "y.gain",
    "y.time_constant_s",
    "y.coulomb_bits",
    "y.stiction_bits",
    "y.presliding_mm",
    "y.stribeck_mm_s",
    "y.backlash_mm",
    "y.resonance.frequency_hz",
    "y.resonance.damping",
    "y.resonance.table_share",
];
/// Values in range, for an axis without a spring.
const STIFF: ResonanceProfile = ResonanceProfile { frequency_hz: 1.0, damping: 1.0, table_share: 0.5 };

impl AxisProfile {
    /// The values with the accepted ranges.
    pub(super) fn figures(
        &self,
        names: &[&'static str; 10],
        period_s: f64,
    ) -> [(&'static str, f64, (f64, f64)); 10] {
        let least_coulomb = if self.presliding_mm.is_some() { 1e-9 } else { 0.0 };
        let spring = self.resonance.unwrap_or(STIFF);
        let ranges = [
            (self.gain, (1e-9, 1e9)),
            (self.time_constant_s, (period_s / 100.0, 1e3)),
            (self.coulomb_bits, (least_coulomb, 1e9)),
            (self.stiction_bits.unwrap_or(self.coulomb_bits), (self.coulomb_bits, 1e9)),
            (self.presliding_mm.unwrap_or(1.0), (1e-5, 10.0)),
            (self.stribeck_mm_s, (1e-3, 1e3)),
            (self.backlash_mm, (0.0, 10.0)),
            (spring.frequency_hz, (1.0, 2000.0)),
            (spring.damping, (1e-3, 1.0)),
            (spring.table_share, (0.01, 0.99)),
        ];
        std::array::from_fn(|number| (names[number], ranges[number].0, ranges[number].1))
    }

    /// The axis in the plant's units.
    pub(super) fn axis(&self, pulses_per_mm: f64) -> Axis {
        let drive = Drive { gain: self.gain, time_constant_s: self.time_constant_s };
        let stribeck = self.stribeck_mm_s * pulses_per_mm;
        Axis {
            drive,
            friction: self.stick(),
            presliding: self
                .presliding_mm
                .map(|mm| Presliding::of(drive, self.coulomb_bits, mm * pulses_per_mm, stribeck)),
            backlash: self.backlash_mm * pulses_per_mm,
            resonance: self.resonance.map(|spring| Resonance {
                angular: spring.frequency_hz * std::f64::consts::TAU,
                damping: spring.damping,
                table_share: spring.table_share,
            }),
        }
    }

    /// The sticking friction of the axis.
    #[must_use]
    pub fn stick(&self) -> Friction {
        let stiction = self.stiction_bits.unwrap_or(self.coulomb_bits);
        if stiction > 0.0 { Friction::Stick { coulomb: self.coulomb_bits, stiction } } else { Friction::None }
    }
}
