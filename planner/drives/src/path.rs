//! A path in the plane, of lines and arcs, in pulses: what the tool should follow.

use std::f64::consts::TAU;

use super::Axes;

/// One line or arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line.
    Line {
        /// Where it begins.
        from: Axes,
        /// Where it ends.
        to: Axes,
    },
    /// An arc of a circle.
    Arc {
        /// Its centre.
        centre: Axes,
        /// Its radius.
        radius: f64,
        /// The angle at which it begins, rad.
        start: f64,
        /// How far it turns, rad; positive is counter-clockwise. At most one turn.
        sweep: f64,
    },
}

/// A place of a path, or beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The point of the path.
    pub point: Axes,
    /// Unit vector along it.
    pub tangent: Axes,
    /// Signed curvature, 1/pulses: positive turns left.
    pub curvature: f64,
}

/// A quarter turn to the left.
#[must_use]
pub fn left_of(direction: Axes) -> Axes {
    Axes::new(-direction.y, direction.x)
}

impl Foot {
    /// How far `from` lies from it, pulses: positive to the left.
    #[must_use]
    pub fn distance(&self, from: Axes) -> f64 {
        let off = from - self.point;
        let side = off.dot(&left_of(self.tangent));
        off.norm().copysign(side)
    }
}

impl Piece {
    /// The arc about `centre` from `from` through so many radians.
    #[must_use]
    pub fn arc(centre: Axes, from: Axes, sweep: f64) -> Self {
        let spoke = from - centre;
        Self::Arc { centre, radius: spoke.norm(), start: spoke.y.atan2(spoke.x), sweep }
    }

    /// Its length, pulses.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// Whether it is a whole circle.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        matches!(self, Self::Arc { sweep, .. } if sweep.abs() >= TAU - ROUNDING)
    }

    /// The place that is `along` pulses from its beginning.
    #[must_use]
    pub fn at(&self, along: f64) -> Foot {
        match *self {
            Self::Line { from, to } => {
                let tangent = direction(from, to);
                Foot { point: from + tangent * along, tangent, curvature: 0.0 }
            }
            Self::Arc { centre, radius, start, sweep } => {
                let turned = along / radius * sweep.signum();
                on_circle(centre, radius, start + turned, sweep)
            }
        }
    }

    /// Its place nearest to `point`.
    #[must_use]
    pub fn nearest(&self, point: Axes) -> Foot {
        match *self {
            Self::Line { from, to } => {
                let tangent = direction(from, to);
                let along = (point - from).dot(&tangent).clamp(0.0, (to - from).norm());
                Foot { point: from + tangent * along, tangent, curvature: 0.0 }
            }
            Self::Arc { centre, radius, start, sweep } => {
                let spoke = point - centre;
                let turned = (spoke.y.atan2(spoke.x) - start) * sweep.signum();
                let turned = turned.rem_euclid(TAU);
                // Beyond its end, the end that is nearer by angle.
                let beyond = turned - sweep.abs();
                if beyond <= 0.0 {
                    let out = spoke.norm();
                    let spoke = if out > 0.0 { spoke / out } else { Axes::new(start.cos(), start.sin()) };
                    let tangent = left_of(spoke) * sweep.signum();
                    return Foot {
                        point: centre + spoke * radius,
                        tangent,
                        curvature: sweep.signum() / radius,
                    };
                }
                let turned = if beyond < TAU - turned { sweep } else { 0.0 };
                on_circle(centre, radius, start + turned, sweep)
            }
        }
    }

    /// Where its place nearest to `point` is, pulses from its beginning.
    #[must_use]
    pub fn along(&self, point: Axes) -> f64 {
        match *self {
            Self::Line { from, to } => {
                (point - from).dot(&direction(from, to)).clamp(0.0, (to - from).norm())
            }
            Self::Arc { centre, radius, start, sweep } => {
                let spoke = self.nearest(point).point - centre;
                let turned = (spoke.y.atan2(spoke.x) - start) * sweep.signum();
                // The beginning, if rounding put it just before.
                let turned = turned.rem_euclid(TAU);
                let turned = if turned > sweep.abs() + ROUNDING { 0.0 } else { turned };
                turned * radius
            }
        }
    }

    /// The same piece in another unit.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match *self {
            Self::Line { from, to } => Self::Line { from: from * factor, to: to * factor },
            Self::Arc { centre, radius, start, sweep } => {
                Self::Arc { centre: centre * factor, radius: radius * factor, start, sweep }
            }
        }
    }

    /// The same piece as seen in a mirror along X.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let flip = |point: &Axes| Axes::new(point.x, -point.y);
        match self {
            Self::Line { from, to } => Self::Line { from: flip(from), to: flip(to) },
            Self::Arc { centre, radius, start, sweep } => {
                Self::Arc { centre: flip(centre), radius: *radius, start: -start, sweep: -sweep }
            }
        }
    }
}

