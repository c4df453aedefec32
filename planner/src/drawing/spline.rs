//! Splits splines into rational Bézier pieces.

use super::entity::Spline;
use super::placement::Placement;
use super::{RawBezier, RawCurve};
use crate::Mm2;

/// Highest degree of a spline.
pub const DEGREE_MAX: usize = 15;

/// Largest distance between ends that count as equal, mm.
const ROUNDING_MM: f64 = 1e-6;

/// Adds the pieces of a spline, mapped by `placement` and projected onto the xy plane.
///
/// The pieces come from blossoming: control point j of the piece over [a, b] is the blossom at p − j times a
/// and j times b, where p is the degree (Ramshaw 1989). Knot insertion gives the same points (Piegl & Tiller,
/// The NURBS Book, §5.2 and 5.3).
///
/// # Errors
/// The fault of the spline, in words for the user.
pub fn pieces(spline: &Spline, placement: &Placement, out: &mut Vec<RawCurve>) -> Result<(), &'static str> {
    if spline.control.len() < 2 && spline.fit.len() >= 2 {
        super::fit_points::through(&spline.fit, spline.closed, spline.tangents, placement, out);
        return Ok(());
    }
    let count = spline.control.len();
    let degree = usize::try_from(spline.degree).unwrap_or(0);
    if !(1..=DEGREE_MAX).contains(&degree) {
        return Err("its degree is not between 1 and 15");
    }
    if count <= degree {
        return Err("it has fewer control points than its degree needs");
    }
    let knots = knots_of(spline, degree)?;
    let weights = match spline.weights.len() {
        0 => vec![1.0; count],
        n if n == count => spline.weights.clone(),
        _ => return Err("its number of weights differs from its number of control points"),
    };
    if weights.iter().any(|&weight| weight <= 0.0) {
        return Err("a weight is not positive");
    }
    let control: Vec<Homogeneous> = spline
        .control
        .iter()
        .zip(&weights)
        .map(|(&p, &w)| {
            let Mm2 { x, y } = placement.seen(p);
            [x * w, y * w, w]
        })
        .collect();
    let mut last: Option<Mm2> = None;
    for span in degree..count {
        let (a, b) = (knots[span], knots[span + 1]);
        if a >= b {
            continue;
        }
        let mut piece = piece_over(&control, &knots, degree, span);
        // Each piece begins exactly at the end of the previous one.
        if let Some(last) = last {
            if piece.points[0].distance(last) > ROUNDING_MM {
                return Err("it jumps at one of its inner knots");
            }
            piece.points[0] = last;
        }
        last = piece.points.last().copied();
        out.push(piece.simplified());
    }
    if last.is_none() {
        return Err("its knots define no curve");
    }
    close_up(spline, out);
    Ok(())
}

type Homogeneous = [f64; 3];

/// The knots of a spline, or uniform knots if the file gives no knots.
fn knots_of(spline: &Spline, degree: usize) -> Result<Vec<f64>, &'static str> {
    let count = spline.control.len();
    let wanted = count + degree + 1;
    if spline.knots.is_empty() {
        let inner = count - degree;
        let mut knot = 0.0;
        let mut knots = vec![0.0; degree + 1];
        for _ in 1..inner {
            knot += 1.0;
            knots.push(knot);
        }
        knots.resize(wanted, knot + 1.0);
        return Ok(knots);
    }
    if spline.knots.len() != wanted {
        return Err("its number of knots does not fit its degree and its number of control points");
    }
    // A knot that is less than its predecessor only by rounding is raised to it.
    let range = spline.knots[wanted - 1] - spline.knots[0];
    let mut knots = spline.knots.clone();
    for i in 1..wanted {
        if knots[i] < knots[i - 1] - 1e-6 * range.abs() {
            return Err("its knots do not ascend");
        }
        knots[i] = knots[i].max(knots[i - 1]);
    }
    Ok(knots)
}

fn piece_over(control: &[Homogeneous], knots: &[f64], degree: usize, span: usize) -> RawBezier {
    let (a, b) = (knots[span], knots[span + 1]);
    let blossom = |ends: usize| {
        // De Boor's algorithm with argument b in the first `ends` rounds, then a.
        let mut d: Vec<Homogeneous> = control[span - degree..=span].to_vec();
        for round in 1..=degree {
            let u = if round <= ends { b } else { a };
            for j in (round..=degree).rev() {
                let (low, high) = (knots[span - degree + j], knots[span + 1 + j - round]);
                let t = if high > low { (u - low) / (high - low) } else { 0.0 };
                let before = d[j - 1];
                d[j] = [0, 1, 2].map(|i| before[i] * (1.0 - t) + d[j][i] * t);
            }
        }
        d[degree]
    };
    let points = (0..=degree).map(blossom);
    let (mut at, mut weights) = (Vec::with_capacity(degree + 1), Vec::with_capacity(degree + 1));
    for [x, y, w] in points {
        at.push(Mm2::new(x / w, y / w));
        weights.push(w);
    }
    RawBezier { points: at, weights }
}

