//! The part of all worlds, a square, and the invariant's checks on it and on the in-flight set. In worlds with
//! three axes it is a plate with a top, beside a clamp, on a table.

use std::sync::Arc;

use keepout_guard::{HeightRules, Interpolation, OnCancel, Rules};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, HeightField, Levels, Place, ProhibitedRegion, Region, Ring, Segment, Side};

use crate::controller::{RESOLUTION, STRAY};
use crate::families::{at, length};
use crate::oracle::quick;
use crate::properties::{Xy, Xyz};

/// Jogging clearance, lattice units.
pub const MANUAL: i64 = 100;
/// Finishing clearance, lattice units.
pub const FINISHING: i64 = 96;
/// Corners of the part, a square.
pub const PART: [Xy; 4] = [(0, 0), (400, 0), (400, 400), (0, 400)];

/// Corners of the clamp beside the plate.
const CLAMP: [Xy; 4] = [(900, 0), (1100, 0), (1100, 200), (900, 200)];
/// Height of the clamp, lattice units.
pub const CLAMP_TOP: i64 = 120;
/// Height of the table.
pub const TABLE: i64 = -200;
/// Height margin: it contains the resolution.
pub const HEIGHT_MARGIN: i64 = 5;

/// The rules of a guard beside the square, on a machine with two axes.
#[must_use]
pub fn rules(interpolation: Interpolation, checked: bool) -> Rules {
    Rules {
        travel: Window::of(at((-5000, -5000))).including(at((5000, 5000))),
        jogging_clearance: length(MANUAL),
        finishing_clearance: length(FINISHING),
        resolution: length(RESOLUTION),
        shortest: length(4),
        interpolation,
        on_cancel: OnCancel::KeepsPath,
        contours: interpolation,
        checked,
        heights: HeightRules::TWO_AXES,
    }
}

/// The square without a top, enlarged by `by` lattice units on each side: the simplified outline that jogging
/// asks.
///
/// # Panics
/// When the enlarged square leaves the lattice.
#[must_use]
pub fn square(by: i64) -> Levels {
    let region = Region::new(vec![ring(&PART, by)]).expect("one ring");
    Levels::flat(Arc::new(ProhibitedRegion::new(region, Side::Outside).expect("small")))
}

/// The square as a plate with its top at height zero, a clamp and a table.
///
/// # Panics
/// When the enlarged square leaves the lattice.
#[must_use]
pub fn plate(by: i64) -> Levels {
    let field = HeightField {
        outlines: Region::new(vec![ring(&PART, by)]).expect("one ring"),
        tops: vec![Some(height(0))],
        around: None,
        zones: vec![(ring(&CLAMP, 0), height(CLAMP_TOP))],
        floor: Some(height(TABLE)),
    };
    Levels::new(&field).expect("few tops")
}

fn ring(corners: &[Xy], by: i64) -> Ring {
    let out = |c: i64| if c > 0 { c + by } else { c - by };
    Ring::new(corners.iter().map(|&(x, y)| at((out(x), out(y)))).collect()).expect("a square")
}

/// A height on the lattice.
///
/// # Panics
/// When it is off the lattice.
#[must_use]
pub fn height(units: i64) -> Height {
    Height::from_units(units).expect("it is small")
}

/// A place on the lattice.
///
/// # Panics
/// When it is off the lattice.
#[must_use]
pub fn place((x, y, z): Xyz) -> Place {
    at((x, y)).at_height(height(z))
}

/// The place as plain numbers.
#[must_use]
pub fn plain_place(place: Place) -> Xyz {
    let (x, y) = plain(place.point);
    (x, y, place.height.units().into())
}

/// The point as plain numbers.
#[must_use]
pub fn plain(point: keepout_kernel::Point) -> Xy {
    (i64::from(point.x.units()), i64::from(point.y.units()))
}

