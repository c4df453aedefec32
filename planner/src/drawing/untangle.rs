//! Removes crossings within a contour that are smaller than the joining tolerance: overshoots at corners, closing
//! segments that run back, loops of a few micrometres.

use keepout_kernel::{Curve, Length, Point, Segment, UNITS_PER_MM};

use super::join::distance_mm;
use super::{Chained, Repair};
use crate::Mm2;
use crate::profile::{ProfileEdge, ProfileLoop};
use crate::units::{point_from_mm, point_mm};

/// What is removed with a crossing has at most this length, in joining tolerances: the edges between the two that
/// cross, and the ends of these two. So no place of it is farther away than half of that.
const LENGTH: f64 = 4.0;
/// Largest number of crossings that are removed from one contour.
const CROSSINGS_MAX: usize = 1000;

/// Removes the small crossings of every contour of lines.
pub(super) fn untangle(chained: &mut Chained, join_mm: f64) {
    let most_mm = LENGTH * join_mm;
    for each in chained.profile.loops.iter_mut().filter(|each| each.sources.is_empty()) {
        let short = |edge: &ProfileEdge| length_mm(&edge.curve) <= most_mm;
        if !each.edges.iter().any(short) {
            continue;
        }
        for _ in 0..CROSSINGS_MAX {
            let Some(crossing) = first_crossing(each, most_mm) else { break };
            chained.repairs.push(Repair::CrossingRemoved { at: crossing.at, length_mm: crossing.length_mm });
            crossing.remove(each);
        }
    }
}

/// Two edges of a contour that meet, with a short way between them.
struct Crossing {
    /// Index of the first edge.
    first: usize,
    /// Number of edges between the two.
    between: usize,
    at: Point,
    /// Length of the removed edges and ends.
    length_mm: f64,
}

impl Crossing {
    /// Joins the two edges where they meet, and drops the edges between them.
    fn remove(&self, each: &mut ProfileLoop) {
        let count = each.edges.len();
        each.edges.rotate_left(self.first);
        let last = self.between + 1;
        let (from, to) = (each.edges[0].curve.from(), each.edges[last % count].curve.to());
        let line =
            |from, to| ProfileEdge { curve: Curve::Line(Segment { from, to }), chord_error: Length::ZERO };
        let ends = [line(from, self.at), line(self.at, to)];
        let ends = ends.into_iter().filter(|edge| edge.curve.from() != edge.curve.to());
        let rest: Vec<ProfileEdge> = each.edges.drain(last + 1..).collect();
        each.edges = ends.chain(rest).collect();
    }
}

fn first_crossing(each: &ProfileLoop, most_mm: f64) -> Option<Crossing> {
    let count = each.edges.len();
    // A contour needs three edges after the repair.
    (0..count).find_map(|first| {
        let Curve::Line(one) = each.edges[first].curve else { return None };
        let mut length_mm = 0.0;
        for between in 1..count.saturating_sub(3) {
            length_mm += self::length_mm(&each.edges[(first + between) % count].curve);
            if length_mm > most_mm {
                return None;
            }
            let Curve::Line(other) = each.edges[(first + between + 1) % count].curve else { continue };
            let Some(at) = meeting(one, other) else { continue };
            let length_mm = length_mm + distance_mm(one.to, at) + distance_mm(at, other.from);
            if length_mm <= most_mm {
                return Some(Crossing { first, between, at, length_mm });
            }
        }
        None
    })
}

/// The place where two lines meet, if they do.
fn meeting(one: Segment, other: Segment) -> Option<Point> {
    if one.near_segment(other, Length::ZERO).is_clear() {
        return None;
    }
    let (a, b, c, d) = (point_mm(one.from), point_mm(one.to), point_mm(other.from), point_mm(other.to));
    let across = (b - a).cross(d - c);
    let at: Mm2 =
        if across.abs() < 1e-12 { c.nearest_on(a, b) } else { a + (b - a) * ((c - a).cross(d - c) / across) };
    point_from_mm(at).ok()
}

fn length_mm(curve: &Curve) -> f64 {
    curve.length() / f64::from(UNITS_PER_MM)
}
