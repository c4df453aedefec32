//! TRUSTED. The places of the in-flight set that are nearest to a reported one.
//!
//! Implements SR-07, SR-08, SR-09.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Blocked, FreePoint, Point, ProhibitedRegion};

use crate::hull::Hull;
use crate::in_flight::InFlight;
use crate::{FreePlace, Interpolation};

impl InFlight {
    /// The point of the hull nearest to `position`.
    pub(crate) fn nearest_in_set(&self, position: Point) -> Option<Point> {
        self.nearest(position, self.lines.len())
    }

    /// The point nearest to `position` in the hull of the confirmed positions and the first `count` targets.
    pub(crate) fn nearest(&self, position: Point, count: usize) -> Option<Point> {
        match self.interpolation {
            Interpolation::Linear => {
                let hull = Hull::of(self.places_up_to(count).map(FreePlace::point));
                hull.and_then(|hull| hull.nearest(position))
            }
            Interpolation::Independent => self.window(count).and_then(|window| nearest_in(window, position)),
        }
    }

    pub(crate) fn window(&self, count: usize) -> Option<Window> {
        self.places_up_to(count).map(|place| Window::of(place.point())).reduce(Window::union)
    }

    /// The place as a free point, if the motion to it from one point of the set is clear.
    ///
    /// One clear motion is enough, because the motion that the tool made was certified before. Rounding can
    /// block the motion from the confirmed position to a far target by a unit.
    pub(crate) fn reached(&self, part: &ProhibitedRegion, place: Point) -> Option<FreePoint> {
        self.places().find_map(|from| part.motion(from.free, place).ok())
    }
}

fn nearest_in(window: Window, position: Point) -> Option<Point> {
    let (x0, y0, x1, y1) = window.corners();
    let (x, y) = (position.x.units().clamp(x0, x1), position.y.units().clamp(y0, y1));
    Point::from_units(x.into(), y.into()).ok()
}

/// Certifies that a box is clear at the threshold of a free point in it. No edge comes near the box, so the
/// whole box is on that point's side.
pub(crate) fn clear_box(part: &ProhibitedRegion, from: FreePoint, window: Window) -> Result<(), Blocked> {
    if !window.holds(from.point()) {
        return Err(Blocked::StartTooNear(from.point()));
    }
    match part.index().near_box(window, from.threshold()) {
        Some(edge) => Err(Blocked::ByEdge(*edge)),
        None => Ok(()),
    }
}
