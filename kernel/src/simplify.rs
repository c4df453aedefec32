//! TRUSTED. A part with fewer edges: runs of chords under one chord, with a chord_error that covers them.
//!
//! **Claim.** What is clear of the simplified part at a threshold is clear of the part at it, and on the same side.
//! Every corner of a run was found within the tolerance of its chord. What is near a segment is convex, so the run's chords
//! are within the tolerance too, and the true curve within the tolerance and its own chord_error: that sum is the chord's chord_error.
//! Moving each point of a run straight onto its chord never leaves that neighbourhood; so a point outside it, as every clear
//! point is, is wound around as often by the simplified ring as by the ring.

use alloc::vec::Vec;

use crate::clear::ProhibitedRegion;
use crate::exact::lattice::Length;
use crate::exact::ring::Ring;
use crate::exact::segment::Segment;
use crate::index::{Edge, IndexFault, build};

/// Most edges under one chord.
const RUN_MAX: usize = 512;

impl ProhibitedRegion {
    /// The same part with runs of edges that keep within `tolerance` of a chord under that chord. Answers are the same but
    /// for what is within twice the tolerance of a threshold: there they are "near".
    ///
    /// # Errors
    /// [`IndexFault::TooManyEdges`] as for the part itself.
    pub fn simplified(&self, tolerance: Length) -> Result<Self, IndexFault> {
        let mut edges = Vec::new();
        for ring in self.region().rings().iter().chain(self.zones()) {
            coarsen(ring, tolerance, &mut edges);
        }
        Ok(self.with_index(build::build(edges)?))
    }
}

fn coarsen(ring: &Ring, tolerance: Length, into: &mut Vec<Edge>) {
    let chords: Vec<Segment> = ring.segments().collect();
    let slacks = ring.slacks();
    // A ring is never less than three chords.
    let longest = RUN_MAX.min(chords.len() / 3).max(1);
    let mut first = 0;
    while first < chords.len() {
        let left = longest.min(chords.len() - first);
        let mut count = 1;
        while count < left && covers(&chords[first..=first + count], tolerance) {
            count += 1;
        }
        let run = first..first + count;
        let chord_error = slacks[run.clone()].iter().copied().max().unwrap_or(Length::ZERO);
        let chord = Segment { from: chords[first].from, to: chords[first + count - 1].to };
        let chord_error = if count == 1 { chord_error } else { chord_error.saturating_plus(tolerance) };
        into.push(Edge { chord, chord_error });
        first += count;
    }
}

/// Whether every corner of the run is within the tolerance of the chord from its beginning to its end.
fn covers(run: &[Segment], tolerance: Length) -> bool {
    let (Some(first), Some(last)) = (run.first(), run.last()) else { return false };
    let chord = Segment { from: first.from, to: last.to };
    chord.from != chord.to && run.iter().all(|each| !chord.near_point(each.to, tolerance).is_clear())
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;
    use crate::{Point, Region, Side};

    #[test]
    fn straight_runs_become_one_chord_and_corners_stay() {
        let at = |x: i64, y: i64| Point::from_units(x, y).unwrap();
        let mut corners = Vec::new();
        for k in 0..100 {
            corners.push(at(k * 1000, k % 2));
        }
        corners.extend([at(100_000, 0), at(100_000, 50_000), at(0, 50_000)]);
        let ring = Ring::new(corners).unwrap();
        let part = ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap();
        let simplified = part.simplified(Length::small(1)).unwrap();
        assert!(simplified.edges().len() <= 8, "{}", simplified.edges().len());
        assert_eq!(part.simplified(Length::ZERO).unwrap().edges().len(), part.edges().len());
        let threshold = Length::small(200);
        // The chord lies on the corners at 0 or 1, and its chord_error is a unit.
        assert!(part.free_point(at(50_000, -201), threshold).is_ok());
        assert!(simplified.free_point(at(50_000, -203), threshold).is_ok());
        assert!(simplified.free_point(at(50_000, -200), threshold).is_err());
        assert!(simplified.holds(at(50_000, 20_000)) && !simplified.holds(at(50_000, -20)));
    }
}
