//! Clipping a wish to what is certified: the longest clear prefix of a motion, and sliding along the wall.
//!
//! Everything here proposes; each answer has passed [`ProhibitedRegion::motion`].

use crate::clear::{FreePoint, ProhibitedRegion};
use crate::exact::lattice::{Length, Point, Vector};
use crate::exact::segment::{Segment, Window};

/// Halvings of a motion when its clear prefix is sought: a motion of 1 m is resolved to 1 µm.
const HALVINGS: u32 = 20;

/// The longest prefix of the motion `from → to` that `accepts` lets through, found by bisection.
///
/// `accepts` must get harder along the motion for the prefix to be the longest; whatever it is, the returned end was
/// accepted. Answers `from` when not even a lattice unit is free.
pub fn longest_prefix(from: Point, to: Point, mut accepts: impl FnMut(Point) -> bool) -> Point {
    if accepts(to) {
        return to;
    }
    let span = to.minus(from);
    let (mut low, mut high, mut best) = (0_i64, 1_i64 << HALVINGS, from);
    while high - low > 1 {
        let middle = i64::midpoint(low, high);
        let part = |d: i32| i64::from(d) * middle / (1 << HALVINGS);
        let candidate = Point::from_units(
            i64::from(from.x.units()) + part(span.dx),
            i64::from(from.y.units()) + part(span.dy),
        );
        match candidate {
            Ok(point) if point == best || accepts(point) => (low, best) = (middle, point),
            _ => high = middle,
        }
    }
    best
}

impl ProhibitedRegion {
    /// The end of the longest prefix of the motion `from → to` that is certified clear.
    #[must_use]
    pub fn clip(&self, from: FreePoint, to: Point) -> FreePoint {
        let mut end = from;
        longest_prefix(from.point(), to, |point| match self.motion(from, point) {
            Ok(free) => {
                end = free;
                true
            }
            Err(_) => false,
        });
        end
    }

    /// The wall nearest to `from`, if one is within its threshold and `band`; which is nearest is a proposal.
    #[must_use]
    pub fn wall(&self, from: FreePoint, band: Length) -> Option<Wall> {
        let point = from.point();
        let reach = from.threshold().saturating_plus(band);
        let mut nearest: Option<(f64, Wall)> = None;
        self.edges_near(Window::of(point), reach, |edge| {
            let near = !edge.chord.near_point(point, reach.saturating_plus(edge.slack)).is_clear();
            let Some((away, scale)) = away_from(point, edge.chord).filter(|_| near) else { return };
            let (x, y) = (approximate(away.0) / scale, approximate(away.1) / scale);
            let distance_2 = x * x + y * y;
            if nearest.is_none_or(|(least_2, _)| distance_2 < least_2) {
                nearest = Some((distance_2, Wall { away: scaled_down(away) }));
            }
        });
        nearest.map(|(_, wall)| wall)
    }
}

/// A wall near the tool: the direction away from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wall {
    away: (i128, i128),
}

impl Wall {
    /// Whether `wish` leads away from the wall, or along it.
    #[must_use]
    pub fn is_left_by(&self, wish: Vector) -> bool {
        self.away.0 * i128::from(wish.dx) + self.away.1 * i128::from(wish.dy) >= 0
    }

    /// What is left of `wish` when the wall takes its part across: its projection on the wall, turned away from the
    /// wall by the angle whose half has the tangent `1 / 2^half_turn` (0.1° for 10, 53° for 1).
    ///
    /// The length is that of the projection; `None` when nothing of the wish runs along the wall.
    #[must_use]
    pub fn slide(&self, wish: Vector, half_turn: u32) -> Option<Vector> {
        let (nx, ny) = self.away;
        let (mut ax, mut ay) = (-ny, nx);
        let mut projected = ax * i128::from(wish.dx) + ay * i128::from(wish.dy);
        if projected < 0 {
            (ax, ay, projected) = (-ax, -ay, -projected);
        }
        let length_2 = ax * ax + ay * ay;
        if length_2 == 0 || projected == 0 {
            return None;
        }
        // Rotation by the rational angle (k² − 1, 2k) / (k² + 1), k = 2^half_turn.
        let k = 1_i128 << half_turn.min(TURN_MAX);
        let (c, s, unit) = (k * k - 1, 2 * k, k * k + 1);
        let component = |along: i128, away: i128| {
            i32::try_from(projected * (along * c + away * s) / (length_2 * unit)).ok()
        };
        Some(Vector { dx: component(ax, nx)?, dy: component(ay, ny)? })
    }
}

