//! The index: its checker refuses boxes that are too small, and trees of another shape.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build;
use keepout_kernel::index::check::{BoxProposal, CheckedIndex, IndexFault, Node};
use keepout_kernel::{Edge, Length, Point, Segment};

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
