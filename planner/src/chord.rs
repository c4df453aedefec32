//! Fits one line or one arc between two end points to sample points between them.
//!
//! The fit uses the frame of the chord between the end points: x along the chord from its midpoint, y to its
//! left. Lengths are in lattice units.

use keepout_kernel::curve::{hypot, radius};
use keepout_kernel::{Curve, Point, Segment, Turn, Vec2};

/// Largest height of an arc as a share of half its chord: tan 22.5° (an arc of a quarter turn), and rounding.
const HEIGHT_MAX: f64 = 0.414_25;
/// Largest radius of an arc (2 m). A line replaces a larger arc if it is near enough.
const RADIUS_MAX: f64 = 2e8;
/// Smallest height of an arc. A line replaces a flatter arc.
const FLAT: f64 = 1.0;
/// Rounding of an arc's centre.
const ROUNDING: f64 = 2.0;
/// Rounds of the search for the height of an arc.
const ROUNDS: usize = 4;
/// The search ends when the height changes by less than this.
const CHANGE_MIN: f64 = 0.1;
/// Samples with a smaller share in the height lie too near an end of the chord to bound the height.
const AT_END: f64 = 1e-3;

/// The band beside a curve within which all samples must lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    /// Its width to the left of the curve.
    pub left: f64,
    /// Its width to the right of the curve.
    pub right: f64,
}

impl Band {
    fn holds(self, to_left: f64) -> bool {
        -self.right - ROUNDING <= to_left && to_left <= self.left + ROUNDING
    }
}

/// The chord between two points.
pub(crate) struct Chord {
    ends: (Point, Point),
    middle: Vec2,
    along: Vec2,
    half: f64,
}

impl Chord {
    /// The chord from one point to the other; `None` if the points are equal.
    pub fn between(from: Point, to: Point) -> Option<Self> {
        let (p, q) = (Vec2::from(from), Vec2::from(to));
        let length = p.distance(q);
        let (middle, along) = (p.midpoint(q), (q - p) / length);
        (from != to).then_some(Self { ends: (from, to), middle, along, half: length / 2.0 })
    }

    /// The line, or the arc of at most a quarter turn, between the chord's ends that has all samples within
    /// its band. Its height is near the middle of the permitted range.
    ///
    /// `None` if no such curve exists, or if the samples do not run forward along the chord.
    pub fn curve_beside(&self, places: &[Vec2], band: Band) -> Option<Curve> {
        let height = self.height(places, band)?;
        let line = || Curve::Line(Segment { from: self.ends.0, to: self.ends.1 });
        let curve = self.arc(height).unwrap_or_else(line);
        places.iter().all(|&p| band.holds(self.to_left(&curve, p))).then_some(curve)
    }

    /// The height of the arc to the left of the chord.
    ///
    /// To first order, an arc of a height larger by h is higher by h·(1 − x²/half²) at x. So each sample
    /// bounds the height from both sides. A few rounds suffice for arcs of up to a quarter turn.
    fn height(&self, places: &[Vec2], band: Band) -> Option<f64> {
        let seen: Vec<Vec2> = places.iter().map(|&p| self.seen(p)).collect();
        if seen.windows(2).any(|pair| pair[1].x < pair[0].x - FLAT) {
            return None;
        }
        let share = |x: f64| 1.0 - (x / self.half) * (x / self.half);
        let middle = seen.iter().copied().min_by(|a, b| a.x.abs().total_cmp(&b.x.abs()))?;
        let mut height = middle.y / share(middle.x).max(0.1);
        for _ in 0..ROUNDS {
            let (mut least, mut greatest) = (f64::NEG_INFINITY, f64::INFINITY);
            for &place in &seen {
                let (above, share) = (self.above(place, height), share(place.x));
                if share > AT_END {
                    least = least.max((above - band.left) / share);
                    greatest = greatest.min((above + band.right) / share);
                }
            }
            if least > greatest + FLAT {
                return None;
            }
            let step = f64::midpoint(least, greatest);
            if !step.is_finite() {
                break;
            }
            height += step;
            if step.abs() < CHANGE_MIN {
                break;
            }
        }
        (height.abs() <= HEIGHT_MAX * self.half).then_some(height)
    }

    fn seen(&self, p: Vec2) -> Vec2 {
        let d = p - self.middle;
        Vec2::new(d.dot(self.along), self.along.cross(d))
    }

