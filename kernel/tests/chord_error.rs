//! Chord errors count: of the profile's edges in clear queries, and of a path's arcs in the certificate.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use keepout_kernel::exact::ring::Piece;
use keepout_kernel::offset::certify_path;
use keepout_kernel::{Arc, Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Turn};

fn at(x: i64, y: i64) -> Point {
    Point::from_units(x, y).unwrap()
}

/// A square of 10 mm. The true curve may leave its upper edge by `chord_error` units.
fn part(chord_error: i64) -> ProhibitedRegion {
    let corners = [at(0, 0), at(1_000_000, 0), at(1_000_000, 1_000_000), at(0, 1_000_000)];
    let piece = |i: usize| Piece::Line {
        segment: Segment { from: corners[i], to: corners[(i + 1) % 4] },
        chord_error: Length::from_units(if i == 2 { chord_error } else { 0 }).unwrap(),
    };
    let ring = Ring::from_pieces(&[piece(0), piece(1), piece(2), piece(3)]).unwrap();
    ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap()
}

#[test]
fn every_query_adds_the_chord_error_of_each_edge() {
    let threshold = Length::from_units(300_000).unwrap();
    let height = |beyond: i64| 1_000_000 + 300_000 + beyond;
    for chord_error in [0, 10, 5_000] {
        let part = part(chord_error);
        let free = |beyond| part.free_point(at(500_000, height(beyond)), threshold);
        assert!(
            free(chord_error).is_err(),
            "a distance equal to the threshold is not clear, chord error {chord_error}"
        );
        let start = free(chord_error + 1).unwrap();
        let along = |beyond| part.motion(start, at(600_000, height(beyond)));
        assert!(along(chord_error).is_err());
        let end = along(chord_error + 1).unwrap();
        assert!(part.swept_triangle(start, end, at(550_000, height(chord_error))).is_err());
        assert!(part.swept_triangle(start, end, at(550_000, height(chord_error + 1))).is_ok());
    }
}

#[test]
fn certificate_includes_the_chord_error_of_arcs() {
    let part = part(0);
    let threshold = Length::from_units(300_000).unwrap();
    // An arc that bulges toward the upper edge: its lowest point is `beyond` units beyond the threshold.
    let hanging = |beyond: i64| {
        let (radius, lowest) = (800_000, 1_000_000 + 300_000 + beyond);
        let centre = at(500_000, lowest + radius);
        let ends = (at(500_000 - radius, lowest + radius), at(500_000 + radius, lowest + radius));
        let arc = Arc::new(ends.0, ends.1, centre, Turn::CounterClockwise).unwrap();
        certify_path(&part, threshold, &[Curve::Arc(arc)])
    };
    assert!(hanging(25).is_ok());
    assert!(hanging(5).is_err(), "the chords are farther from the edge than the arc");
}
