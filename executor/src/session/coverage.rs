//! The distance between the cut contour and the profile, for the report after finishing.
//!
//! Implements SR-23.

use std::collections::BTreeMap;

use keepout_kernel::{Height, Length, Place, Point, ProhibitedRegion, UNITS_PER_MM};
use keepout_planner::Mm2;
use keepout_planner::finish::{FreeSpaces, PATH_CLEARANCE, centre_distance};
use keepout_planner::plan::{CertifiedPlan, Walls};
use keepout_planner::profile::ProfileLoop;
use keepout_planner::units::{along_mm, length_up_from_mm, mm, point_from_mm, point_mm};

/// The comparison of the cut contour with the profile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Sampled points of the profile.
    pub points: usize,
    /// Of these, points that the tool can touch from the free space in which it cut.
    pub reachable: usize,
    /// Of these, points without a cut near them: their contour was not run.
    pub missed: usize,
    /// Largest distance from one of the other reachable points to the cut contour, mm.
    pub worst_mm: f64,
    /// Mean of those distances, mm.
    pub mean_mm: f64,
    /// The point with the largest distance, mm.
    pub worst_at: Mm2,
}

impl Coverage {
    /// The comparison for two sessions that cut different contours of one profile.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let cut = |each: Self| f64::from(u32::try_from(each.reachable - each.missed).unwrap_or(u32::MAX));
        let sum = self.mean_mm * cut(self) + other.mean_mm * cut(other);
        let worst = if self.worst_mm >= other.worst_mm { self } else { other };
        Self {
            reachable: self.reachable + other.reachable,
            missed: self.missed + other.missed,
            mean_mm: sum / (cut(self) + cut(other)).max(1.0),
            ..worst
        }
    }
}

/// Distance between two sampled points of the profile, mm.
const STEP_MM: f64 = 0.2;
/// Tolerance of the clearance check for the tool that touches the profile, mm.
const TOUCHING_MM: f64 = 0.000_5;

/// Compares the true paths of the tool's centre while cutting with the profile, at each depth with the walls there.
///
/// A point of the profile is reachable if the tool fits against it at R + M, in the connected component of free
/// space that holds the cut. The check is exact.
#[must_use]
pub fn coverage<'a>(plan: &CertifiedPlan, cut: impl Iterator<Item = &'a [Place]>) -> Coverage {
    let paths: Vec<&[Place]> = cut.collect();
    let mut result = Coverage::default();
    let mut sum = 0.0;
    for walls in &plan.walls {
        compare(plan, walls, &paths, &mut result, &mut sum);
    }
    let cut = result.reachable - result.missed;
    if cut > 0 {
        result.mean_mm = sum / f64::from(u32::try_from(cut).unwrap_or(u32::MAX));
    }
    result
}

/// Compares the paths at one depth with the walls there.
fn compare(plan: &CertifiedPlan, walls: &Walls, paths: &[&[Place]], result: &mut Coverage, sum: &mut f64) {
    let radius = mm(plan.plan.tool_radius.units());
    let pass = &plan.plan.passes[walls.pass];
    let part = plan.region(pass.height);
    let centres = CentrePaths::new(paths, pass.height, mm(plan.finishing.units()) + MISSED_MM);
    let spaces = pass.path.free_spaces();
    // A path lies on the loop that bounds its free space, give or take rounding. A place beside it lies inside.
    let beside = |place: Point| {
        let asides = [(0.0, 0.0), (ASIDE_MM, 0.0), (-ASIDE_MM, 0.0), (0.0, ASIDE_MM), (0.0, -ASIDE_MM)];
        asides.into_iter().filter_map(move |(x, y)| point_from_mm(point_mm(place) + Mm2::new(x, y)).ok())
    };
    let component = |places: &Vec<Point>| {
        places.iter().flat_map(|&place| beside(place)).map(|place| spaces.component_of(place)).max()
    };
    let components: Vec<usize> = centres.places.iter().filter_map(component).collect();
    let touching = Touching::of(plan);
    for (&contour, outline) in walls.contours.iter().zip(&walls.outlines) {
        let each = &plan.plan.profile.loops[contour];
        for (at, normal) in stations(each, outline.free_on_left) {
            result.points += 1;
            let Some(component) = touching.component(part, &spaces, at, normal) else { continue };
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
            *sum += off;
            if off > result.worst_mm {
                (result.worst_mm, result.worst_at) = (off, at);
            }
        }
    }
}

/// A reachable point farther than R + M and this distance from every cut was not cut, mm.
const MISSED_MM: f64 = 0.5;
/// Largest distance of a cut from the height of its pass, mm: positioning error and steps of the axis.
const SAME_HEIGHT_MM: f64 = 0.05;
/// Number of places of a path that tell its free space.
const PLACES: usize = 32;
/// Offset of the component lookup from the toolpath, mm. It exceeds the chord error of the loops in that
/// lookup.
const ASIDE_MM: f64 = 0.01;

