//! Closed simple rings of chords.
//!
//! Implements SR-02, SR-04.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;

use super::arc::ArcChords;
use super::contact::first_contact;
use super::lattice::{Length, Point};
use super::predicate::{self, Orientation};
use super::segment::{Segment, orientation};
use super::width::{Lattice, Product};

/// One piece of a ring's outline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// A straight piece.
    Line {
        /// The straight segment.
        segment: Segment,
        /// Bound on the distance between segment and true curve; zero for a true line.
        chord_error: Length,
    },
    /// Checked chords of an arc.
    Arc {
        /// The chords.
        chords: ArcChords,
        /// Bound on the distance between arc and true curve; zero for a true arc.
        chord_error: Length,
    },
}

/// A closed simple polygon. Each edge carries its chord-error bound: the greatest distance between chord and
/// true curve. Copies share their vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ring {
    vertices: Arc<[Point]>,
    chord_errors: Arc<[Length]>,
}

/// Why a ring is invalid. Edge `i` runs from vertex `i` to the next vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingError {
    /// Fewer than three vertices.
    TooFewVertices {
        /// The number of vertices.
        count: usize,
    },
    /// Two consecutive vertices are the same point.
    ZeroLengthEdge {
        /// The repeated point.
        at: Point,
    },
    /// A piece does not begin at the end of the piece before it.
    Gap {
        /// The end of the piece before.
        from: Point,
        /// The start of the piece.
        to: Point,
    },
    /// Two edges touch or cross outside a common vertex, or fold back on each other.
    Contact(Contact),
}

/// An unwanted contact of two edges: they touch, cross or fold back on each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// Index of the first edge.
    pub first: usize,
    /// Index of the second edge.
    pub second: usize,
    /// The point of contact, to the lattice unit.
    pub at: Point,
}

impl Contact {
    pub(super) fn of(edges: &[Segment], (first, second): (usize, usize)) -> Self {
        let at = match (edges.get(first), edges.get(second)) {
            (Some(&one), Some(&other)) => meeting_point(one, other),
            _ => Point::ORIGIN,
        };
        Self { first, second, at }
    }
}

impl fmt::Display for RingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewVertices { count } => {
                write!(f, "a ring needs at least three vertices; this one has {count}")
            }
            Self::ZeroLengthEdge { at } => write!(f, "the ring has an edge of zero length at {at}"),
            Self::Gap { from, to } => write!(f, "the outline is open between {from} and {to}"),
            Self::Contact(contact) => write!(f, "the ring crosses or touches itself at {}", contact.at),
        }
    }
}

impl core::error::Error for RingError {}

impl Ring {
    /// A ring of straight edges through `vertices`. The last vertex joins the first.
    ///
    /// # Errors
    /// [`RingError`] with the place of the first fault.
    pub fn new(vertices: Vec<Point>) -> Result<Self, RingError> {
        let chord_errors = vertices.iter().map(|_| Length::ZERO).collect();
        Self::checked(vertices, chord_errors)
    }

    /// A ring from consecutive pieces. The last piece ends where the first begins.
    ///
    /// # Errors
    /// [`RingError`] with the place of the first fault.
    pub fn from_pieces(pieces: &[Piece]) -> Result<Self, RingError> {
        let mut vertices: Vec<Point> = Vec::new();
        let mut chord_errors = Vec::new();
        let mut end = pieces.last().map(Piece::end);
        for piece in pieces {
            match end {
                Some(from) if from != piece.start() => {
                    return Err(RingError::Gap { from, to: piece.start() });
                }
                _ => end = Some(piece.end()),
            }
            match piece {
                Piece::Line { segment, chord_error } => {
                    vertices.push(segment.from);
                    chord_errors.push(*chord_error);
                }
                Piece::Arc { chords, chord_error } => {
                    // A sum that saturates exceeds the lattice with every positive threshold: every query
                    // then answers "near".
                    let total = chords.chord_error().saturating_plus(*chord_error);
                    for chord in chords.segments() {
                        vertices.push(chord.from);
                        chord_errors.push(total);
                    }
                }
            }
        }
        Self::checked(vertices, chord_errors)
    }

