//! A path in the plane, of lines and arcs, in pulses. The tool should follow it.

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use keepout_kernel::{ArcView, Vec2};

use crate::Axes;

/// One line or arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathPiece {
    /// A straight line.
    Line {
        /// Start point.
        from: Axes,
        /// End point.
        to: Axes,
    },
    /// An arc of a circle, of at most one turn.
    Arc(ArcView),
}

/// A point of a path with its tangent and curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The point.
    pub point: Axes,
    /// Unit vector along the path.
    pub tangent: Axes,
    /// Signed curvature, 1/pulses. Positive is counter-clockwise.
    pub curvature: f64,
}

/// `direction` turned counter-clockwise by a quarter turn.
#[must_use]
pub fn left_of(direction: Axes) -> Axes {
    Axes::new(-direction.y, direction.x)
}

impl Foot {
    /// Whether the path turns by more than about 8° from this point to `next`.
    #[must_use]
    pub fn turns_to(&self, next: &Self) -> bool {
        self.tangent.dot(&next.tangent) < CORNER_COS
    }

    /// Signed distance of `from` from this point, pulses: positive to the left of the path.
    #[must_use]
    pub fn distance(&self, from: Axes) -> f64 {
        let off = from - self.point;
        let side = off.dot(&left_of(self.tangent));
        off.norm().copysign(side)
    }
}

impl PathPiece {
    /// The arc about `centre` that starts at `from` and turns by `sweep` rad.
    #[must_use]
    pub fn arc(centre: Axes, from: Axes, sweep: f64) -> Self {
        Self::Arc(ArcView::starting_at(Vec2::new(from.x, from.y), Vec2::new(centre.x, centre.y), sweep))
    }

    /// Whether the path has a corner between this piece and `next`.
    #[must_use]
    pub fn turns_to(&self, next: &Self) -> bool {
        self.at(self.length()).turns_to(&next.at(0.0))
    }

    /// Length, pulses.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc(arc) => arc.length(),
        }
    }

    /// Whether the piece is a full circle.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        matches!(self, Self::Arc(arc) if arc.is_full())
    }

    /// The point at a distance of `along` pulses from the start.
    #[must_use]
    pub fn at(&self, along: f64) -> Foot {
        match *self {
            Self::Line { from, to } => {
                let tangent = direction(from, to);
                Foot { point: from + tangent * along, tangent, curvature: 0.0 }
            }
            Self::Arc(arc) => on_circle(&arc, arc.start + along / arc.radius * arc.sign()),
        }
    }

    /// The nearest point of this piece to `point`.
    #[must_use]
    pub fn nearest(&self, point: Axes) -> Foot {
        match *self {
            Self::Line { from, to } => {
                let tangent = direction(from, to);
                let along = (point - from).dot(&tangent).clamp(0.0, (to - from).norm());
                Foot { point: from + tangent * along, tangent, curvature: 0.0 }
            }
            Self::Arc(arc) => {
                let turned = arc.angle_to(Vec2::new(point.x, point.y));
                // Outside the sector of the arc, take the end that is nearer by angle.
                let beyond = turned - arc.sweep.abs();
                if beyond > 0.0 {
                    return on_circle(&arc, arc.angle(if beyond < TAU - turned { 1.0 } else { 0.0 }));
                }
                let centre = Axes::new(arc.centre.x, arc.centre.y);
                let Some(spoke) = (point - centre).try_normalize(0.0) else {
                    return on_circle(&arc, arc.start);
                };
                Foot {
                    point: centre + spoke * arc.radius,
                    tangent: left_of(spoke) * arc.sign(),
                    curvature: arc.curvature(),
                }
            }
        }
    }

    /// Distance of the nearest point to `point` from the start of this piece, pulses.
    #[must_use]
    pub fn along(&self, point: Axes) -> f64 {
        match *self {
            Self::Line { from, to } => {
                (point - from).dot(&direction(from, to)).clamp(0.0, (to - from).norm())
            }
            Self::Arc(arc) => {
                let foot = self.nearest(point).point;
                let turned = arc.angle_to(Vec2::new(foot.x, foot.y));
                // Rounding may put the point just before the start. Then it is the start.
                let turned = if turned > arc.sweep.abs() + ROUNDING { 0.0 } else { turned };
                turned * arc.radius
            }
        }
    }

    /// The same piece in another unit.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match *self {
            Self::Line { from, to } => Self::Line { from: from * factor, to: to * factor },
            Self::Arc(arc) => Self::Arc(arc.scaled(factor)),
        }
    }

    /// The same piece, mirrored at the X axis.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let flip = |point: &Axes| Axes::new(point.x, -point.y);
        match self {
            Self::Line { from, to } => Self::Line { from: flip(from), to: flip(to) },
            Self::Arc(arc) => Self::Arc(arc.mirrored()),
        }
    }
}

/// Unit vector of a line. For a line without length, the X direction.
fn direction(from: Axes, to: Axes) -> Axes {
    (to - from).try_normalize(0.0).unwrap_or(Axes::x())
}

/// The point of the arc's circle at a polar angle.
fn on_circle(arc: &ArcView, angle: f64) -> Foot {
    let (Vec2 { x, y }, tangent) = (arc.at_angle(angle), arc.direction_at_angle(angle));
    Foot { point: Axes::new(x, y), tangent: Axes::new(tangent.x, tangent.y), curvature: arc.curvature() }
}

/// A sequence of connected pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    pieces: Vec<PathPiece>,
    /// Start of each piece along the path, and the end of the path, pulses.
    starts: Vec<f64>,
}

