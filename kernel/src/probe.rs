//! TRUSTED: successive nearby queries at one threshold, answered from the square of the last answer.

use crate::clear::{FreePoint, ProhibitedRegion};
use crate::exact::lattice::{Length, Point};
use crate::exact::predicate::Proximity;
use crate::exact::segment::Segment;
use crate::index::cells::{Answer, Square};
use crate::index::{Cells, Edge};

/// A part, a threshold, and the square of the last answer. The claim of a closed square holds for every point
/// in it. Squares are convex, so it also holds for every motion with both ends in it. Other queries look up a
/// new square.
///
/// Without cells for the threshold ([`ProhibitedRegion::prepare`]) every query goes to the index.
#[derive(Clone, Copy, Debug)]
pub struct Probe<'a> {
    part: &'a ProhibitedRegion,
    threshold: Length,
    cells: Option<&'a Cells>,
    square: Option<Square<'a>>,
}

impl<'a> Probe<'a> {
    /// A probe of `part` at `threshold`.
    #[must_use]
    pub fn new(part: &'a ProhibitedRegion, threshold: Length) -> Self {
        Self { part, threshold, cells: part.cells_for(threshold), square: None }
    }

    /// As [`ProhibitedRegion::point_clear`].
    #[must_use]
    #[inline]
    pub fn point_clear(&mut self, point: Point) -> Proximity {
        let threshold = self.threshold;
        match self.ask_square(point, point, |edge| edge.near_point(point, threshold)) {
            Answer::Clear => Proximity::Clear,
            Answer::Near(_) => Proximity::Near,
            Answer::Unknown => self.part.point_clear(point, threshold),
        }
    }

    /// As [`ProhibitedRegion::motion_clear`].
    #[must_use]
    #[inline]
    pub fn motion_clear(&mut self, motion: Segment) -> Proximity {
        let threshold = self.threshold;
        match self.ask_square(motion.from, motion.to, |edge| edge.near_motion(motion, threshold)) {
            Answer::Clear => Proximity::Clear,
            Answer::Near(_) => Proximity::Near,
            Answer::Unknown => self.part.motion_clear(motion, threshold),
        }
    }

    /// As [`ProhibitedRegion::motion`]: the end of a clear motion. The start must be free at the probe's
    /// threshold or a higher one.
    #[must_use]
    #[inline]
    pub fn passes(&mut self, from: FreePoint, to: Point) -> Option<FreePoint> {
        let free = from.lowered(self.threshold)?;
        self.motion_clear(Segment { from: from.point(), to }).is_clear().then(|| free.moved(to))
    }

    /// The part.
    #[must_use]
    pub fn part(&self) -> &'a ProhibitedRegion {
        self.part
    }

    /// The threshold.
    #[must_use]
    pub fn threshold(&self) -> Length {
        self.threshold
    }

    /// The answer of the square that holds both points: the last square, or the square at `to`.
    /// [`Answer::Unknown`] when neither holds both.
    #[inline(always)]
    fn ask_square(&mut self, from: Point, to: Point, ask: impl Fn(&Edge) -> Proximity) -> Answer {
        let Some(cells) = self.cells else { return Answer::Unknown };
        let holds = |square: &Square<'_>| square.holds(to) && square.holds(from);
        if !self.square.as_ref().is_some_and(holds) {
            self.square = cells.square_at(to.x.units(), to.y.units());
        }
        let square = self.square.filter(holds);
        square.map_or(Answer::Unknown, |square| cells.ask(self.part.index(), square.known, ask))
    }
}
