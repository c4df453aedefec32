//! Queries of a prohibited region: what each refuses and what it names.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use keepout_kernel::offset::certify_path;
use keepout_kernel::{
    Arc, Blocked, Convex, Curve, FreePoint, Height, HeightField, Length, Levels, Point, ProhibitedRegion,
    Region, Ring, Segment, Side, Turn,
};

fn at(x: i64, y: i64) -> Point {
    Point::from_units(x, y).unwrap()
}

fn length(units: i64) -> Length {
    Length::from_units(units).unwrap()
}

fn square(low: i64, high: i64) -> Ring {
    Ring::new(vec![at(low, low), at(high, low), at(high, high), at(low, high)]).unwrap()
}

/// A square of 1000 units, machined outside.
fn part() -> ProhibitedRegion {
    ProhibitedRegion::new(Region::new(vec![square(0, 1000)]).unwrap(), Side::Outside).unwrap()
}

fn free(part: &ProhibitedRegion, x: i64, y: i64, threshold: i64) -> FreePoint {
    part.free_point(at(x, y), length(threshold)).unwrap()
}

#[test]
fn threshold_of_a_free_point_only_falls() {
    let point = free(&part(), -300, 500, 200);
    assert_eq!((point.point(), point.threshold(), point.level()), (at(-300, 500), length(200), 0));
    assert_eq!(point.lowered(length(200)), Some(point));
    assert_eq!(point.lowered(length(150)).map(FreePoint::threshold), Some(length(150)));
    assert_eq!(point.lowered(length(201)), None);
}

#[test]
fn levels_number_their_regions_and_points() {
    let field = HeightField {
        outlines: Region::new(vec![square(0, 1000), square(200, 800)]).unwrap(),
        tops: vec![Some(Height::ZERO), Some(Height::from_units(-50).unwrap())],
        around: None,
        zones: vec![(square(2000, 2100), Height::from_units(-20).unwrap())],
        floor: None,
    };
    let levels = Levels::new(&field).unwrap();
    let numbers: Vec<u16> = levels.regions().map(|region| region.level()).collect();
    assert_eq!(numbers, [0, 1, 2, 3]);
    assert_eq!(levels.regions().map(|region| region.zones().len()).collect::<Vec<_>>(), [0, 0, 1, 1]);
    for region in levels.regions() {
        assert_eq!(region.free_point(at(-900, -900), length(10)).unwrap().level(), region.level());
    }
}

#[test]
fn cells_serve_only_the_threshold_they_were_prepared_for() {
    let mut part = part();
    part.prepare(length(100)).unwrap();
    part.prepare(length(300)).unwrap();
    for threshold in [100, 300] {
        assert_eq!(part.cells_for(length(threshold)).unwrap().threshold(), length(threshold));
    }
    assert!(part.cells_for(length(200)).is_none());
    for threshold in [100, 200, 300] {
        assert!(part.free_point(at(-threshold, 500), length(threshold)).is_err());
        assert!(part.free_point(at(-threshold - 1, 500), length(threshold)).is_ok());
    }
}

#[test]
fn clearance_is_a_lower_bound_within_two_units() {
    let part = part();
    for distance in [3, 100, 777] {
        let clearance = i64::from(part.clearance(at(500, 1000 + distance)).unwrap().units());
        assert!((distance - 2..=distance).contains(&clearance), "{clearance} of {distance}");
    }
    assert_eq!(part.clearance(at(500, 1000)), None);
}

#[test]
fn arc_begins_at_the_free_point() {
    let part = part();
    let start = free(&part, 1300, 1000, 250);
    let round = |from| Arc::new(from, at(1000, 1300), at(1000, 1000), Turn::CounterClockwise).unwrap();
    assert_eq!(part.arc(start, &round(at(1300, 1000))).unwrap().point(), at(1000, 1300));
    let elsewhere = round(at(1300, 1001));
    assert_eq!(part.arc(start, &elsewhere), Err(Blocked::StartTooNear(at(1300, 1000))));
}

/// The path of a tool around a corner, at a radius of a metre.
#[test]
fn arc_around_a_corner_is_clear_almost_at_its_radius() {
    let far = 100_000_000;
    let ring = Ring::new(vec![at(0, 0), at(-far, 0), at(-far, -far), at(0, -far)]).unwrap();
    let part = ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap();
    let arc = Arc::new(at(far, 0), at(0, far), Point::ORIGIN, Turn::CounterClockwise).unwrap();
    assert!(part.arc(free(&part, far, 0, far - 20), &arc).is_ok());
    assert!(part.arc(free(&part, far, 0, far - 1), &arc).is_err());
}

