//! Replaces curves of changing curvature by lines and arcs, within a bound that the kernel checks exactly.

use keepout_kernel::curve::nearest_point;
use keepout_kernel::exact::bezier::{Bezier, Stray};
use keepout_kernel::{Curve, Length, Point, Segment, Vec2};

use super::RawBezier;
use crate::chord::{Band, Chord};
use crate::units::point_from_mm;

/// Default of the chord-error bound between a curve and the lines and arcs that replace it, mm.
pub const CURVE_MM: f64 = 0.001;

/// Shares of the bound to try in turn as the tolerance at the samples. The exact check needs the rest.
const SHARES: [f64; 4] = [0.85, 0.6, 0.35, 0.15];
/// Number of intervals between the samples of a stretch.
const SAMPLES: u32 = 12;
/// Smallest tolerance, lattice units. Rounding of the ends uses up any smaller tolerance.
const TOLERANCE_MIN: f64 = 2.0;
/// Shortest step of the parameter. A line replaces a stretch of this length.
const STEP_MIN: f64 = 1.0 / 16_777_216.0;
/// The search for the longest stretch ends when a stretch longer by this share is too long.
const CLOSE: f64 = 0.04;
/// Rounds that narrow the tolerance while the number of curves stays the same.
const NARROWINGS: u32 = 3;

/// A parameter of the curve, and the lattice point there.
type Place = (f64, Point);

/// The curve on the lattice: rounded control points, and weights scaled to a largest weight of 2^40.
///
/// # Errors
/// [`BezierFault`].
pub fn on_lattice(raw: &RawBezier) -> Result<Bezier, BezierFault> {
    let largest = raw.weights.iter().copied().fold(0.0, f64::max);
    let scaled = |weight: &f64| {
        let units = keepout_kernel::curve::round_down(weight / largest * power_of_two_40() + 0.5);
        u64::try_from(units).unwrap_or(0)
    };
    let weights = raw.weights.iter().map(scaled).collect();
    let control = raw.points.iter().map(|&p| point_from_mm(p)).collect::<Result<Vec<_>, _>>();
    let control = control.map_err(BezierFault::OffLattice)?;
    Bezier::new(control, weights).map_err(|_| BezierFault::Uneven)
}

/// Reasons why a curve has no place on the lattice.
pub enum BezierFault {
    /// A control point lies outside the lattice.
    OffLattice(keepout_kernel::LatticeError),
    /// Its weights differ too much, or its degree is too high.
    Uneven,
}

fn power_of_two_40() -> f64 {
    // 2^40 is an exact f64.
    f64::from(1_u32 << 20) * f64::from(1_u32 << 20)
}

/// A chain of lines and arcs from the curve's start to its end. By the kernel's check the whole curve lies
/// within `bound` of the chain.
///
/// Each line or arc begins and ends on the curve, and replaces the longest stretch that its tolerance
/// permits. If the curvature changes by k per unit of length and arcs leave the curve by e, their length L is
/// about (125·e/k)^⅓. They meet at angles of at most 20·e/L.
///
/// # Errors
/// [`Stray`] if no chain passes the check.
pub fn chain_along(curve: &Bezier, bound: Length) -> Result<Vec<Curve>, Stray> {
    let fitter = Fitter::of(curve);
    let mut refused = Stray { at: curve.control()[0] };
    // First the longest stretches, then halves: stretches that are halves can meet at a cusp in the middle of
    // the range.
    let longest = SHARES.map(|share| (share, false));
    for (share, halved) in longest.into_iter().chain(SHARES.map(|share| (share, true))) {
        let tolerance = (f64::from(bound.units()) * share).max(TOLERANCE_MIN);
        let chain = if halved { fitter.halves(tolerance) } else { fitter.fit(tolerance) };
        match curve.follows(&chain, bound) {
            Ok(()) if !chain.is_empty() => return Ok(chain),
            Ok(()) => {}
            Err(stray) => refused = stray,
        }
    }
    Err(refused)
}

struct Fitter {
    /// x·w, y·w, w of the control points, lattice units.
    rows: Vec<[f64; 3]>,
    ends: (Point, Point),
}

impl Fitter {
    fn of(curve: &Bezier) -> Self {
        let largest = power_of_two_40();
        let row = |(&p, &w): (&Point, &u64)| {
            // Weights are at most 2^40, so they are exact in f64.
            let w = (f64::from(u32::try_from(w >> 20).unwrap_or(u32::MAX)) * f64::from(1_u32 << 20)
                + f64::from(u32::try_from(w & 0xf_ffff).unwrap_or(0)))
                / largest;
            let Vec2 { x, y } = Vec2::from(p);
            [x * w, y * w, w]
        };
        let control = curve.control();
        Self {
            rows: control.iter().zip(curve.weights()).map(row).collect(),
            ends: (control[0], control[control.len() - 1]),
        }
    }

