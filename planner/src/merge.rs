//! Merging of motions: one line or arc replaces a run of short motions of the finishing toolpath.
//!
//! A run keeps both its ends. The line or arc between them comes nearer to the part than the run by at
//! most [`INWARD`], and lies farther out by at most [`OUTWARD`]. It is kept only when the kernel
//! certifies it.

use keepout_kernel::offset::certify_path;
use keepout_kernel::{ArcView, Curve, Length, ProhibitedRegion, Vec2};

use crate::chord::{Band, Chord};
use crate::finish::{FinishingLoop, FinishingPath};

/// Largest inward shift of a merged motion, nearer to the part than its run, lattice units (0.3 µm). It
/// is half of [`crate::finish::PATH_CLEARANCE`].
pub const INWARD: f64 = 30.0;
/// Largest outward shift of a merged motion, lattice units (0.6 µm). Together with the chord error of the
/// completeness check it is less than [`keepout_kernel::offset::BESIDE`].
pub const OUTWARD: f64 = 60.0;
/// Extra clearance of merged motions, lattice units. A controller may receive an arc in parts or chords,
/// and each of them begins with [`keepout_kernel::offset::PATH_CHORD_ERROR`] to spare, on the lattice.
const RESERVE: Length = Length::small(16);
/// Turn above which a joint of two motions is a corner, radians (3°). Corners stay.
const CORNER: f64 = 0.052;
/// A motion up to this length has no direction, lattice units (0.5 µm).
const POINT: f64 = 50.0;
/// A line longer than this never becomes part of an arc, lattice units (2 mm).
const LONG: f64 = 200_000.0;
/// Places of each motion, its start among them, beside which a merged motion must lie.
const PLACES: usize = 4;
/// Rounds that narrow the band while the number of motions stays the same.
const NARROWINGS: usize = 3;
/// Share of the inward bound for a second try, after the whole bound was refused.
const CAUTIOUS: f64 = 0.3;

/// The toolpath with runs of short motions merged. Motions whose merge cannot be certified at `threshold`
/// stay as they are.
#[must_use]
pub fn merged(path: &FinishingPath, part: &ProhibitedRegion, threshold: Length) -> FinishingPath {
    let threshold = threshold.saturating_plus(RESERVE);
    let is_clear = |curve: &Curve| certify_path(part, threshold, std::slice::from_ref(curve)).is_ok();
    let merge = |each: &FinishingLoop| FinishingLoop {
        curves: merged_loop(&each.curves, &is_clear),
        component: each.component,
    };
    FinishingPath { loops: path.loops.iter().map(merge).collect(), ..path.clone() }
}

/// A closed loop with the part on its left, with runs of motions merged where `is_clear` permits. It
/// never has more motions than before.
#[must_use]
pub fn merged_loop(curves: &[Curve], is_clear: &dyn Fn(&Curve) -> bool) -> Vec<Curve> {
    let turns = turns(curves);
    // The loop starts at its sharpest joint, so no run crosses that joint.
    let first = (0..curves.len()).max_by(|&a, &b| turns[a].total_cmp(&turns[b]).then(b.cmp(&a)));
    let first = first.unwrap_or(0);
    let mut turned = curves.to_vec();
    turned.rotate_left(first);
    let corners = (1..turned.len()).filter(|k| turns[(k + first) % turned.len()] > CORNER);
    let bounds: Vec<usize> = std::iter::once(0).chain(corners).chain([turned.len()]).collect();
    let runs = bounds.windows(2).map(|pair| Run::of(&turned[pair[0]..pair[1]]));
    let merged: Vec<Curve> = runs.flat_map(|run| run.merged(INWARD, is_clear)).collect();
    // A loop has at least two motions.
    if (2..curves.len()).contains(&merged.len()) { merged } else { curves.to_vec() }
}

/// Turn of the loop at the start of each curve, radians. A curve without a direction belongs to the
/// joint.
fn turns(curves: &[Curve]) -> Vec<f64> {
    let long = |curve: &&Curve| curve.length() > POINT;
    let mut before = curves.iter().rfind(long).map(|curve| directions(curve).1);
    let mut turns = Vec::with_capacity(curves.len());
    for (index, curve) in curves.iter().enumerate().filter(|(_, curve)| long(curve)) {
        let (begin, end) = directions(curve);
        let turn = before.map_or(0.0, |before| before.cross(begin).atan2(before.dot(begin)).abs());
        turns.resize(index + 1, turn);
        before = Some(end);
    }
    // Such curves at the end of the loop belong to the joint at its start.
    turns.resize(curves.len(), turns.first().copied().unwrap_or(0.0));
    turns
}

