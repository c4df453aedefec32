//! Offsets with certificates, compared with the peers' offsets without certificates.

use cavalier_contours::polyline::{PlineSource, PlineSourceMut, Polyline};
use clipper2_rust::core::{PathD, PathsD, PointD};
use clipper2_rust::offset::{EndType, JoinType};
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};
use keepout_kernel::offset::{self, Outline};
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Vec2};

use crate::paths::RADIUS_MM;
use crate::profiles::{MM, ProfileFamily, mm};
use crate::rivals::Xy;
use crate::timing::{median, seconds};

/// Allowed flattening error of the peers, mm.
const FLAT_MM: f64 = 0.001;
/// Time limit, s. A peer that exceeds it at one size does not run at the next sizes.
const PATIENCE_S: f64 = 12.0;
/// Extra distance of our offset, lattice units, as in the planner. The certificate checks the loops at the
/// radius.
const PATH_CLEARANCE: f64 = 60.0;

/// One offsetter on one profile.
pub struct Run {
    pub name: &'static str,
    pub ms: f64,
    pub loops: usize,
    pub pieces: usize,
    /// Smallest distance between the result and the profile, mm.
    pub least_mm: f64,
}

/// All offsetters on one profile and side.
pub struct Offsets {
    pub family: ProfileFamily,
    pub edges: usize,
    pub outside: bool,
    pub runs: Vec<Run>,
    /// Time of our certificate, ms.
    pub certificate_ms: f64,
    /// Time of our second certificate, that no piece is missing, ms.
    pub complete_ms: f64,
    /// Number of our loops that a certificate rejects, plus loose ends.
    pub refused: usize,
}

/// Result points, by loops.
type Loops = Vec<Vec<Xy>>;

type Offsetter = fn(&[Xy], f64) -> (f64, Loops, usize);