    /// Signed distance of a sample, in the chord's frame, to the left of the arc of that height.
    fn above(&self, Vec2 { x, y }: Vec2, height: f64) -> f64 {
        if height.abs() < AT_END {
            return y;
        }
        let r = self.radius(height);
        // D − r = (D² − r²) / (D + r) avoids the cancellation between two large radii.
        let up = y - height;
        (x * x + up * up + 2.0 * r * up) / (hypot(x, up + r) + r.abs()) * r.signum()
    }

    /// The radius of the arc of that height; negative for an arc to the right of the chord.
    fn radius(&self, height: f64) -> f64 {
        (self.half * self.half + height * height) / (2.0 * height)
    }

    /// The arc of that height; `None` if a line must replace it.
    fn arc(&self, height: f64) -> Option<Curve> {
        if height.abs() < FLAT {
            return None;
        }
        let up = height - self.radius(height);
        let centre = self.middle + self.along.left() * up;
        let turn = if height > 0.0 { Turn::Clockwise } else { Turn::CounterClockwise };
        let fitted = Curve::fitted(self.ends.0, self.ends.1, centre, turn).ok();
        fitted.filter(|curve| matches!(curve, Curve::Arc(arc) if radius(arc) <= RADIUS_MAX))
    }

    /// Signed distance of a sample to the left of a curve between the chord's ends.
    fn to_left(&self, curve: &Curve, p: Vec2) -> f64 {
        match curve {
            Curve::Line(_) => self.seen(p).y,
            Curve::Arc(arc) => {
                let outside = p.distance(arc.centre().into()) - radius(arc);
                if arc.turn() == Turn::CounterClockwise { -outside } else { outside }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use keepout_kernel::curve::nearest_point;

    use super::*;

    fn at(place: Vec2) -> Point {
        nearest_point(place).unwrap()
    }

    /// Samples of an arc, moved inward and outward by up to `off`.
    fn places(radius: f64, begin: f64, turn: f64, off: f64) -> Vec<Vec2> {
        let place = |k: u32| {
            let (sine, cosine) = (begin + turn * f64::from(k) / 16.0).sin_cos();
            let r = if k.is_multiple_of(16) { radius } else { radius + off * (f64::from(k) * 2.0).sin() };
            Vec2::new(1000.0 + r * cosine, r * sine - 500.0)
        };
        (0..=16).map(place).collect()
    }

    #[test]
    fn arcs_are_fitted_to_their_own_samples() {
        for radius in [5e4, 1e6, 1e7, 1.9e8] {
            for turn in [-1.5, -0.3, 0.05, 1.0, 1.5] {
                let places = places(radius, 0.7, turn, 20.0);
                let chord = Chord::between(at(places[0]), at(places[16])).unwrap();
                let curve = chord.curve_beside(&places, Band { left: 25.0, right: 25.0 });
                let Some(Curve::Arc(arc)) = curve else { panic!("{radius} {turn}: {curve:?}") };
                assert_eq!(arc.turn(), if turn > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise });
                assert!(chord.curve_beside(&places, Band { left: 5.0, right: 5.0 }).is_none());
            }
        }
    }

    #[test]
    fn one_sided_bands_are_kept() {
        let places = places(1e5, 0.0, 1.2, 0.0);
        let chord = Chord::between(at(places[0]), at(places[16])).unwrap();
        for (band, longer) in
            [(Band { left: 0.0, right: 40.0 }, false), (Band { left: 40.0, right: 0.0 }, true)]
        {
            let Some(Curve::Arc(arc)) = chord.curve_beside(&places, band) else { panic!("{band:?}") };
            // All samples lie on one side of the arc. They turn left, so an arc of larger radius passes
            // inside them.
            let far = places[8].distance(arc.centre().into()) - radius(&arc);
            assert_eq!(far < 0.0, longer, "{band:?}: {far}");
        }
    }

    #[test]
    fn samples_that_run_back_have_no_curve() {
        let chord = Chord::between(at(Vec2::new(0.0, 0.0)), at(Vec2::new(1000.0, 0.0))).unwrap();
        let band = Band { left: 10.0, right: 10.0 };
        assert!(
            chord
                .curve_beside(
                    &[
                        Vec2::new(0.0, 0.0),
                        Vec2::new(600.0, 0.0),
                        Vec2::new(400.0, 0.0),
                        Vec2::new(1000.0, 0.0)
                    ],
                    band
                )
                .is_none()
        );
        assert!(Chord::between(at(Vec2::new(5.0, 5.0)), at(Vec2::new(5.0, 5.0))).is_none());
    }
}
