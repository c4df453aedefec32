//! Joins the ends of pieces: first the ends that coincide, then the ends with a small gap between them.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::ops::ControlFlow;

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::{CheckedIndex, Edge, build};
use keepout_kernel::{Length, Point, Segment, UNITS_PER_MM, Vec2};

use super::chain::{Bend, End, Piece, remove};
use super::{Origin, Problem, Repair};
use crate::units::{length_up_from_mm, point_from_mm, point_mm};

/// Largest gap that counts as rounding, in lattice units (0.1 µm). It is closed without a note.
pub(super) const ROUNDING: f64 = 10.0;
/// Number of nearest loose ends that are candidates for the other side of a gap.
const CANDIDATES: usize = 8;
/// A chain may close on itself if it is at least this many times as long as the gap between its ends.
const LONG: f64 = 8.0;
/// The pieces, and the joints found so far.
pub(super) struct Joiner {
    pub pieces: Vec<Piece>,
    /// Places where more than two loose ends coincide.
    pub crowded: Vec<Vec<End>>,
    reach: f64,
}

impl Joiner {
    pub fn new(pieces: Vec<Piece>, join_mm: f64) -> Self {
        let reach = (join_mm.max(0.0) * f64::from(UNITS_PER_MM)).max(ROUNDING);
        Self { pieces, crowded: Vec::new(), reach }
    }

    /// Ends without a joint.
    pub fn loose(&self) -> Vec<End> {
        let ends = (0..self.pieces.len()).flat_map(|i| [(i, 0), (i, 1)]);
        ends.filter(|&(i, which)| self.pieces[i].joined[which].is_none()).collect()
    }

    fn crowded_ends(&self) -> HashSet<End> {
        self.crowded.iter().flatten().copied().collect()
    }

    /// Loose ends that coincide with no other end.
    fn alone(&self) -> Vec<End> {
        let crowded = self.crowded_ends();
        self.loose().into_iter().filter(|end| !crowded.contains(end)).collect()
    }

    pub fn at(&self, (piece, which): End) -> Point {
        self.pieces[piece].end(which)
    }

    fn join(&mut self, a: End, b: End) {
        self.pieces[a.0].joined[a.1] = Some(b);
        self.pieces[b.0].joined[b.1] = Some(a);
    }

    /// Joins pairs of loose ends that coincide up to rounding. Groups of more than two go to `crowded`.
    pub fn coincident(&mut self) {
        self.crowded.clear();
        let mut ends = self.loose();
        ends.sort_by_key(|&end| self.at(end));
        // Most ends meet exactly, at one lattice point.
        let mut first = 0;
        let mut rest: Vec<Vec<End>> = Vec::new();
        while first < ends.len() {
            let same = ends[first..].iter().take_while(|&&end| self.at(end) == self.at(ends[first])).count();
            match ends[first..first + same] {
                [a, b] => self.join(a, b),
                ref others => rest.push(others.to_vec()),
            }
            first += same;
        }
        let points: Vec<Point> = rest.iter().map(|same| self.at(same[0])).collect();
        for group in groups_within(&points, ROUNDING) {
            let mut ends: Vec<End> = group.into_iter().flat_map(|i| rest[i].iter().copied()).collect();
            match ends[..] {
                [_] => {}
                [a, b] => {
                    self.meet(a, b);
                }
                _ => {
                    ends.sort_unstable();
                    self.crowded.push(ends);
                }
            }
        }
    }

    /// Joins two ends at the midpoint between them.
    fn meet(&mut self, a: End, b: End) -> Point {
        let (p, q) = (point_mm(self.at(a)), point_mm(self.at(b)));
        let middle = point_from_mm(p.midpoint(q)).unwrap_or(self.at(a));
        for (piece, which) in [a, b] {
            let piece = &mut self.pieces[piece];
            if which == 0 { piece.from = middle } else { piece.to = middle }
        }
        self.join(a, b);
        middle
    }

    /// Drops pieces without joints that are no longer than rounding: their neighbours meet without them.
    pub fn drop_specks(&mut self, repairs: &mut Vec<Repair>) {
        let rounding_mm = ROUNDING / f64::from(UNITS_PER_MM);
        let speck = |piece: &Piece| piece.joined == [None; 2] && piece.length_mm() <= rounding_mm;
        self.drop(repairs, |joiner, i| speck(&joiner.pieces[i]));
    }

    /// Drops straight pieces no longer than the reach that stand alone, or hang on a crowded place by one
    /// end. There is one pass: a piece that only this pass makes loose stays, and is reported as open.
    pub fn drop_tiny(&mut self, repairs: &mut Vec<Repair>) {
        let reach_mm = self.reach / f64::from(UNITS_PER_MM);
        let crowded = self.crowded_ends();
        let dangles = |piece: &Piece, i: usize| {
            let alone = |which: usize| piece.joined[which].is_none() && !crowded.contains(&(i, which));
            let held = |which: usize| crowded.contains(&(i, which));
            alone(0) && (alone(1) || held(1)) || alone(1) && held(0)
        };
        self.drop(repairs, |joiner, i| {
            let piece = &joiner.pieces[i];
            matches!(piece.bend, Bend::Straight) && dangles(piece, i) && piece.length_mm() <= reach_mm
        });
    }

