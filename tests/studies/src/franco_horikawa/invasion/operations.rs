//! The operations of the three checks of section 5.2 for one position, counted.
//!
//! The formulas stand here again, with numbers that count their own operations. Tests compare the results with those of
//! the checks.

use std::cell::Cell;
use std::ops::{Add, Mul, Sub};

use super::segments;
use keepout_planner::{Box2, Mm2};

/// Numbers of operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Additions and subtractions.
    pub sums: u64,
    /// Multiplications and divisions.
    pub products: u64,
    /// Square roots.
    pub roots: u64,
    /// Arctangents.
    pub arctangents: u64,
    /// Comparisons.
    pub comparisons: u64,
}

impl Operations {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.sums + self.products + self.roots + self.arctangents + self.comparisons
    }
}

/// Counts operations.
#[derive(Debug, Default)]
struct Tally {
    done: Cell<Operations>,
}

/// A number whose operations are counted.
#[derive(Clone, Copy, Debug)]
struct Counted<'a> {
    value: f64,
    tally: &'a Tally,
}

impl Tally {
    fn note(&self, kind: fn(&mut Operations) -> &mut u64) {
        let mut done = self.done.get();
        *kind(&mut done) += 1;
        self.done.set(done);
    }

    fn number(&self, value: f64) -> Counted<'_> {
        Counted { value, tally: self }
    }

    fn point(&self, at: Mm2) -> [Counted<'_>; 2] {
        [self.number(at.x), self.number(at.y)]
    }
}

impl Counted<'_> {
    fn made(self, value: f64, kind: fn(&mut Operations) -> &mut u64) -> Self {
        self.tally.note(kind);
        Self { value, ..self }
    }

    fn over(self, other: Self) -> Self {
        self.made(self.value / other.value, |done| &mut done.products)
    }

    fn root(self) -> Self {
        self.made(self.value.sqrt(), |done| &mut done.roots)
    }

    fn angle(self, along: Self) -> Self {
        self.made(self.value.abs().atan2(along.value), |done| &mut done.arctangents)
    }

    fn at_most(self, other: Self) -> bool {
        self.tally.note(|done| &mut done.comparisons);
        self.value <= other.value
    }

    fn within(self, one: Self, other: Self) -> bool {
        let (low, high) = if one.at_most(other) { (one, other) } else { (other, one) };
        low.at_most(self) && self.at_most(high)
    }
}

impl Add for Counted<'_> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.made(self.value + other.value, |done| &mut done.sums)
    }
}

impl Sub for Counted<'_> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.made(self.value - other.value, |done| &mut done.sums)
    }
}

impl Mul for Counted<'_> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        self.made(self.value * other.value, |done| &mut done.products)
    }
}

type Vector<'a> = [Counted<'a>; 2];

fn minus<'a>([ax, ay]: Vector<'a>, [bx, by]: Vector<'a>) -> Vector<'a> {
    [ax - bx, ay - by]
}

fn dot<'a>([ax, ay]: Vector<'a>, [bx, by]: Vector<'a>) -> Counted<'a> {
    ax * bx + ay * by
}

fn cross<'a>([ax, ay]: Vector<'a>, [bx, by]: Vector<'a>) -> Counted<'a> {
    ax * by - ay * bx
}

/// The operations of the first method, eq. (1), and whether it finds an invasion: a distance to each of the points
/// along the profile.
#[must_use]
pub fn of_matrix(points: &[Mm2], p: Mm2, tolerance_mm: f64) -> (Operations, bool) {
    let tally = Tally::default();
    let (p, tolerance) = (tally.point(p), tally.number(tolerance_mm));
    let mut invades = false;
    for &point in points {
        let off = minus(p, tally.point(point));
        invades |= dot(off, off).root().at_most(tolerance);
    }
    (tally.done.get(), invades)
}

/// The nearest segment with `p` in its x or y interval: its number and the distance of eq. (2).
fn nearest<'a>(tally: &'a Tally, profile: &[Mm2], p: Vector<'a>) -> Option<(usize, Counted<'a>)> {
    let mut best: Option<(usize, Counted)> = None;
    for (index, (from, to)) in segments(profile).enumerate() {
        let (from, to) = (tally.point(from), tally.point(to));
        if !(p[0].within(from[0], to[0]) || p[1].within(from[1], to[1])) {
            continue;
        }
        let along = minus(to, from);
        let across = cross(minus(p, from), along).over(dot(along, along).root());
        let distance = Counted { value: across.value.abs(), ..across };
        if best.is_none_or(|(_, best)| !best.at_most(distance)) {
            best = Some((index, distance));
        }
    }
    best
}

/// The operations of the second method, and whether it finds an invasion: the sum of the three angles at the triangle
/// of the nearest segment.
#[must_use]
pub fn of_angles(profile: &[Mm2], p: Mm2) -> (Operations, bool) {
    let tally = Tally::default();
    let at = tally.point(p);
    let Some((segment, _)) = nearest(&tally, profile, at) else { return (tally.done.get(), false) };
    let corner = |i: usize| minus(tally.point(profile[(segment + i) % profile.len()]), at);
    let [a, b, c] = [corner(0), corner(1), corner(2)];
    let angle = |u, v| cross(u, v).angle(dot(u, v));
    let sum = angle(a, b) + angle(b, c) + angle(c, a);
    let whole = tally.number(std::f64::consts::TAU - 1e-11);
    let invades = whole.at_most(sum);
    (tally.done.get(), invades)
}

/// The operations of the third method, eq. (2), and whether it finds an invasion: the distance to the segments with `p`
/// in their x or y interval.
#[must_use]
pub fn of_intervals(profile: &[Mm2], p: Mm2, tolerance_mm: f64) -> (Operations, bool) {
    let tally = Tally::default();
    let found = nearest(&tally, profile, tally.point(p));
    let invades = found.is_some_and(|(_, distance)| distance.at_most(tally.number(tolerance_mm)));
    (tally.done.get(), invades)
}

/// Mean numbers of operations of the second and the third method over positions around a profile, 2 mm apart and up to
/// 30 mm away.
#[must_use]
pub fn mean_operations(profile: &[Mm2]) -> [f64; 2] {
    let around = Box2::around(profile.iter().copied()).unwrap_or_default().grown(30.0);
    let (mut sums, mut count, mut at) = ([0; 2], 0_u32, around.low);
    while at.y <= around.high.y {
        let found = [of_angles(profile, at).0, of_intervals(profile, at, 0.0).0];
        for (sum, found) in sums.iter_mut().zip(found) {
            *sum += found.total();
        }
        count += 1;
        at.x += 2.0;
        if at.x > around.high.x {
            at = Mm2::new(around.low.x, at.y + 2.0);
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "counts of operations")]
    sums.map(|sum| sum as f64 / f64::from(count))
}