    /// The point at `t`, by de Casteljau's algorithm.
    fn at(&self, t: f64) -> Vec2 {
        let mut rows = [[0.0; 3]; keepout_kernel::exact::bezier::DEGREE_MAX + 1];
        let count = self.rows.len();
        rows[..count].copy_from_slice(&self.rows);
        for round in 1..count {
            for i in 0..count - round {
                let (a, b) = (rows[i], rows[i + 1]);
                rows[i] = [0, 1, 2].map(|k| a[k] * (1.0 - t) + b[k] * t);
            }
        }
        let [x, y, w] = rows[0];
        Vec2::new(x / w, y / w)
    }

    /// The shortest chain that the search finds within the tolerance. Of chains with as many lines and arcs,
    /// it is the nearest to the curve.
    fn fit(&self, tolerance: f64) -> Vec<Curve> {
        let (mut low, mut high) = (0.0, tolerance);
        let mut best = self.greedy(high, usize::MAX);
        for _ in 0..NARROWINGS {
            let tried = f64::midpoint(low, high).max(TOLERANCE_MIN);
            let chain = self.greedy(tried, best.len());
            if chain.len() <= best.len() {
                (best, high) = (chain, tried);
            } else {
                low = tried;
            }
        }
        best
    }

    /// A chain of the longest stretches, one after the other. It stops after more than `most` of them.
    fn greedy(&self, tolerance: f64, most: usize) -> Vec<Curve> {
        let mut chain = Vec::new();
        let (mut from, mut step) = ((0.0, self.ends.0), 0.5);
        while from.0 < 1.0 && chain.len() <= most {
            let (curve, to) = self.longest(from, step, tolerance);
            chain.extend(curve);
            step = (to.0 - from.0).max(STEP_MIN);
            from = to;
        }
        chain
    }

    /// The line or arc for the longest stretch from `from`, and the end of the stretch.
    ///
    /// The search shortens the step until a line or arc fits, or lengthens it until none fits. It then
    /// bisects between a step that fits and a step that does not.
    fn longest(&self, from: Place, step: f64, tolerance: f64) -> (Option<Curve>, Place) {
        let mut best = None;
        let (mut near, mut far, mut tried, mut growth) = (0.0, f64::INFINITY, step, 1.0 + CLOSE);
        while tried >= STEP_MIN && near * (1.0 + CLOSE) < far * (1.0 - 1e-9) {
            let to = self.place(from.0 + tried);
            match self.stretch(from, to, tolerance) {
                Some(curve) => (best, near) = (Some((curve, to)), tried),
                None => far = tried,
            }
            if near == tried && to.0 >= 1.0 {
                break;
            }
            (tried, growth) = match far {
                f64::INFINITY => (near * growth, 2.0 * growth),
                _ => (f64::midpoint(near, far), growth),
            };
        }
        best.unwrap_or_else(|| {
            let to = self.place(from.0 + STEP_MIN);
            (line_between(from.1, to.1), to)
        })
    }

    /// A chain over halves of the range. Each half is halved again until a line or arc fits.
    fn halves(&self, tolerance: f64) -> Vec<Curve> {
        let (mut chain, mut from, mut ends) = (Vec::new(), self.place(0.0), vec![1.0]);
        while let Some(&end) = ends.last() {
            let to = self.place(end);
            match self.stretch(from, to, tolerance) {
                None if end - from.0 > STEP_MIN => ends.push(f64::midpoint(from.0, end)),
                found => {
                    chain.extend(found.unwrap_or_else(|| line_between(from.1, to.1)));
                    from = to;
                    ends.pop();
                }
            }
        }
        chain
    }

    /// The parameter with its lattice point. A parameter near 1 becomes the end of the curve.
    fn place(&self, t: f64) -> Place {
        if t >= 1.0 - STEP_MIN {
            return (1.0, self.ends.1);
        }
        // The point lies in the convex hull of lattice points, so it has a nearest lattice point.
        (t, nearest_point(self.at(t)).unwrap_or(self.ends.0))
    }

    /// The line or arc for the stretch within the tolerance, or `None` if neither fits. The inner `None`
    /// stands for a stretch that is only a point.
    fn stretch(&self, from: Place, to: Place, tolerance: f64) -> Option<Option<Curve>> {
        let at = |k: u32| self.at(from.0 + (to.0 - from.0) * f64::from(k) / f64::from(SAMPLES));
        let places: Vec<Vec2> = (0..=SAMPLES).map(at).collect();
        // The direction of a stretch within the tolerance of its start does not matter.
        if places.iter().all(|place| place.distance(from.1.into()) <= tolerance) {
            return Some(line_between(from.1, to.1));
        }
        let band = Band { left: tolerance, right: tolerance };
        Chord::between(from.1, to.1)?.curve_beside(&places, band).map(Some)
    }
}

fn line_between(from: Point, to: Point) -> Option<Curve> {
    (from != to).then_some(Curve::Line(Segment { from, to }))
}

#[cfg(test)]
mod tests {
    use crate::Mm2;
    use proptest::strategy::{Strategy, ValueTree};
    use proptest::test_runner::TestRunner;

    use super::*;