#[test]
fn swept_triangle_is_filled() {
    let part = part();
    // Two points left and right of the square, and a target below it: only the triangle's sides are clear.
    let (left, right) = (free(&part, -2000, 3000, 100), free(&part, 3000, 3000, 100));
    let to = at(500, -3000);
    assert!(
        part.motion(left, to).is_ok()
            && part.motion(right, to).is_ok()
            && part.motion(left, right.point()).is_ok()
    );
    assert!(matches!(part.swept_triangle(left, right, to), Err(Blocked::ByEdge(_))));
    let above = at(500, 5000);
    assert_eq!(part.swept_triangle(left, right, above).unwrap().point(), above);
    // A motion that has not begun.
    assert_eq!(part.swept_triangle(left, left, to).unwrap().point(), to);
    let through = at(3000, -1000);
    assert!(matches!(part.swept_triangle(left, left, through), Err(Blocked::ByEdge(_))));
}

#[test]
fn swept_triangle_names_the_end_with_the_lower_threshold() {
    let part = part();
    let (high, low) = (free(&part, -2000, 0, 200), free(&part, -2000, 10, 100));
    let refused = Err(Blocked::StartTooNear(low.point()));
    assert_eq!(part.swept_triangle(high, low, at(-1500, 0)), refused);
    assert_eq!(part.swept_triangle(low, high, at(-1500, 0)), refused);
}

#[test]
fn polygon_holds_both_ends_of_the_motion() {
    let part = part();
    let start = free(&part, -500, 500, 100);
    let corners = [at(-600, 400), at(-300, 400), at(-300, 600), at(-600, 600)];
    let polygon = Convex::check(&corners).unwrap();
    let to = at(-300, 600);
    assert_eq!(part.polygon(start, polygon, to).unwrap().point(), to);
    assert_eq!(part.polygon(start, polygon, at(-299, 600)), Err(Blocked::StartTooNear(at(-500, 500))));
    let outside = free(&part, -601, 500, 100);
    assert_eq!(part.polygon(outside, polygon, to), Err(Blocked::StartTooNear(at(-601, 500))));
    let wide = [at(-600, 400), at(-50, 400), at(-50, 600), at(-600, 600)];
    let blocked = part.polygon(start, Convex::check(&wide).unwrap(), to);
    assert!(matches!(blocked, Err(Blocked::ByEdge(edge)) if edge.chord.from.x.units() == 0));
}

#[test]
fn retract_moves_away_from_what_is_near() {
    let part = part();
    let start = free(&part, -150, 500, 100);
    let away = at(-400, 700);
    let end = part.retract(start, away, length(300)).unwrap();
    assert_eq!((end.point(), end.threshold()), (away, length(100)));
    assert!(part.retract(start, at(-149, 700), length(300)).is_err(), "it approaches the left edge");
    assert!(part.retract(start, at(-149, 500), length(100)).is_ok(), "nothing is within 100 units of it");
    // Only the upper edge comes nearer, and within the threshold.
    assert!(part.retract(start, at(-150, 1100), length(300)).is_err());
    assert!(part.retract(start, at(-150, 1100), length(140)).is_ok());
}

#[test]
fn path_with_a_gap_has_no_certificate() {
    let part = part();
    let line = |from, to| Curve::Line(Segment { from, to });
    let (a, b, c) = (at(-500, 0), at(-500, 500), at(-500, 900));
    let end = certify_path(&part, length(300), &[line(a, b), line(b, c)]).unwrap();
    assert_eq!(end.map(FreePoint::point), Some(c));
    let gap = certify_path(&part, length(300), &[line(a, b), line(at(-501, 500), c)]).unwrap_err();
    assert_eq!((gap.index, gap.at), (1, b));
    assert!(matches!(gap.cause, keepout_kernel::offset::GougeCause::Discontinuous));
}

/// The simplified outline covers the outline: what the first calls clear is clear of the second.
#[test]
fn simplified_outline_covers_the_outline() {
    let mut random = fastrand::Rng::with_seed(12);
    let corners: Vec<Point> = (0..90)
        .map(|k| {
            let wave = random.i64(-40..40);
            match k / 30 {
                0 => at(k * 300, wave),
                1 => at(9000 + wave, (k - 30) * 300),
                _ => at(9000 - (k - 60) * 300, 9000 - (k - 60) * 300 + 500 + wave),
            }
        })
        .collect();
    let part = ProhibitedRegion::new(Region::new(vec![Ring::new(corners).unwrap()]).unwrap(), Side::Outside)
        .unwrap();
    let simplified = part.simplified(length(50)).unwrap();
    assert!(simplified.edges().len() < 50, "{}", simplified.edges().len());
    let threshold = length(200);
    for _ in 0..20_000 {
        let point = at(random.i64(-1000..10_500), random.i64(-1000..10_500));
        let clear = simplified.point_clear(point, threshold).is_clear();
        assert!(!clear || part.point_clear(point, threshold).is_clear(), "{point:?}");
    }
}

#[test]
fn simplified_ring_keeps_three_chords() {
    let corners: Vec<Point> =
        [(100, 0), (70, 70), (0, 100), (-70, 70), (-100, 0), (-70, -70), (0, -100), (70, -70)]
            .map(|(x, y)| at(x, y))
            .to_vec();
    let part = ProhibitedRegion::new(Region::new(vec![Ring::new(corners).unwrap()]).unwrap(), Side::Outside)
        .unwrap();
    assert!(part.simplified(length(5000)).unwrap().edges().len() >= 3);
}
