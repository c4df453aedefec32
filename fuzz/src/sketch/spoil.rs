//! The faults of drawings.

use super::shape::{Corner, SketchOutline};
use crate::oracle::on_the_way;

/// A fault of an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OutlineFault {
    /// An edge ends before the next begins.
    Gap,
    /// An edge runs back over the one before.
    Overlap,
    /// An edge occurs twice.
    Duplicate,
    /// The whole outline occurs twice.
    Twice,
    /// A line ends on the middle of an edge.
    TJunction,
    /// A corner lies on another edge, or at another corner.
    SelfTouch,
    /// A needle stands out of an edge.
    Needle,
    /// Edges of no length, or nearly none.
    Tiny,
    /// The outline is as large as a hall.
    Huge,
    /// The outline is smaller than a hair.
    Small,
    /// Bulges near zero.
    Flat,
    /// Bulges near infinity.
    Full,
    /// Knots that are repeated, or not in order.
    Knots,
    /// An edge is missing.
    Open,
    /// An edge has a value that is not a number.
    NoNumber,
    /// The outline is in nested blocks.
    Blocks,
}

impl OutlineFault {
    /// All faults that a single outline can have.
    pub const OF_OUTLINES: [Self; 15] = [
        Self::Gap,
        Self::Overlap,
        Self::Duplicate,
        Self::Twice,
        Self::TJunction,
        Self::SelfTouch,
        Self::Needle,
        Self::Tiny,
        Self::Huge,
        Self::Small,
        Self::Flat,
        Self::Full,
        Self::Knots,
        Self::Open,
        Self::NoNumber,
    ];

    /// The name of a file with this fault.
    #[must_use]
    pub fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

/// An edge on its way to the file.
#[derive(Clone, Debug, PartialEq)]
pub struct SpoiltEdge {
    /// Where it begins.
    pub from: Corner,
    /// Where it ends.
    pub to: (f64, f64),
}

/// An outline with faults: edges, each with its beginning and end, or whole curves with their number. An
/// edge need not end where the next begins.
pub enum Spoilt {
    /// Edges.
    Edges(Vec<SpoiltEdge>),
    /// A whole curve, and how often it occurs.
    Whole(SketchOutline, usize),
}

/// Adds the faults to the outline.
pub fn spoilt(outline: &SketchOutline, wrong: &[(OutlineFault, u8, f64)]) -> Spoilt {
    match outline {
        SketchOutline::Corners(corners) => {
            let mut corners = corners.clone();
            wrong
                .iter()
                .for_each(|&(family, at, by)| spoil_corners(&mut corners, family, usize::from(at), by));
            let mut edges = edges_of(&corners);
            wrong.iter().for_each(|&(family, at, by)| spoil_edges(&mut edges, family, usize::from(at), by));
            Spoilt::Edges(edges)
        }
        whole => {
            let mut whole = whole.clone();
            wrong.iter().for_each(|&(family, at, by)| spoil_whole(&mut whole, family, usize::from(at), by));
            let twice = wrong
                .iter()
                .filter(|each| matches!(each.0, OutlineFault::Twice | OutlineFault::Duplicate))
                .count();
            Spoilt::Whole(whole, 1 + twice)
        }
    }
}

fn edges_of(corners: &[Corner]) -> Vec<SpoiltEdge> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&from, to)| SpoiltEdge { from, to: to.at }).collect()
}

/// A length of gaps: from less than a lattice unit to millimetres.
fn small(at: usize) -> f64 {
    const SIZES: [f64; 10] = [0.0, 4e-6, 6e-6, 1e-5, 0.0009, 0.005, 0.009_99, 0.010_01, 0.05, 2.0];
    SIZES[at % SIZES.len()]
}

fn spoil_corners(corners: &mut Vec<Corner>, family: OutlineFault, at: usize, by: f64) {
    let count = corners.len();
    let (k, next, far) = (at % count, (at + 1) % count, (at + count / 2) % count);
    let (here, there) = (corners[k].at, corners[next].at);
    match family {
        OutlineFault::SelfTouch => {
            let opposite = (corners[far].at, corners[(far + 1) % count].at);
            corners[k].at =
                if at.is_multiple_of(2) { opposite.0 } else { on_the_way(opposite.0, opposite.1, 0.5) };
        }
        OutlineFault::Needle => {
            let foot = on_the_way(here, there, 0.5);
            let tip = (foot.0 - (there.1 - here.1), foot.1 + (there.0 - here.0));
            let beside = on_the_way(foot, there, small(at).min(0.4));
            let corner = |at| Corner { at, bulge: 0.0 };
            corners[k].bulge = 0.0;
            corners.splice(next.max(1)..next.max(1), [corner(foot), corner(tip), corner(beside)]);
        }
        OutlineFault::Tiny => {
            let close = (here.0 + small(at), here.1 + small(at / 3));
            corners.insert(k + 1, Corner { at: close, bulge: corners[k].bulge });
        }
        OutlineFault::Huge => scale(corners, 10.0_f64.powi(i32::try_from(at % 12).unwrap_or(0))),
        OutlineFault::Small => scale(corners, 0.1_f64.powi(i32::try_from(at % 12).unwrap_or(0))),
        OutlineFault::Flat => corners[k].bulge = [1e-3, 1e-6, 1e-9, 1e-12, 1e-300, -1e-5, 5e-324][at % 7],
        OutlineFault::Full => corners[k].bulge = [10.0, 1e3, 1e6, 1e12, -1e9, 1e300, -30.0][at % 7],
        OutlineFault::NoNumber => corners[k].bulge = by,
        _ => {}
    }
}

