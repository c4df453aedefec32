//! The index: its checker refuses boxes that are too small, and trees of another shape. It finds what all edges
//! together have near a shape.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use core::ops::ControlFlow;

use fastrand::Rng;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build;
use keepout_kernel::index::check::{BoxProposal, CheckedIndex, IndexFault, Node};
use keepout_kernel::{Convex, Edge, Length, Point, Segment, Triangle};

#[test]
fn box_one_unit_too_small_is_rejected_on_every_side_and_level() {
    let edges: Vec<Edge> = (0..300)
        .map(|k| {
            let corner = |d| Point::from_units(k * 10, (k * k) % 97 + d).unwrap();
            Edge { chord: Segment { from: corner(0), to: corner(9) }, chord_error: Length::small(3) }
        })
        .collect();
    let right = build::propose(&edges);
    assert!(CheckedIndex::check(edges.clone(), right.clone()).is_ok());
    assert_eq!(right.levels.len(), 3);
    for level in 0..right.levels.len() {
        for side in 0..4 {
            let mut wrong = right.clone();
            let node = wrong.levels[level][0];
            let mut windows: Vec<Window> = node.windows().collect();
            let (x0, y0, x1, y1) = windows[1].corners();
            let d = |k| i32::from(side == k);
            windows[1] = Window::from_corners(x0 + d(0), y0 + d(1), x1 - d(2), y1 - d(3));
            wrong.levels[level][0] = Node::of(windows.into_iter());
            let fault = CheckedIndex::check(edges.clone(), wrong).unwrap_err();
            assert_eq!(fault, IndexFault::Box { level, index: 1 });
        }
    }
    for (levels, fault) in [
        (vec![], IndexFault::Levels { count: 0 }),
        (right.levels[..2].to_vec(), IndexFault::Levels { count: 2 }),
        ([&right.levels[..], &right.levels[2..]].concat(), IndexFault::Levels { count: 4 }),
        (right.levels[1..].to_vec(), IndexFault::Nodes { level: 0, count: 2 }),
    ] {
        assert_eq!(CheckedIndex::check(edges.clone(), BoxProposal { levels }).unwrap_err(), fault);
    }
    assert!(
        CheckedIndex::check(vec![], BoxProposal::default())
            .unwrap()
            .near_point(Point::ORIGIN, Length::small(9))
            .is_none()
    );
}

fn point(random: &mut Rng) -> Point {
    Point::from_units(random.i64(-500..500), random.i64(-500..500)).unwrap()
}

/// An edge from `from` to a point that is up to `size` away along each axis.
fn edge(random: &mut Rng, size: i64) -> Edge {
    let from = point(random);
    let mut beside = |c: i32| i64::from(c) + random.i64(-size..size);
    let to = Point::from_units(beside(from.x.units()), beside(from.y.units())).unwrap();
    Edge { chord: Segment { from, to }, chord_error: Length::small(random.u8(0..5)) }
}

/// The index finds an edge exactly when there is one.
#[test]
fn index_answers_as_all_edges_do() {
    let random = &mut Rng::with_seed(9);
    for _ in 0..60 {
        let edges: Vec<Edge> = (0..random.usize(1..400))
            .map(|_| {
                let size = if random.bool() { 3 } else { 60 };
                edge(random, size)
            })
            .collect();
        let index = build::build(edges).unwrap();
        for _ in 0..60 {
            ask(&index, random);
        }
    }
}

/// Asks about shapes at a random place.
fn ask(index: &CheckedIndex, random: &mut Rng) {
    let threshold = Length::small(random.u8(0..30));
    let (from, to, size) = (point(random), point(random), random.i64(1..80));
    let motion = Segment { from, to };
    let window = Window::of(from).including(to);
    let corner = |dx, dy| {
        let moved = |c: i32, d: i64| i64::from(c) + d * size;
        Point::from_units(moved(from.x.units(), dx), moved(from.y.units(), dy)).unwrap()
    };
    let corners = [from, corner(2, 0), corner(3, 1), corner(2, 3)];
    let polygon = Convex::check(&corners).unwrap();
    let triangle = Triangle { corners: [from, corner(2, 0), to] };
    let agrees = |found: Option<&Edge>, near: &dyn Fn(&Edge) -> bool, shape: &str| {
        assert_eq!(found.is_some(), index.edges().iter().any(near), "{shape} at {from:?}");
        assert!(found.is_none_or(near), "{shape} at {from:?}");
    };
    agrees(index.near_point(from, threshold), &|edge| !edge.near_point(from, threshold).is_clear(), "point");
    let near_motion = |edge: &Edge| !edge.near_motion(motion, threshold).is_clear();
    agrees(index.near_motion(motion, threshold), &near_motion, "motion");
    agrees(
        index.near_triangle(triangle, threshold),
        &|edge| !edge.near_triangle(triangle, threshold).is_clear(),
        "triangle",
    );
    let near_polygon = |edge: &Edge| !edge.near_convex(polygon, threshold).is_clear();
    agrees(index.near_convex(polygon, threshold), &near_polygon, "polygon");
    agrees(index.near_box(window, threshold), &|edge| !edge.near_box(window, threshold).is_clear(), "box");
    let approached = |edge: &Edge| !motion.retracts_from(edge.chord) && near_motion(edge);
    agrees(index.approached(motion, threshold), &approached, "retract move");
    let mut visited = vec![false; index.edges().len()];
    let _ = index.along(motion, threshold, |number, _| {
        visited[number] = true;
        ControlFlow::Continue(())
    });
    let left_out = index.edges().iter().zip(visited).find(|(edge, visited)| !visited && near_motion(edge));
    assert_eq!(left_out, None, "along the motion from {from:?}");
}