    fn drop(&mut self, repairs: &mut Vec<Repair>, is_dropped: impl Fn(&Self, usize) -> bool) {
        let gone: HashSet<usize> = (0..self.pieces.len()).filter(|&i| is_dropped(self, i)).collect();
        if gone.is_empty() {
            return;
        }
        let mut dropped: Vec<usize> = gone.iter().copied().collect();
        dropped.sort_unstable();
        for i in dropped {
            let piece = &self.pieces[i];
            repairs.push(Repair::TinyDropped { at: piece.from, length_mm: piece.length_mm() });
        }
        remove(&mut self.pieces, &gone);
        self.coincident();
    }

    /// The other end of the chain that begins at a loose end, and the length of the chain, mm.
    fn other_end(&self, loose: End) -> (End, f64) {
        let (mut at, mut length_mm) = (loose, 0.0);
        loop {
            let piece = &self.pieces[at.0];
            length_mm += piece.length_mm();
            let end = (at.0, 1 - at.1);
            match piece.joined[end.1] {
                Some(next) => at = next,
                None => return (end, length_mm),
            }
        }
    }

    /// Joins loose ends that are within reach of each other, the nearest first.
    pub fn close_gaps(&mut self, repairs: &mut Vec<Repair>) {
        let ends = self.alone();
        let points: Vec<Point> = ends.iter().map(|&end| self.at(end)).collect();
        let mut pairs = BinaryHeap::new();
        let grid = Grid::of(&points, self.reach);
        for i in 0..points.len() {
            // A chain is not bent onto its own end, unless it is long and so almost closes by itself.
            let (far, length_mm) = self.other_end(ends[i]);
            let own = |j: usize| ends[j] == far && length_mm < LONG * distance_mm(points[i], points[j]);
            let mut near: Vec<(i64, usize)> = Vec::new();
            grid.near(&points, i, |j| {
                if !own(j) {
                    near.push((nearest_unit(distance(points[i], points[j]) * 16.0), j));
                }
            });
            near.sort_unstable();
            pairs.extend(near.into_iter().take(CANDIDATES).map(|(gap, j)| Reverse((gap, i, j))));
        }
        let mut taken = vec![false; ends.len()];
        while let Some(Reverse((_, i, j))) = pairs.pop() {
            if taken[i] || taken[j] {
                continue;
            }
            (taken[i], taken[j]) = (true, true);
            let gap_mm = distance_mm(points[i], points[j]);
            let at = self.meet(ends[i], ends[j]);
            repairs.push(Repair::GapClosed { at, gap_mm });
        }
    }

    /// Adds a problem for each end that is still loose and each place that is still crowded.
    pub fn problems(&self, origins: &[Origin], problems: &mut Vec<Problem>) {
        let origin = |(i, _): End| Box::new(origins[self.pieces[i].origin as usize].clone());
        for group in &self.crowded {
            problems.push(Problem::Branch {
                origin: origin(group[0]),
                at: self.at(group[0]),
                count: group.len(),
            });
        }
        let loose = self.alone();
        if loose.is_empty() {
            return;
        }
        let lines = LineIndex::of(&self.pieces);
        let points: Vec<Point> = loose.iter().map(|&end| self.at(end)).collect();
        for (&end, gap_mm) in loose.iter().zip(nearest_mm(&points)) {
            let at = self.at(end);
            let tee = lines.as_ref().and_then(|lines| lines.passing(&self.pieces, at, self.reach, end.0));
            if let Some(other) = tee {
                problems.push(Problem::Tee { origin: origin(end), on: origin((other, 0)), at });
                continue;
            }
            problems.push(Problem::Open { origin: origin(end), at, gap_mm });
        }
    }
}

/// A spatial index of the straight pieces.
pub(super) struct LineIndex {
    index: CheckedIndex,
    /// The piece of each edge.
    pieces: Vec<usize>,
}

impl LineIndex {
    pub fn of(pieces: &[Piece]) -> Option<Self> {
        let straight = |(i, piece): (usize, &Piece)| {
            matches!(piece.bend, Bend::Straight).then_some((piece.from, piece.to, i))
        };
        let lines: Vec<(Point, Point, usize)> = pieces.iter().enumerate().filter_map(straight).collect();
        let edge = |&(from, to, _): &(Point, Point, usize)| Edge {
            chord: Segment { from, to },
            chord_error: Length::ZERO,
        };
        let index = build::build(lines.iter().map(edge).collect()).ok()?;
        Some(Self { index, pieces: lines.into_iter().map(|(.., i)| i).collect() })
    }