/// The centre of a tool that touches the profile.
struct Touching {
    /// Distance of the path from the profile, mm.
    path_mm: f64,
    /// Least clearance of the centre. The check adds the chord-error bound of each edge.
    clearance: Length,
}

impl Touching {
    fn of(plan: &CertifiedPlan) -> Self {
        let path = centre_distance(&plan.plan.profile, &plan.plan.zones, plan.finishing);
        let clearance = mm(plan.finishing.units()) + mm(i32::from(PATH_CLEARANCE)) - TOUCHING_MM;
        Self {
            path_mm: path / f64::from(UNITS_PER_MM),
            clearance: length_up_from_mm(clearance).unwrap_or(plan.finishing),
        }
    }

    /// The component of free space from which the tool touches the profile at `at`, if it fits there.
    ///
    /// If no edge is nearer to the centre than the profile's own point, no edge lies between them. The centre
    /// is then on the side of the normal, unless it is in a keep-out zone that overlaps the profile.
    fn component(&self, part: &ProhibitedRegion, spaces: &FreeSpaces, at: Mm2, normal: Mm2) -> Option<usize> {
        let off = |distance_mm: f64| point_from_mm(at + normal * distance_mm).ok();
        part.free_point(off(self.path_mm)?, self.clearance).ok()?;
        // The lookup is a little farther out, because the centre itself lies on the loop that bounds the free
        // space.
        Some(spaces.component_of(off(self.path_mm + ASIDE_MM)?))
    }
}

type Station = (Mm2, Mm2);

/// Points along a loop, each with the direction toward the free side. Both ends of every curve are included.
fn stations(each: &ProfileLoop, free_on_left: bool) -> Vec<Station> {
    let sign = if free_on_left { 1.0 } else { -1.0 };
    let mut stations = Vec::new();
    for edge in &each.edges {
        let length = edge.curve.length() / f64::from(UNITS_PER_MM);
        let count = (length / STEP_MM).ceil().max(1.0);
        let mut k = 0.0;
        while k <= count {
            let (at, direction) = along_mm(&edge.curve, k / count);
            stations.push((at, direction.left() * sign));
            k += 1.0;
        }
    }
    stations
}

/// The paths of the tool's centre in a grid of cells, for the search of the nearest segment.
struct CentrePaths {
    cell: f64,
    cells: BTreeMap<(i64, i64), Vec<usize>>,
    segments: Vec<(Mm2, Mm2)>,
    /// Some places of each path.
    places: Vec<Vec<Point>>,
}

impl CentrePaths {
    /// The parts of the paths at a height.
    fn new(cut: &[&[Place]], height: Height, cell: f64) -> Self {
        let is_there =
            |place: &Place| (mm(place.height.units()) - mm(height.units())).abs() <= SAME_HEIGHT_MM;
        let mut paths = Self { cell, cells: BTreeMap::new(), segments: Vec::new(), places: Vec::new() };
        for path in cut.iter().flat_map(|path| path.split(|place| !is_there(place))) {
            if path.is_empty() {
                continue;
            }
            paths
                .places
                .push(path.iter().step_by((path.len() / PLACES).max(1)).map(|place| place.point).collect());
            for pair in path.windows(2) {
                let segment = (point_mm(pair[0].point), point_mm(pair[1].point));
                let index = paths.segments.len();
                let (a, b) = (paths.key(segment.0), paths.key(segment.1));
                for x in a.0.min(b.0)..=a.0.max(b.0) {
                    for y in a.1.min(b.1)..=a.1.max(b.1) {
                        paths.cells.entry((x, y)).or_default().push(index);
                    }
                }
                paths.segments.push(segment);
            }
        }
        paths
    }

    fn key(&self, Mm2 { x, y }: Mm2) -> (i64, i64) {
        let index = |c: f64| keepout_kernel::curve::nearest_unit((c / self.cell).floor());
        (index(x), index(y))
    }

    /// The distance from `p` to the nearest segment, if it is within one cell width. Otherwise infinite.
    fn distance(&self, p: Mm2) -> f64 {
        let to_segment = |(a, b)| p.distance(p.nearest_on(a, b));
        let (i, j) = self.key(p);
        let near = (i - 1..=i + 1).flat_map(|x| (j - 1..=j + 1).map(move |y| (x, y)));
        let segments = near.filter_map(|key| self.cells.get(&key)).flatten();
        segments.map(|&index| to_segment(self.segments[index])).fold(f64::INFINITY, f64::min)
    }
}
