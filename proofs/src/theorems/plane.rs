//! Points and vectors of unknown coordinates.

use std::ops::{Add, Sub};

use keepout_kernel::exact::predicate::Site;

use crate::smt::fact::{Fact, all, between, equal};
use crate::smt::symbolic::{Scalar, SymbolicPoint};
use crate::smt::term::{Term, whole};

/// A point or vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct V {
    /// Along x.
    pub x: Term,
    /// Along y.
    pub y: Term,
}

impl V {
    /// A point with unknown coordinates.
    pub fn unknown(name: &str) -> Self {
        Self { x: Term::fresh(&format!("{name}x")), y: Term::fresh(&format!("{name}y")) }
    }

    /// Any point, given by its difference to this one: so solvers need not find out that only differences
    /// matter.
    pub fn other(self, name: &str) -> Self {
        self + Self::unknown(name)
    }

    /// The vector `k` times as long.
    pub fn times(self, k: Term) -> Self {
        Self { x: k * self.x, y: k * self.y }
    }

    /// Scalar product.
    pub fn dot(self, other: Self) -> Term {
        self.x * other.x + self.y * other.y
    }

    /// Vector product.
    pub fn cross(self, other: Self) -> Term {
        self.x * other.y - self.y * other.x
    }

    /// Square of the length.
    pub fn norm_2(self) -> Term {
        self.dot(self)
    }

    /// Equal in both coordinates.
    pub fn is(self, other: Self) -> Fact {
        all([equal(self.x, other.x), equal(self.y, other.y)])
    }

    /// Both coordinates are zero.
    pub fn is_zero(self) -> Fact {
        all([equal(self.x, whole(0)), equal(self.y, whole(0))])
    }

    /// In the closed box.
    pub fn is_in(self, low: Self, high: Self) -> Fact {
        all([between(low.x, self.x, high.x), between(low.y, self.y, high.y)])
    }

    /// The point as the predicates take it.
    pub fn place(self) -> SymbolicPoint {
        Site { x: Scalar(self.x), y: Scalar(self.y) }
    }
}

impl Add for V {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y }
    }
}

impl Sub for V {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y }
    }
}

/// The vector of two numbers.
pub fn v(x: Term, y: Term) -> V {
    V { x, y }
}

/// `0 ≤ t ≤ 1`.
pub fn share(t: Term) -> Fact {
    between(whole(0), t, whole(1))
}

/// The vector from `p` to the point of the segment `a b` at `t`.
pub fn to_segment(p: V, a: V, b: V, t: Term) -> V {
    (a - p) + (b - a).times(t)
}

/// The vector from the point of `c d` at `t` to that of `a b` at `s`, with `w = a − c`, `u = b − a` and `v
/// = d − c`.
pub fn between_lines(w: V, u: V, v: V, s: Term, t: Term) -> V {
    (w + u.times(s)) - v.times(t)
}

/// The vector from the point of `c d` at `t` to that of `a b` at `s`.
pub fn between_segments([a, b]: [V; 2], [c, d]: [V; 2], s: Term, t: Term) -> V {
    between_lines(a - c, b - a, d - c, s, t)
}

/// The coordinates of the points, and more numbers.
pub fn terms<const N: usize>(points: &[V], more: &[Term]) -> [Term; N] {
    let all: Vec<Term> = points.iter().flat_map(|p| [p.x, p.y]).chain(more.iter().copied()).collect();
    all.try_into().expect("the caller wants as many numbers")
}
