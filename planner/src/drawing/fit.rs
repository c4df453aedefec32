//! Curves with changing curvature to arcs and lines, within a bound that the kernel checks exactly.

use keepout_kernel::curve::{fit_arc, hypot, nearest_point, xy};
use keepout_kernel::exact::bezier::{Bezier, Stray};
use keepout_kernel::{Curve, Length, Point, Segment, Turn};

use super::RawBezier;
use crate::units::point_from_mm;

/// How far lines and arcs may leave the curve they stand for, in millimetres, unless the caller says otherwise.
pub const CURVE_MM: f64 = 0.001;

/// Shares of the bound that are tried in turn for what is sampled: the exact check wants some of it for itself.
const SHARES: [f64; 3] = [0.6, 0.35, 0.15];
/// The arcs of a pair turn by less than this altogether, radians.
const TURN_MAX: f64 = 1.5;
/// Halvings before what is left is taken as a line.
const DEPTH_MAX: u32 = 24;
/// Places at which the distance to the curve is sampled.
const SAMPLES: u32 = 12;
/// An arc whose centre is farther away than this, in lattice units (2 m), is not tried.
const RADIUS_MAX: f64 = 2e8;
/// An arc flatter than this, in lattice units, is a line.
const FLAT: f64 = 2.0;

type Xy = (f64, f64);

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
/// Pairs of arcs that share a tangent where they meet and have the curve's own at their ends (biarcs: Bolton 1975), over
/// halves of the parameter's range until they are near enough.
///
/// # Errors
/// [`Stray`] when no chain was found that passes the check.
pub fn chain_along(curve: &Bezier, bound: Length) -> Result<Vec<Curve>, Stray> {
    let fitter = Fitter::of(curve);
    let mut refused = Stray { at: curve.control()[0] };
    for share in SHARES {
        let mut chain = Vec::new();
        fitter.fit(f64::from(bound.units()) * share, &mut chain);
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

    /// The point and the derivative at `t`.
    fn at(&self, t: f64) -> (Xy, Xy) {
        let mut rows = [[0.0; 3]; keepout_kernel::exact::bezier::DEGREE_MAX + 1];
        let count = self.rows.len();
        rows[..count].copy_from_slice(&self.rows);
        let mean = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] * (1.0 - t) + b[k] * t);
        for round in 1..count - 1 {
            for i in 0..count - round {
                rows[i] = mean(rows[i], rows[i + 1]);
            }
        }
        let [a, b] = [rows[0], rows[1]];
        let [x, y, w] = mean(a, b);
        let p = (x / w, y / w);
        // The quotient rule, but for a positive factor.
        let (dx, dy, dw) = (b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        (p, ((dx - p.0 * dw) / w, (dy - p.1 * dw) / w))
    }

    fn fit(&self, tolerance: f64, chain: &mut Vec<Curve>) {
        let begin = self.ends.0;
        let mut from = (0.0, begin);
        self.interval(&mut from, (1.0, self.ends.1), tolerance, 0, chain);
    }

    /// Fits the stretch from `from` to `to`; `from` is then where the chain has come to.
    fn interval(
        &self,
        from: &mut (f64, Point),
        to: (f64, Point),
        tolerance: f64,
        depth: u32,
        chain: &mut Vec<Curve>,
    ) {
        let line = Curve::Line(Segment { from: from.1, to: to.1 });
        let deviation = self.deviation(&[line], from.0, to.0);
        // A stretch shorter than the bound has no direction worth keeping.
        let short = line.length() <= tolerance && deviation <= tolerance;
        if deviation <= FLAT || short || depth >= DEPTH_MAX {
            if from.1 != to.1 {
                chain.push(line);
            }
            *from = to;
            return;
        }
        // Where arcs would be too large, a line that is near enough does.
        let (fitted, off) = match self.pair(*from, to) {
            Some(pair) => {
                let off = self.deviation(&pair, from.0, to.0);
                (pair, off)
            }
            None => (vec![line], deviation),
        };
        if off <= tolerance {
            chain.extend(fitted);
            *from = to;
            return;
        }
        let t = f64::midpoint(from.0, to.0);
        let (x, y) = self.at(t).0;
        // Inside the hull of points of the lattice.
        let middle = nearest_point(x, y).unwrap_or(from.1);
        self.interval(from, (t, middle), tolerance, depth + 1, chain);
        self.interval(from, to, tolerance, depth + 1, chain);
    }

    /// The unit direction of the curve at `t`, looking into the stretch that ends at `towards`.
    fn direction(&self, t: f64, towards: f64) -> Option<Xy> {
        let (p, d) = self.at(t);
        let forwards = if towards > t { 1.0 } else { -1.0 };
        unit(d).or_else(|| {
            // A control point sits on the end: a short way on the direction shows.
            let (q, _) = self.at(t + (towards - t) * 1e-3);
            unit(((q.0 - p.0) * forwards, (q.1 - p.1) * forwards))
        })
    }

    fn pair(&self, (s, from): (f64, Point), (t, to): (f64, Point)) -> Option<Vec<Curve>> {
        let (u, v) = (self.direction(s, t)?, self.direction(t, s)?);
        let (p, q) = (xy(from), xy(to));
        let chord = (q.0 - p.0, q.1 - p.1);
        let length = hypot(chord.0, chord.1);
        let turned = |a: Xy, b: Xy| cross(a, b).atan2(dot(a, b)).abs();
        if length < 1.0 || turned(u, chord) + turned(chord, v) > TURN_MAX {
            return None;
        }
        let joint = nearest_between(p, q, u, v);
        let joint = nearest_point(joint.0, joint.1).ok()?;
        // The middle tangent is that of the first arc at the joint; the second is fitted backwards from its end.
        let first = arc_from(from, joint, u)?;
        let second = arc_from(to, joint, (-v.0, -v.1))?.reversed()?;
        let parts = [first, second].into_iter().filter(|part| part.from() != part.to());
        Some(parts.collect())
    }

    /// The farthest of sampled places of the stretch from the chain, lattice units.
    fn deviation(&self, chain: &[Curve], from: f64, to: f64) -> f64 {
        let far = |k: u32| {
            let t = from + (to - from) * f64::from(k) / f64::from(SAMPLES);
            let p = self.at(t).0;
            chain.iter().map(|curve| distance(curve, p)).fold(f64::INFINITY, f64::min)
        };
        (1..SAMPLES).map(far).fold(0.0, f64::max)
    }
}