/// Makes the ends of a closed spline meet exactly, if they meet up to rounding.
fn close_up(spline: &Spline, out: &mut [RawCurve]) {
    let Some(begin) = out.first().map(RawCurve::from) else { return };
    let Some(last) = out.last_mut() else { return };
    let end = last.to();
    if spline.closed && begin.distance(end) < ROUNDING_MM {
        last.set_to(begin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces_of(spline: &Spline) -> Vec<RawCurve> {
        let mut out = Vec::new();
        pieces(spline, &Placement::scaled(1.0), &mut out).unwrap();
        out
    }

    fn at(curve: &RawCurve, t: f64) -> Mm2 {
        match curve {
            RawCurve::Bezier(bezier) => bezier.at(t),
            RawCurve::Line { from, to } => {
                Mm2::new(from.x + (to.x - from.x) * t, from.y + (to.y - from.y) * t)
            }
            RawCurve::Arc { .. } => panic!("no arcs here"),
        }
    }

    /// The point of the spline by the definition of the basis functions: the oracle.
    fn de_boor(spline: &Spline, u: f64) -> Mm2 {
        let p = usize::try_from(spline.degree).unwrap();
        let basis = |i: usize, u: f64| basis(&spline.knots, i, p, u);
        let weight = |i: usize| spline.weights.get(i).copied().unwrap_or(1.0);
        let mut sum = [0.0; 3];
        for (i, c) in spline.control.iter().enumerate() {
            let n = basis(i, u) * weight(i);
            sum = [sum[0] + n * c[0], sum[1] + n * c[1], sum[2] + n];
        }
        Mm2::new(sum[0] / sum[2], sum[1] / sum[2])
    }

    fn basis(knots: &[f64], i: usize, p: usize, u: f64) -> f64 {
        if p == 0 {
            return if knots[i] <= u && u < knots[i + 1] { 1.0 } else { 0.0 };
        }
        let part = |top: f64, below: f64| if below > 0.0 { top / below } else { 0.0 };
        part(u - knots[i], knots[i + p] - knots[i]) * basis(knots, i, p - 1, u)
            + part(knots[i + p + 1] - u, knots[i + p + 1] - knots[i + 1]) * basis(knots, i + 1, p - 1, u)
    }

    #[test]
    fn pieces_agree_with_the_basis_functions() {
        let control = vec![
            [0.0; 3],
            [10.0, 5.0, 0.0],
            [20.0, -8.0, 3.0],
            [33.0, 4.0, 0.0],
            [40.0, 0.0, 0.0],
            [52.0, 9.0, 0.0],
        ];
        let cases = [
            (3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.5, 3.0, 3.0, 3.0, 3.0], vec![]),
            (3, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], vec![1.0, 0.5, 2.0, 3.0, 0.7, 1.0]),
            (2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0], vec![]),
            (
                5,
                vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
                vec![1.0, 2.0, 1.0, 1.0, 4.0, 1.0],
            ),
            (1, vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0], vec![]),
        ];
        for (degree, knots, weights) in cases {
            let spline = Spline { degree, knots, weights, control: control.clone(), ..Spline::default() };
            let p = usize::try_from(degree).unwrap();
            let spans: Vec<(f64, f64)> = spline.knots[p..=control.len()]
                .windows(2)
                .filter(|pair| pair[0] < pair[1])
                .map(|pair| (pair[0], pair[1]))
                .collect();
            let found = pieces_of(&spline);
            assert_eq!(found.len(), spans.len());
            for (curve, (a, b)) in found.iter().zip(spans) {
                for t in [0.0, 0.25, 0.5, 0.999] {
                    let Mm2 { x, y } = at(curve, t);
                    let Mm2 { x: u, y: v } = de_boor(&spline, a + (b - a) * t);
                    assert!((x - u).hypot(y - v) < 1e-9, "degree {degree} at {t}: {x} {y}, {u} {v}");
                }
            }
        }
    }

    #[test]
    fn invalid_splines_are_refused_with_the_reason() {
        let control = vec![[0.0; 3]; 4];
        let bad = |spline: Spline| pieces(&spline, &Placement::scaled(1.0), &mut Vec::new()).unwrap_err();
        assert!(bad(Spline { degree: 99, control: control.clone(), ..Spline::default() }).contains("degree"));
        assert!(bad(Spline { degree: 5, control: control.clone(), ..Spline::default() }).contains("fewer"));
        let knots = vec![0.0; 3];
        assert!(
            bad(Spline { degree: 3, knots, control: control.clone(), ..Spline::default() }).contains("knots")
        );
        let knots = vec![0.0, 0.0, 0.0, 2.0, 1.0, 3.0, 3.0, 3.0];
        assert!(
            bad(Spline { degree: 3, knots, control: control.clone(), ..Spline::default() })
                .contains("ascend")
        );
        let weights = vec![1.0, -1.0, 1.0, 1.0];
        assert!(bad(Spline { degree: 3, weights, control, ..Spline::default() }).contains("weight"));
    }
}
