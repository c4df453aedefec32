//! Curves with changing curvature to arcs and lines, within a bound that the kernel checks exactly.

use keepout_kernel::curve::{hypot, nearest_point, xy};
use keepout_kernel::exact::bezier::{Bezier, Stray};
use keepout_kernel::{Curve, Length, Point, Segment};

use super::RawBezier;
use crate::chord::{Band, Chord, Xy};
use crate::units::point_from_mm;

/// How far lines and arcs may leave the curve they stand for, in millimetres, unless the caller says otherwise.
pub const CURVE_MM: f64 = 0.001;

/// Shares of the bound that are tried in turn for what is sampled: the exact check wants some of it for itself.
const SHARES: [f64; 4] = [0.85, 0.6, 0.35, 0.15];
/// Places of a stretch at which the distance to the curve is sampled, and one more.
const SAMPLES: u32 = 12;
/// Below this, lattice units, rounding of the ends leaves nothing.
const TOLERANCE_MIN: f64 = 2.0;
/// The shortest step of the parameter: its stretch is taken as a line.
const STEP_MIN: f64 = 1.0 / 16_777_216.0;
/// A stretch is long enough when one that is longer by this share is too long.
const CLOSE: f64 = 0.04;
/// Rounds in which the tolerance is narrowed as long as the number of curves stays.
const NARROWINGS: u32 = 3;

/// A parameter of the curve, and the lattice point there.
type Place = (f64, Point);

/// The curve on the lattice: control points rounded, the largest weight made 2^40.
///
/// # Errors
/// What is wrong with it, for a person.
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

/// Why a curve can not be carried to the lattice.
pub enum BezierFault {
    /// A control point is off it.
    OffLattice(keepout_kernel::LatticeError),
    /// Its weights differ too much, or its degree is too high.
    Uneven,
}

fn power_of_two_40() -> f64 {
    // 2^40 is an exact f64.
    f64::from(1_u32 << 20) * f64::from(1_u32 << 20)
}

/// Lines and arcs from the curve's beginning to its end, all of it within `bound` of them by the kernel's check.
///
/// Each begins and ends on the curve, and takes the longest stretch that it is near enough to: arcs of length L that leave a
/// curve by e, whose curvature changes by k for a unit of length, are about (125·e/k)^⅓ long, and meet at angles of 20·e/L at most.
///
/// # Errors
/// [`Stray`] when no chain was found that passes the check.
pub fn chain_along(curve: &Bezier, bound: Length) -> Result<Vec<Curve>, Stray> {
    let fitter = Fitter::of(curve);
    let mut refused = Stray { at: curve.control()[0] };
    // The longest stretches, or else halves: these meet in a cusp at the middle of the range.
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
            // Weights are at most 2^40: exact in f64.
            let w = (f64::from(u32::try_from(w >> 20).unwrap_or(u32::MAX)) * f64::from(1_u32 << 20)
                + f64::from(u32::try_from(w & 0xf_ffff).unwrap_or(0)))
                / largest;
            let (x, y) = xy(p);
            [x * w, y * w, w]
        };
        let control = curve.control();
        Self {
            rows: control.iter().zip(curve.weights()).map(row).collect(),
            ends: (control[0], control[control.len() - 1]),
        }
    }

    /// The point at `t`, by de Casteljau's algorithm.
    fn at(&self, t: f64) -> Xy {
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
        (x / w, y / w)
    }

    /// The fewest curves that are found within the tolerance, and of these the nearest to the curve.
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

    /// The longest stretches, one after the other, until there are more than `most`.
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

    /// The curve along the longest stretch from `from` on that it is near to, and the stretch's end. Steps are shortened until
    /// there is one, or else lengthened until there is none, and the end is bisected between.
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

    /// Curves over halves of the range, each halved until there is one.
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

    /// The parameter, and the lattice point there.
    fn place(&self, t: f64) -> Place {
        if t >= 1.0 - STEP_MIN {
            return (1.0, self.ends.1);
        }
        let (x, y) = self.at(t);
        // Inside the hull of points of the lattice.
        (t, nearest_point(x, y).unwrap_or(self.ends.0))
    }

    /// The line or arc along the stretch within the tolerance, nothing where that is a point; `None` when there is none.
    fn stretch(&self, from: Place, to: Place, tolerance: f64) -> Option<Option<Curve>> {
        let at = |k: u32| self.at(from.0 + (to.0 - from.0) * f64::from(k) / f64::from(SAMPLES));
        let places: Vec<Xy> = (0..=SAMPLES).map(at).collect();
        // A stretch within the tolerance of its beginning has no direction worth keeping.
        let (x, y) = xy(from.1);
        if places.iter().all(|p| hypot(p.0 - x, p.1 - y) <= tolerance) {
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
    use proptest::strategy::{Strategy, ValueTree};
    use proptest::test_runner::TestRunner;

    use super::*;

    fn chain(points: &[Xy], weights: &[f64]) -> (Bezier, Vec<Curve>) {
        let raw = RawBezier { points: points.to_vec(), weights: weights.to_vec() };
        let Ok(curve) = on_lattice(&raw) else { panic!("on the lattice") };
        let chain = chain_along(&curve, Length::small(100)).unwrap();
        (curve, chain)
    }

    /// How far two curves that follow each other turn where they meet, radians.
    fn turn(pair: &[Curve]) -> f64 {
        let (_, a) = crate::units::along_mm(&pair[0], 1.0);
        let (_, b) = crate::units::along_mm(&pair[1], 0.0);
        (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1).abs()
    }

    #[test]
    fn chains_join_their_ends_and_turn_smoothly() {
        let cases: [(&[Xy], &[f64]); 4] = [
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

    /// A cusp, loops, control points that coincide, curves as short as the bound.
    #[test]
    fn degenerate_curves_have_chains() {
        let cases: [&[Xy]; 7] = [
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

    /// Random curves of 0.1 to 100 mm: a chain is returned only when the kernel finds that the curve follows it. It finds none where
    /// a curve turns back within the bound, as some of the smallest do.
    #[test]
    fn random_curves_have_chains() {
        let places = proptest::collection::vec((-40.0..40.0_f64, -40.0..40.0_f64, 0.1..1.0_f64), 2..7);
        let mut runner = TestRunner::deterministic();
        let (mut found, mut curves) = (0, 0);
        for _ in 0..1000 {
            let (places, power) = (places.clone(), -3.0..0.0_f64).new_tree(&mut runner).unwrap().current();
            let size = 10_f64.powf(power);
            let points = places.iter().map(|&(x, y, _)| (x * size, y * size)).collect();
            let raw = RawBezier { points, weights: places.iter().map(|place| place.2).collect() };
            let Ok(curve) = on_lattice(&raw) else { panic!("on the lattice") };
            if let Ok(chain) = chain_along(&curve, Length::small(100)) {
                (found, curves) = (found + 1, curves + chain.len());
            }
        }
        assert!(found > 970 && curves < 10 * found, "{found}: {curves}");
    }
}
