//! Integer widths: the one place of the trusted core where the predicates add and multiply.
//!
//! Implements SR-01.
//!
//! The predicates are written once over [`Lattice`]. The product runs them at [`Product`] width. Exhaustive
//! tests and model checkers run the same source at [`Narrow`] width.

use core::cmp::Ordering;

use super::predicate::{self, Proximity, Site};

/// A coordinate has magnitude at most `2^COORD_BITS`.
pub const COORD_BITS: u32 = 29;
const NARROW_COORD_BITS: u32 = 5;

/// Whether no operation of [`Lattice`] overflows, for coordinates of `bits` bits.
#[expect(
    clippy::arithmetic_side_effects,
    reason = "evaluated at compile time only, where overflow is an error"
)]
const fn widths_hold(bits: u32, linear: u32, area: u32, volume: u32) -> bool {
    let difference = bits + 1; //        |a − b|          ≤ 2^(bits + 1)
    let sum = 2 * difference + 1; //     |ab + cd|        ≤ 2^(2·difference + 1)
    let product = 2 * sum; //            |(ab + cd)·(…)|  ≤ 2^(2·sum)
    difference < linear - 1 && sum < area - 1 && product < volume - 1
}

const _: () = assert!(widths_hold(COORD_BITS, i32::BITS, i64::BITS, i128::BITS));
const _: () = assert!(widths_hold(NARROW_COORD_BITS, i8::BITS, i16::BITS, i32::BITS));

/// The seal of [`Lattice`]. The feature `symbolic` opens it for the proofs, which run the predicates on
/// symbolic numbers.
#[cfg(feature = "symbolic")]
pub use sealed::Sealed;

mod sealed {
    /// The integer widths of this crate.
    pub trait Sealed {}
}

/// A set of three integer widths for the predicates. Sealed, unless the feature `symbolic` is on.
///
/// `Linear` holds coordinates and their differences. `Area` holds sums of two products of differences.
/// `Volume` holds products of two areas. No operation overflows while coordinates and thresholds stay within
/// the bound of the width.
pub trait Lattice: sealed::Sealed + Copy {
    /// Coordinates, lengths and differences of coordinates.
    type Linear: Copy + Ord;
    /// Sums of two products of two linear values.
    type Area: Copy;
    /// Products of two areas.
    type Volume: Copy;

    /// `a − b`.
    fn difference(a: Self::Linear, b: Self::Linear) -> Self::Linear;
    /// `a · b`.
    fn product(a: Self::Linear, b: Self::Linear) -> Self::Area;
    /// `a + b` of two products.
    fn sum(a: Self::Area, b: Self::Area) -> Self::Area;
    /// `a − b` of two products.
    fn gap(a: Self::Area, b: Self::Area) -> Self::Area;
    /// `a · b` of two areas.
    fn product_of_areas(a: Self::Area, b: Self::Area) -> Self::Volume;
    /// Compares two areas.
    fn compare(a: Self::Area, b: Self::Area) -> Ordering;
    /// Compares two volumes.
    fn compare_volumes(a: Self::Volume, b: Self::Volume) -> Ordering;
    /// The area zero.
    fn zero() -> Self::Area;
    /// The length of `count` units.
    fn units(count: i8) -> Self::Linear;
    /// `⌊a / b⌋` for `a ≥ 0` and `b > 0`.
    fn quotient(a: Self::Area, b: Self::Area) -> Self::Area;
    /// `factor · (c − origin)`, where `c` may lie beyond the lattice. With `|c| ≤ 2^31` at [`Product`] width
    /// the result is below `2^62`, and the sum of two is below `2^63`.
    fn moment(factor: Self::Linear, c: Self::Linear, origin: Self::Linear) -> Self::Area;