/// Runs all offsetters that are not in `slow`, and adds those that exceed the time limit to it.
pub fn run(family: ProfileFamily, count: usize, outside: bool, slow: &mut Vec<&'static str>) -> Offsets {
    let vertices = family.rings(count).swap_remove(0);
    let rounds = if count <= 1_000 {
        15
    } else if count <= 10_000 {
        3
    } else {
        1
    };
    let ring = Ring::new(vertices.clone()).expect("profiles are simple");
    let side = if outside { Side::Outside } else { Side::Inside };
    let part = ProhibitedRegion::new(Region::new(vec![ring]).expect("one ring"), side).expect("few edges");
    let points: Vec<Xy> = vertices.iter().map(|&point| mm(point)).collect();
    let mut offsets = Offsets {
        family,
        edges: points.len(),
        outside,
        runs: Vec::new(),
        certificate_ms: 0.0,
        complete_ms: 0.0,
        refused: 0,
    };
    ours(&vertices, &part, rounds, &mut offsets);
    let peers: [(&'static str, Offsetter); 3] =
        [("cavalier_contours", cavalier), ("i_overlay", i_overlay), ("clipper2-rust", clipper)];
    let distance = if outside { RADIUS_MM } else { -RADIUS_MM };
    for (name, peer) in peers {
        if slow.contains(&name) {
            continue;
        }
        let mut times = Vec::new();
        let mut made = (Loops::new(), 0);
        for _ in 0..rounds {
            let (time, loops, pieces) = peer(&points, distance);
            times.push(time * 1e3);
            made = (loops, pieces);
            if time > PATIENCE_S {
                slow.push(name);
            }
            if time > 1.0 {
                break;
            }
        }
        offsets.runs.push(measured(name, median(&mut times), made.1, &made.0, &part));
    }
    offsets
}

/// Proposes and certifies our offset `rounds` times.
fn ours(vertices: &[Point], part: &ProhibitedRegion, rounds: usize, offsets: &mut Offsets) {
    let threshold = Length::from_units((RADIUS_MM * MM).round() as i64).expect("a length");
    let next = vertices.iter().cycle().skip(1);
    let curves = vertices.iter().zip(next).map(|(&from, &to)| Curve::Line(Segment { from, to })).collect();
    let outline = [Outline { curves, free_on_left: !offsets.outside }];
    let (mut times, mut certificates) = (Vec::new(), Vec::new());
    let mut made = offset::Offset::default();
    for _ in 0..rounds {
        let (proposing, proposed) = seconds(|| offset::propose(&outline, RADIUS_MM * MM + PATH_CLEARANCE));
        let refused =
            |each: &&offset::OffsetLoop| offset::certify_path(part, threshold, &each.curves).is_err();
        let (certifying, refused) = seconds(|| proposed.loops.iter().filter(refused).count());
        times.push((proposing + certifying) * 1e3);
        certificates.push(certifying * 1e3);
        offsets.refused = refused + proposed.loose_ends.len();
        made = proposed;
    }
    let (completing, complete) = seconds(|| {
        let path = made.loops.iter().flat_map(|each| &each.curves);
        offset::certify_complete(part, &outline, RADIUS_MM * MM + PATH_CLEARANCE, Length::small(20), path)
    });
    offsets.complete_ms = completing * 1e3;
    offsets.refused += usize::from(complete.is_err());
    let corners = |each: &offset::OffsetLoop| each.curves.iter().flat_map(sampled).collect();
    let loops: Loops = made.loops.iter().map(corners).collect();
    let pieces = made.loops.iter().map(|each| each.curves.len()).sum();
    offsets.certificate_ms = median(&mut certificates);
    offsets.runs.push(measured("keepout, certified", median(&mut times), pieces, &loops, part));
}

fn measured(name: &'static str, ms: f64, pieces: usize, loops: &Loops, part: &ProhibitedRegion) -> Run {
    let mut least_mm = f64::INFINITY;
    let mut hint = None;
    for each in loops {
        for (&a, &b) in each.iter().zip(each.iter().cycle().skip(1)) {
            let middle = (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1));
            for (x, y) in [a, middle] {
                let Ok(point) = keepout_kernel::curve::nearest_point(Vec2::new(x * MM, y * MM)) else {
                    continue;
                };
                let Some(nearest) = part.index().nearest(point, hint) else { continue };
                hint = Some(nearest.edge);
                least_mm = least_mm.min(nearest.distance() / MM);
            }
        }
    }
    Run { name, ms, loops: loops.len(), pieces, least_mm }
}

/// Points along a curve. The chords between them deviate from an arc by at most 0.07 µm.
fn sampled(curve: &Curve) -> Vec<Xy> {
    let chord_error = Length::from_units(7).expect("a length");
    let points = curve.chord_points(chord_error).unwrap_or_else(|_| vec![curve.from(), curve.to()]);
    let in_mm = |&point: &Point| mm(point);
    points[..points.len() - 1].iter().map(in_mm).collect()
}

/// Offset by `cavalier_contours`. Like the other peers, it returns the time of its work, s, without the
/// conversion of input and output, then its loops and the number of its pieces.
fn cavalier(points: &[Xy], distance: f64) -> (f64, Loops, usize) {
    let mut polyline = Polyline::<f64>::new_closed();
    for &(x, y) in points {
        polyline.add(x, y, 0.0);
    }
    // Positive is to the left; the profiles run counter-clockwise.
    let (time, made) = seconds(|| polyline.parallel_offset(-distance));
    let pieces = made.iter().map(PlineSource::vertex_count).sum();
    let flat = |each: &Polyline<f64>| {
        let flat = each.arcs_to_approx_lines(1e-5);
        flat.map_or(vec![], |flat| flat.iter_vertexes().map(|vertex| (vertex.x, vertex.y)).collect())
    };
    (time, made.iter().map(flat).collect(), pieces)
}

fn i_overlay(points: &[Xy], distance: f64) -> (f64, Loops, usize) {
    let contour: Vec<[f64; 2]> = points.iter().map(|&(x, y)| [x, y]).collect();
    let angle = 2.0 * (1.0 - FLAT_MM / RADIUS_MM).acos();
    let style = OutlineStyle::new(distance).line_join(LineJoin::Round(angle));
    let contours = vec![contour];
    let (time, shapes) = seconds(|| contours.outline(&style));
    let loops: Loops = shapes
        .iter()
        .flatten()
        .map(|contour| contour.iter().map(|point| (point[0], point[1])).collect())
        .collect();
    let pieces = loops.iter().map(Vec::len).sum();
    (time, loops, pieces)
}

fn clipper(points: &[Xy], distance: f64) -> (f64, Loops, usize) {
    let path: PathD = points.iter().map(|&(x, y)| PointD { x, y }).collect();
    let paths: PathsD = vec![path];
    let (time, made) = seconds(|| {
        clipper2_rust::clipper::inflate_paths_d(
            &paths,
            distance,
            JoinType::Round,
            EndType::Polygon,
            2.0,
            5,
            FLAT_MM,
        )
    });
    let loops: Loops =
        made.iter().map(|path| path.iter().map(|point| (point.x, point.y)).collect()).collect();
    let pieces = loops.iter().map(Vec::len).sum();
    (time, loops, pieces)
}
