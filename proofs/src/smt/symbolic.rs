//! The predicates' arithmetic on terms: a [`Lattice`] of unknown numbers.

use std::cell::RefCell;
use std::cmp::Ordering;

use keepout_kernel::exact::predicate::{self, Proximity, Site};
use keepout_kernel::exact::width::{Lattice, Sealed};

use super::explore::{Part, ask, is_closed, is_less, order};
use super::term::{Term, TermNode, whole};

/// The symbolic width.
#[derive(Clone, Copy, Debug)]
pub struct Symbolic;

/// A coordinate or length. Comparing two asks the explorer.
#[derive(Clone, Copy, Debug)]
pub struct Scalar(pub Term);

/// Which of the product's widths holds the result of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Width {
    /// `i32`.
    Linear,
    /// `i64`.
    Area,
    /// `i128`.
    Volume,
}

thread_local! {
    static OPERATIONS: RefCell<Vec<(Term, Width)>> = RefCell::default();
}

/// The results of all operations since the last call, each once.
#[must_use]
pub fn operations() -> Vec<(Term, Width)> {
    let mut operations = OPERATIONS.take();
    operations.sort_unstable();
    operations.dedup();
    operations
}

fn record(term: Term, width: Width) -> Term {
    OPERATIONS.with_borrow_mut(|operations| operations.push((term, width)));
    term
}

impl PartialEq for Scalar {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Scalar {}

impl PartialOrd for Scalar {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
    fn lt(&self, other: &Self) -> bool {
        is_less(self.0, other.0)
    }
    fn gt(&self, other: &Self) -> bool {
        is_less(other.0, self.0)
    }
    fn le(&self, other: &Self) -> bool {
        !is_less(other.0, self.0)
    }
    fn ge(&self, other: &Self) -> bool {
        !is_less(self.0, other.0)
    }
}

impl Ord for Scalar {
    fn cmp(&self, other: &Self) -> Ordering {
        order(self.0, other.0)
    }
}

/// A point of unknown coordinates.
pub type SymbolicPoint = Site<Symbolic>;

fn arguments(places: impl IntoIterator<Item = SymbolicPoint>, r: Option<Scalar>) -> Vec<Term> {
    places.into_iter().flat_map(|place| [place.x.0, place.y.0]).chain(r.map(|r| r.0)).collect()
}

fn proximity(near: bool) -> Proximity {
    if near { Proximity::Near } else { Proximity::Clear }
}

impl Sealed for Symbolic {}

impl Lattice for Symbolic {
    type Linear = Scalar;
    type Area = Term;
    type Volume = Term;

    fn difference(a: Scalar, b: Scalar) -> Scalar {
        Scalar(record(a.0 - b.0, Width::Linear))
    }
    fn product(a: Scalar, b: Scalar) -> Term {
        record(a.0 * b.0, Width::Area)
    }
    fn sum(a: Term, b: Term) -> Term {
        record(a + b, Width::Area)
    }
    fn gap(a: Term, b: Term) -> Term {
        record(a - b, Width::Area)
    }
    fn product_of_areas(a: Term, b: Term) -> Term {
        record(a * b, Width::Volume)
    }
    fn compare(a: Term, b: Term) -> Ordering {
        order(a, b)
    }
    fn compare_volumes(a: Term, b: Term) -> Ordering {
        order(a, b)
    }
    fn zero() -> Term {
        whole(0)
    }
    fn units(count: i8) -> Scalar {
        Scalar(whole(count.into()))
    }
    fn quotient(a: Term, b: Term) -> Term {
        record(Term::of(TermNode::Quotient(a, b)), Width::Area)
    }
    fn moment(factor: Scalar, c: Scalar, origin: Scalar) -> Term {
        record(factor.0 * record(c.0 - origin.0, Width::Area), Width::Area)
    }

    fn point_segment(p: SymbolicPoint, a: SymbolicPoint, b: SymbolicPoint, r: Scalar) -> Proximity {
        if is_closed(Part::PointSegment) {
            return proximity(ask(Part::PointSegment, &arguments([p, a, b], Some(r))));
        }
        predicate::point_segment(p, a, b, r)
    }
    fn crosses_properly(a: SymbolicPoint, b: SymbolicPoint, c: SymbolicPoint, d: SymbolicPoint) -> bool {
        if is_closed(Part::CrossesProperly) {
            return ask(Part::CrossesProperly, &arguments([a, b, c, d], None));
        }
        predicate::crosses_properly(a, b, c, d)
    }
    fn segment_segment([a, b]: [SymbolicPoint; 2], [c, d]: [SymbolicPoint; 2], r: Scalar) -> Proximity {
        if is_closed(Part::SegmentSegment) {
            return proximity(ask(Part::SegmentSegment, &arguments([a, b, c, d], Some(r))));
        }
        predicate::segment_segment([a, b], [c, d], r)
    }
    fn strictly_inside(p: SymbolicPoint, a: SymbolicPoint, b: SymbolicPoint, c: SymbolicPoint) -> bool {
        if is_closed(Part::StrictlyInside) {
            return ask(Part::StrictlyInside, &arguments([p, a, b, c], None));
        }
        predicate::strictly_inside(p, a, b, c)
    }
    fn box_point(low: SymbolicPoint, high: SymbolicPoint, p: SymbolicPoint, r: Scalar) -> Proximity {
        if is_closed(Part::BoxPoint) {
            return proximity(ask(Part::BoxPoint, &arguments([low, high, p], Some(r))));
        }
        predicate::box_point(low, high, p, r)
    }
    fn beyond(line: [SymbolicPoint; 2], points: impl Iterator<Item = SymbolicPoint>, r: Scalar) -> bool {
        if is_closed(Part::Beyond) {
            return ask(Part::Beyond, &arguments(line.into_iter().chain(points), Some(r)));
        }
        predicate::beyond(line, points, r)
    }
    fn convex_holds(corners: impl Iterator<Item = SymbolicPoint> + Clone, p: SymbolicPoint) -> bool {
        if is_closed(Part::ConvexHolds) {
            return ask(Part::ConvexHolds, &arguments(corners.chain([p]), None));
        }
        predicate::convex_holds(corners, p)
    }
}

#[cfg(test)]
mod tests {
    use super::super::explore::explore;
    use super::*;

    fn place(name: &str) -> SymbolicPoint {
        Site { x: Scalar(Term::fresh(name)), y: Scalar(Term::fresh(name)) }
    }

    #[test]
    fn shipped_predicates_run_path_by_path() {
        let (p, a, b) = (place("p"), place("a"), place("b"));
        assert_eq!(explore(&[], &[], || predicate::orientation::<Symbolic>(p, a, b)).len(), 3);
        let r = Scalar(Term::fresh("r"));
        let near = || predicate::point_segment::<Symbolic>(p, a, b, r);
        assert_eq!(explore(&[], &[], near).len(), 15);
        let box_near = || predicate::box_point::<Symbolic>(a, b, p, r);
        let ordered = [(a.x.0, b.x.0), (a.y.0, b.y.0)];
        assert_eq!(explore(&ordered, &[], box_near).len(), 27);
        let parts = [Part::Beyond, Part::PointSegment, Part::CrossesProperly];
        let c = place("c");
        let both = || predicate::segment_segment::<Symbolic>([p, a], [b, c], r);
        assert_eq!(explore(&[], &parts, both).len(), 10);
    }
}
