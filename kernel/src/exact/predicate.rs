//! The predicates, generic over the integer width.
//!
//! Each function decides a statement about real geometry without rounding. "Near" is `distance ≤ r`: a threshold that
//! is exactly met is not clear.

use core::cmp::Ordering;

use super::width::Lattice;

/// A point at width `L`.
#[derive(Clone, Copy, Debug)]
pub struct Site<L: Lattice> {
    /// Abscissa.
    pub x: L::Linear,
    /// Ordinate.
    pub y: L::Linear,
}

/// Where a point lies with respect to a directed line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// To the left: `a, b, c` turn counter-clockwise.
    Left,
    /// On the line.
    On,
    /// To the right: `a, b, c` turn clockwise.
    Right,
}

/// The answer to "is the distance greater than the threshold?".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proximity {
    /// The distance is greater than the threshold.
    Clear,
    /// The distance is the threshold or less.
    Near,
}

impl Proximity {
    /// Whether the distance is greater than the threshold.
    #[must_use]
    pub fn is_clear(self) -> bool {
        self == Self::Clear
    }

    #[inline(always)]
    pub(crate) fn near_if(near: bool) -> Self {
        if near { Self::Near } else { Self::Clear }
    }
}

#[inline(always)]
fn cross<L: Lattice>(o: Site<L>, a: Site<L>, b: Site<L>) -> L::Area {
    let (ax, ay) = (L::difference(a.x, o.x), L::difference(a.y, o.y));
    let (bx, by) = (L::difference(b.x, o.x), L::difference(b.y, o.y));
    L::gap(L::product(ax, by), L::product(ay, bx))
}

#[inline(always)]
fn dot<L: Lattice>(o: Site<L>, a: Site<L>, b: Site<L>) -> L::Area {
    let (ax, ay) = (L::difference(a.x, o.x), L::difference(a.y, o.y));
    let (bx, by) = (L::difference(b.x, o.x), L::difference(b.y, o.y));
    L::sum(L::product(ax, bx), L::product(ay, by))
}

/// The side of the directed line `a → b` on which `c` lies (sign of the cross product of `b − a` and `c − a`).
#[inline(always)]
pub fn orientation<L: Lattice>(a: Site<L>, b: Site<L>, c: Site<L>) -> Orientation {
    match L::compare(cross::<L>(a, b, c), L::zero()) {
        Ordering::Greater => Orientation::Left,
        Ordering::Equal => Orientation::On,
        Ordering::Less => Orientation::Right,
    }
}

/// Whether `|p − q| ≤ r`.
#[inline(always)]
pub fn point_point<L: Lattice>(p: Site<L>, q: Site<L>, r: L::Linear) -> Proximity {
    Proximity::near_if(L::compare(dot::<L>(p, q, q), L::product(r, r)) != Ordering::Greater)
}

/// Whether some point of the segment `a b` is within `r` of `p`, for `r ≥ 0`.
///
/// With `t = (p − a)·(b − a)`: before `a` when `t ≤ 0`, past `b` when `t ≥ |b − a|²`, else the foot of the
/// perpendicular is inside and `cross² ≤ r²·|b − a|²` decides. A segment of zero length is its point.
#[inline(always)]
pub fn point_segment<L: Lattice>(p: Site<L>, a: Site<L>, b: Site<L>, r: L::Linear) -> Proximity {
    let along = dot::<L>(a, p, b);
    let length_2 = dot::<L>(a, b, b);
    if L::compare(along, L::zero()) != Ordering::Greater {
        return point_point::<L>(p, a, r);
    }
    if L::compare(along, length_2) != Ordering::Less {
        return point_point::<L>(p, b, r);
    }
    let off = cross::<L>(a, b, p);
    let reach = L::product_of_areas(L::product(r, r), length_2);
    Proximity::near_if(L::compare_volumes(L::product_of_areas(off, off), reach) != Ordering::Greater)
}

/// Whether all of `points` lie to the right of the directed line `a → b`, farther than `r ≥ 0` from it; a line through
/// `a = b` is none.
///
/// The distance of `p` from the line is `|cross| / |b − a|`, and the point with the greatest cross product of those to the
/// right, where it is negative, is the nearest: `cross² > r²·|b − a|²` decides.
#[inline(always)]
pub fn beyond<L: Lattice>(
    a: Site<L>,
    b: Site<L>,
    points: impl Iterator<Item = Site<L>>,
    r: L::Linear,
) -> bool {
    let mut nearest = None;
    for p in points {
        let off = cross::<L>(a, b, p);
        if L::compare(off, L::zero()) != Ordering::Less {
            return false;
        }
        if nearest.is_none_or(|nearest| L::compare(off, nearest) == Ordering::Greater) {
            nearest = Some(off);
        }
    }
    nearest.is_some_and(|off| {
        let reach = L::product_of_areas(L::product(r, r), dot::<L>(a, b, b));
        L::compare_volumes(L::product_of_areas(off, off), reach) == Ordering::Greater
    })
}

/// Whether the segments cross at a point interior to both.
#[inline(always)]
pub fn crosses_properly<L: Lattice>(a: Site<L>, b: Site<L>, c: Site<L>, d: Site<L>) -> bool {
    let opposite = |s, t| {
        matches!((s, t), (Orientation::Left, Orientation::Right) | (Orientation::Right, Orientation::Left))
    };
    opposite(orientation::<L>(a, b, c), orientation::<L>(a, b, d))
        && opposite(orientation::<L>(c, d, a), orientation::<L>(c, d, b))
}

