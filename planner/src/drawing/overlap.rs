//! Merges lines that overlap in part, at places where a contour can not be followed otherwise.

use std::collections::{BTreeMap, HashSet};

use keepout_kernel::{Point, Vec2};

use super::Repair;
use super::chain::{Bend, End, Piece, remove};
use super::join::{EndIndex, Joiner, LineIndex, ROUNDING, distance, distance_mm};

/// Largest number of lines that are compared at one end in a round.
const NEAR_MAX: usize = 256;
/// Rounds of merging: a merged line can reveal another overlap.
const ROUNDS: usize = 3;

/// Merges straight pieces that overlap on one line, at loose or crowded ends. Closed contours that lie on
/// each other stay unchanged; the check of contours reports them.
pub(super) fn merge(joiner: &mut Joiner, repairs: &mut Vec<Repair>) {
    for _ in 0..ROUNDS {
        let groups = overlapping(joiner);
        if groups.is_empty() {
            return;
        }
        let Some(loose) = EndIndex::of(joiner, joiner.loose()) else { return };
        let mut gone = HashSet::new();
        let mut made = Vec::new();
        for group in &groups {
            let (whole, own): (Vec<usize>, Vec<usize>) = group.iter().partition(|&&i| joiner.pieces[i].whole);
            if whole.is_empty() {
                let group = on_one_line(joiner, group);
                made.extend(merged(joiner, &group, &loose, repairs));
                gone.extend(group);
            } else {
                gone.extend(own.into_iter().filter(|&i| lies_on(joiner, i, &whole, repairs)));
            }
        }
        if gone.is_empty() {
            return;
        }
        remove(&mut joiner.pieces, &gone);
        joiner.pieces.extend(made);
        joiner.coincident();
    }
}

/// Whether a piece lies on one of the given pieces of closed contours, and is therefore superfluous. Adds the
/// repair; the contours stay unchanged.
fn lies_on(joiner: &Joiner, i: usize, whole: &[usize], repairs: &mut Vec<Repair>) -> bool {
    let piece = &joiner.pieces[i];
    let covers = |&j: &usize| {
        let line = Line::of(&joiner.pieces[j]);
        [piece.from, piece.to].iter().all(|&p| {
            let t = line.along(p);
            line.off(p) <= ROUNDING && t >= -ROUNDING && t <= line.length + ROUNDING
        })
    };
    let covered = whole.iter().any(covers);
    if covered {
        repairs.push(Repair::OverlapMerged { at: piece.from, length_mm: piece.length_mm(), count: 2 });
    }
    covered
}

