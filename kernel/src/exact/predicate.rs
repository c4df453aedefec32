//! The predicates, generic over the integer width.
//!
//! Implements SR-01, SR-04, SR-14.
//!
//! Each function decides a statement about real geometry without rounding. "Near" means `distance ≤ r`: a
//! distance equal to the threshold is not clear.

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

/// The side of a directed line on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// To the left: `a, b, c` turn counter-clockwise.
    Left,
    /// On the line.
    On,
    /// To the right: `a, b, c` turn clockwise.
    Right,
}

/// The result of a comparison of a distance with a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proximity {
    /// The distance is greater than the threshold.
    Clear,
    /// The distance is at most the threshold.
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

/// The side of the directed line `a → b` on which `c` lies: the sign of the cross product of `b − a` and
/// `c − a`.
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

/// Whether some point of the segment `a b` is within `r` of `p`. Requires `r ≥ 0`.
///
/// Let `t = (p − a)·(b − a)`. For `t ≤ 0` the nearest point is `a`, for `t ≥ |b − a|²` it is `b`. Otherwise
/// the foot of the perpendicular lies inside, and `cross² ≤ r²·|b − a|²` decides. A segment of zero length
/// counts as its point.
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

/// Whether all of `points` lie to the right of the directed line `a → b` and farther than `r` from it.
/// Requires `r ≥ 0`. The answer is "no" for `a = b`.
///
/// The distance of `p` from the line is `|cross| / |b − a|`. To the right the cross product is negative, so
/// its greatest value belongs to the nearest point. There `cross² > r²·|b − a|²` decides.
#[inline(always)]
pub fn beyond<L: Lattice>([a, b]: [Site<L>; 2], points: impl Iterator<Item = Site<L>>, r: L::Linear) -> bool {
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
/// Segments that do not cross properly are nearest at one of their four ends (proved as `segment_ends` in
/// `proofs/src/theorems/`). So four point–segment tests and one crossing test decide. A shortcut skips them
/// when one segment lies wholly [`beyond`] the line of the other.
#[inline(always)]
pub fn segment_segment<L: Lattice>([a, b]: [Site<L>; 2], [c, d]: [Site<L>; 2], r: L::Linear) -> Proximity {
    let separated = L::beyond([a, b], [c, d].into_iter(), r)
        || L::beyond([b, a], [c, d].into_iter(), r)
        || L::beyond([c, d], [a, b].into_iter(), r)
        || L::beyond([d, c], [a, b].into_iter(), r);
    if separated {
        return Proximity::Clear;
    }
    let ends_clear = L::point_segment(c, a, b, r).is_clear()
        && L::point_segment(d, a, b, r).is_clear()
        && L::point_segment(a, c, d, r).is_clear()
        && L::point_segment(b, c, d, r).is_clear();
    Proximity::near_if(!ends_clear || L::crosses_properly(a, b, c, d))
}

/// Whether `p` lies strictly inside the triangle `a b c`, of either orientation.
#[inline(always)]
pub fn strictly_inside<L: Lattice>(p: Site<L>, a: Site<L>, b: Site<L>, c: Site<L>) -> bool {
    let first = orientation::<L>(a, b, p);
    first != Orientation::On && first == orientation::<L>(b, c, p) && first == orientation::<L>(c, a, p)
}

/// Whether the filled triangle `a b c` and the segment `d e` come within `r` of each other.
///
/// Either a side of the triangle is near the segment, or the segment lies wholly inside. The end `d` then
/// lies inside too.
#[inline(always)]
pub fn triangle_segment<L: Lattice>(
    [a, b, c]: [Site<L>; 3],
    [d, e]: [Site<L>; 2],
    r: L::Linear,
) -> Proximity {
    let sides_clear = L::segment_segment([a, b], [d, e], r).is_clear()
        && L::segment_segment([b, c], [d, e], r).is_clear()
        && L::segment_segment([c, a], [d, e], r).is_clear();
    Proximity::near_if(!sides_clear || L::strictly_inside(d, a, b, c))
}

/// The sides of a closed polygon, corner to corner. A segment has two sides: there and back.
#[inline(always)]
pub fn sides<T>(corners: impl Iterator<Item = T> + Clone) -> impl Iterator<Item = [T; 2]> {
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(from, to)| [from, to])
}