/// Components of a wall's direction keep 24 bits and a half turn 12, so that the products of [`Wall::slide`], of at
/// most 24 + 31 + 1 + 24 + 24 + 2 bits, fit `i128`.
const WALL_BITS: u32 = 24;
const TURN_MAX: u32 = 12;

/// From the nearest point of the segment to `p`, scaled by the second value; `None` when `p` is on the segment.
fn away_from(p: Point, segment: Segment) -> Option<((i128, i128), f64)> {
    let (d, w) = (segment.to.minus(segment.from), p.minus(segment.from));
    let wide = |v: Vector| (i128::from(v.dx), i128::from(v.dy));
    let ((dx, dy), (wx, wy)) = (wide(d), wide(w));
    let length_2 = dx * dx + dy * dy;
    let along = (wx * dx + wy * dy).clamp(0, length_2);
    let away =
        if length_2 == 0 { (wx, wy) } else { (wx * length_2 - dx * along, wy * length_2 - dy * along) };
    (away != (0, 0)).then_some((away, approximate(length_2.max(1))))
}

#[expect(clippy::cast_precision_loss, reason = "used to propose the nearest wall, nothing rests on it")]
fn approximate(value: i128) -> f64 {
    value as f64
}

/// The same direction with components below `2^WALL_BITS`.
fn scaled_down((x, y): (i128, i128)) -> (i128, i128) {
    let bits = i128::BITS - x.unsigned_abs().max(y.unsigned_abs()).leading_zeros();
    let shift = bits.saturating_sub(WALL_BITS);
    (x >> shift, y >> shift)
}

/// Angles tried when sliding, as `half_turn` of [`Wall::slide`]: along the wall first, then turned away from it.
pub const SLIDE_TURNS: [u32; 12] = [12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1];

/// How near the wall a point must be, beyond the threshold, to slide rather than to run up to it.
#[must_use]
pub fn contact_band() -> Length {
    Length::from_units(10_000).unwrap_or(Length::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Region, Ring, Side};
    use alloc::vec;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    fn square() -> ProhibitedRegion {
        let ring = Ring::new(vec![at(0, 0), at(1000, 0), at(1000, 1000), at(0, 1000)]).unwrap();
        ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside)
    }

    #[test]
    fn clip_stops_just_short_of_the_threshold() {
        let part = square();
        let start = part.free_point(at(-5000, 500), Length::from_units(300).unwrap()).unwrap();
        let end = part.clip(start, at(5000, 500));
        assert_eq!(end.point(), at(-301, 500), "met is not clear");
        assert_eq!(part.clip(start, at(-9000, 500)).point(), at(-9000, 500));
    }

    #[test]
    fn slide_keeps_the_part_along_the_wall() {
        let part = square();
        let start = part.free_point(at(-301, 500), Length::from_units(300).unwrap()).unwrap();
        let wish = Vector { dx: 1000, dy: 1000 };
        assert!(part.motion(start, at(699, 1500)).is_err());
        let wall = part.wall(start, contact_band()).unwrap();
        let slid = wall.slide(wish, 12).unwrap();
        assert!((slid.dy - 1000).abs() <= 1 && slid.dx.abs() <= 1, "{slid:?}");
        let turned = wall.slide(wish, 3).unwrap();
        assert!(turned.dx < -200 && turned.dy > 900, "away from the wall: {turned:?}");
        assert_eq!(wall.slide(Vector { dx: 1000, dy: 0 }, 12), None, "straight at the wall");
    }
}
