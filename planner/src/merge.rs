//! Fewer, longer motions: a run of short motions of a finishing path becomes one line or arc.
//!
//! A run keeps both its ends. The line or arc between them comes nearer to the part than the run by [`INWARD`] at most, lies
//! farther out by [`OUTWARD`] at most, and is kept only when the kernel certifies it.

use keepout_kernel::curve::{angle, radius, sweep, xy};
use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, Length, ProhibitedRegion, Turn};

use crate::chord::{Band, Chord, Xy, cross, dot, minus};
use crate::finish::{FinishingLoop, FinishingPath};

/// The most by which a merged motion comes nearer to the part than the run that it replaces, lattice units (0.3 µm): half of
/// what [`crate::finish::PATH_CLEARANCE`] adds to the path's distance.
pub const INWARD: f64 = 30.0;
/// The most by which it lies farther out, lattice units (0.6 µm): with the chord_error of the chords by which a path is checked
/// for completeness this is less than [`keepout_kernel::offset::BESIDE`].
pub const OUTWARD: f64 = 60.0;
/// Merged motions keep so much more than the threshold, lattice units: where a controller is sent parts or chords of an arc, each
/// of these begins with [`keepout_kernel::offset::PATH_CHORD_ERROR`] to spare, on the lattice.
const RESERVE: Length = Length::small(16);
/// Where motions turn by more than this, radians (3°), the path has a corner, which stays.
const CORNER: f64 = 0.052;
/// Motions not longer than this have no direction, lattice units (0.5 µm).
const POINT: f64 = 50.0;
/// A line longer than this stays a line, lattice units (2 mm).
const LONG: f64 = 200_000.0;
/// Places of each motion beside which a merged one is sought, its beginning among them.
const PLACES: usize = 4;
/// Rounds in which the bounds are narrowed as long as the number of motions stays.
const NARROWINGS: usize = 3;
/// Share of the inward bound that is tried where the whole one was refused.
const CAUTIOUS: f64 = 0.3;

/// The path with runs of short motions merged. What can not be certified at `threshold` stays as it is.
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

/// A closed loop, the part on its left, with runs of its motions merged where `is_clear` permits; never more motions than
/// before.
#[must_use]
pub fn merged_loop(curves: &[Curve], is_clear: &dyn Fn(&Curve) -> bool) -> Vec<Curve> {
    let turns = turns(curves);
    // It begins at its sharpest joint: no run goes over that.
    let first = (0..curves.len()).max_by(|&a, &b| turns[a].total_cmp(&turns[b]).then(b.cmp(&a)));
    let first = first.unwrap_or(0);
    let mut turned = curves.to_vec();
    turned.rotate_left(first);
    let corners = (1..turned.len()).filter(|k| turns[(k + first) % turned.len()] > CORNER);
    let bounds: Vec<usize> = std::iter::once(0).chain(corners).chain([turned.len()]).collect();
    let runs = bounds.windows(2).map(|pair| Run::of(&turned[pair[0]..pair[1]]));
    let merged: Vec<Curve> = runs.flat_map(|run| run.merged(INWARD, is_clear)).collect();
    // A loop has two motions at least.
    if (2..curves.len()).contains(&merged.len()) { merged } else { curves.to_vec() }
}

/// How far the loop turns at the beginning of each curve, radians. Curves without a direction belong to the joint.
fn turns(curves: &[Curve]) -> Vec<f64> {
    let long = |curve: &&Curve| curve.length() > POINT;
    let mut before = curves.iter().rfind(long).map(|curve| directions(curve).1);
    let mut turns = Vec::with_capacity(curves.len());
    for (index, curve) in curves.iter().enumerate().filter(|(_, curve)| long(curve)) {
        let (begin, end) = directions(curve);
        let turn = before.map_or(0.0, |before| cross(before, begin).atan2(dot(before, begin)).abs());
        turns.resize(index + 1, turn);
        before = Some(end);
    }
    // Those at the end of the loop belong to the joint at its beginning.
    turns.resize(curves.len(), turns.first().copied().unwrap_or(0.0));
    turns
}

/// The directions of a curve at its beginning and its end, of any length.
fn directions(curve: &Curve) -> (Xy, Xy) {
    let (from, to) = (xy(curve.from()), xy(curve.to()));
    match curve {
        Curve::Line(_) => (minus(to, from), minus(to, from)),
        Curve::Arc(arc) => {
            let sign = turn_sign(arc.turn());
            let tangent = |p: Xy| {
                let (x, y) = minus(p, xy(arc.centre()));
                (-y * sign, x * sign)
            };
            (tangent(from), tangent(to))
        }
    }
}

fn turn_sign(turn: Turn) -> f64 {
    if turn == Turn::CounterClockwise { 1.0 } else { -1.0 }
}

/// Motions without a corner between them.
struct Run<'a> {
    curves: &'a [Curve],
    /// [`PLACES`] places of each motion, and the end of the last.
    places: Vec<Xy>,
}

/// A motion, and how many of a run it takes the place of: one that stays, of itself.
type Merged = (Curve, usize);

impl<'a> Run<'a> {
    fn of(curves: &'a [Curve]) -> Self {
        let mut places = Vec::with_capacity(curves.len() * PLACES + 1);
        for curve in curves {
            push_places(curve, &mut places);
        }
        places.extend(curves.last().map(|last| xy(last.to())));
        Self { curves, places }
    }

    /// The run in as few motions as are found, evenly near to it. What is not clear is merged with more care, or stays.
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

    /// As few motions as are found within the band, and of these the nearest to the run.
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

    /// The motion in place of the most from `first` on: their number is doubled as long as there is one, then bisected.
    fn longest(&self, first: usize, band: Band) -> Merged {
        let left = self.curves.len() - first;
        let single = |count| Some((self.single(first, count, band)?, count));
        // A short motion between two can hide that all three are one.
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

    /// One motion in place of `count` from `first` on.
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

fn push_places(curve: &Curve, places: &mut Vec<Xy>) {
    let (from, to) = (xy(curve.from()), xy(curve.to()));
    places.push(from);
    let between = [0.25, 0.5, 0.75].into_iter();
    match curve {
        Curve::Line(_) => {
            let (dx, dy) = minus(to, from);
            places.extend(between.map(|t| (from.0 + dx * t, from.1 + dy * t)));
        }
        Curve::Arc(arc) => {
            let (begin, turn) = (angle(arc.centre(), arc.from()), turn_sign(arc.turn()) * sweep(arc));
            let (centre, radius) = (xy(arc.centre()), radius(arc));
            places.extend(between.map(|t| {
                let (sine, cosine) = (begin + turn * t).sin_cos();
                (centre.0 + radius * cosine, centre.1 + radius * sine)
            }));
        }
    }
}