/// Groups of straight pieces that overlap, found at loose and crowded ends.
fn overlapping(joiner: &Joiner) -> Vec<Vec<usize>> {
    let loose = joiner.loose();
    if loose.is_empty() {
        return Vec::new();
    }
    let Some(lines) = LineIndex::of(&joiner.pieces) else { return Vec::new() };
    let mut leader: BTreeMap<usize, usize> = BTreeMap::new();
    for &end in &loose {
        let i = end.0;
        for j in lines.near(joiner.at(end), ROUNDING, NEAR_MAX) {
            if i != j && overlap(&joiner.pieces[i], &joiner.pieces[j]) {
                let (a, b) = (led_by(&leader, i), led_by(&leader, j));
                let first = a.min(b);
                [i, j, a, b].into_iter().for_each(|each| _ = leader.insert(each, first));
            }
        }
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &i in leader.keys() {
        groups.entry(led_by(&leader, i)).or_default().push(i);
    }
    groups.into_values().filter(|group| group.len() > 1).collect()
}

fn led_by(leader: &BTreeMap<usize, usize>, mut i: usize) -> usize {
    while let Some(&up) = leader.get(&i) {
        if up == i {
            break;
        }
        i = up;
    }
    i
}

/// The members of a group that one line can replace: the line from their first to their last end is within
/// rounding of each.
///
/// If not all members fit, the result is a run without a gap along the longest member. It is empty if only
/// the longest fits. Neighbours in a group overlap, but a piece need not be near the line of every other
/// member.
fn on_one_line(joiner: &Joiner, group: &[usize]) -> Vec<usize> {
    let off = |line: &Line, i: usize| {
        let piece = &joiner.pieces[i];
        line.off(piece.from).max(line.off(piece.to))
    };
    let is_one = |group: &[usize]| {
        span(joiner, group).is_some_and(|(first, last)| {
            let whole = Line::between(first, last);
            group.iter().all(|&i| off(&whole, i) <= ROUNDING)
        })
    };
    if is_one(group) {
        return group.to_vec();
    }
    let Some(longest) = longest(joiner, group).map(Line::of) else { return Vec::new() };
    // Pieces within half the rounding of one line are within the rounding of a line between any two of
    // their ends.
    let runs = [ROUNDING, ROUNDING / 2.0].map(|within| {
        let near = group.iter().copied().filter(|&i| off(&longest, i) <= within).collect();
        run_of(joiner, &longest, near)
    });
    runs.into_iter().find(|run| is_one(run)).filter(|run| run.len() > 1).unwrap_or_default()
}

/// Of pieces along a line, the run that covers the whole line and continues without a gap.
fn run_of(joiner: &Joiner, line: &Line, mut group: Vec<usize>) -> Vec<usize> {
    let ends = |i: usize| {
        let piece = &joiner.pieces[i];
        let (a, b) = (line.along(piece.from), line.along(piece.to));
        (a.min(b), a.max(b))
    };
    group.sort_by(|&i, &j| ends(i).0.total_cmp(&ends(j).0));
    let (mut run, mut covered) = (Vec::new(), f64::NEG_INFINITY);
    for i in group {
        let (first, last) = ends(i);
        if first > covered + ROUNDING {
            if covered >= line.length - ROUNDING {
                break;
            }
            run.clear();
        }
        run.push(i);
        covered = covered.max(last);
    }
    run
}

/// The longest straight piece of a group.
fn longest<'a>(joiner: &'a Joiner, group: &[usize]) -> Option<&'a Piece> {
    let pieces = group.iter().map(|&i| &joiner.pieces[i]);
    pieces.max_by(|a, b| distance(a.from, a.to).total_cmp(&distance(b.from, b.to)))
}

/// The first and the last end of a group, along its longest piece.
fn span(joiner: &Joiner, group: &[usize]) -> Option<(Point, Point)> {
    let line = Line::of(longest(joiner, group)?);
    let ends = || group.iter().flat_map(|&i| [joiner.pieces[i].from, joiner.pieces[i].to]);
    let by_way = |p: &Point, q: &Point| line.along(*p).total_cmp(&line.along(*q));
    Some((ends().min_by(by_way)?, ends().max_by(by_way)?))
}

/// Whether two straight pieces lie on one line and share more than a point of it.
fn overlap(one: &Piece, other: &Piece) -> bool {
    let straight = |piece: &Piece| matches!(piece.bend, Bend::Straight);
    if !straight(one) || !straight(other) {
        return false;
    }
    let (long, short) = if distance(one.from, one.to) >= distance(other.from, other.to) {
        (one, other)
    } else {
        (other, one)
    };
    let line = Line::of(long);
    if [short.from, short.to].iter().any(|&p| line.off(p) > ROUNDING) {
        return false;
    }
    let (a, b) = (line.along(short.from), line.along(short.to));
    a.max(b).min(line.length) - a.min(b).max(0.0) > ROUNDING
}

struct Line {
    from: Vec2,
    direction: Vec2,
    length: f64,
}

impl Line {
    fn of(piece: &Piece) -> Self {
        Self::between(piece.from, piece.to)
    }

    fn between(from: Point, to: Point) -> Self {
        let (a, b) = (Vec2::from(from), Vec2::from(to));
        let length = a.distance(b);
        Self { from: a, direction: (b - a) / length, length }
    }

    fn along(&self, p: Point) -> f64 {
        (Vec2::from(p) - self.from).dot(self.direction)
    }

