//! Lengths in a controller's own counts: rounded to the nearest count for sending, and to the nearest lattice
//! unit on receipt.
//!
//! Implements SR-17, SR-18.

use keepout_kernel::UNITS_PER_MM;
use keepout_kernel::curve::nearest_unit;

/// The number of counts per mm, as a ratio.
///
/// A length goes out as the nearest count, at most half a count off. The margin's step term covers this as
/// long as a mm has at least as many counts as the machine has steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scale {
    counts: i64,
    mm: i64,
}

/// Resolution of counts per mm: parts of one count.
const PARTS: i64 = 1_000_000;
/// Most counts per mm.
const COUNTS_MAX: f64 = 1e6;

impl Scale {
    /// One count for one mm.
    pub(super) const ONE: Self = Self { counts: 1, mm: 1 };

    /// `counts` counts per `mm` millimetres, both from 1 to 10^12.
    pub(super) fn ratio(counts: i64, mm: i64) -> Option<Self> {
        let fits = |value: i64| (1..=1_000_000_000_000).contains(&value);
        (fits(counts) && fits(mm)).then_some(Self { counts, mm })
    }

    /// `counts` per mm, rounded to a millionth of a count.
    pub(super) fn per_mm(counts: f64) -> Option<Self> {
        let (whole, rest) = (counts.floor(), counts.fract());
        let in_range = counts > 0.0 && counts <= COUNTS_MAX;
        let parts = nearest_unit(rest * 1e6).checked_add(nearest_unit(whole).checked_mul(PARTS)?)?;
        Self::ratio(parts, PARTS).filter(|_| in_range)
    }

    /// The nearest count to a length in lattice units; halves are rounded up.
    pub(super) fn counts(self, units: i32) -> i64 {
        let over = i128::from(self.mm) * i128::from(UNITS_PER_MM);
        let twice = 2 * i128::from(units) * i128::from(self.counts) + over;
        i64::try_from(twice.div_euclid(2 * over)).unwrap_or(i64::MAX)
    }

    /// The nearest lattice units to a number of counts. Too many counts give a value off the lattice.
    pub(super) fn units(self, counts: i64) -> i64 {
        let over = i128::from(self.counts);
        let units = i128::from(counts) * i128::from(self.mm) * i128::from(UNITS_PER_MM);
        i64::try_from((2 * units + over).div_euclid(2 * over)).unwrap_or(i64::MAX)
    }

    /// A length in mm as counts, in floating point. Safety does not rest on it.
    pub(super) fn approximate(self, mm: f64) -> f64 {
        mm * self.per_mm_f64()
    }

    /// Counts in mm, in floating point.
    #[expect(clippy::cast_precision_loss, reason = "used in comparisons only")]
    pub(super) fn to_mm(self, counts: i64) -> f64 {
        counts as f64 / self.per_mm_f64()
    }

    /// Counts per mm, in floating point. Safety does not rest on it.
    #[expect(clippy::cast_precision_loss, reason = "used in comparisons only")]
    pub(super) fn per_mm_f64(self) -> f64 {
        self.counts as f64 / self.mm as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-17.
    #[test]
    fn lengths_are_rounded_to_half_a_count_and_convert_back() {
        let mut random = fastrand::Rng::with_seed(5);
        for per_mm in [1.0, 400.0, 2015.748, 1000.0, 36.5, 100_000.0, 999_999.5] {
            let scale = Scale::per_mm(per_mm).unwrap();
            for _ in 0..2000 {
                let units = random.i32(-500_000_000..500_000_000);
                let counts = scale.counts(units);
                let off = (scale.units(counts) - i64::from(units)).abs();
                assert!(off <= i64::from(UNITS_PER_MM) * scale.mm / scale.counts / 2 + 1, "{per_mm} {units}");
                if per_mm <= 100_000.0 {
                    let back = i32::try_from(scale.units(counts)).unwrap();
                    assert_eq!(scale.counts(back), counts);
                }
            }
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert_eq!(Scale::per_mm(bad), None);
        }
        assert_eq!(Scale::per_mm(400.0).unwrap().counts(-125), -0);
        assert_eq!(Scale::per_mm(400.0).unwrap().counts(125), 1);
    }
}
