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
/// If they do not cross properly, the distance is attained at one of the four ends (`research`: T3, Cramer and
/// convexity), so four point–segment questions and one crossing question decide. They need not be asked where the line of one
/// has all of the other on one side of it and [`beyond`] `r`.
#[inline(always)]
pub fn segment_segment<L: Lattice>([a, b]: [Site<L>; 2], [c, d]: [Site<L>; 2], r: L::Linear) -> Proximity {
    let told_apart = L::beyond([a, b], [c, d].into_iter(), r)
        || L::beyond([b, a], [c, d].into_iter(), r)
        || L::beyond([c, d], [a, b].into_iter(), r)
        || L::beyond([d, c], [a, b].into_iter(), r);
    if told_apart {
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
/// Either a side of the triangle does, or the segment lies wholly inside, which its end `d` then tells.
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

/// The sides of a closed polygon, corner to corner; those of a segment are the segment there and back.
#[inline(always)]
pub fn sides<T>(corners: impl Iterator<Item = T> + Clone) -> impl Iterator<Item = [T; 2]> {
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(from, to)| [from, to])
}

/// Whether the filled convex polygon, border included, holds `p`: it is right of no side, nor outside the box of the corners
/// (which tells for corners on a line). All corners lie to the left of each side or on its line.
#[inline(always)]
pub fn convex_holds<L: Lattice>(corners: impl Iterator<Item = Site<L>> + Clone, p: Site<L>) -> bool {
    let each = || corners.clone();
    each().any(|c| c.x <= p.x)
        && each().any(|c| p.x <= c.x)
        && each().any(|c| c.y <= p.y)
        && each().any(|c| p.y <= c.y)
        && sides(corners).all(|[a, b]| orientation::<L>(a, b, p) != Orientation::Right)
}

/// Whether the filled convex polygon and the segment `c d` come within `r` of each other. All corners lie to the left of each
/// side or on its line.
///
/// Either a side does, or the segment lies wholly inside, which its end `c` then tells. They need not be asked where a line
/// tells the two apart: the polygon is to the left of a side's line, and the segment [`beyond`] it; or the corners, and with
/// them what is convex over them, are beyond the line of the segment.
#[inline(always)]
pub fn convex_segment<L: Lattice>(
    corners: impl ExactSizeIterator<Item = Site<L>> + Clone,
    [c, d]: [Site<L>; 2],
    r: L::Linear,
) -> Proximity {
    let told_apart = L::beyond([c, d], corners.clone(), r)
        || L::beyond([d, c], corners.clone(), r)
        || sides(corners.clone()).any(|side| L::beyond(side, [c, d].into_iter(), r));
    if told_apart {
        return Proximity::Clear;
    }
    // The way back over a segment is the same.
    let count = if corners.len() == 2 { 1 } else { corners.len() };
    let near = sides(corners.clone()).take(count).any(|side| !L::segment_segment(side, [c, d], r).is_clear());
    Proximity::near_if(near || L::convex_holds(corners, c))
}

/// Whether the ray from `p` toward +x crosses the edge `a b`, counting an edge's lower end and not its upper one, so
/// that the parity over a closed ring is odd exactly for points inside. `p` must not lie on the edge.
#[inline(always)]
pub fn ray_crosses<L: Lattice>(p: Site<L>, a: Site<L>, b: Site<L>) -> bool {
    if (a.y > p.y) == (b.y > p.y) {
        return false;
    }
    let (low, high) = if a.y > p.y { (b, a) } else { (a, b) };
    orientation::<L>(low, high, p) == Orientation::Left
}

/// Whether the closed box from `low` to `high` (`low ≤ high` in both coordinates) comes within `r` of `p`.
#[inline(always)]
pub fn box_point<L: Lattice>(low: Site<L>, high: Site<L>, p: Site<L>, r: L::Linear) -> Proximity {
    // The nearest point of a box is found in each coordinate on its own.
    let foot = Site { x: p.x.clamp(low.x, high.x), y: p.y.clamp(low.y, high.y) };
    point_point::<L>(p, foot, r)
}

/// Whether the closed box from `low` to `high` and the segment `a b` come within `r` of each other.
///
/// Two convex polygons that do not meet are nearest at a corner of one of them. When they meet without a corner or an
/// end being in the other, the segment enters and leaves through two sides, and so crosses a diagonal.
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
/// The distance to a convex set is convex along a line: it never falls when it does not fall at the start. There the
/// nearest point is `a`, `b` or the foot of the perpendicular, as in [`point_segment`], and the sign of the motion's
/// component away from it decides. From a point of the segment itself every motion retract.
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

/// The side of the directed line `p → q` on which the whole box lies; [`Orientation::On`] when it is not strictly on one. Its
/// corners may lie off the lattice.
///
/// With d the motion and w from its start, `d × w` over the box is between the sums of its least and greatest terms.
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

/// Whether `p` lies between `radius − inward` and `radius + outward` from `centre`, for `radius ≥ inward`.
#[inline(always)]
pub fn on_ring<L: Lattice>(p: Site<L>, centre: Site<L>, radius: L::Linear, inward: i8, outward: i8) -> bool {
    let square = |r| L::product(r, r);
    let distance_2 = dot::<L>(centre, p, p);
    // `radius + outward` as a difference, of which the width keeps the bound.
    let most = L::difference(radius, L::units(outward.wrapping_neg()));
    L::compare(distance_2, square(L::difference(radius, L::units(inward)))) != Ordering::Less
        && L::compare(distance_2, square(most)) != Ordering::Greater
}

/// `⌊length_2 / 7·radius⌋ + 1`: more than an arc leaves a chord of that length squared, for `radius ≥ 64` and chords no longer
/// than it ([`ArcChords::check`](super::arc::ArcChords::check)).
#[inline(always)]
pub fn sagitta<L: Lattice>(length_2: L::Area, radius: L::Linear) -> L::Area {
    let one = L::product(L::units(1), L::units(1));
    L::sum(L::quotient(length_2, L::product(L::units(7), radius)), one)
}

/// Whether the projection of `p` from `origin` on the direction from `a` to `b` exceeds `units`, for `units ≥ 0`: dot > units · |ab|.
#[inline(always)]
pub fn ahead<L: Lattice>(origin: Site<L>, p: Site<L>, a: Site<L>, b: Site<L>, units: i8) -> bool {
    let (wx, wy) = (L::difference(p.x, origin.x), L::difference(p.y, origin.y));
    let (ex, ey) = (L::difference(b.x, a.x), L::difference(b.y, a.y));
    let along = L::sum(L::product(wx, ex), L::product(wy, ey));
    let reach = L::product_of_areas(L::product(L::units(units), L::units(units)), dot::<L>(a, b, b));
    L::compare(along, L::zero()) == Ordering::Greater
        && L::compare_volumes(L::product_of_areas(along, along), reach) == Ordering::Greater
}