    /// The straight pieces within `reach` lattice units of the point, at most `most` of them.
    pub fn near(&self, at: Point, reach: f64, most: usize) -> Vec<usize> {
        let Ok(reach) = length_up_from_mm(reach / f64::from(UNITS_PER_MM)) else { return Vec::new() };
        let mut found = Vec::new();
        let _ = self.index.visit(Window::of(at).grown(reach), |number, edge| {
            if !edge.chord.near_point(at, reach).is_clear() {
                found.extend(self.pieces.get(number));
            }
            if found.len() < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        found
    }

    /// A straight piece, other than `own`, within `reach` of the point, whose ends are farther away.
    fn passing(&self, pieces: &[Piece], at: Point, reach: f64, own: usize) -> Option<usize> {
        let ends_here = |piece: &Piece| [piece.from, piece.to].iter().any(|&end| distance(end, at) <= reach);
        self.near(at, reach, usize::MAX).into_iter().find(|&i| i != own && !ends_here(&pieces[i]))
    }
}

/// A spatial index of ends.
pub(super) struct EndIndex {
    index: CheckedIndex,
    ends: Vec<End>,
}

impl EndIndex {
    pub fn of(joiner: &Joiner, ends: Vec<End>) -> Option<Self> {
        let at = |&end: &End| Edge {
            chord: Segment { from: joiner.at(end), to: joiner.at(end) },
            chord_error: Length::ZERO,
        };
        let index = build::build(ends.iter().map(at).collect()).ok()?;
        Some(Self { index, ends })
    }

    /// The ends in the box around two points, grown by rounding.
    pub fn between(&self, from: Point, to: Point) -> Vec<End> {
        let Ok(rounding) = length_up_from_mm(ROUNDING / f64::from(UNITS_PER_MM)) else { return Vec::new() };
        let mut found = Vec::new();
        let _ = self.index.visit(Window::of(from).including(to).grown(rounding), |number, _| {
            found.extend(self.ends.get(number));
            ControlFlow::<()>::Continue(())
        });
        found
    }
}

pub(super) fn distance(p: Point, q: Point) -> f64 {
    Vec2::from(p).distance(q.into())
}

pub(super) fn distance_mm(p: Point, q: Point) -> f64 {
    distance(p, q) / f64::from(UNITS_PER_MM)
}

/// For each point the distance to the nearest other, mm.
fn nearest_mm(points: &[Point]) -> Vec<Option<f64>> {
    let mut by_x: Vec<usize> = (0..points.len()).collect();
    by_x.sort_by_key(|&i| points[i]);
    let mut nearest = vec![f64::INFINITY; points.len()];
    for (place, &i) in by_x.iter().enumerate() {
        let beyond = |j: usize, best: f64| {
            f64::from(points[j].x.units().abs_diff(points[i].x.units())) / f64::from(UNITS_PER_MM) > best
        };
        let mut look = |others: &mut dyn Iterator<Item = &usize>| {
            for &j in others {
                if beyond(j, nearest[i]) {
                    break;
                }
                nearest[i] = nearest[i].min(distance_mm(points[i], points[j]));
            }
        };
        look(&mut by_x[..place].iter().rev());
        look(&mut by_x[place + 1..].iter());
    }
    nearest.into_iter().map(|mm| Some(mm).filter(|mm| mm.is_finite())).collect()
}

/// A grid of square cells that holds the points of each cell.
struct Grid {
    reach: f64,
    cells: HashMap<(i64, i64), Vec<usize>>,
}

impl Grid {
    fn of(points: &[Point], reach: f64) -> Self {
        let mut grid = Self { reach, cells: HashMap::new() };
        for (i, &point) in points.iter().enumerate() {
            grid.cells.entry(grid.key(point)).or_default().push(i);
        }
        grid
    }

    fn key(&self, p: Point) -> (i64, i64) {
        let Vec2 { x, y } = Vec2::from(p);
        let cell = |c: f64| keepout_kernel::curve::round_down(c / self.reach);
        (cell(x), cell(y))
    }

    /// Visits the other points within reach of the point number `i`.
    fn near(&self, points: &[Point], i: usize, mut visit: impl FnMut(usize)) {
        let (x, y) = self.key(points[i]);
        for cell in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
            for &j in self.cells.get(&cell).map_or(&[][..], Vec::as_slice) {
                if j != i && distance(points[i], points[j]) <= self.reach {
                    visit(j);
                }
            }
        }
    }
}

/// Groups of points that are linked by steps of at most `reach` lattice units.
fn groups_within(points: &[Point], reach: f64) -> Vec<Vec<usize>> {
    let grid = Grid::of(points, reach);
    let mut grouped = vec![false; points.len()];
    let mut groups = Vec::new();
    for first in 0..points.len() {
        if grouped[first] {
            continue;
        }
        grouped[first] = true;
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&i) = group.get(next) {
            next += 1;
            grid.near(points, i, |j| {
                if !grouped[j] {
                    grouped[j] = true;
                    group.push(j);
                }
            });
        }
        groups.push(group);
    }
    groups
}