/// Whether the filled convex polygon holds `p`, its border included. Requires that all corners lie to the
/// left of each side or on its line.
///
/// The point is right of no side and inside the box of the corners. The box decides when all corners lie on
/// one line.
#[inline(always)]
pub fn convex_holds<L: Lattice>(corners: impl Iterator<Item = Site<L>> + Clone, p: Site<L>) -> bool {
    let each = || corners.clone();
    each().any(|c| c.x <= p.x)
        && each().any(|c| p.x <= c.x)
        && each().any(|c| c.y <= p.y)
        && each().any(|c| p.y <= c.y)
        && sides(corners).all(|[a, b]| orientation::<L>(a, b, p) != Orientation::Right)
}

/// Whether the filled convex polygon and the segment `c d` come within `r` of each other. Requires that all
/// corners lie to the left of each side or on its line.
///
/// Either a side is near the segment, or the segment lies wholly inside, and then its end `c` does too. A
/// shortcut skips these tests when a line separates the two. It is the line of a side with the segment
/// [`beyond`] it, or the line of the segment with all corners beyond it.
#[inline(always)]
pub fn convex_segment<L: Lattice>(
    corners: impl ExactSizeIterator<Item = Site<L>> + Clone,
    [c, d]: [Site<L>; 2],
    r: L::Linear,
) -> Proximity {
    let separated = L::beyond([c, d], corners.clone(), r)
        || L::beyond([d, c], corners.clone(), r)
        || sides(corners.clone()).any(|side| L::beyond(side, [c, d].into_iter(), r));
    if separated {
        return Proximity::Clear;
    }
    // The two sides of a segment are the same.
    let count = if corners.len() == 2 { 1 } else { corners.len() };
    let near = sides(corners.clone()).take(count).any(|side| !L::segment_segment(side, [c, d], r).is_clear());
    Proximity::near_if(near || L::convex_holds(corners, c))
}

/// Whether the ray from `p` toward +x crosses the edge `a b`. The lower end of an edge counts and the upper
/// end does not. So over a closed ring the number of crossings is odd exactly for points inside. `p` must not
/// lie on the edge.
#[inline(always)]
pub fn ray_crosses<L: Lattice>(p: Site<L>, a: Site<L>, b: Site<L>) -> bool {
    if (a.y > p.y) == (b.y > p.y) {
        return false;
    }
    let (low, high) = if a.y > p.y { (b, a) } else { (a, b) };
    orientation::<L>(low, high, p) == Orientation::Left
}

/// Whether the closed box from `low` to `high` comes within `r` of `p`. Requires `low ≤ high` in both
/// coordinates.
#[inline(always)]
pub fn box_point<L: Lattice>(low: Site<L>, high: Site<L>, p: Site<L>, r: L::Linear) -> Proximity {
    // Each coordinate of the nearest point follows on its own.
    let foot = Site { x: p.x.clamp(low.x, high.x), y: p.y.clamp(low.y, high.y) };
    point_point::<L>(p, foot, r)
}

/// Whether the closed box from `low` to `high` and the segment `a b` come within `r` of each other.
///
/// Two convex polygons that do not meet are nearest at a corner of one of them. If they meet with no corner
/// or end inside the other, the segment enters and leaves through two sides, and so crosses a diagonal.
#[inline(always)]
pub fn box_segment<L: Lattice>(
    low: Site<L>,
    high: Site<L>,
    a: Site<L>,
    b: Site<L>,
    r: L::Linear,
) -> Proximity {
    let (right, left) = (Site { x: high.x, y: low.y }, Site { x: low.x, y: high.y });
    let clear = L::box_point(low, high, a, r).is_clear()
        && L::box_point(low, high, b, r).is_clear()
        && [low, right, high, left].into_iter().all(|corner| L::point_segment(corner, a, b, r).is_clear())
        && !L::crosses_properly(low, high, a, b)
        && !L::crosses_properly(right, left, a, b);
    Proximity::near_if(!clear)
}