/// Unit vector of a line; along X for one without length.
fn direction(from: Axes, to: Axes) -> Axes {
    (to - from).try_normalize(0.0).unwrap_or(Axes::x())
}

fn on_circle(centre: Axes, radius: f64, angle: f64, sweep: f64) -> Foot {
    let spoke = Axes::new(angle.cos(), angle.sin());
    let tangent = left_of(spoke) * sweep.signum();
    Foot { point: centre + spoke * radius, tangent, curvature: sweep.signum() / radius }
}

/// Pieces one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    pieces: Vec<Piece>,
    /// Where each begins along the path; one more for the end.
    starts: Vec<f64>,
}

impl Path {
    /// The path of these pieces, each of which begins where the one before ends. Pieces without length are left out.
    #[must_use]
    pub fn of(pieces: Vec<Piece>) -> Self {
        let pieces: Vec<_> = pieces.into_iter().filter(|piece| piece.length() > 0.0).collect();
        let mut starts = vec![0.0];
        let mut sum = 0.0;
        for piece in &pieces {
            sum += piece.length();
            starts.push(sum);
        }
        Self { pieces, starts }
    }

    /// A straight line from the origin.
    #[must_use]
    pub fn line(to: Axes) -> Self {
        Self::of(vec![Piece::Line { from: Axes::zeros(), to }])
    }

    /// Circles through the origin about (radius, 0): clockwise as the paper's, or the other way round.
    #[must_use]
    pub fn circle(radius: f64, clockwise: bool, turns: u32) -> Self {
        let sweep = if clockwise { -TAU } else { TAU };
        let turn = Piece::arc(Axes::new(radius, 0.0), Axes::zeros(), sweep);
        Self::of((0..turns).map(|_| turn).collect())
    }

    /// Along X, then as far to the left, turning by `angle` rad.
    #[must_use]
    pub fn corner(leg: f64, angle: f64) -> Self {
        let tip = Axes::new(leg, 0.0);
        let end = tip + Axes::new(angle.cos(), angle.sin()) * leg;
        Self::of(vec![Piece::Line { from: Axes::zeros(), to: tip }, Piece::Line { from: tip, to: end }])
    }

    /// Once around an ellipse through the origin, clockwise, with half axes `a` along X and `b` along Y, as arcs through
    /// three points each: `ELLIPSE_ARCS` of them, within about 10⁻⁵ of its size.
    #[must_use]
    pub fn ellipse(a: f64, b: f64) -> Self {
        let step = TAU / f64::from(ELLIPSE_ARCS);
        let at = |angle: f64| Axes::new(a - a * angle.cos(), b * angle.sin());
        let arc = |index: u32| {
            let angle = f64::from(index) * step;
            through(at(angle), at(angle + step / 2.0), at(angle + step))
        };
        Self::of((0..ELLIPSE_ARCS).map(arc).collect())
    }

