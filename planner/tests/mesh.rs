//! The mesh agrees with the index, and with brute force, on profiles of many kinds.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "a test helper may panic; it computes shapes in f64"
)]

use fastrand::Rng;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build::build;
use keepout_kernel::{CheckedIndex, Edge, Length, Point, Segment};
use keepout_planner::mesh::{Mesh, MeshError};

const FRAME: Window = Window::from_corners(-20_000_000, -20_000_000, 20_000_000, 20_000_000);

fn ring(points: &[Point]) -> Vec<Edge> {
    let ends = points.iter().zip(points.iter().cycle().skip(1));
    ends.map(|(&from, &to)| Edge { chord: Segment { from, to }, chord_error: Length::ZERO }).collect()
}

/// A star-shaped polygon about a centre. It does not cross itself; with many corners it has needles.
fn star(random: &mut Rng, centre: (f64, f64), reach: f64, count: usize) -> Vec<Point> {
    let vertex = |k: usize| {
        let phi = std::f64::consts::TAU * k as f64 / count as f64;
        let r = reach * (0.2 + 0.8 * random.f64());
        keepout_kernel::curve::nearest_point(centre.0 + r * phi.cos(), centre.1 + r * phi.sin()).unwrap()
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
        let mut edges = ring(&star(&mut random, (0.0, 0.0), 8e6, count));
        let holes = random.usize(0..4);
        for k in 0..holes {
            edges.extend(ring(&star(&mut random, (1.2e7, 3e6 * k as f64 - 4e6), 1e6, 12)));
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
    assert!(mesh.left_out() >= 1, "two edges that cross can not both be in the mesh");
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
