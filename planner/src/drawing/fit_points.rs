//! Splines that are given by fit points alone: cubics with continuous curvature, parametrized by chord
//! length.

use super::RawCurve;
use super::entity::Vec3;
use super::placement::Placement;

/// Adds the cubic pieces of the spline through the points.
///
/// At an open end the spline has the given direction; without one, its curvature there is zero (a natural
/// spline). A closed spline is smooth at its first point, too. Chord lengths are distances in the spline's
/// own space. `placement`, which may stretch them, is applied to the finished pieces.
///
/// The unknowns are the derivatives at the points. They solve the tridiagonal system of cubic Hermite
/// interpolation with knots at the chord lengths (de Boor, A Practical Guide to Splines, ch. IV).
pub fn through(
    points: &[Vec3],
    closed: bool,
    directions: (Option<Vec3>, Option<Vec3>),
    placement: &Placement,
    out: &mut Vec<RawCurve>,
) {
    let mut points = points.to_vec();
    points.dedup();
    if closed && points.len() > 2 && points.first() != points.last() {
        points.push(points[0]);
    }
    let closed = closed && points.len() > 3;
    if points.len() < 2 {
        return;
    }
    let steps: Vec<f64> = points.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
    let slopes = if closed { periodic(&points, &steps) } else { open(&points, &steps, directions) };
    for (i, &h) in steps.iter().enumerate() {
        let (p, q) = (points[i], points[i + 1]);
        let (u, v) = (slopes[i], slopes[i + 1]);
        let control = [p, each(|k| p[k] + u[k] * h / 3.0), each(|k| q[k] - v[k] * h / 3.0), q];
        out.push(RawCurve::bezier(control.iter().map(|&c| placement.seen(c)).collect(), vec![1.0; 4]));
    }
}

fn distance(p: Vec3, q: Vec3) -> f64 {
    length(each(|k| p[k] - q[k]))
}

fn length([x, y, z]: Vec3) -> f64 {
    x.hypot(y).hypot(z)
}

/// The vector with the coordinates `of(0)`, `of(1)`, `of(2)`.
fn each(of: impl Fn(usize) -> f64) -> Vec3 {
    [of(0), of(1), of(2)]
}

/// A row of a tridiagonal system: below, on and above the diagonal, and the right side.
#[derive(Clone, Copy)]
struct Row {
    below: f64,
    on: f64,
    above: f64,
    right: Vec3,
}

/// The row that makes the curvature continuous at a point between two steps.
fn smooth(before: f64, after: f64, [p, q, r]: [Vec3; 3]) -> Row {
    let side = |p: f64, q: f64, r: f64| 3.0 * (after * (q - p) / before + before * (r - q) / after);
    Row { below: after, on: 2.0 * (before + after), above: before, right: each(|k| side(p[k], q[k], r[k])) }
}

fn open(points: &[Vec3], steps: &[f64], directions: (Option<Vec3>, Option<Vec3>)) -> Vec<Vec3> {
    let last = steps.len();
    let end = |direction: Option<Vec3>, step: f64, p: Vec3, q: Vec3, first: bool| {
        let length = direction.map_or(0.0, length);
        match direction {
            Some(d) if length > 0.0 => Row { below: 0.0, on: 1.0, above: 0.0, right: d.map(|c| c / length) },
            _ => {
                let (below, above) = if first { (0.0, 1.0) } else { (1.0, 0.0) };
                Row { below, on: 2.0, above, right: each(|k| 3.0 * (q[k] - p[k]) / step) }
            }
        }
    };
    let mut rows = vec![end(directions.0, steps[0], points[0], points[1], true)];
    for i in 1..last {
        rows.push(smooth(steps[i - 1], steps[i], [points[i - 1], points[i], points[i + 1]]));
    }
    rows.push(end(directions.1, steps[last - 1], points[last - 1], points[last], false));
    solve(&rows)
}

/// The slopes of a closed spline. The first and the last row have an element in a corner of the matrix. The
/// formula of Sherman and Morrison reduces this system to tridiagonal ones.
fn periodic(points: &[Vec3], steps: &[f64]) -> Vec<Vec3> {
    let n = steps.len();
    let row = |i: usize| {
        let before = (i + n - 1) % n;
        smooth(steps[before], steps[i], [points[before], points[i], points[i + 1]])
    };
    let mut rows: Vec<Row> = (0..n).map(row).collect();
    let (corner_above, corner_below) = (rows[0].below, rows[n - 1].above);
    let gamma = -rows[0].on;
    rows[0].on -= gamma;
    rows[n - 1].on -= corner_below * corner_above / gamma;
    let plain = solve(&rows);
    let mut unit_rows: Vec<Row> = rows.iter().map(|row| Row { right: [0.0; 3], ..*row }).collect();
    unit_rows[0].right[0] = gamma;
    unit_rows[n - 1].right[0] = corner_below;
    let z: Vec<f64> = solve(&unit_rows).into_iter().map(|[x, ..]| x).collect();
    let share = |first: f64, last: f64| first + corner_above * last / gamma;
    let below = 1.0 + share(z[0], z[n - 1]);
    let factor = each(|k| share(plain[0][k], plain[n - 1][k]) / below);
    let mut slopes: Vec<Vec3> = plain.iter().zip(&z).map(|(p, z)| each(|k| p[k] - factor[k] * z)).collect();
    slopes.push(slopes[0]);
    slopes
}

