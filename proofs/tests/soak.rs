//! Short runs of the differential soaks, and a degenerate profile that is too large for them.

use fastrand::Rng;
use keepout_kernel::index::build::build;
use keepout_kernel::index::subdivide;
use keepout_kernel::{Edge, Length, Point, Segment};
use keepout_proofs::families::Family;
use keepout_proofs::soak;

#[test]
fn predicates() {
    soak::predicates(&mut Rng::with_seed(11), 400_000);
}

#[test]
fn arcs() {
    soak::arcs(&mut Rng::with_seed(13), 20_000);
}

#[test]
fn every_family() {
    let mut random = Rng::with_seed(17);
    for family in Family::ALL {
        for _ in 0..12 {
            soak::family_queries(family, &mut random);
        }
    }
}

/// A million edges in a millimetre: answers agree with all edges, and cells stay within their bounds.
#[test]
fn a_million_edges_in_a_millimetre() {
    let mut random = Rng::with_seed(19);
    let mut at = || Point::from_units(random.i64(-50_000..=50_000), random.i64(-50_000..=50_000)).unwrap();
    let edge = |from: Point, to: Point| {
        let (x, y) = (i64::from(from.x.units()), i64::from(from.y.units()));
        let to =
            Point::from_units(x + i64::from(to.x.units()) / 500, y + i64::from(to.y.units()) / 500).unwrap();
        Edge { chord: Segment { from, to }, chord_error: Length::ZERO }
    };
    let edges: Vec<Edge> = (0..1_000_000).map(|_| edge(at(), at())).collect();
    let index = build(edges).unwrap();
    let threshold = Length::from_units(300_000).unwrap();
    let cells = subdivide::build(&index, threshold, None).unwrap();
    assert!(cells.bytes() < 64 << 20, "{}", cells.bytes());
    for (x, threshold) in [(0, 3), (49_000, 100), (60_000, 9_000), (500_000, 300_000), (360_000, 300_000)] {
        for y in [-40_000, 0, 45_001] {
            let point = Point::from_units(x, y).unwrap();
            let r = Length::from_units(threshold).unwrap();
            let near = index.edges().iter().any(|edge| !edge.near_point(point, r).is_clear());
            assert_eq!(index.near_point(point, r).is_some(), near, "{x} {y} {threshold}");
        }
    }
}