fn scale(corners: &mut [Corner], by: f64) {
    corners.iter_mut().for_each(|corner| corner.at = (corner.at.0 * by, corner.at.1 * by));
}

fn spoil_edges(edges: &mut Vec<SpoiltEdge>, family: OutlineFault, at: usize, by: f64) {
    let k = at % edges.len();
    let edge = edges[k].clone();
    match family {
        OutlineFault::Gap => edges[k].to = (edge.to.0 + small(at / 2), edge.to.1 - small(at / 5)),
        OutlineFault::Overlap => {
            let from = Corner { at: on_the_way(edge.from.at, edge.to, 0.3), bulge: 0.0 };
            edges.push(SpoiltEdge {
                from,
                to: on_the_way(
                    edge.from.at,
                    edge.to,
                    if at.is_multiple_of(2) { 0.7 } else { 1.0 + small(at) },
                ),
            });
        }
        OutlineFault::Duplicate => {
            let back = SpoiltEdge { from: Corner { at: edge.to, bulge: -edge.from.bulge }, to: edge.from.at };
            edges.push(if at.is_multiple_of(2) { edge } else { back });
        }
        OutlineFault::Twice => edges.extend_from_within(..),
        OutlineFault::TJunction => {
            let from = Corner { at: on_the_way(edge.from.at, edge.to, 0.5), bulge: 0.0 };
            edges.push(SpoiltEdge { from, to: (by, by) });
        }
        OutlineFault::Open => drop(edges.remove(k)),
        _ => {}
    }
    if edges.is_empty() {
        edges.push(SpoiltEdge { from: Corner { at: (0.0, 0.0), bulge: 0.0 }, to: (by, 0.0) });
    }
}

fn spoil_whole(outline: &mut SketchOutline, family: OutlineFault, at: usize, by: f64) {
    match outline {
        SketchOutline::Corners(_) => {}
        SketchOutline::Round { centre, axis, ratio, range, .. } => match family {
            OutlineFault::Gap | OutlineFault::Open => range.1 -= small(at).max(1e-7),
            OutlineFault::Overlap => range.1 += small(at),
            OutlineFault::Huge => *axis = (axis.0 * 1e3, axis.1 * 1e3),
            OutlineFault::Small => *axis = (axis.0 * 1e-6, axis.1 * 1e-6),
            OutlineFault::Flat | OutlineFault::Needle => *ratio = [1e-3, 1e-6, 1e-12, 0.0, -0.5][at % 5],
            OutlineFault::NoNumber => centre.0 = by,
            OutlineFault::Tiny => range.1 = range.0 + small(at),
            _ => {}
        },
        SketchOutline::Spline { knots, points, weights, .. } => {
            let (k, p) = (at % knots.len(), at % points.len());
            match family {
                OutlineFault::Gap | OutlineFault::Open => {
                    let last = points.len() - 1;
                    points[last] = (points[last].0 + small(at), points[last].1);
                }
                OutlineFault::Knots => {
                    knots[k] = if at.is_multiple_of(2) { knots[(k + 1) % knots.len()] } else { by }
                }
                OutlineFault::SelfTouch | OutlineFault::Duplicate => points[p] = points[0],
                OutlineFault::Needle => points[p] = (points[p].0 + by, points[p].1),
                OutlineFault::Huge => {
                    points.iter_mut().for_each(|point| *point = (point.0 * 1e3, point.1 * 1e3))
                }
                OutlineFault::Small => {
                    points.iter_mut().for_each(|point| *point = (point.0 * 1e-5, point.1 * 1e-5))
                }
                OutlineFault::NoNumber => points[p].1 = by,
                OutlineFault::Full | OutlineFault::Flat => {
                    if let Some(weight) = weights.get_mut(p) {
                        *weight = by;
                    }
                }
                OutlineFault::Overlap => drop(points.pop()),
                _ => {}
            }
        }
    }
}