    fn off(&self, p: Point) -> f64 {
        self.direction.cross(Vec2::from(p) - self.from).abs()
    }
}

/// The lines that replace a group, split where other pieces end on them.
fn merged(joiner: &Joiner, group: &[usize], loose: &EndIndex, repairs: &mut Vec<Repair>) -> Vec<Piece> {
    let (Some(longest), Some((first, last))) = (longest(joiner, group), span(joiner, group)) else {
        return Vec::new();
    };
    let line = Line::between(first, last);
    repairs.push(Repair::OverlapMerged {
        at: first,
        length_mm: distance_mm(first, last),
        count: group.len(),
    });
    // Other pieces that end on the line split it there.
    let on_it = |&end: &End| {
        let p = joiner.at(end);
        let t = line.along(p);
        line.off(p) <= ROUNDING && t > ROUNDING && t < line.length - ROUNDING
    };
    let members: HashSet<usize> = group.iter().copied().collect();
    let joined = group.iter().flat_map(|&i| joiner.pieces[i].joined).flatten();
    let others = joined.chain(loose.between(first, last)).filter(on_it).filter(|(i, _)| !members.contains(i));
    let mut cuts: Vec<Point> = others.map(|end| joiner.at(end)).collect();
    cuts.sort_by(|&p, &q| line.along(p).total_cmp(&line.along(q)));
    cuts.dedup();
    let from = std::iter::once(first).chain(cuts.iter().copied());
    let to = cuts.iter().copied().chain([last]);
    let origin = longest.origin;
    let piece =
        |(from, to)| Piece { from, to, bend: Bend::Straight, origin, whole: false, joined: [None; 2] };
    from.zip(to).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::fmt::Write as _;

    use super::super::{CURVE_MM, EntityFilter, JOIN_MM, chain, import};

    /// A slot of lines, with half circles of radius `r` at its ends. Each line begins a little before the
    /// previous line ends. One side is open from x = 40 to 60 mm.
    fn open_slot(r: f64) -> String {
        let mut corners = vec![(40.0, 0.0), (0.0, 0.0)];
        let count = 1200_u16;
        let half = |corners: &mut Vec<(f64, f64)>, x: f64, begin: f64| {
            corners.extend((1..=count).map(|k| {
                let angle = begin - PI * f64::from(k) / f64::from(count);
                (x + r * angle.cos(), r + r * angle.sin())
            }));
        };
        half(&mut corners, 0.0, -PI / 2.0);
        corners.extend([25.0, 50.0, 75.0].map(|x| (x, 2.0 * r)));
        half(&mut corners, 75.0, PI / 2.0);
        corners.push((60.0, 0.0));
        let mut text =
            "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n".to_owned();
        let last = corners.len() - 2;
        for (k, pair) in corners.windows(2).enumerate() {
            let ((a, b), (c, d)) = (pair[0], pair[1]);
            let length = (c - a).hypot(d - b);
            let (x, y) = ((c - a) / length * 3e-4, (d - b) / length * 3e-4);
            let (before, behind) = (f64::from(u8::from(k > 0)), f64::from(u8::from(k < last)));
            let (a, b, c, d) = (a - x * before, b - y * before, c + x * behind, d + y * behind);
            write!(text, "0\nLINE\n8\n0\n10\n{a:.7}\n20\n{b:.7}\n11\n{c:.7}\n21\n{d:.7}\n").unwrap();
        }
        text + "0\nENDSEC\n0\nEOF\n"
    }

    /// Two lines far apart on one straight line are not merged, although a chain of lines joins them.
    #[test]
    fn opening_of_a_slot_stays_open() {
        let drawing = import(open_slot(10.0).as_bytes(), &EntityFilter::default()).unwrap();
        let chained = chain(&drawing, JOIN_MM, CURVE_MM).unwrap();
        assert!(chained.profile.loops.is_empty(), "{:?}", chained.profile);
        assert!(!chained.problems.is_empty());
    }
}
