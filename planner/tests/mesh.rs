//! The mesh agrees with the index, and with brute force, on profiles of many kinds.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "a test helper may panic; it computes shapes in f64"
)]

use fastrand::Rng;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build::build;
use keepout_kernel::{
    CheckedIndex, Edge, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Vec2,
};
use keepout_planner::Mm2;
use keepout_planner::finish::FinishError;
use keepout_planner::machine::MachineProfile;
use keepout_planner::mesh::{Mesh, MeshError};
use keepout_planner::plan::{CertifiedPlan, PlanError, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::{PlanRequest, PlanRequestError};
use keepout_planner::route::around;

const FRAME: Window = Window::from_corners(-20_000_000, -20_000_000, 20_000_000, 20_000_000);

fn ring(points: &[Point]) -> Vec<Edge> {
    let ends = points.iter().zip(points.iter().cycle().skip(1));
    ends.map(|(&from, &to)| Edge { chord: Segment { from, to }, chord_error: Length::ZERO }).collect()
}

/// A star-shaped polygon about a centre. It does not cross itself; with many corners it has needles.
fn star(random: &mut Rng, centre: Mm2, reach: f64, count: usize) -> Vec<Point> {
    let vertex = |k: usize| {
        let phi = std::f64::consts::TAU * k as f64 / count as f64;
        let r = reach * (0.2 + 0.8 * random.f64());
        keepout_kernel::curve::nearest_point(Vec2::new(centre.x + r * phi.cos(), centre.y + r * phi.sin()))
            .unwrap()
    };
    (0..count).map(vertex).collect()
}

fn brute(index: &CheckedIndex, p: Point) -> f64 {
    let xy = |p: Point| (f64::from(p.x.units()), f64::from(p.y.units()));
    let distance = |edge: &Edge| {
        let (a, b, p) = (xy(edge.chord.from), xy(edge.chord.to), xy(p));
        let (d, w) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
        let t = ((w.0 * d.0 + w.1 * d.1) / (d.0 * d.0 + d.1 * d.1).max(1.0)).clamp(0.0, 1.0);
        (w.0 - t * d.0).hypot(w.1 - t * d.1)
    };
    index.edges().iter().map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn nearest_edges_and_components_agree_with_brute_force() {
    let mut random = Rng::with_seed(43);
    for case in 0..40 {
        let count = random.usize(3..400);
        let mut edges = ring(&star(&mut random, Mm2::new(0.0, 0.0), 8e6, count));
        let holes = random.usize(0..4);
        for k in 0..holes {
            edges.extend(ring(&star(&mut random, Mm2::new(1.2e7, 3e6 * k as f64 - 4e6), 1e6, 12)));
        }
        let index = build(edges).unwrap();
        for refined in [false, true] {
            let mesh = Mesh::build(&index, FRAME, refined).unwrap();
            assert_eq!(mesh.left_out(), 0, "case {case}");
            assert_eq!(mesh.components(), 2 + holes, "case {case}");
            let mut walk = mesh.walk();
            for _ in 0..200 {
                let mut c = || random.i64(-19_000_000..19_000_000);
                let p = Point::from_units(c(), c()).unwrap();
                let nearest = walk.nearest(&mesh, &index, p).unwrap();
                let truth = brute(&index, p);
                assert!((nearest.distance() - truth).abs() < 1e-3, "case {case}: {nearest:?}, {truth}");
                assert!(index.confirms(p, nearest));
                assert!((index.nearest(p, None).unwrap().distance() - truth).abs() < 1e-3);
                let outside = walk.component(&mesh, p) == Some(0);
                let located = index.locate(p);
                assert_eq!(outside, located == keepout_kernel::exact::region::Location::Outside, "{p:?}");
            }
        }
    }
}

#[test]
fn wrong_nearest_edges_are_not_confirmed() {
    let at = |x, y| Point::from_units(x, y).unwrap();
    let index = build(ring(&[at(0, 0), at(900, 0), at(450, 900)])).unwrap();
    let p = at(450, -200);
    let right = index.nearest(p, Some(2)).unwrap();
    assert!(index.confirms(p, right));
    for wrong in [
        keepout_kernel::Nearest { edge: 1, ..right },
        keepout_kernel::Nearest { edge: 7, ..right },
        keepout_kernel::Nearest { distance_2: right.distance_2 * 1.5, ..right },
        keepout_kernel::Nearest { distance_2: right.distance_2 * 0.7, ..right },
    ] {
        assert!(!index.confirms(p, wrong), "{wrong:?}");
    }
}

#[test]
fn degenerate_edges_make_a_mesh_or_are_left_out() {
    let at = |x, y| Point::from_units(x, y).unwrap();
    let edge = |a, b| Edge { chord: Segment { from: a, to: b }, chord_error: Length::ZERO };
    let soup = vec![
        edge(at(0, 0), at(900, 900)),
        edge(at(0, 900), at(900, 0)),
        edge(at(0, 0), at(900, 900)),
        edge(at(300, 300), at(600, 600)),
        edge(at(77, 5), at(77, 5)),
        edge(at(0, 450), at(400, 450)),
    ];
    let index = build(soup).unwrap();
    let mesh = Mesh::build(&index, FRAME, false).unwrap();
    assert!(mesh.left_out() >= 1, "two edges that cross cannot both be in the mesh");
    assert!(mesh.walk().locate(&mesh, at(450, 440)).is_some());
    assert!(mesh.walk().locate(&mesh, at(21_000_000, 0)).is_none(), "outside the frame");
    let small = Window::from_corners(-10, -10, 899, 2000);
    assert_eq!(Mesh::build(&index, small, false).unwrap_err(), MeshError::Frame);
}

#[test]
fn neighbours_share_ends() {
    let at = |x, y| Point::from_units(x, y).unwrap();
    let index = build(ring(&[at(0, 0), at(900, 0), at(900, 900), at(0, 900)])).unwrap();
    let mesh = Mesh::build(&index, FRAME, false).unwrap();
    assert_eq!(mesh.neighbours(&index, 0), [1, 3]);
    assert_eq!(mesh.neighbours(&index, 2), [1, 3]);
    assert_eq!(mesh.neighbours(&index, 9), [0; 0]);
}

fn pockets(outlines: &[&[(i64, i64)]]) -> ProhibitedRegion {
    let at = |&(x, y): &(i64, i64)| Point::from_units(x, y).unwrap();
    let rings = outlines.iter().map(|outline| Ring::new(outline.iter().map(at).collect()).unwrap());
    ProhibitedRegion::new(Region::new(rings.collect()).unwrap(), Side::Inside).unwrap()
}

#[test]
fn largest_disc_is_the_inscribed_circle() {
    let square = [(0, 0), (4_000_000, 0), (4_000_000, 4_000_000), (0, 4_000_000)];
    let slot = [(0, 0), (10_000_000, 0), (10_000_000, 1_000_000), (0, 1_000_000)];
    let right = [(0, 0), (4_000_000, 0), (0, 3_000_000)];
    let corner = [
        (0, 0),
        (6_000_000, 0),
        (6_000_000, 2_000_000),
        (2_000_000, 2_000_000),
        (2_000_000, 6_000_000),
        (0, 6_000_000),
    ];
    // The largest circle in the L touches both outer walls and the inner corner, 20 mm from each wall.
    let in_corner = 2e6 * std::f64::consts::SQRT_2 / (1.0 + std::f64::consts::SQRT_2);
    for (outline, radius) in
        [(&square[..], 2e6), (&slot[..], 5e5), (&right[..], 1e6), (&corner[..], in_corner)]
    {
        let part = pockets(&[outline]);
        let mesh = Mesh::of(&part).unwrap();
        let disc = mesh.largest_disc(&part, None).unwrap();
        let found = f64::from(disc.radius.units());
        assert!(found <= radius && found > radius * 0.998 - 3.0, "{found} of {radius}");
        assert!(part.free_point(disc.centre, disc.radius).is_ok());
    }
}

#[test]
fn largest_disc_is_sought_around_a_point() {
    let large = [(0, 0), (4_000_000, 0), (4_000_000, 4_000_000), (0, 4_000_000)];
    let small = [(5_000_000, 0), (6_000_000, 0), (6_000_000, 1_000_000), (5_000_000, 1_000_000)];
    let part = pockets(&[&large, &small]);
    let mesh = Mesh::of(&part).unwrap();
    let at = |x, y| Point::from_units(x, y).unwrap();
    let radius = |around| mesh.largest_disc(&part, around).map(|disc| disc.radius.units() / 1000);
    assert_eq!(radius(None), Some(1999));
    assert_eq!(radius(Some(at(5_100_000, 100_000))), Some(499));
    assert_eq!(radius(Some(at(4_500_000, 100_000))), None, "the material between the pockets");
    let outside = ProhibitedRegion::new(part.region().clone(), Side::Outside).unwrap();
    assert_eq!(mesh.largest_disc(&outside, None), None, "free space without bounds");
}

#[test]
fn link_moves_pass_a_slot_that_is_wide_enough() {
    let threshold = Length::from_units(300_000).unwrap();
    for (width, passes) in [(603_000, true), (600_400, true), (599_990, false), (400_000, false)] {
        // Two chambers, with a slot from one to the other that is bent at a right angle.
        let (low, high) = (2_000_000, 2_000_000 + width);
        let part = pockets(&[&[
            (0, 0),
            (4_000_000, 0),
            (4_000_000, low),
            (6_000_000 + width, low),
            (6_000_000 + width, 6_000_000),
            (9_000_000, 6_000_000),
            (9_000_000, 9_000_000),
            (3_000_000, 9_000_000),
            (3_000_000, 6_000_000),
            (6_000_000, 6_000_000),
            (6_000_000, high),
            (4_000_000, high),
            (4_000_000, 4_000_000),
            (0, 4_000_000),
        ]]);
        let mesh = Mesh::of(&part).unwrap();
        let at = |x, y| Point::from_units(x, y).unwrap();
        let (from, to) =
            (part.free_point(at(400_000, 500_000), threshold).unwrap(), at(3_500_000, 8_500_000));
        let found = around(&part, &mesh, (from, to), FRAME);
        assert_eq!(found.is_some(), passes, "a slot of {width}");
        let mut here = from;
        for point in found.into_iter().flatten() {
            here = part.motion(here, point).unwrap();
        }
        assert!(!passes || here.point() == to);
        let narrow = Window::from_corners(300_000, 300_000, 5_000_000, 8_700_000);
        assert_eq!(around(&part, &mesh, (from, to), narrow), None, "the slot is beyond the travel");
    }
}

#[test]
fn message_names_the_largest_tool_that_fits() {
    for name in ["nested.dxf", "pocket.dxf", "d_pocket.dxf"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/drawings").join(name);
        let bytes = std::fs::read(path).unwrap();
        let planned = |tool_diameter_mm| -> Result<CertifiedPlan, PlanRequestError> {
            let job =
                PlanParameters { tool_diameter_mm, side: MachinedSide::Inside, ..PlanParameters::default() };
            let request = PlanRequest { job, ..PlanRequest::default() };
            request.plan(name, &bytes, &MachineProfile::simulated(), &mut |_| {})
        };
        let refused = planned(400.0).unwrap_err();
        let PlanRequestError::Plan(PlanError::Finish(FinishError::ToolFitsNowhere { largest_mm, .. })) =
            refused
        else {
            panic!("{name}: {refused}");
        };
        let largest_mm = largest_mm.unwrap();
        assert!(refused.to_string().ends_with(&format!("that fits has {largest_mm:.2} mm.")), "{refused}");
        assert!(planned(largest_mm).is_ok(), "{name}: {largest_mm}");
        assert!(planned(largest_mm * 1.003 + 0.01).is_err(), "{name}: {largest_mm}");
    }
}
