//! Clips a jog to its certified part: the longest clear prefix of a motion, and sliding along the wall.
//!
//! Implements SR-07.
//!
//! The code here only proposes. Each answer has passed [`ProhibitedRegion::motion`].

use core::ops::ControlFlow;

use crate::clear::{FreePoint, ProhibitedRegion};
use crate::exact::lattice::{Length, Point, Vector};
use crate::exact::segment::{Segment, Window};
use crate::index::Edge;
use crate::index::cells::{Known, Square};
use crate::vec2::Vec2;

/// Distances before the first contact at which the end of a clipped motion is tried, in lattice units.
const SET_BACK: [f64; 7] = [1.0, 2.0, 3.0, 5.0, 10.0, 40.0, 200.0];

/// Halvings in the search for the clear prefix of a motion. A motion of 1 m is resolved to 1 µm.
const HALVINGS: u32 = 20;

/// The end of the longest prefix of the motion `from → to` that `accepts` permits, found by bisection.
///
/// The prefix is the longest only if `accepts` never permits again after it has refused. In every case
/// `accepts` has permitted the returned end. Returns `from` when no prefix passes, even of a lattice unit.
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
    /// The end of a certified clear prefix of the motion `from → to`, the longest to within a few lattice
    /// units.
    ///
    /// The first contact is calculated in `f64`. The end is set back from it until the exact query permits
    /// the motion.
    #[must_use]
    pub fn clip(&self, from: FreePoint, to: Point) -> FreePoint {
        if let Ok(free) = self.motion(from, to) {
            return free;
        }
        let motion = Segment { from: from.point(), to };
        let contact = self.first_contact(motion, from.threshold()).unwrap_or(1.0);
        let span = Vec2::from(to.minus(motion.from));
        let length = span.length();
        let start = Vec2::from(motion.from);
        for back in SET_BACK {
            let t = contact - back / length;
            if t <= 0.0 {
                return from;
            }
            let end = crate::curve::nearest_point(start + span * t);
            if let Some(free) = end.ok().and_then(|end| self.motion(from, end).ok()) {
                return free;
            }
        }
        // The floats missed a contact: halve the motion.
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

    /// The share of the motion at which it first comes within `threshold` of an edge. `None` when no edge
    /// comes that near.
    fn first_contact(&self, motion: Segment, threshold: Length) -> Option<f64> {
        let line = Line::of(motion);
        if let Some(cells) = self.cells_for(threshold) {
            let mut first: Option<f64> = None;
            let mut known = true;
            let contact = |number: &u32| {
                let edge = self.edges().get(*number as usize)?;
                line.contact_with(edge, motion, threshold)
            };
            let walked = cells.walk(motion, |square| {
                let here = match square.known {
                    Known::Free => return ControlFlow::Continue(()),
                    Known::Blocked(number) => contact(&number),
                    Known::Near(list) => list.iter().filter_map(contact).reduce(f64::min),
                    Known::Open => {
                        known = false;
                        return ControlFlow::Break(());
                    }
                };
                first = here.into_iter().chain(first).reduce(f64::min);
                if first.is_some_and(|first| first <= line.exit(square)) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
            if walked.is_some() && known {
                return first;
            }
        }
        self.first_contact_by_index(motion, &line, threshold)
    }

    fn first_contact_by_index(&self, motion: Segment, line: &Line, threshold: Length) -> Option<f64> {
        let mut first: Option<f64> = None;
        // Skip edges whose box begins after the first contact.
        let mut rest = motion;
        let _ = self.index().along(motion, threshold, |_, edge| {
            let reach = edge.bounds().grown(threshold);
            let contact =
                if reach.meets(rest.bounds()) { line.contact_with(edge, rest, threshold) } else { None };
            if let Some(contact) = contact.filter(|&contact| first.is_none_or(|first| contact < first)) {
                first = Some(contact);
                rest.to = line.point_beyond(contact).unwrap_or(rest.to);
            }
            ControlFlow::Continue(())
        });
        first
    }

    /// The wall nearest to `from`, if one lies within its threshold plus `band`. The choice of the nearest is
    /// only a proposal.
    #[must_use]
    pub fn wall(&self, from: FreePoint, band: Length) -> Option<Wall> {
        let point = from.point();
        let reach = from.threshold().saturating_plus(band);
        let mut nearest: Option<(f64, Wall)> = None;
        self.edges_near(Window::of(point), reach, |edge| {
            let near = !edge.chord.near_point(point, reach.saturating_plus(edge.chord_error)).is_clear();
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

/// A motion in `f64`, for the search.
struct Line {
    start: Vec2,
    span: Vec2,
    length_2: f64,
}

impl Line {
    fn of(motion: Segment) -> Self {
        let span = Vec2::from(motion.to.minus(motion.from));
        Self { start: Vec2::from(motion.from), span, length_2: span.dot(span) }
    }

    /// The share of the motion at which it first comes near the edge. `motion` is a beginning of this line.
    /// `None` when the exact test finds `motion` clear of the edge.
    fn contact_with(&self, edge: &Edge, motion: Segment, threshold: Length) -> Option<f64> {
        if edge.near_motion(motion, threshold).is_clear() {
            return None;
        }
        let r = f64::from(threshold.saturating_plus(edge.chord_error).units());
        Some(self.contact(edge.chord, r).unwrap_or(1.0))
    }

    /// The smallest share of the motion, in [0, 1], that is within `r` of the chord.
    fn contact(&self, chord: Segment, r: f64) -> Option<f64> {
        let (a, b) = (Vec2::from(chord.from), Vec2::from(chord.to));
        let (along, w) = (b - a, self.start - a);
        let length_2 = along.dot(along);
        let mut first = f64::INFINITY;
        let mut consider = |t: f64| {
            if t < first && (0.0..=1.0).contains(&t) {
                first = t;
            }
        };
        if length_2 > 0.0 {
            // Beside the chord: the distance from its line is r on the side of the start.
            let off = along.cross(w);
            let rate = along.cross(self.span);
            let reach = r * libm::sqrt(length_2);
            if off * rate < 0.0 && off.abs() >= reach {
                let t = (off.abs() - reach) / rate.abs();
                let foot = (w + self.span * t).dot(along);
                if (0.0..=length_2).contains(&foot) {
                    return (t <= 1.0).then_some(t);
                }
            }
        }
        for end in [a, b] {
            consider(self.enters_disc(end, r));
        }
        first.is_finite().then_some(first)
    }

    /// The share at which the motion enters the disc. It is 0 when the motion starts inside, and infinite
    /// when it never enters.
    fn enters_disc(&self, centre: Vec2, r: f64) -> f64 {
        let w = self.start - centre;
        let toward = -w.dot(self.span);
        let outside_2 = w.dot(w) - r * r;
        if outside_2 <= 0.0 {
            return 0.0;
        }
        let root = toward * toward - self.length_2 * outside_2;
        if toward <= 0.0 || root < 0.0 { f64::INFINITY } else { outside_2 / (toward + libm::sqrt(root)) }
    }

    /// The share of the motion at which it leaves the square.
    fn exit(&self, square: Square<'_>) -> f64 {
        let side = f64::from(1_u32 << square.log_2);
        let along = |start: f64, span: f64, low: i32| {
            let far = if span > 0.0 { f64::from(low) + side } else { f64::from(low) };
            if span == 0.0 { f64::INFINITY } else { (far - start) / span }
        };
        along(self.start.x, self.span.x, square.low.0).min(along(self.start.y, self.span.y, square.low.1))
    }

    /// A lattice point of the motion two units beyond `t`.
    fn point_beyond(&self, t: f64) -> Option<Point> {
        let t = t + 2.0 / libm::sqrt(self.length_2);
        let at = self.start + self.span * t;
        (t < 1.0).then(|| crate::curve::nearest_point(at).ok()).flatten()
    }
}

/// A wall near the tool: the direction away from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wall {
    away: (i128, i128),
}

impl Wall {
    /// Whether the jog input `input` leads away from the wall or along it.
    #[must_use]
    pub fn is_left_by(&self, input: Vector) -> bool {
        self.away.0 * i128::from(input.dx) + self.away.1 * i128::from(input.dy) >= 0
    }

    /// The direction away from the wall, of length 1.
    #[must_use]
    pub fn normal(&self) -> Vec2 {
        let away = Vec2::new(approximate(self.away.0), approximate(self.away.1));
        away / away.length().max(1.0)
    }

    /// The jog input `input` without its component across the wall, turned away from the wall. The angle is
    /// twice the arctangent of `1 / 2^half_turn` (0.1° for 10, 53° for 1).
    ///
    /// The length is that of the projection on the wall. Returns `None` when the input has no component along
    /// the wall.
    #[must_use]
    pub fn slide(&self, input: Vector, half_turn: u32) -> Option<Vector> {
        let (nx, ny) = self.away;
        let (mut ax, mut ay) = (-ny, nx);
        let mut projected = ax * i128::from(input.dx) + ay * i128::from(input.dy);
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

/// Components of a wall's direction keep 24 bits and `half_turn` is at most 12. So the products of
/// [`Wall::slide`] need at most 24 + 31 + 1 + 24 + 24 + 2 bits and fit `i128`.
const WALL_BITS: u32 = 24;
const TURN_MAX: u32 = 12;

/// The vector from the nearest point of the segment to `p`, multiplied by the second value. `None` when `p`
/// is on the segment.
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

#[expect(clippy::cast_precision_loss, reason = "only proposes the nearest wall")]
fn approximate(value: i128) -> f64 {
    value as f64
}

/// The same direction, with components below `2^WALL_BITS`.
fn scaled_down((x, y): (i128, i128)) -> (i128, i128) {
    let bits = i128::BITS - x.unsigned_abs().max(y.unsigned_abs()).leading_zeros();
    let shift = bits.saturating_sub(WALL_BITS);
    (x >> shift, y >> shift)
}

/// The angles to try when sliding, as `half_turn` of [`Wall::slide`]. They begin along the wall and turn away
/// from it.
pub const SLIDE_TURNS: [u32; 12] = [12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1];

/// The width of the contact band, 0.1 mm beyond the threshold. A tool in the band slides along the wall; a
/// tool outside it drives up to the wall.
#[must_use]
pub fn contact_band() -> Length {
    Length::from_units(10_000).unwrap_or(Length::ZERO)
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;
    use crate::{Region, Ring, Side};

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    fn square() -> ProhibitedRegion {
        let ring = Ring::new(vec![at(0, 0), at(1000, 0), at(1000, 1000), at(0, 1000)]).unwrap();
        ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap()
    }

    #[test]
    fn clip_stops_just_short_of_the_threshold() {
        let part = square();
        let start = part.free_point(at(-5000, 500), Length::from_units(300).unwrap()).unwrap();
        let end = part.clip(start, at(5000, 500));
        assert_eq!(end.point(), at(-301, 500), "a distance equal to the threshold is not clear");
        assert_eq!(part.clip(start, at(-9000, 500)).point(), at(-9000, 500));
    }

    #[test]
    fn slide_keeps_the_part_along_the_wall() {
        let part = square();
        let start = part.free_point(at(-301, 500), Length::from_units(300).unwrap()).unwrap();
        let input = Vector { dx: 1000, dy: 1000 };
        assert!(part.motion(start, at(699, 1500)).is_err());
        let wall = part.wall(start, contact_band()).unwrap();
        let slid = wall.slide(input, 12).unwrap();
        assert!((slid.dy - 1000).abs() <= 1 && slid.dx.abs() <= 1, "{slid:?}");
        let turned = wall.slide(input, 3).unwrap();
        assert!(turned.dx < -200 && turned.dy > 900, "away from the wall: {turned:?}");
        assert_eq!(wall.slide(Vector { dx: 1000, dy: 0 }, 12), None, "straight at the wall");
        assert_eq!(wall.normal(), Vec2::new(-1.0, 0.0));
    }
}