    /// The same path as seen in a mirror along X.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self { pieces: self.pieces.iter().map(Piece::mirrored).collect(), starts: self.starts.clone() }
    }

    /// Its length, pulses.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.starts.last().copied().unwrap_or(0.0)
    }

    /// Where a piece begins along the path, pulses; its end for one that is not there.
    #[must_use]
    pub fn begins(&self, number: usize) -> f64 {
        self.starts.get(number).copied().unwrap_or_else(|| self.length())
    }

    /// Its pieces.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The place that is `along` pulses from its beginning, or the end nearest to that, and the piece it is on; `None` for a
    /// path without length.
    #[must_use]
    pub fn at(&self, along: f64) -> Option<(usize, Foot)> {
        let along = along.clamp(0.0, self.length());
        let last = self.pieces.len().checked_sub(1)?;
        let index = self.starts.partition_point(|&start| start <= along).saturating_sub(1).min(last);
        Some((index, self.pieces[index].at(along - self.starts[index])))
    }

    /// The place nearest to `point` on the stretch around piece `near` that stays within twice the distance to it. Where
    /// the path comes back later, that is another cut.
    #[must_use]
    pub fn nearest(&self, point: Axes, near: usize) -> Foot {
        let mut best = self.pieces[near].nearest(point);
        let mut least = (best.point - point).norm_squared();
        let reach_2 = 4.0 * least;
        let mut look = |index: usize| {
            let foot = self.pieces[index].nearest(point);
            let distance_2 = (foot.point - point).norm_squared();
            if distance_2 < least {
                (best, least) = (foot, distance_2);
            }
            distance_2 <= reach_2
        };
        for index in (0..near).rev() {
            if !look(index) {
                break;
            }
        }
        for index in near + 1..self.pieces.len() {
            if !look(index) {
                break;
            }
        }
        best
    }

    /// How far `point` lies beyond its `foot` on the path in the direction of a piece that ends in a corner, pulses; 0 where none
    /// does. Looked at for the piece `on` and the one before.
    #[must_use]
    pub fn overshoot(&self, point: Axes, foot: &Foot, on: usize) -> f64 {
        let beyond = |index: usize| -> Option<f64> {
            let (end, next) = (self.pieces.get(index)?, self.pieces.get(index + 1)?);
            let (end, next) = (end.at(end.length()), next.at(0.0));
            let turns = end.tangent.dot(&next.tangent) < CORNER_COS;
            turns.then(|| (point - foot.point).dot(&end.tangent))
        };
        let before = on.checked_sub(1).and_then(beyond);
        [before, beyond(on)].into_iter().flatten().fold(0.0, f64::max)
    }
}

/// Angles are rounded by less than this, rad.
const ROUNDING: f64 = 1e-9;
/// Arcs of an ellipse.
const ELLIPSE_ARCS: u32 = 720;
/// Tangents that differ by more than this cosine make a corner (about 8°).
pub const CORNER_COS: f64 = 0.99;