    fn checked(vertices: Vec<Point>, chord_errors: Vec<Length>) -> Result<Self, RingError> {
        if vertices.len() < 3 {
            return Err(RingError::TooFewVertices { count: vertices.len() });
        }
        let ring = Self { vertices: vertices.into(), chord_errors: chord_errors.into() };
        if let Some(edge) = ring.segments().find(|edge| edge.from == edge.to) {
            return Err(RingError::ZeroLengthEdge { at: edge.from });
        }
        let edges: Vec<Segment> = ring.segments().collect();
        let meet = |i: usize, j: usize| match (edges.get(i), edges.get(j)) {
            (Some(&one), Some(&other)) if ring.adjacent(i, j) => folds_back(one, other),
            (Some(&one), Some(&other)) => one.touches(other),
            _ => false,
        };
        match first_contact(&edges, |edge| edge, meet) {
            Some(pair) => Err(RingError::Contact(Contact::of(&edges, pair))),
            None => Ok(ring),
        }
    }

    fn adjacent(&self, i: usize, j: usize) -> bool {
        let next =
            |k: usize| if k.saturating_add(1) == self.vertices.len() { 0 } else { k.saturating_add(1) };
        next(i) == j || next(j) == i
    }

    /// The vertices in order.
    #[must_use]
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// The edges in order, edge `i` from vertex `i`.
    pub fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let ends = self.vertices.iter().skip(1).chain(self.vertices.first());
        self.vertices.iter().zip(ends).map(|(&from, &to)| Segment { from, to })
    }

    /// The chord-error bound of each edge, in the order of [`Ring::segments`].
    #[must_use]
    pub fn chord_errors(&self) -> &[Length] {
        &self.chord_errors
    }

    /// Twice the enclosed area in square lattice units; positive when the ring runs counter-clockwise.
    #[must_use]
    pub fn double_area(&self) -> i128 {
        let Some(&origin) = self.vertices.first() else { return 0 };
        self.segments()
            .map(|edge| {
                let (a, b) = (edge.from.minus(origin), edge.to.minus(origin));
                i128::from(Product::gap(Product::product(a.dx, b.dy), Product::product(a.dy, b.dx)))
            })
            .fold(0, i128::saturating_add)
    }

    /// Whether the ray from `point` toward +x crosses an odd number of edges. Odd means inside. The answer
    /// has no meaning for a point on the ring.
    #[must_use]
    pub fn crossing_parity_is_odd(&self, point: Point) -> bool {
        self.segments().fold(false, |odd, edge| {
            odd ^ predicate::ray_crosses::<Product>(point.into(), edge.from.into(), edge.to.into())
        })
    }
}

impl Piece {
    /// The start point.
    #[must_use]
    pub fn start(&self) -> Point {
        match self {
            Self::Line { segment, .. } => segment.from,
            Self::Arc { chords, .. } => chords.points().first().copied().unwrap_or(Point::ORIGIN),
        }
    }

    /// The end point.
    #[must_use]
    pub fn end(&self) -> Point {
        match self {
            Self::Line { segment, .. } => segment.to,
            Self::Arc { chords, .. } => chords.points().last().copied().unwrap_or(Point::ORIGIN),
        }
    }
}

/// Whether two edges with a common end share more than that end.
fn folds_back(one: Segment, other: Segment) -> bool {
    let beyond = |shared: Point, edge: Segment| if edge.from == shared { edge.to } else { edge.from };
    let shared = if one.from == other.to || one.from == other.from { one.from } else { one.to };
    let (a, b) = (beyond(shared, one), beyond(shared, other));
    let near = |point, edge: Segment| !edge.near_point(point, Length::ZERO).is_clear();
    a == b
        || orientation(shared, a, b) == Orientation::On
            && (near(a, Segment { from: shared, to: b }) || near(b, Segment { from: shared, to: a }))
}