/// Whether the segments `a b` and `c d` come within `r` of each other.
///
/// If they do not cross properly, the distance is attained at one of the four ends (`research`: T3, Cramer and
/// convexity), so four point–segment questions and one crossing question decide. They need not be asked where the line of one
/// has all of the other on one side of it and [`beyond`] `r`.
#[inline(always)]
pub fn segment_segment<L: Lattice>(
    a: Site<L>,
    b: Site<L>,
    c: Site<L>,
    d: Site<L>,
    r: L::Linear,
) -> Proximity {
    let (ab, cd) = ([a, b], [c, d]);
    let told_apart = beyond::<L>(a, b, cd.into_iter(), r)
        || beyond::<L>(b, a, cd.into_iter(), r)
        || beyond::<L>(c, d, ab.into_iter(), r)
        || beyond::<L>(d, c, ab.into_iter(), r);
    if told_apart {
        return Proximity::Clear;
    }
    let ends_clear = point_segment::<L>(c, a, b, r).is_clear()
        && point_segment::<L>(d, a, b, r).is_clear()
        && point_segment::<L>(a, c, d, r).is_clear()
        && point_segment::<L>(b, c, d, r).is_clear();
    Proximity::near_if(!ends_clear || crosses_properly::<L>(a, b, c, d))
}

/// Whether `p` lies strictly inside the triangle `a b c`, of either orientation.
#[inline(always)]
pub fn strictly_inside<L: Lattice>(p: Site<L>, a: Site<L>, b: Site<L>, c: Site<L>) -> bool {
    let first = orientation::<L>(a, b, p);
    first != Orientation::On && first == orientation::<L>(b, c, p) && first == orientation::<L>(c, a, p)
}

/// Whether the filled triangle `a b c` and the segment `d e` come within `r` of each other.
///
/// Either a side of the triangle does, or the segment lies wholly inside, which its end `d` then tells.
#[inline(always)]
pub fn triangle_segment<L: Lattice>(
    [a, b, c]: [Site<L>; 3],
    d: Site<L>,
    e: Site<L>,
    r: L::Linear,
) -> Proximity {
    let sides_clear = segment_segment::<L>(a, b, d, e, r).is_clear()
        && segment_segment::<L>(b, c, d, e, r).is_clear()
        && segment_segment::<L>(c, a, d, e, r).is_clear();
    Proximity::near_if(!sides_clear || strictly_inside::<L>(d, a, b, c))
}

/// Whether the ray from `p` toward +x crosses the edge `a b`, counting an edge's lower end and not its upper one, so
/// that the parity over a closed ring is odd exactly for points inside. `p` must not lie on the edge.
#[inline(always)]
pub fn ray_crosses<L: Lattice>(p: Site<L>, a: Site<L>, b: Site<L>) -> bool
where
    L::Linear: Ord,
{
    if (a.y > p.y) == (b.y > p.y) {
        return false;
    }
    let (low, high) = if a.y > p.y { (b, a) } else { (a, b) };
    orientation::<L>(low, high, p) == Orientation::Left
}

/// Whether the closed box from `low` to `high` (`low ≤ high` in both coordinates) comes within `r` of `p`.
#[inline(always)]
pub fn box_point<L: Lattice>(low: Site<L>, high: Site<L>, p: Site<L>, r: L::Linear) -> Proximity
where
    L::Linear: Ord,
{
    // The nearest point of a box is found in each coordinate on its own.
    let foot = Site { x: p.x.clamp(low.x, high.x), y: p.y.clamp(low.y, high.y) };
    point_point::<L>(p, foot, r)
}

/// Whether the closed box from `low` to `high` and the segment `a b` come within `r` of each other.
///
/// Two convex polygons that do not meet are nearest at a corner of one of them. When they meet without a corner or an
/// end being in the other, the segment enters and leaves through two sides, and so crosses a diagonal.
#[inline(always)]
pub fn box_segment<L: Lattice>(low: Site<L>, high: Site<L>, a: Site<L>, b: Site<L>, r: L::Linear) -> Proximity
where
    L::Linear: Ord,
{
    let (right, left) = (Site { x: high.x, y: low.y }, Site { x: low.x, y: high.y });
    let clear = box_point::<L>(low, high, a, r).is_clear()
        && box_point::<L>(low, high, b, r).is_clear()
        && [low, right, high, left].into_iter().all(|corner| point_segment::<L>(corner, a, b, r).is_clear())
        && !crosses_properly::<L>(low, high, a, b)
        && !crosses_properly::<L>(right, left, a, b);
    Proximity::near_if(!clear)
}

/// Whether the distance to the segment `a b` never falls on the motion `p → q`.
///
/// The distance to a convex set is convex along a line: it never falls when it does not fall at the start. There the
/// nearest point is `a`, `b` or the foot of the perpendicular, as in [`point_segment`], and the sign of the motion's
/// component away from it decides. From a point of the segment itself every motion recedes.
#[inline(always)]
pub fn recedes<L: Lattice>(p: Site<L>, q: Site<L>, a: Site<L>, b: Site<L>) -> bool {
    let along = dot::<L>(a, p, b);
    let away_from = |end| L::compare(dot::<L>(p, end, q), L::zero()) != Ordering::Greater;
    if L::compare(along, L::zero()) != Ordering::Greater {
        return away_from(a);
    }
    if L::compare(along, dot::<L>(a, b, b)) != Ordering::Less {
        return away_from(b);
    }
    let growth = L::compare(cross::<L>(a, b, q), cross::<L>(a, b, p));
    match orientation::<L>(a, b, p) {
        Orientation::Left => growth != Ordering::Less,
        Orientation::Right => growth != Ordering::Greater,
        Orientation::On => true,
    }
}