/// The arc from `from` through `by` to `to`; the line where these are straight.
fn through(from: Axes, by: Axes, to: Axes) -> Piece {
    let (u, v) = (by - from, to - from);
    let twice_area = u.perp(&v);
    if twice_area.abs() < 1e-12 * v.norm_squared() {
        return Piece::Line { from, to };
    }
    let (uu, vv) = (u.norm_squared(), v.norm_squared());
    let centre = from + Axes::new(v.y * uu - u.y * vv, u.x * vv - v.x * uu) / (2.0 * twice_area);
    let (a, c) = (from - centre, to - centre);
    let turn = a.perp(&c).atan2(a.dot(&c));
    // Left is the way round when `by` lies to the right of the chord.
    let sweep = if twice_area > 0.0 { turn.rem_euclid(TAU) } else { turn.rem_euclid(TAU) - TAU };
    Piece::arc(centre, from, sweep)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circle_begins_as_the_papers() {
        // x = rho(1 − cos wt), y = rho·sin wt.
        let circle = Path::circle(2000.0, true, 1);
        for angle in [0.1, 1.0, 4.0] {
            let (_, foot) = circle.at(2000.0 * angle).unwrap();
            let wanted = Axes::new(2000.0 * (1.0 - angle.cos()), 2000.0 * angle.sin());
            assert!((foot.point - wanted).norm() < 1e-9);
            assert!((foot.tangent - Axes::new(angle.sin(), angle.cos())).norm() < 1e-12);
            assert!((foot.curvature + 1.0 / 2000.0).abs() < 1e-15);
        }
    }

    /// Distances are those of a search over many points.
    #[test]
    fn nearest_place_is_the_nearest_of_many() {
        let path = Path::of(vec![
            Piece::Line { from: Axes::zeros(), to: Axes::new(100.0, 0.0) },
            Piece::arc(Axes::new(100.0, 30.0), Axes::new(100.0, 0.0), 2.0),
            Piece::arc(Axes::new(200.0, 30.0), Axes::new(180.0, 30.0), -1.0),
        ]);
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..300 {
            let index = random.usize(0..3);
            let piece = path.pieces()[index];
            let point = Axes::new(random.f64() * 260.0 - 30.0, random.f64() * 120.0 - 30.0);
            let foot = piece.nearest(point);
            let steps = 20_000;
            let nearest = (0..=steps)
                .map(|i| (piece.at(piece.length() * f64::from(i) / f64::from(steps)).point - point).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(((foot.point - point).norm() - nearest).abs() < 1e-2, "{index}");
            assert!((piece.at(piece.along(point)).point - foot.point).norm() < 1e-6, "{index}");
            assert!((foot.distance(point).abs() - (foot.point - point).norm()).abs() < 1e-12);
        }
    }

    #[test]
    fn left_is_positive() {
        let foot = Path::line(Axes::new(10.0, 0.0)).nearest(Axes::new(5.0, 2.0), 0);
        assert!((foot.distance(Axes::new(5.0, 2.0)) - 2.0).abs() < 1e-12);
        // Left of a clockwise circle is outside.
        let circle = Path::circle(20.0, true, 1);
        let point = Axes::new(-3.0, 0.1);
        assert!(circle.nearest(point, 0).distance(point) > 2.9);
    }

    #[test]
    fn ellipse_is_met_by_its_arcs() {
        let (a, b) = (2000.0, 1000.0);
        let ellipse = Path::ellipse(a, b);
        let mut worst: f64 = 0.0;
        for step in 0..20_000 {
            let (_, foot) = ellipse.at(ellipse.length() * f64::from(step) / 20_000.0).unwrap();
            let (x, y) = ((foot.point.x - a) / a, foot.point.y / b);
            worst = worst.max((x.hypot(y) - 1.0).abs() * b);
        }
        assert!(worst < 1e-4, "{worst} pulses");
    }

    #[test]
    fn corner_knows_what_runs_past_it() {
        let past = |path: &Path, (x, y): (f64, f64), on: usize| {
            let point = Axes::new(x, y);
            path.overshoot(point, &path.nearest(point, on), on)
        };
        let corner = Path::corner(100.0, std::f64::consts::FRAC_PI_2);
        assert!((past(&corner, (103.0, 20.0), 1) - 3.0).abs() < 1e-12);
        assert!((past(&corner, (103.0, 0.0), 0) - 3.0).abs() < 1e-12);
        assert!(past(&corner, (97.0, 0.0), 0) <= 0.0);
        // A second leg that goes on in the first one's direction is no overshoot.
        let flat = Path::corner(100.0, std::f64::consts::FRAC_PI_4);
        assert!(past(&flat, (150.0, 50.0), 1).abs() < 1e-9);
        assert!((past(&flat, (102.0, -2.0), 0) - 2.0).abs() < 1e-9);
        assert!(past(&Path::circle(10.0, true, 2), (-1.0, 3.0), 1) <= 0.0);
    }
}
