//! TRUSTED. The simplified outline of a part: one chord replaces a run of chords, with a chord error that
//! covers them.
//!
//! Implements SR-05.
//!
//! **Claim.** A shape that is clear of the simplified outline at a threshold is clear of the part at that
//! threshold, and on the same side. Every corner of a run was found within the tolerance of its chord. The
//! points near a segment form a convex set, so the chords of the run are within the tolerance too. The true
//! curve is within the tolerance plus its own chord error, and that sum is the chord error of the new chord.
//! Moving each point of a run straight onto its chord never leaves that neighbourhood. Every clear point lies
//! outside it. So the simplified ring winds around a clear point as often as the ring does.

use alloc::vec::Vec;

use crate::clear::ProhibitedRegion;
use crate::exact::lattice::Length;
use crate::exact::ring::Ring;
use crate::exact::segment::Segment;
use crate::index::{Edge, IndexFault, build};

/// Most edges of a run.
const RUN_MAX: usize = 512;

impl ProhibitedRegion {
    /// The same part with simplified outlines: one chord replaces each run of edges within `tolerance` of it.
    /// Answers are the same, except for shapes within twice the tolerance beyond the threshold: there the
    /// answer is "near".
    ///
    /// # Errors
    /// [`IndexFault::TooManyEdges`] above 2^30 edges.
    pub fn simplified(&self, tolerance: Length) -> Result<Self, IndexFault> {
        let mut edges = Vec::new();
        for ring in self.region().rings().iter().chain(self.zones()) {
            simplify(ring, tolerance, &mut edges);
        }
        Ok(self.with_index(build::build(edges)?))
    }
}

fn simplify(ring: &Ring, tolerance: Length, into: &mut Vec<Edge>) {
    let chords: Vec<Segment> = ring.segments().collect();
    let chord_errors = ring.chord_errors();
    // A ring keeps at least three chords.
    let longest = RUN_MAX.min(chords.len() / 3).max(1);
    let mut first = 0;
    while first < chords.len() {
        let left = longest.min(chords.len() - first);
        let mut count = 1;
        while count < left && covers(&chords[first..=first + count], tolerance) {
            count += 1;
        }
        let run = first..first + count;
        let chord_error = chord_errors[run.clone()].iter().copied().max().unwrap_or(Length::ZERO);
        let chord = Segment { from: chords[first].from, to: chords[first + count - 1].to };
        let chord_error = if count == 1 { chord_error } else { chord_error.saturating_plus(tolerance) };
        into.push(Edge { chord, chord_error });
        first += count;
    }
}

/// Whether every corner of the run is within the tolerance of the chord from its start to its end.
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
        // The chord lies on the corners at 0 or 1, and its chord error is one unit.
        assert!(part.free_point(at(50_000, -201), threshold).is_ok());
        assert!(simplified.free_point(at(50_000, -203), threshold).is_ok());
        assert!(simplified.free_point(at(50_000, -200), threshold).is_err());
        assert!(simplified.holds(at(50_000, 20_000)) && !simplified.holds(at(50_000, -20)));
    }
}
