//! The properties, by topic. Each is a plain asserting function. The lists name its engines and their
//! bounds.

pub mod arcs;
#[cfg(feature = "guard")]
pub mod contours;
#[cfg(feature = "guard")]
pub mod dialects;
#[cfg(feature = "guard")]
pub mod guard;
#[cfg(feature = "guard")]
pub mod heights;
pub mod index;
pub mod lattice;
pub mod levels;
pub mod parts;
pub mod polygons;
pub mod predicates;
#[cfg(feature = "guard")]
pub mod reports;
pub mod rings;
#[cfg(feature = "guard")]
pub mod starts;

use keepout_kernel::exact::predicate::Site;
use keepout_kernel::exact::width::{Lattice, Narrow, Product};
pub use predicates::*;

use crate::oracle::{Whole, WholePoint, Wide};
use crate::property::Property;

/// All properties.
#[must_use]
pub fn all() -> Vec<&'static Property> {
    let groups: &[&[Property]] = &[
        predicates::ALL,
        polygons::ALL,
        lattice::ALL,
        rings::ALL,
        arcs::ALL,
        index::ALL,
        parts::ALL,
        levels::ALL,
        #[cfg(feature = "guard")]
        guard::ALL,
        #[cfg(feature = "guard")]
        contours::ALL,
        #[cfg(feature = "guard")]
        starts::ALL,
        #[cfg(feature = "guard")]
        reports::ALL,
        #[cfg(feature = "guard")]
        heights::ALL,
        #[cfg(feature = "guard")]
        dialects::ALL,
    ];
    groups.iter().copied().flatten().collect()
}

/// Coordinates of a point as plain numbers.
pub type Xy = (i64, i64);

/// Coordinates of a place as plain numbers: a point and a height.
pub type Xyz = (i64, i64, i64);

/// Makes points at a width from plain numbers.
pub trait FromPlain: Lattice<Linear: Ord> {
    /// The numbers of the definitions.
    type Number: Whole;

    /// The linear value of a plain number that fits.
    fn linear(value: i64) -> Self::Linear;

    /// The site of a plain point.
    fn site((x, y): Xy) -> Site<Self> {
        Site { x: Self::linear(x), y: Self::linear(y) }
    }
}

impl FromPlain for Product {
    type Number = Wide;

    fn linear(value: i64) -> i32 {
        i32::try_from(value).expect("engines choose coordinates within 2^29")
    }
}

impl FromPlain for Narrow {
    type Number = i64;

    fn linear(value: i64) -> i8 {
        i8::try_from(value).expect("engines choose coordinates within 16")
    }
}

/// The point for the definitions, in the numbers of a width.
fn exact<L: FromPlain>((x, y): Xy) -> WholePoint<L::Number> {
    WholePoint::new(x, y)
}