impl Path {
    /// The path of these pieces. Each piece must begin at the end of the previous one. Pieces without length
    /// are dropped.
    #[must_use]
    pub fn of(pieces: Vec<PathPiece>) -> Self {
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
        Self::of(vec![PathPiece::Line { from: Axes::zeros(), to }])
    }

    /// A circle through the origin about (radius, 0), repeated `turns` times. The paper's circle is
    /// clockwise.
    #[must_use]
    pub fn circle(radius: f64, clockwise: bool, turns: u32) -> Self {
        let sweep = if clockwise { -TAU } else { TAU };
        let turn = PathPiece::arc(Axes::new(radius, 0.0), Axes::zeros(), sweep);
        Self::of((0..turns).map(|_| turn).collect())
    }

    /// Two legs of length `leg`: the first along X, the second turned to the left by `angle` rad.
    #[must_use]
    pub fn corner(leg: f64, angle: f64) -> Self {
        let tip = Axes::new(leg, 0.0);
        let end = tip + Axes::new(angle.cos(), angle.sin()) * leg;
        Self::of(vec![
            PathPiece::Line { from: Axes::zeros(), to: tip },
            PathPiece::Line { from: tip, to: end },
        ])
    }

    /// One clockwise turn around an ellipse through the origin, with semi-axes `a` along X and `b` along Y.
    ///
    /// It consists of `ELLIPSE_ARCS` arcs through three points each. Their error is about 10⁻⁵ of the size.
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

    /// An Archimedean spiral about the origin, counter-clockwise from (`from`, 0), with the radii `from` and `to` at
    /// its ends.
    ///
    /// It consists of `ELLIPSE_ARCS` arcs in each turn.
    #[must_use]
    pub fn spiral(from: f64, to: f64, turns: u32) -> Self {
        let count = ELLIPSE_ARCS * turns;
        let at = |number: f64| {
            let share = number / f64::from(count);
            let angle = TAU * f64::from(turns) * share;
            Axes::new(angle.cos(), angle.sin()) * (from + (to - from) * share)
        };
        let arc = |index: u32| {
            let index = f64::from(index);
            through(at(index), at(index + 0.5), at(index + 1.0))
        };
        Self::of((0..count).map(arc).collect())
    }

    /// The same path, mirrored at the X axis.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self { pieces: self.pieces.iter().map(PathPiece::mirrored).collect(), starts: self.starts.clone() }
    }

    /// Length, pulses.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.starts.last().copied().unwrap_or(0.0)
    }

    /// Start of a piece along the path, pulses. For a number without a piece, the end of the path.
    #[must_use]
    pub fn begins(&self, number: usize) -> f64 {
        self.starts.get(number).copied().unwrap_or_else(|| self.length())
    }

    /// The pieces, in order.
    #[must_use]
    pub fn pieces(&self) -> &[PathPiece] {
        &self.pieces
    }

    /// The point at a distance of `along` pulses from the start, with the number of its piece. `along` is
    /// clamped to the path. `None` for a path without length.
    #[must_use]
    pub fn at(&self, along: f64) -> Option<(usize, Foot)> {
        let along = along.clamp(0.0, self.length());
        let last = self.pieces.len().checked_sub(1)?;
        let index = self.starts.partition_point(|&start| start <= along).saturating_sub(1).min(last);
        Some((index, self.pieces[index].at(along - self.starts[index])))
    }

    /// The nearest point to `point` on the pieces around piece `near`.
    ///
    /// The search goes in both directions, as long as the pieces stay within twice the distance of piece
    /// `near`. Where the path returns later, it is a different cut, so the search ignores it.
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

    /// Distance of `point` past the end of the path in its direction, pulses. 0 if `foot`, its nearest point, is not
    /// the end, or for a path that ends where it begins and goes on in the same direction there.
    #[must_use]
    pub fn past_end(&self, point: Axes, foot: &Foot) -> f64 {
        let Some(end) = self.pieces.last().map(|piece| piece.at(piece.length())) else { return 0.0 };
        if (foot.point - end.point).norm() > NEAR_END {
            0.0
        } else {
            (point - end.point).dot(&end.tangent).max(0.0)
        }
    }

    /// Overshoot of `point` past a corner, pulses: its distance from `foot` in the direction of the piece
    /// that ends there.
    ///
    /// Considers the ends of the piece `on` and of the piece before it. 0 without a corner or an overshoot.
    #[must_use]
    pub fn overshoot(&self, point: Axes, foot: &Foot, on: usize) -> f64 {
        let beyond = |index: usize| -> Option<f64> {
            let (end, next) = (self.pieces.get(index)?, self.pieces.get(index + 1)?);
            let (end, next) = (end.at(end.length()), next.at(0.0));
            end.turns_to(&next).then(|| (point - foot.point).dot(&end.tangent))
        };
        let before = on.checked_sub(1).and_then(beyond);
        [before, beyond(on)].into_iter().flatten().fold(0.0, f64::max)
    }
}

/// Largest distance of a nearest point from the end that it is, pulses.
const NEAR_END: f64 = 1e-6;
/// Bound on the rounding error of angles, rad.
const ROUNDING: f64 = 1e-9;
/// Number of arcs of an ellipse.
const ELLIPSE_ARCS: u32 = 720;
/// Two tangents form a corner if the cosine of their angle is below this (about 8°).
const CORNER_COS: f64 = 0.99;

/// The arc from `from` through `by` to `to`. Points on a straight line give a line.
fn through(from: Axes, by: Axes, to: Axes) -> PathPiece {
    let arc = ArcView::through(Vec2::new(from.x, from.y), Vec2::new(by.x, by.y), Vec2::new(to.x, to.y));
    arc.map_or(PathPiece::Line { from, to }, PathPiece::Arc)
}