/// Whether the hull of the set keeps the jogging clearance plus `stray`, less a unit of rounding. With
/// non-interpolated axes (`apart`) the box around the set replaces the hull.
#[must_use]
pub fn certified(part: &ProhibitedRegion, set: &[Xy], apart: bool, stray: i64) -> bool {
    let kept = length(MANUAL + stray - 1);
    let window = set.iter().skip(1).fold(Window::of(at(set[0])), |window, &p| window.including(at(p)));
    if apart {
        return part.index().near_box(window, kept).is_none();
    }
    let ways = set.iter().enumerate().flat_map(|(i, &a)| set[i..].iter().map(move |&b| (a, b)));
    let mut ways = ways.map(|(a, b)| Segment { from: at(a), to: at(b) });
    // A hull that no edge crosses is beside each outline, or around all of it.
    let rings = part.region().rings().iter().chain(part.zones());
    let mut corners = rings.filter_map(|ring| ring.vertices().first());
    ways.all(|way| part.motion_clear(way, kept).is_clear())
        && corners.all(|&corner| off_hull(set, plain(corner)) > 0)
        && !part.holds(at(set[0]))
}

/// Whether the motion comes nearer to an edge than it begins, by more than a unit, and within the jogging
/// clearance of it. The distance is sampled at 65 points of the motion.
#[must_use]
pub fn approaches(part: &ProhibitedRegion, p: Xy, q: Xy) -> bool {
    let float =
        |(x, y): Xy| (f64::from(i32::try_from(x).unwrap_or(0)), f64::from(i32::try_from(y).unwrap_or(0)));
    part.edges().iter().any(|edge| {
        let away = |p: (f64, f64)| {
            quick::point_segment(p, float(plain(edge.chord.from)), float(plain(edge.chord.to)))
        };
        let (p, q) = (float(p), float(q));
        let least = (0..=64).map(|k| {
            let t = f64::from(k) / 64.0;
            away((p.0 + (q.0 - p.0) * t, p.1 + (q.1 - p.1) * t))
        });
        let least = least.fold(f64::INFINITY, f64::min);
        least < away(p) - 1.0 && least <= 100.0
    })
}

/// The larger of the point's distances from the box of the set along x and along y.
#[must_use]
pub fn off_box(set: &[Xy], (x, y): Xy) -> i64 {
    let off = |c: i64, all: &dyn Fn(&Xy) -> i64| {
        let (low, high) = (set.iter().map(all).min().unwrap_or(c), set.iter().map(all).max().unwrap_or(c));
        (low - c).max(c - high).max(0)
    };
    off(x, &|p| p.0).max(off(y, &|p| p.1))
}

/// Distance of the point from the convex hull of the set, rounded up. The point is in the hull when it is
/// in some triangle of set points. Beyond the largest distance that the invariant allows, the result is
/// `i64::MAX`.
#[must_use]
pub fn off_hull(set: &[Xy], p: Xy) -> i64 {
    let side = |a: Xy, b: Xy, c: Xy| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let inside = |a: Xy, b: Xy, c: Xy| {
        let of = [side(a, b, p), side(b, c, p), side(c, a, p)];
        of.iter().all(|&s| s > 0) || of.iter().all(|&s| s < 0)
    };
    // Mostly the point is in the set, and then no edge need be asked.
    if set.contains(&p) {
        return 0;
    }
    let mut least = i64::MAX;
    for (i, &a) in set.iter().enumerate() {
        for (j, &b) in set.iter().enumerate().skip(i) {
            if set.iter().skip(j + 1).any(|&c| inside(a, b, c)) {
                return 0;
            }
            let edge = Segment { from: at(a), to: at(b) };
            let near = |r: i64| !edge.near_point(at(p), length(r)).is_clear();
            let (mut beyond, mut reach) = (0, 3 * RESOLUTION + STRAY + 4);
            if near(0) {
                return 0;
            }
            if !near(reach) {
                continue;
            }
            while beyond + 1 < reach {
                let middle = (beyond + reach).div_euclid(2);
                *(if near(middle) { &mut reach } else { &mut beyond }) = middle;
            }
            least = least.min(reach);
        }
    }
    least
}
