//! Curves of profiles and paths: straight segments and arcs, and their conversion to certified chords.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

use libm::{asin, ceil, fmin, sqrt};

use crate::arc_view::ArcView;
pub use crate::exact::arc::Curve;
use crate::exact::arc::{Arc, ArcChords, ArcError, Turn};
use crate::exact::lattice::{COORD_MAX, LatticeError, Length, Point};
use crate::exact::ring::Piece;
use crate::exact::segment::{Segment, distance_2};
use crate::offset::shortest_arc;
use crate::vec2::Vec2;

impl Curve {
    /// The length in lattice units.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Line(segment) => Vec2::from(segment.to.minus(segment.from)).length(),
            Self::Arc(arc) => ArcView::of(arc).length(),
        }
    }

    /// The best-fitting arc, as by [`fit_arc`], or a line where the arc is shorter than [`shortest_arc`].
    ///
    /// # Errors
    /// As [`fit_arc`].
    pub fn fitted(from: Point, to: Point, centre: Vec2, turn: Turn) -> Result<Self, ArcError> {
        let (arc, line) = (fit_arc(from, to, centre, turn)?, Self::Line(Segment { from, to }));
        let short = line.length() <= f64::from(shortest_arc(arc.radius()).units());
        Ok(if short { line } else { Self::Arc(arc) })
    }

    /// The same curve in the opposite direction. Returns `None` when no lattice centre fits both ends of the
    /// reversed arc.
    #[must_use]
    pub fn reversed(&self) -> Option<Self> {
        match self {
            Self::Line(segment) => Some(Self::Line(Segment { from: segment.to, to: segment.from })),
            Self::Arc(arc) => {
                let again = || fit_arc(arc.to(), arc.from(), Vec2::from(arc.centre()), arc.turn().reversed());
                arc.reversed().or_else(|_| again()).ok().map(Self::Arc)
            }
        }
    }

    /// The lattice point near `place` that divides the curve. The nearest one can lie off the circle of an arc,
    /// measured from the arc's other end. This one is at the arc's radius from its centre, rounded down. So the parts
    /// before and behind it are arcs about the same centre.
    ///
    /// # Errors
    /// [`LatticeError`] when `place` is off the lattice.
    pub fn dividing_point(&self, place: Vec2) -> Result<Point, LatticeError> {
        let nearest = nearest_point(place)?;
        let Self::Arc(arc) = self else { return Ok(nearest) };
        let divides =
            |point: &Point| distance_2(*point, arc.centre()).isqrt() == i64::from(arc.radius().units());
        if divides(&nearest) {
            return Ok(nearest);
        }
        // Steps of one unit change the distance by at most one, so one of these points has it.
        let (x, y) = (i64::from(nearest.x.units()), i64::from(nearest.y.units()));
        let near = (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| Point::from_units(x + dx, y + dy)));
        let away = |point: &Point| place.distance(Vec2::from(*point));
        let best = near.flatten().filter(divides).min_by(|a, b| away(a).total_cmp(&away(b)));
        Ok(best.unwrap_or(nearest))
    }

    /// The curve as checked chords, each within `chord_error` of it. `own` bounds the distance between this
    /// curve and the true curve.
    ///
    /// # Errors
    /// [`ArcError`] when the proposed chords fail the exact check, as for a `chord_error` below 6 units.
    pub fn piece(&self, chord_error: Length, own: Length) -> Result<Piece, ArcError> {
        match self {
            Self::Line(segment) => Ok(Piece::Line { segment: *segment, chord_error: own }),
            Self::Arc(arc) => {
                let chords = ArcChords::check(arc, propose_chords(arc, chord_error))?;
                Ok(Piece::Arc { chords, chord_error: own })
            }
        }
    }

    /// The corners of checked chords within `chord_error` of the curve. A line has two.
    ///
    /// # Errors
    /// As [`Curve::piece`]. [`ArcError::Chord`] when the checked chord error exceeds `chord_error`.
    pub fn chord_points(&self, chord_error: Length) -> Result<Vec<Point>, ArcError> {
        match self.piece(chord_error, Length::ZERO)? {
            Piece::Line { segment, .. } => Ok(vec![segment.from, segment.to]),
            Piece::Arc { chords, .. } if chords.chord_error() <= chord_error => Ok(chords.points().to_vec()),
            Piece::Arc { .. } => Err(ArcError::Chord { at: self.from() }),
        }
    }
}