/// Solves a diagonally dominant tridiagonal system by Thomas' algorithm. All systems here are of this kind.
fn solve(rows: &[Row]) -> Vec<Vec3> {
    let mut above = Vec::with_capacity(rows.len());
    let mut right: Vec<Vec3> = Vec::with_capacity(rows.len());
    let (mut last_above, mut last) = (0.0, [0.0; 3]);
    for row in rows {
        let on = row.on - row.below * last_above;
        last = each(|k| (row.right[k] - row.below * last[k]) / on);
        last_above = row.above / on;
        above.push(last_above);
        right.push(last);
    }
    for i in (0..rows.len().saturating_sub(1)).rev() {
        let next = right[i + 1];
        right[i] = each(|k| right[i][k] - above[i] * next[k]);
    }
    right
}

#[cfg(test)]
mod tests {
    use super::super::entity::Insert;
    use super::*;
    use crate::Mm2;

    fn beziers(points: &[(f64, f64)], closed: bool) -> Vec<Vec<Mm2>> {
        beziers_in(&Placement::scaled(1.0), points, closed)
    }

    fn beziers_in(placement: &Placement, points: &[(f64, f64)], closed: bool) -> Vec<Vec<Mm2>> {
        let mut out = Vec::new();
        let points: Vec<Vec3> = points.iter().map(|&(x, y)| [x, y, 0.0]).collect();
        through(&points, closed, (None, None), placement, &mut out);
        let control = |curve: &RawCurve| match curve {
            RawCurve::Bezier(bezier) => bezier.points.clone(),
            RawCurve::Line { from, to } => vec![*from, *to],
            RawCurve::Arc { .. } => panic!("no arcs here"),
        };
        out.iter().map(control).collect()
    }

    /// Second derivatives by chord length at the start and the end of a piece.
    fn bends(b: &[Mm2]) -> (Mm2, Mm2) {
        let h = b[0].distance(b[3]);
        let second = |p: Mm2, q: Mm2, r: Mm2| (p - q * 2.0 + r) * 6.0 / (h * h);
        (second(b[0], b[1], b[2]), second(b[1], b[2], b[3]))
    }

    #[test]
    fn curvature_is_continuous_at_every_point_of_open_and_closed_splines() {
        let points = [(0.0, 0.0), (10.0, 3.0), (17.0, -4.0), (9.0, -12.0), (-3.0, -6.0)];
        for closed in [false, true] {
            let pieces = beziers(&points, closed);
            assert_eq!(pieces.len(), if closed { 5 } else { 4 });
            let next = pieces.iter().cycle().skip(1);
            let count = if closed { 5 } else { 3 };
            for (a, b) in pieces.iter().zip(next).take(count) {
                let (end, begin) = (bends(a).1, bends(b).0);
                assert!(end.distance(begin) < 1e-9, "{closed}: {end:?} {begin:?}");
                assert_eq!(a[3], b[0]);
            }
            if !closed {
                assert!(bends(&pieces[0]).0.distance(Mm2::ZERO) < 1e-9, "natural at its beginning");
                assert!(bends(&pieces[3]).1.distance(Mm2::ZERO) < 1e-9, "natural at its end");
            }
        }
    }

    /// An insert with another scale along y stretches the finished spline. It does not change the chord
    /// lengths.
    #[test]
    fn placement_applies_to_the_finished_spline() {
        let points = [(0.0, 0.0), (10.0, 6.0), (14.0, 5.0), (30.0, 9.0), (40.0, 0.0)];
        let insert = Insert {
            block: 0,
            at: [5.0, 7.0, 0.0],
            scale: [1.0, 2.0, 1.0],
            rotation: 0.0,
            count: (1, 1),
            spacing: (0.0, 0.0),
        };
        let up = [0.0, 0.0, 1.0];
        let placement = Placement::scaled(1.0).inserted(&insert, up, [0.0; 3], (0.0, 0.0));
        for (plain, placed) in beziers(&points, false).iter().zip(beziers_in(&placement, &points, false)) {
            for (p, q) in plain.iter().zip(placed) {
                assert!(Mm2::new(5.0 + p.x, 7.0 + 2.0 * p.y).distance(q) < 1e-9, "{p:?} {q:?}");
            }
        }
    }

    #[test]
    fn splines_of_two_or_three_points_have_pieces() {
        assert_eq!(beziers(&[(0.0, 0.0), (3.0, 0.0)], true).len(), 1);
        assert!(beziers(&[(0.0, 0.0), (0.0, 0.0)], false).is_empty());
        assert_eq!(beziers(&[(0.0, 0.0), (3.0, 0.0), (0.0, 3.0)], true).len(), 3);
    }
}