/// A lattice point within a unit of the contact of two touching segments. For messages only.
fn meeting_point(one: Segment, other: Segment) -> Point {
    let on = |point: Point, edge: Segment| !edge.near_point(point, Length::ZERO).is_clear();
    for (point, edge) in [(one.from, other), (one.to, other), (other.from, one), (other.to, one)] {
        if on(point, edge) {
            return point;
        }
    }
    // Proper crossing: from + d·n/m with n/m in (0, 1); i128 holds every product.
    let (d, e, w) = (one.to.minus(one.from), other.to.minus(other.from), other.from.minus(one.from));
    let cross = |ax: i32, ay: i32, bx: i32, by: i32| {
        i128::from(Product::gap(Product::product(ax, by), Product::product(ay, bx)))
    };
    let (n, m) = (cross(w.dx, w.dy, e.dx, e.dy), cross(d.dx, d.dy, e.dx, e.dy));
    let along = |c: i32, span: i32| {
        let step = i128::from(span).saturating_mul(n).checked_div(m).unwrap_or(0);
        i64::from(c).saturating_add(i64::try_from(step).unwrap_or(0))
    };
    Point::from_units(along(one.from.x.units(), d.dx), along(one.from.y.units(), d.dy)).unwrap_or(one.from)
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;

    fn ring(points: &[(i64, i64)]) -> Result<Ring, RingError> {
        Ring::new(points.iter().map(|&(x, y)| Point::from_units(x, y).unwrap()).collect())
    }

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    #[test]
    fn square_is_a_ring_with_its_area() {
        let square = ring(&[(0, 0), (10, 0), (10, 10), (0, 10)]).unwrap();
        assert_eq!(square.double_area(), 200);
        assert!(square.crossing_parity_is_odd(at(5, 5)));
        assert!(!square.crossing_parity_is_odd(at(15, 5)));
    }

    #[test]
    fn faults_name_their_place() {
        let contact = |points: &[(i64, i64)]| match ring(points).unwrap_err() {
            RingError::Contact(contact) => contact.at,
            other => panic!("{other:?}"),
        };
        assert_eq!(contact(&[(0, 0), (10, 10), (10, 0), (0, 10)]), at(5, 5), "bow tie");
        assert_eq!(contact(&[(0, 0), (10, 0), (4, 0), (4, 9)]), at(10, 0), "fold back");
        assert_eq!(contact(&[(0, 0), (8, 0), (8, 4), (4, 0), (0, 4)]), at(4, 0), "vertex on edge");
        assert_eq!(ring(&[(0, 0), (1, 0)]), Err(RingError::TooFewVertices { count: 2 }));
        assert_eq!(ring(&[(0, 0), (1, 0), (1, 0), (3, 4)]), Err(RingError::ZeroLengthEdge { at: at(1, 0) }));
        assert!(ring(&[(0, 0), (9, 0), (4, 0)]).is_err(), "flat triangle");
    }

    #[test]
    fn gap_between_pieces_is_an_error() {
        let line = |a, b| Piece::Line { segment: Segment { from: a, to: b }, chord_error: Length::ZERO };
        let pieces = vec![line(at(0, 0), at(9, 0)), line(at(9, 1), at(4, 5)), line(at(4, 5), at(0, 0))];
        assert_eq!(Ring::from_pieces(&pieces), Err(RingError::Gap { from: at(9, 0), to: at(9, 1) }));
    }

    #[test]
    fn triangles_and_straight_corners_are_rings() {
        assert!(ring(&[(0, 0), (9, 0), (4, 7)]).is_ok());
        assert!(ring(&[(0, 0), (5, 0), (10, 0), (10, 10), (0, 10)]).is_ok(), "a corner of 180 degrees");
        assert!(ring(&[(5, 0), (10, 0), (10, 10), (0, 10), (0, 0)]).is_ok(), "at the beginning");
    }

    #[test]
    fn edges_fold_back_from_either_end() {
        let edge = |a: (i64, i64), b: (i64, i64)| Segment { from: at(a.0, a.1), to: at(b.0, b.1) };
        for (far, folds) in
            [((4, 0), true), ((9, 0), true), ((14, 0), true), ((-4, 0), false), ((4, 1), false)]
        {
            // Both orders of the edges, and both directions.
            assert_eq!(folds_back(edge((9, 0), (0, 0)), edge((0, 0), far)), folds, "{far:?}");
            assert_eq!(folds_back(edge((0, 0), far), edge((9, 0), (0, 0))), folds, "{far:?}");
            assert_eq!(folds_back(edge((0, 0), (9, 0)), edge((0, 0), far)), folds, "{far:?}");
            assert_eq!(folds_back(edge((9, 0), (0, 0)), edge(far, (0, 0))), folds, "{far:?}");
        }
    }
}