/// Directions of a curve at its start and its end, not normalised.
fn directions(curve: &Curve) -> (Vec2, Vec2) {
    let (from, to) = (Vec2::from(curve.from()), Vec2::from(curve.to()));
    match curve {
        Curve::Line(_) => (to - from, to - from),
        Curve::Arc(arc) => {
            let arc = ArcView::of(arc);
            (arc.direction_beside(from), arc.direction_beside(to))
        }
    }
}

/// A run: motions without a corner between them.
struct Run<'a> {
    curves: &'a [Curve],
    /// [`PLACES`] places of each motion, and the end of the last.
    places: Vec<Vec2>,
}

/// A motion, and the number of motions that it replaces: 1 for a motion that stays.
type Merged = (Curve, usize);

impl<'a> Run<'a> {
    fn of(curves: &'a [Curve]) -> Self {
        let mut places = Vec::with_capacity(curves.len() * PLACES + 1);
        for curve in curves {
            push_places(curve, &mut places);
        }
        places.extend(curves.last().map(|last| Vec2::from(last.to())));
        Self { curves, places }
    }

    /// The run in few motions, with an even distance to it. A motion that is not clear is merged again
    /// within a narrower band, or stays.
    fn merged(&self, inward: f64, is_clear: &dyn Fn(&Curve) -> bool) -> Vec<Curve> {
        let mut first = 0;
        let mut result = Vec::with_capacity(self.curves.len());
        for (curve, count) in self.fewest(Band { left: OUTWARD, right: inward }) {
            let replaced = &self.curves[first..first + count];
            if count == 1 || is_clear(&curve) {
                result.push(curve);
            } else if inward == INWARD {
                result.extend(Run::of(replaced).merged(inward * CAUTIOUS, is_clear));
            } else {
                result.extend(replaced);
            }
            first += count;
        }
        result
    }

    /// The fewest motions found within the band, and of these the ones nearest to the run.
    fn fewest(&self, band: Band) -> Vec<Merged> {
        let mut best = self.greedy(band);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..NARROWINGS {
            if best.len() == self.curves.len() {
                break;
            }
            let share = f64::midpoint(low, high);
            let tried = self.greedy(Band { left: band.left * share, right: band.right * share });
            if tried.len() <= best.len() {
                (best, high) = (tried, share);
            } else {
                low = share;
            }
        }
        best
    }

    /// The longest merged motions, one after the other.
    fn greedy(&self, band: Band) -> Vec<Merged> {
        let mut merged = Vec::new();
        let mut first = 0;
        while first < self.curves.len() {
            let longest = self.longest(first, band);
            merged.push(longest);
            first += longest.1;
        }
        merged
    }

    /// The motion that replaces the most motions from `first` on. The search doubles the number while it
    /// succeeds, then bisects.
    fn longest(&self, first: usize, band: Band) -> Merged {
        let left = self.curves.len() - first;
        let single = |count| Some((self.single(first, count, band)?, count));
        // A short middle motion can hide that three motions are one.
        let found = (2..=left.min(3)).find_map(single);
        let Some(mut best) = found else { return (self.curves[first], 1) };
        let mut beyond = left + 1;
        while best.1 + 1 < beyond {
            let tried = if beyond > left { left.min(2 * best.1) } else { best.1.midpoint(beyond) };
            match single(tried) {
                Some(found) => best = found,
                None => beyond = tried,
            }
        }
        best
    }

    /// One motion that replaces `count` motions from `first` on.
    fn single(&self, first: usize, count: usize, band: Band) -> Option<Curve> {
        let replaced = &self.curves[first..first + count];
        let places = &self.places[first * PLACES..=(first + count) * PLACES];
        let chord = Chord::between(replaced[0].from(), replaced[count - 1].to())?;
        let curve = chord.curve_beside(places, band)?;
        let is_line = |curve: &Curve| matches!(curve, Curve::Line(_));
        let bent = !is_line(&curve) && replaced.iter().any(|each| is_line(each) && each.length() > LONG);
        (!bent).then_some(curve)
    }
}

fn push_places(curve: &Curve, places: &mut Vec<Vec2>) {
    let (from, to) = (Vec2::from(curve.from()), Vec2::from(curve.to()));
    places.push(from);
    let between = [0.25, 0.5, 0.75].into_iter();
    match curve {
        Curve::Line(_) => {
            places.extend(between.map(|t| from + (to - from) * t));
        }
        Curve::Arc(arc) => {
            let arc = ArcView::of(arc);
            places.extend(between.map(|t| arc.at(t)));
        }
    }
}