    fn chain(points: &[(f64, f64)], weights: &[f64]) -> (Bezier, Vec<Curve>) {
        let raw = RawBezier {
            points: points.iter().map(|&point| point.into()).collect(),
            weights: weights.to_vec(),
        };
        let Ok(curve) = on_lattice(&raw) else { panic!("on the lattice") };
        let chain = chain_along(&curve, Length::small(100)).unwrap();
        (curve, chain)
    }

    /// The angle between two successive curves at the point where they meet, radians.
    fn turn(pair: &[Curve]) -> f64 {
        let (_, a) = crate::units::along_mm(&pair[0], 1.0);
        let (_, b) = crate::units::along_mm(&pair[1], 0.0);
        a.cross(b).atan2(a.dot(b)).abs()
    }

    #[test]
    fn chains_join_their_ends_and_turn_smoothly() {
        type Control<'a> = (&'a [(f64, f64)], &'a [f64]);
        let cases: [Control<'_>; 4] = [
            (&[(0.0, 0.0), (30.0, 0.0), (30.0, 20.0)], &[1.0, std::f64::consts::FRAC_1_SQRT_2, 1.0]),
            (&[(0.0, 0.0), (20.0, 30.0), (-10.0, 30.0), (25.0, -5.0)], &[1.0; 4]),
            (&[(0.0, 0.0), (0.0, 0.0), (10.0, 1.0), (10.0, 1.0)], &[1.0; 4]),
            (&[(0.0, 0.0), (50.0, 40.0), (-40.0, 40.0), (5.0, 0.0)], &[1.0, 2.0, 3.0, 0.5]),
        ];
        for (points, weights) in cases {
            let (curve, chain) = chain(points, weights);
            assert_eq!(chain[0].from(), curve.control()[0]);
            assert_eq!(chain[chain.len() - 1].to(), curve.control()[points.len() - 1]);
            assert!(chain.windows(2).all(|pair| pair[0].to() == pair[1].from()));
            assert!(chain.len() < 60, "{points:?}: {}", chain.len());
            let times_length = |pair: &[Curve]| turn(pair) * pair[0].length().min(pair[1].length());
            let kinks = chain.windows(2).map(times_length);
            let most = kinks.fold(0.0, f64::max);
            assert!(most < 20.0 * 100.0, "{points:?}: {most}");
        }
    }

    /// A quarter of an ellipse of 30 by 20 mm within 1 µm.
    #[test]
    fn quarter_of_an_ellipse_takes_few_arcs() {
        let points = [(30.0, 0.0), (30.0, 20.0), (0.0, 20.0)];
        let (_, chain) = chain(&points, &[1.0, std::f64::consts::FRAC_1_SQRT_2, 1.0]);
        assert!(chain.len() <= 10, "{}", chain.len());
    }

    /// Curves with a cusp or loops, with equal control points, or as short as the bound.
    #[test]
    fn degenerate_curves_have_chains() {
        let cases: [&[(f64, f64)]; 7] = [
            &[(0.0, 0.0), (10.0, 10.0), (0.0, 10.0), (10.0, 0.0)],
            &[(0.0, 0.0), (30.0, 20.0), (-20.0, 20.0), (10.0, 0.0)],
            &[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (5.0, 1.0)],
            &[(0.0, 0.0), (5.0, 0.0), (5.0, 0.0), (5.0, 0.0), (5.0, 5.0)],
            &[(0.0, 0.0), (0.000_02, 0.000_01)],
            &[(0.0, 0.0), (0.02, 0.04), (0.04, -0.02), (0.0, 0.0)],
            &[(0.0, 0.0), (100.0, 3000.0), (-100.0, 3000.0), (0.0, 0.0)],
        ];
        for points in cases {
            let (_, chain) = chain(points, &vec![1.0; points.len()]);
            assert!(chain.len() < 400, "{points:?}: {}", chain.len());
        }
    }

    /// Random curves of 0.1 to 100 mm. A chain is returned only if it passes the kernel's check. A curve that
    /// turns back within the bound, as some of the smallest do, has no such chain.
    #[test]
    fn random_curves_have_chains() {
        let places = proptest::collection::vec((-40.0..40.0_f64, -40.0..40.0_f64, 0.1..1.0_f64), 2..7);
        let mut runner = TestRunner::deterministic();
        let (mut found, mut curves) = (0, 0);
        for _ in 0..1000 {
            let (places, power) = (places.clone(), -3.0..0.0_f64).new_tree(&mut runner).unwrap().current();
            let size = 10_f64.powf(power);
            let points = places.iter().map(|&(x, y, _)| Mm2::new(x * size, y * size)).collect();
            let raw = RawBezier { points, weights: places.iter().map(|place| place.2).collect() };
            let Ok(curve) = on_lattice(&raw) else { panic!("on the lattice") };
            if let Ok(chain) = chain_along(&curve, Length::small(100)) {
                (found, curves) = (found + 1, curves + chain.len());
            }
        }
        assert!(found > 970 && curves < 10 * found, "{found}: {curves}");
    }
}
