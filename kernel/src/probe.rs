//! TRUSTED: coherent questions at one threshold, answered from the square where the last one was.

use crate::clear::{FreePoint, ProhibitedRegion};
use crate::exact::lattice::{Length, Point};
use crate::exact::predicate::Proximity;
use crate::exact::segment::Segment;
use crate::index::Cells;
use crate::index::cells::{Answer, Square};

/// A part and a threshold, and the square in which the last question was answered. What is known of a closed square holds
/// for every point in it and every motion with both ends in it, as squares are convex; anything else is looked up anew.
///
/// Without cells for the threshold ([`ProhibitedRegion::prepare`]) every question goes to the index.
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
        let answer = self.in_square(point, point).map_or(Answer::Unknown, |(cells, square)| {
            cells.ask_square(self.part.index(), &square, |edge| edge.near_point(point, self.threshold))
        });
        match answer {
            Answer::Clear => Proximity::Clear,
            Answer::Near(_) => Proximity::Near,
            Answer::Unknown => self.part.point_clear(point, self.threshold),
        }
    }

    /// As [`ProhibitedRegion::motion_clear`].
    #[must_use]
    #[inline]
    pub fn motion_clear(&mut self, motion: Segment) -> Proximity {
        let answer = self.in_square(motion.from, motion.to).map_or(Answer::Unknown, |(cells, square)| {
            cells.ask_square(self.part.index(), &square, |edge| edge.near_motion(motion, self.threshold))
        });
        match answer {
            Answer::Clear => Proximity::Clear,
            Answer::Near(_) => Proximity::Near,
            Answer::Unknown => self.part.motion_clear(motion, self.threshold),
        }
    }

    /// As [`ProhibitedRegion::motion`]: the end of a clear motion from a point that is free at the probe's threshold or more.
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

    /// The square that holds both points, if one does, found from the last one or anew.
    #[inline(always)]
    pub(crate) fn in_square(&mut self, from: Point, to: Point) -> Option<(&'a Cells, Square<'a>)> {
        let cells = self.cells?;
        if let Some(square) = self.square.filter(|square| square.holds(to) && square.holds(from)) {
            return Some((cells, square));
        }
        self.square = cells.square_at(to.x.units(), to.y.units());
        self.square.filter(|square| square.holds(from)).map(|square| (cells, square))
    }
}
