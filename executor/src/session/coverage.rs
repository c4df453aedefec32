//! How near the cut contour comes to the profile: the machinist's question after finishing.

use std::collections::BTreeMap;

use keepout_kernel::{Length, Point, UNITS_PER_MM};
use keepout_planner::finish::{FreeSpaces, PATH_CLEARANCE, centre_distance};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::profile::ProfileLoop;
use keepout_planner::units::{along_mm, length_up_from_mm, mm, nearest_on_mm, point_from_mm, point_mm};

/// What the cut contour is like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Points of the profile that were looked at.
    pub points: usize,
    /// Of these, points that the tool can touch from the free space it was in.
    pub reachable: usize,
    /// Of these, points that no cut came near: their contour was not run.
    pub missed: usize,
    /// Largest distance from another reachable point to the cut contour, mm.
    pub worst_mm: f64,
    /// Mean of those distances, mm.
    pub mean_mm: f64,
    /// Where the largest is, mm.
    pub worst_at: (f64, f64),
}

/// Points of the profile are looked at this far apart, mm.
const STEP_MM: f64 = 0.2;
/// Where the tool could stand to touch a point, it must be clear but for this, mm.
const TOUCHING_MM: f64 = 0.000_5;

/// Measures the paths that the tool's centre really took while cutting against the profile.
///
/// A point of the profile counts as reachable when the tool fits against it at R + M, decided exactly, in the same
/// connected piece of free space as the cut.
#[must_use]
pub fn coverage<'a>(plan: &CertifiedPlan, cut: impl Iterator<Item = &'a [Point]>) -> Coverage {
    let radius = mm(plan.plan.tool_radius.units());
    let centres = CentrePaths::new(cut, mm(plan.finishing.units()) + MISSED_MM);
    let spaces = plan.plan.finish().free_spaces();
    let components: Vec<usize> = centres.firsts.iter().map(|&point| spaces.component_of(point)).collect();
    let mut result = Coverage::default();
    let mut sum = 0.0;
    let outlines = plan.plan.profile.outlines(&plan.part);
    let touching = Touching::of(plan);
    for (each, outline) in plan.plan.profile.loops.iter().zip(outlines) {
        for (at, normal) in stations(each, outline.free_on_left) {
            result.points += 1;
            let Some(component) = touching.component(plan, &spaces, at, normal) else { continue };
            if !components.contains(&component) {
                continue;
            }
            result.reachable += 1;
            let distance = centres.distance(at);
            if distance > mm(plan.finishing.units()) + MISSED_MM {
                result.missed += 1;
                continue;
            }
            let off = (distance - radius).abs();
            sum += off;
            if off > result.worst_mm {
                (result.worst_mm, result.worst_at) = (off, at);
            }
        }
    }
    let cut = result.reachable - result.missed;
    if cut > 0 {
        result.mean_mm = sum / f64::from(u32::try_from(cut).unwrap_or(u32::MAX));
    }
    result
}

/// A point farther than the margin and this from every cut was not cut at all, mm.
const MISSED_MM: f64 = 0.5;
/// Farther out than the chords by which loops are told apart leave their arcs, mm.
const ASIDE_MM: f64 = 0.01;

/// Where the centre of a tool is that touches the profile.
struct Touching {
    /// Distance of the path from the profile, mm.
    path_mm: f64,
    /// What the centre is clear at; edges are asked with their chord_error on top.
    threshold: Length,
}

impl Touching {
    fn of(plan: &CertifiedPlan) -> Self {
        let path = centre_distance(&plan.plan.profile, &plan.plan.zones, plan.finishing);
        let threshold = mm(plan.finishing.units()) + mm(i32::from(PATH_CLEARANCE)) - TOUCHING_MM;
        Self {
            path_mm: path / f64::from(UNITS_PER_MM),
            threshold: length_up_from_mm(threshold).unwrap_or(plan.finishing),
        }
    }

    /// The free space from which the tool touches the profile at `at`, if it fits there.
    ///
    /// No edge nearer to that centre than the profile's own point means that nothing lies between them: the centre is on
    /// the side that the normal points to, unless it is in a zone that lies over the profile.
    fn component(
        &self,
        plan: &CertifiedPlan,
        spaces: &FreeSpaces,
        at: (f64, f64),
        normal: (f64, f64),
    ) -> Option<usize> {
        let off = |distance_mm: f64| {
            point_from_mm((at.0 + normal.0 * distance_mm, at.1 + normal.1 * distance_mm)).ok()
        };
        plan.part.free_point(off(self.path_mm)?, self.threshold).ok()?;
        // Looked at from a little farther out: the place itself lies on the loop that bounds the free space.
        Some(spaces.component_of(off(self.path_mm + ASIDE_MM)?))
    }
}

type Station = ((f64, f64), (f64, f64));

/// Points along a loop with the direction toward the free side, both ends of every curve among them.
fn stations(each: &ProfileLoop, free_on_left: bool) -> Vec<Station> {
    let sign = if free_on_left { -1.0 } else { 1.0 };
    let mut stations = Vec::new();
    for edge in &each.edges {
        let length = edge.curve.length() / f64::from(UNITS_PER_MM);
        let count = (length / STEP_MM).ceil().max(1.0);
        let mut k = 0.0;
        while k <= count {
            let (at, direction) = along_mm(&edge.curve, k / count);
            stations.push((at, (direction.1 * sign, -direction.0 * sign)));
            k += 1.0;
        }
    }
    stations
}

/// The centre's paths in cells, to find the nearest piece.
struct CentrePaths {
    cell: f64,
    cells: BTreeMap<(i64, i64), Vec<usize>>,
    pieces: Vec<((f64, f64), (f64, f64))>,
    firsts: Vec<Point>,
}

impl CentrePaths {
    fn new<'a>(cut: impl Iterator<Item = &'a [Point]>, cell: f64) -> Self {
        let mut paths = Self { cell, cells: BTreeMap::new(), pieces: Vec::new(), firsts: Vec::new() };
        for path in cut {
            paths.firsts.extend(path.first());
            for pair in path.windows(2) {
                let piece = (point_mm(pair[0]), point_mm(pair[1]));
                let index = paths.pieces.len();
                let (a, b) = (paths.key(piece.0), paths.key(piece.1));
                for x in a.0.min(b.0)..=a.0.max(b.0) {
                    for y in a.1.min(b.1)..=a.1.max(b.1) {
                        paths.cells.entry((x, y)).or_default().push(index);
                    }
                }
                paths.pieces.push(piece);
            }
        }
        paths
    }

    fn key(&self, (x, y): (f64, f64)) -> (i64, i64) {
        let index = |c: f64| keepout_kernel::curve::nearest_unit((c / self.cell).floor());
        (index(x), index(y))
    }

    /// The distance from `p` to the nearest piece, if it is within a cell; infinite otherwise.
    fn distance(&self, p: (f64, f64)) -> f64 {
        let to_piece = |(a, b)| {
            let foot = nearest_on_mm(p, a, b);
            (p.0 - foot.0).hypot(p.1 - foot.1)
        };
        let (i, j) = self.key(p);
        let near = (i - 1..=i + 1).flat_map(|x| (j - 1..=j + 1).map(move |y| (x, y)));
        let pieces = near.filter_map(|key| self.cells.get(&key)).flatten();
        pieces.map(|&index| to_piece(self.pieces[index])).fold(f64::INFINITY, f64::min)
    }
}