/// The lattice point nearest to `point`.
///
/// # Errors
/// [`LatticeError`] when a coordinate is not finite or lies beyond ±2^29.
pub fn nearest_point(point: Vec2) -> Result<Point, LatticeError> {
    Point::from_units(nearest_unit(point.x), nearest_unit(point.y))
}

/// The integer nearest to `value`. Returns an integer off the lattice when `value` is not finite or too
/// large.
#[must_use]
pub fn nearest_unit(value: f64) -> i64 {
    let limit = f64::from(COORD_MAX) + 1.0;
    if value.abs() <= limit { round_down(value + 0.5) } else { i64::MAX }
}

/// The greatest integer not above `value`, which is clamped to ±2^52. Returns 0 for NaN.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "clamped to integers that f64 holds exactly"
)]
pub fn round_down(value: f64) -> i64 {
    const EXACT: f64 = 4_503_599_627_370_496.0;
    let value = value.clamp(-EXACT, EXACT);
    let truncated = value as i64;
    truncated - i64::from(truncated as f64 > value)
}

/// The smallest integer not below `value`, with the limits of [`round_down`].
#[must_use]
pub fn round_up(value: f64) -> i64 {
    -round_down(-value)
}

/// The length of the vector `(x, y)`, in lattice units. On the lattice no square overflows or underflows.
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    sqrt(x * x + y * y)
}

/// The best-fitting arc from `from` to `to`, about a lattice centre near `centre`.
///
/// # Errors
/// [`ArcError`] when no centre within two units puts both ends on one circle.
pub fn fit_arc(from: Point, to: Point, centre: Vec2, turn: Turn) -> Result<Arc, ArcError> {
    let (x0, y0) = (nearest_unit(centre.x), nearest_unit(centre.y));
    let mut best: Option<(f64, Arc)> = None;
    let mut refused = ArcError::OffCircle { at: to };
    if let Ok(arc) =
        Point::from_units(x0, y0).map_err(|_| refused).and_then(|centre| Arc::new(from, to, centre, turn))
        && (distance(from, arc.centre()) - distance(to, arc.centre())).abs() < 1.0
    {
        return Ok(arc);
    }
    for (dx, dy) in (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy))) {
        let Ok(near) = Point::from_units(x0.saturating_add(dx), y0.saturating_add(dy)) else { continue };
        match Arc::new(from, to, near, turn) {
            Ok(arc) => {
                let mismatch = (distance(from, near) - distance(to, near)).abs();
                let cost = mismatch + 0.25 * centre.distance(near.into());
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, arc));
                }
            }
            Err(error) => refused = error,
        }
    }
    best.map(|(_, arc)| arc).ok_or(refused)
}

/// The angle of the arc, in (0, 2π].
#[must_use]
pub fn sweep(arc: &Arc) -> f64 {
    ArcView::of(arc).sweep.abs()
}

/// The radius of the arc, measured at its start, in lattice units.
#[must_use]
pub fn radius(arc: &Arc) -> f64 {
    distance(arc.from(), arc.centre())
}

fn distance(p: Point, q: Point) -> f64 {
    Vec2::from(p).distance(q.into())
}

/// The amount that [`ArcChords::check`] adds to the sagitta: the ring's width, and one unit of rounding up.
const RING_WIDTH: f64 = 5.0;

