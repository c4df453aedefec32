//! The places on the path that are nearest to the predicted positions.

use super::HORIZON;
use crate::Axes;
use crate::path::{Foot, left_of};
use crate::plant::MOST_DELAY;
use crate::reference::{ReferenceSample, ReferenceWindow};

/// Largest number of pieces of the path in the search.
const MOST_PIECES: usize = 2 * HORIZON + MOST_DELAY + 2;

/// The distance `along` the piece of `sample`. On a full circle, it is shifted by whole turns to the value
/// nearest to the reference.
fn around(sample: &ReferenceSample, along: f64) -> f64 {
    let length = sample.piece.length();
    let off = along - (sample.along - sample.begins);
    let turns = if sample.piece.is_closed() { (off / length).round() } else { 0.0 };
    along - turns * length
}

/// The nearest point of the path to a predicted position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) expected: Axes,
    pub(super) point: Axes,
    /// Unit vector from the point to the predicted position, or across the path.
    pub(super) normal: Axes,
    pub(super) tangent: Axes,
    /// Distance from the start of the path, pulses.
    pub(super) along: f64,
    pub(super) number: usize,
}

/// The pieces of the path around the current sample of the reference.
pub(super) struct Pieces {
    pieces: [Option<ReferenceSample>; MOST_PIECES],
    oldest: ReferenceSample,
}

impl Pieces {
    pub(super) fn around(window: &ReferenceWindow) -> Self {
        let mut pieces = [None; MOST_PIECES];
        let (mut found, mut last) = (0, None);
        for i in 0..=2 * HORIZON + MOST_DELAY {
            #[expect(clippy::cast_possible_wrap, reason = "at most twice the horizon and the longest delay")]
            let sample = window.ahead(i as isize - HORIZON as isize);
            if last != Some(sample.number) && found < MOST_PIECES {
                pieces[found] = Some(*sample);
                (found, last) = (found + 1, Some(sample.number));
            }
        }
        #[expect(clippy::cast_possible_wrap, reason = "the horizon")]
        let oldest = *window.ahead(-(HORIZON as isize));
        Self { pieces, oldest }
    }

    /// The nearest point to `expected` on the pieces with these numbers. At equal distances, the later one.
    pub(super) fn nearest(&self, expected: Axes, numbers: std::ops::RangeInclusive<usize>) -> Place {
        let found = self.pieces.iter().map_while(Option::as_ref);
        let allowed = found.filter(|sample| numbers.contains(&sample.number));
        let feet = allowed.map(|sample| (sample, sample.piece.nearest(expected)));
        let distance_2 = |foot: &Foot| (foot.point - expected).norm_squared();
        let best =
            feet.reduce(|best, next| if distance_2(&next.1) <= distance_2(&best.1) { next } else { best });
        // A tool far behind may need a piece that is no longer in the list. Then use the oldest piece.
        let oldest = self.oldest;
        let (sample, Foot { point, tangent, .. }) = best.unwrap_or((&oldest, oldest.piece.nearest(expected)));
        let off = expected - point;
        // Past a corner, the normal points from the corner to the position.
        let beside = off.dot(&tangent).abs() <= 1e-3 * off.norm();
        let normal = if beside || off.norm() < 1e-3 { left_of(tangent) } else { off.normalize() };
        let along = sample.begins + around(sample, sample.piece.along(expected));
        Place { expected, point, normal, tangent, along, number: sample.number }
    }
}
