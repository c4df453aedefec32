//! A guard of an empty plane, for tests of dialects and simulated controllers.

use alloc::sync::Arc;
use alloc::vec;

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Length, Levels, Point, ProhibitedRegion, Region, Ring, Side};

use crate::{Guard, HeightRules, Interpolation, OnCancel, Rules};

/// A guard with a part of two lattice units, in the farthest corner of the lattice. Returns `None` only if
/// that part could not be built.
#[must_use]
pub fn guard_in_open_space() -> Option<Guard> {
    let far = i64::from(COORD_MAX);
    let corner = |x, y| Point::from_units(x, y).ok();
    let ring = Ring::new(vec![corner(far - 2, far - 2)?, corner(far, far - 2)?, corner(far, far)?]).ok()?;
    let part = ProhibitedRegion::new(Region::new(vec![ring]).ok()?, Side::Outside).ok()?;
    let part = Arc::new(Levels::flat(Arc::new(part)));
    let rules = Rules {
        travel: Window::from_corners(i32::MIN, i32::MIN, i32::MAX, i32::MAX),
        jogging_clearance: Length::ZERO,
        finishing_clearance: Length::ZERO,
        resolution: Length::ZERO,
        shortest: Length::ZERO,
        interpolation: Interpolation::Linear,
        on_cancel: OnCancel::KeepsPath,
        contours: Interpolation::Linear,
        checked: true,
        heights: HeightRules { lowest: Height::LOWEST, highest: Height::HIGHEST, ..HeightRules::TWO_AXES },
    };
    Some(Guard::new(Arc::clone(&part), part, rules))
}