fn propose_chords(arc: &Arc, chord_error: Length) -> Vec<Point> {
    let (rho, end_rho) = (radius(arc), distance(arc.to(), arc.centre()));
    let sagitta = (f64::from(chord_error.units()) - RING_WIDTH).max(1.0);
    // The checker bounds the sagitta by `L² / 7ρ`. Two units of L are reserved for rounding.
    let longest = fmin(sqrt(7.0 * rho * sagitta) - 2.0, 0.9 * rho).max(4.0);
    let view = ArcView::of(arc);
    let count = ceil(view.sweep.abs() / (2.0 * asin(fmin(longest / (2.0 * rho), 0.5)))).max(1.0);
    let step = view.sweep / count;
    let mut points = vec![arc.from()];
    let mut k = 1.0;
    while k < count {
        let radius = rho + (end_rho - rho) * (k / count);
        points.extend(nearest_point(ArcView { radius, ..view }.at_angle(view.start + step * k)));
        k += 1.0;
    }
    points.push(arc.to());
    points
}

/// The number of equal parts, each at most half a circle, for a turn of `sweep` radians.
#[must_use]
pub fn half_circle_parts(sweep: f64) -> u8 {
    if sweep <= PI + 1e-9 {
        1
    } else if sweep <= TAU + 1e-9 {
        2
    } else {
        3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proposed_chords_pass_the_check_for_all_sizes() {
        for radius in [100, 1_000, 30_000, 300_000, 10_000_000, 200_000_000_i64] {
            for turn in [Turn::CounterClockwise, Turn::Clockwise] {
                let at = |x, y| Point::from_units(x, y).unwrap();
                let arc = Arc::new(at(radius + 7, 9), at(7 - radius, 9), at(7, 9), turn).unwrap();
                let chords = Curve::Arc(arc).chord_points(Length::from_units(10).unwrap()).unwrap();
                assert!(chords.len() > 2);
            }
        }
    }

    #[test]
    fn an_arc_divides_anywhere_into_arcs_about_its_centre() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut divided = 0;
        while divided < 20_000 {
            let radius = 64.0 * 8_000_000.0_f64.powf(random.f64());
            let centre = Point::from_units(random.i64(-1000..1000), random.i64(-1000..1000)).unwrap();
            // Ends that the lattice rounds, and a unit more, at axes and elsewhere.
            let mut end = || {
                let eighth = TAU / 8.0 * f64::from(random.u8(0..8));
                let angle = eighth + [0.0, 1e-6, 0.02, 1.0][random.usize(0..4)] * (random.f64() - 0.5);
                let far = radius + 3.0 * (random.f64() - 0.5);
                nearest_point(Vec2::from(centre) + Vec2::new(far * libm::cos(angle), far * libm::sin(angle)))
                    .unwrap()
            };
            let turn = if divided % 2 == 0 { Turn::CounterClockwise } else { Turn::Clockwise };
            let Ok(arc) = Arc::new(end(), end(), centre, turn) else { continue };
            divided += 1;
            let view = ArcView::of(&arc);
            let at = |share: f64| {
                let place = view.at(share);
                let point = Curve::Arc(arc).dividing_point(place).unwrap();
                assert!(place.distance(point.into()) < 2.0, "{arc:?} at {share}");
                point
            };
            let share = [random.f64(), 1e-3 * random.f64(), 1.0 - 1e-3 * random.f64()][random.usize(0..3)];
            let points = [arc.from(), at(share * random.f64()), at(share), arc.to()];
            for (k, from) in points.iter().enumerate() {
                for to in points.iter().skip(k + 1).filter(|to| *to != from) {
                    let part = Arc::new(*from, *to, centre, turn);
                    assert!(part.is_ok(), "{arc:?} at {share}: {part:?}");
                }
            }
        }
    }

    #[test]
    fn off_lattice_values_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, -1e300, 6e8] {
            assert!(nearest_point(Vec2::new(bad, 0.0)).is_err(), "{bad}");
        }
    }
}