/// Where the two arcs of a pair meet, with equal distances from the ends to the corners of their tangents.
fn nearest_between(p: Xy, q: Xy, u: Xy, v: Xy) -> Xy {
    let chord = (q.0 - p.0, q.1 - p.1);
    let sum = (u.0 + v.0, u.1 + v.1);
    let along = dot(chord, sum);
    let bend = 2.0 * (1.0 - dot(u, v));
    let d = if bend > 1e-12 {
        ((along * along + bend * dot(chord, chord)).sqrt() - along) / bend
    } else {
        dot(chord, chord) / (2.0 * along)
    };
    (f64::midpoint(p.0, q.0) + d * (u.0 - v.0) / 2.0, f64::midpoint(p.1, q.1) + d * (u.1 - v.1) / 2.0)
}

/// The arc from `from` in the direction `u` to `to`, or the line when it is as flat as one; `None` when there is neither.
fn arc_from(from: Point, to: Point, u: Xy) -> Option<Curve> {
    let line = Curve::Line(Segment { from, to });
    let (p, q) = (xy(from), xy(to));
    let chord = (q.0 - p.0, q.1 - p.1);
    let length_2 = dot(chord, chord);
    let side = cross(u, chord);
    // Sagitta: chord² / 8r with r = chord² / 2·side.
    if side.abs() / 4.0 < FLAT {
        return Some(line);
    }
    let r = length_2 / (2.0 * side);
    if r.abs() > RADIUS_MAX {
        return None;
    }
    let middle = (f64::midpoint(p.0, q.0), f64::midpoint(p.1, q.1));
    // On the chord's bisector, where the normal of `u` meets it.
    let half = dot(chord, u) / (2.0 * side);
    let centre = (middle.0 - chord.1 * half, middle.1 + chord.0 * half);
    let turn = if side > 0.0 { Turn::Left } else { Turn::Right };
    fit_arc(from, to, centre, turn).ok().map(Curve::Arc)
}

fn distance(curve: &Curve, p: Xy) -> f64 {
    let ends = [xy(curve.from()), xy(curve.to())];
    let to_end = || ends.iter().map(|e| hypot(p.0 - e.0, p.1 - e.1)).fold(f64::INFINITY, f64::min);
    match curve {
        Curve::Line(_) => {
            let [a, b] = ends;
            let n = crate::units::nearest_on_mm(p, a, b);
            hypot(p.0 - n.0, p.1 - n.1)
        }
        Curve::Arc(arc) => {
            let c = xy(arc.centre());
            let spoke = |e: Xy| (e.0 - c.0, e.1 - c.1);
            let sign = if arc.turn() == Turn::Left { 1.0 } else { -1.0 };
            let within = sign * cross(spoke(ends[0]), spoke(p)) >= 0.0
                && sign * cross(spoke(p), spoke(ends[1])) >= 0.0;
            let (px, py) = spoke(p);
            if within { (hypot(px, py) - keepout_kernel::curve::radius(arc)).abs() } else { to_end() }
        }
    }
}

fn unit((x, y): Xy) -> Option<Xy> {
    let length = hypot(x, y);
    (length > 1e-6).then(|| (x / length, y / length))
}

fn dot(a: Xy, b: Xy) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

fn cross(a: Xy, b: Xy) -> f64 {
    a.0 * b.1 - a.1 * b.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(points: &[Xy], weights: &[f64]) -> (Bezier, Vec<Curve>) {
        let raw = RawBezier { points: points.to_vec(), weights: weights.to_vec() };
        let Ok(curve) = on_lattice(&raw) else { panic!("on the lattice") };
        let chain = chain_along(&curve, Length::small(100)).unwrap();
        (curve, chain)
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
            assert!(chain.len() < 160, "{points:?}: {}", chain.len());
        }
    }

    /// A tenth of a turn at 8 m is 5 m long: chords of 5 mm are 0.4 µm off it.
    #[test]
    fn arcs_too_large_for_the_lattice_are_lines_no_shorter_than_needed() {
        let (half, r) = (std::f64::consts::PI / 10.0, 8000.0);
        let (sine, cosine) = half.sin_cos();
        let points = [(-r * sine, 0.0), (0.0, r * sine * sine / cosine), (r * sine, 0.0)];
        let (_, chain) = chain(&points, &[1.0, cosine, 1.0]);
        assert!((300..1100).contains(&chain.len()), "{}", chain.len());
    }

    #[test]
    fn straight_curves_are_lines() {
        let (_, chain) = chain(&[(0.0, 0.0), (10.0, 1.0), (20.0, 2.0), (30.0, 3.0)], &[1.0; 4]);
        assert_eq!(chain.len(), 1, "{chain:?}");
    }
}