/// Whether the distance to the segment `a b` never falls on the motion `p → q`.
///
/// The distance to a convex set is convex along a line, so it never falls if it does not fall at the start.
/// There the nearest point is `a`, `b` or the foot of the perpendicular, as in [`point_segment`]. The sign of
/// the motion's component away from that point decides. From a point of the segment itself every motion
/// retracts.
#[inline(always)]
pub fn retract<L: Lattice>(p: Site<L>, q: Site<L>, a: Site<L>, b: Site<L>) -> bool {
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

/// The side of the directed line `p → q` on which the whole box lies, or [`Orientation::On`] when the box is
/// not strictly on one side. The corners may lie off the lattice.
///
/// Let d be the motion and w a vector from its start. Over the box, `d × w` lies between the sums of the
/// least and of the greatest terms.
#[inline(always)]
pub fn box_side<L: Lattice>(low: Site<L>, high: Site<L>, p: Site<L>, q: Site<L>) -> Orientation {
    let (dx, dy) = (L::difference(q.x, p.x), L::difference(q.y, p.y));
    let ordered = |a, b| if L::compare(a, b) == Ordering::Greater { (b, a) } else { (a, b) };
    let (up_least, up_most) = ordered(L::moment(dx, low.y, p.y), L::moment(dx, high.y, p.y));
    let (left_least, left_most) = ordered(L::moment(dy, low.x, p.x), L::moment(dy, high.x, p.x));
    if L::compare(up_least, left_most) == Ordering::Greater {
        return Orientation::Left;
    }
    if L::compare(up_most, left_least) == Ordering::Less { Orientation::Right } else { Orientation::On }
}

/// Whether the distance of `p` from `centre` lies between `radius − inward` and `radius + outward`. Requires
/// `radius ≥ inward`.
#[inline(always)]
pub fn on_ring<L: Lattice>(p: Site<L>, centre: Site<L>, radius: L::Linear, inward: i8, outward: i8) -> bool {
    let square = |r| L::product(r, r);
    let distance_2 = dot::<L>(centre, p, p);
    // The sum is written as a difference, because the width bounds differences.
    let most = L::difference(radius, L::units(outward.wrapping_neg()));
    L::compare(distance_2, square(L::difference(radius, L::units(inward)))) != Ordering::Less
        && L::compare(distance_2, square(most)) != Ordering::Greater
}

/// `⌊length_2 / 7·radius⌋ + 1`, where `length_2` is the square of a chord's length. An arc leaves its chord
/// by less, for `radius ≥ 64` and chords no longer than the radius
/// ([`ArcChords::check`](super::arc::ArcChords::check)).
#[inline(always)]
pub fn sagitta<L: Lattice>(length_2: L::Area, radius: L::Linear) -> L::Area {
    let one = L::product(L::units(1), L::units(1));
    L::sum(L::quotient(length_2, L::product(L::units(7), radius)), one)
}

/// Whether the projection of `p − origin` on the direction from `a` to `b` exceeds `units`: dot > units ·
/// |ab|. Requires `units ≥ 0`.
#[inline(always)]
pub fn ahead<L: Lattice>(origin: Site<L>, p: Site<L>, a: Site<L>, b: Site<L>, units: i8) -> bool {
    let (wx, wy) = (L::difference(p.x, origin.x), L::difference(p.y, origin.y));
    let (ex, ey) = (L::difference(b.x, a.x), L::difference(b.y, a.y));
    let along = L::sum(L::product(wx, ex), L::product(wy, ey));
    let reach = L::product_of_areas(L::product(L::units(units), L::units(units)), dot::<L>(a, b, b));
    L::compare(along, L::zero()) == Ordering::Greater
        && L::compare_volumes(L::product_of_areas(along, along), reach) == Ordering::Greater
}