    /// [`predicate::point_segment`], as a part of another predicate. A proof may replace such a part by the
    /// statement that is proved for it.
    #[inline(always)]
    fn point_segment(p: Site<Self>, a: Site<Self>, b: Site<Self>, r: Self::Linear) -> Proximity {
        predicate::point_segment(p, a, b, r)
    }
    /// [`predicate::crosses_properly`], as a part of another predicate.
    #[inline(always)]
    fn crosses_properly(a: Site<Self>, b: Site<Self>, c: Site<Self>, d: Site<Self>) -> bool {
        predicate::crosses_properly(a, b, c, d)
    }
    /// [`predicate::segment_segment`], as a part of another predicate.
    #[inline(always)]
    fn segment_segment(ab: [Site<Self>; 2], cd: [Site<Self>; 2], r: Self::Linear) -> Proximity {
        predicate::segment_segment(ab, cd, r)
    }
    /// [`predicate::strictly_inside`], as a part of another predicate.
    #[inline(always)]
    fn strictly_inside(p: Site<Self>, a: Site<Self>, b: Site<Self>, c: Site<Self>) -> bool {
        predicate::strictly_inside(p, a, b, c)
    }
    /// [`predicate::box_point`], as a part of another predicate.
    #[inline(always)]
    fn box_point(low: Site<Self>, high: Site<Self>, p: Site<Self>, r: Self::Linear) -> Proximity {
        predicate::box_point(low, high, p, r)
    }
    /// [`predicate::beyond`], as a part of another predicate.
    #[inline(always)]
    fn beyond(line: [Site<Self>; 2], points: impl Iterator<Item = Site<Self>>, r: Self::Linear) -> bool {
        predicate::beyond(line, points, r)
    }
    /// [`predicate::convex_holds`], as a part of another predicate.
    #[inline(always)]
    fn convex_holds(corners: impl Iterator<Item = Site<Self>> + Clone, p: Site<Self>) -> bool {
        predicate::convex_holds(corners, p)
    }
}

macro_rules! lattice {
    ($(#[$doc:meta])* $name:ident: $linear:ty, $area:ty, $volume:ty) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;

        impl sealed::Sealed for $name {}

        #[expect(clippy::arithmetic_side_effects, reason = "`widths_hold` is asserted for these widths above")]
        impl Lattice for $name {
            type Linear = $linear;
            type Area = $area;
            type Volume = $volume;

            #[inline(always)]
            fn difference(a: $linear, b: $linear) -> $linear {
                a - b
            }
            #[inline(always)]
            fn product(a: $linear, b: $linear) -> $area {
                <$area>::from(a) * <$area>::from(b)
            }
            #[inline(always)]
            fn sum(a: $area, b: $area) -> $area {
                a + b
            }
            #[inline(always)]
            fn gap(a: $area, b: $area) -> $area {
                a - b
            }
            #[inline(always)]
            fn product_of_areas(a: $area, b: $area) -> $volume {
                <$volume>::from(a) * <$volume>::from(b)
            }
            #[inline(always)]
            fn compare(a: $area, b: $area) -> Ordering {
                a.cmp(&b)
            }
            #[inline(always)]
            fn compare_volumes(a: $volume, b: $volume) -> Ordering {
                a.cmp(&b)
            }
            #[inline(always)]
            fn zero() -> $area {
                0
            }
            #[inline(always)]
            fn units(count: i8) -> $linear {
                <$linear>::from(count)
            }
            #[inline(always)]
            fn quotient(a: $area, b: $area) -> $area {
                a / b
            }
            #[inline(always)]
            fn moment(factor: $linear, c: $linear, origin: $linear) -> $area {
                <$area>::from(factor) * (<$area>::from(c) - <$area>::from(origin))
            }
        }
    };
}

lattice! {
    /// The width of the product: coordinates up to 2^29 in `i32`, areas in `i64`, volumes in `i128`.
    Product: i32, i64, i128
}

lattice! {
    /// A lattice of at most ±32 units, small enough for an exhaustive search. It runs the same source as
    /// [`Product`].
    Narrow: i8, i16, i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_fail_one_bit_beyond() {
        assert!(widths_hold(29, 32, 64, 128));
        assert!(!widths_hold(30, 32, 64, 128) && !widths_hold(31, 64, 64, 128));
        assert!(!widths_hold(29, 31, 64, 128), "differences");
        assert!(widths_hold(29, 32, 63, 124) && !widths_hold(29, 32, 62, 124), "areas");
        assert!(!widths_hold(29, 32, 64, 123), "volumes");
    }
}
