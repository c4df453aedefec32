use keepout_planner::Mm2;
use keepout_planner::profile::MachinedSide;

use super::*;

const SQUARE: [Mm2; 4] = [Mm2::ZERO, Mm2::new(40.0, 0.0), Mm2::new(40.0, 40.0), Mm2::new(0.0, 40.0)];
const TRIANGLE: [Mm2; 3] = [Mm2::ZERO, Mm2::new(40.0, 0.0), Mm2::new(10.0, 30.0)];

/// The true distance to the polygon's boundary.
fn true_distance_mm(profile: &[Mm2], p: Mm2) -> f64 {
    segments(profile).map(|(a, b)| p.distance(p.nearest_on(a, b))).fold(f64::INFINITY, f64::min)
}

fn near(a: f64, b: f64, within: f64) -> bool {
    (a - b).abs() <= within
}

/// Points 0.01 mm apart from `a` to `b`, which avoid whole coordinates.
fn travel(a: Mm2, b: Mm2) -> impl Iterator<Item = Mm2> {
    let steps = (a.distance(b) * 100.0).round();
    let shares = (0_u32..).map(f64::from).take_while(move |i| *i < steps).map(move |i| (i + 0.5) / steps);
    shares.map(move |t| a + (b - a) * t)
}

mod matrix {
    use super::*;

    #[test]
    fn distance_is_accurate_to_half_the_separation() {
        let matrix = PointMatrix::new(&TRIANGLE, 0.5).unwrap();
        for p in [(50.0, -3.0), (12.0, 8.0), (-4.0, 21.0)].map(Mm2::from) {
            let excess = matrix.distance_mm(p) - true_distance_mm(&TRIANGLE, p);
            assert!((-1e-12..=0.25).contains(&excess), "{p:?}: {excess}");
        }
        assert!(matrix.invades(Mm2::new(40.5, 0.0), 0.5) && !matrix.invades(Mm2::new(40.6, 0.0), 0.5));
    }

    #[test]
    fn invalid_separations_are_rejected() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-6] {
            assert!(PointMatrix::new(&SQUARE, bad).is_err(), "{bad}");
        }
        assert!(PointMatrix::new(&[Mm2::new(f64::NAN, 0.0), Mm2::new(1.0, 0.0)], 1.0).is_err());
        assert!(PointMatrix::new(&[], 1.0).unwrap().is_empty());
    }

    #[test]
    fn defect_a_tool_passes_between_two_points() {
        let matrix = PointMatrix::new(&SQUARE, 1.0).unwrap();
        let across = || travel(Mm2::new(5.5, -6.0), Mm2::new(5.5, 6.0));
        assert!(across().all(|p| !matrix.invades(p, 0.49)));
        assert!(across().any(|p| true_distance_mm(&SQUARE, p) < 0.01));
    }

    #[test]
    fn defect_cost_grows_with_resolution() {
        let points = |spacing_mm| PointMatrix::new(&SQUARE, spacing_mm).unwrap().len();
        assert_eq!((points(1.0), points(0.1), points(0.01)), (160, 1600, 16_000));
    }
}

mod angles {
    use super::*;

    #[test]
    fn sum_is_360_inside_and_less_outside() {
        assert!(near(angle_sum_deg(Mm2::new(15.0, 10.0), TRIANGLE), 360.0, 1e-9));
        assert!(angle_sum_deg(Mm2::new(15.0, -10.0), TRIANGLE) < 350.0);
        assert!(!is_external(Mm2::new(15.0, 10.0), TRIANGLE) && is_external(Mm2::new(41.0, 0.0), TRIANGLE));
        assert!(
            angle_sum_invades(&TRIANGLE, Mm2::new(15.0, 1.0))
                && !angle_sum_invades(&TRIANGLE, Mm2::new(15.0, -1.0))
        );
    }

    #[test]
    fn defect_an_invasion_is_detected_only_after_it_happened() {
        assert!(!angle_sum_invades(&TRIANGLE, Mm2::new(15.0, -0.001)));
        assert!(angle_sum_invades(&TRIANGLE, Mm2::new(15.0, 0.001)));
    }

    #[test]
    fn defect_on_the_boundary_rounding_decides() {
        let sums = || (1_u32..4000).map(|i| angle_sum_deg(Mm2::new(f64::from(i) * 0.01, 0.0), TRIANGLE));
        assert!(sums().all(|sum| near(sum, 360.0, 1e-12)));
        assert!(sums().any(|sum| sum < 360.0) && sums().any(|sum| sum >= 360.0));
        // A corner is on the boundary too, but only one of its three angles exists.
        assert!(near(angle_sum_deg(Mm2::ZERO, TRIANGLE), 3.0_f64.atan().to_degrees(), 1e-9));
        assert!(is_external(Mm2::ZERO, TRIANGLE));
    }

    #[test]
    fn defect_wrong_on_both_sides_of_a_concave_corner() {
        let notched = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (20.0, 10.0), (0.0, 40.0)].map(Mm2::from);
        let (in_notch, in_part) = (Mm2::new(21.0, 13.0), Mm2::new(25.0, 15.0));
        assert!(angle_sum_invades(&notched, in_notch));
        assert!(!angle_sum_invades(&notched, in_part));
        assert!(near(true_distance_mm(&notched, in_notch), 0.832, 0.001));
        assert!(near(true_distance_mm(&notched, in_part), 1.387, 0.001));
    }

    #[test]
    fn defect_a_triangle_is_not_the_whole_of_a_rectangle() {
        let rectangle = [(0.0, 0.0), (40.0, 0.0), (40.0, 10.0), (0.0, 10.0)].map(Mm2::from);
        let in_part = Mm2::new(2.0, 1.0);
        assert!(!angle_sum_invades(&rectangle, in_part));
        assert!(near(true_distance_mm(&rectangle, in_part), 1.0, 1e-12));
    }
}

mod intervals {
    use super::*;

    const BOTH: [Classified; 2] = [Classified::ByX, Classified::ByXOrY];

    #[test]
    fn distance_is_exact_beside_a_segment() {
        for classified in BOTH {
            let intervals = Intervals::new(&TRIANGLE, classified);
            let (segment, distance_mm) = intervals.nearest(Mm2::new(28.0, 15.0)).unwrap();
            assert_eq!(segment, 1);
            assert!(near(distance_mm, true_distance_mm(&TRIANGLE, Mm2::new(28.0, 15.0)), 1e-12));
            assert!(
                intervals.invades(Mm2::new(20.0, -1.0), 1.0) && !intervals.invades(Mm2::new(20.0, -1.1), 1.0)
            );
        }
        assert_eq!(Intervals::new(&[], Classified::ByXOrY).nearest(Mm2::ZERO), None);
        assert_eq!(Intervals::new(&[Mm2::new(1.0, 1.0)], Classified::ByX).nearest(Mm2::new(1.0, 1.0)), None);
    }

    #[test]
    fn defect_by_x_a_vertical_segment_is_never_detected() {
        let through = || travel(Mm2::new(-10.0, 20.0), Mm2::new(50.0, 20.0));
        let by_x = Intervals::new(&SQUARE, Classified::ByX);
        assert!(through().all(|p| !by_x.invades(p, 5.0)));
        assert!(through().any(|p| true_distance_mm(&SQUARE, p) < 0.01));
        assert_eq!(by_x.nearest(Mm2::new(-0.005, 20.0)), None);
        assert!(Intervals::new(&SQUARE, Classified::ByXOrY).invades(Mm2::new(-5.0, 20.0), 5.0));
    }

    #[test]
    fn defect_a_line_without_ends_is_near_far_from_the_segment() {
        let wedge = [(0.0, 0.0), (100.0, 1.0), (0.0, 20.0)].map(Mm2::from);
        let beyond = Mm2::new(150.0, 0.9);
        let (segment, distance_mm) = Intervals::new(&wedge, Classified::ByXOrY).nearest(beyond).unwrap();
        assert_eq!(segment, 0);
        assert!(near(distance_mm, 0.6, 1e-3), "{distance_mm}");
        assert!(near(true_distance_mm(&wedge, beyond), 50.0, 1e-3));
        // The same wedge with x and y exchanged, by x intervals.
        let upright = wedge.map(|Mm2 { x, y }| Mm2::new(y, x));
        assert!(Intervals::new(&upright, Classified::ByX).invades(Mm2::new(0.9, 150.0), 1.0));
    }

    #[test]
    fn defect_beyond_a_corner_no_interval_contains_the_tool() {
        let tip = [(0.0, 0.0), (30.0, 10.0), (10.0, 30.0)].map(Mm2::from);
        let beyond = Mm2::new(-0.01, -0.01);
        for classified in BOTH {
            assert_eq!(Intervals::new(&tip, classified).nearest(beyond), None);
        }
        assert!(near(true_distance_mm(&tip, beyond), 0.0141, 1e-4));
    }

    #[test]
    fn defect_no_sign_a_tool_past_the_band_is_not_detected() {
        for classified in BOTH {
            let intervals = Intervals::new(&SQUARE, classified);
            let queries = [(20.0, -5.1), (20.0, 5.1), (20.0, 20.0)].map(Mm2::from);
            assert!(queries.iter().all(|&p| !intervals.invades(p, 5.0)));
            assert!(intervals.invades(Mm2::new(20.0, 0.0), 5.0));
        }
    }
}

mod tool_radius {
    use super::*;

    const QUADRILATERAL: [Mm2; 4] =
        [Mm2::ZERO, Mm2::new(60.0, 5.0), Mm2::new(50.0, 45.0), Mm2::new(-5.0, 30.0)];
    /// A step of 3 mm on the upper side.
    const STEPPED: [Mm2; 8] = [
        Mm2::ZERO,
        Mm2::new(60.0, 0.0),
        Mm2::new(60.0, 40.0),
        Mm2::new(33.0, 40.0),
        Mm2::new(33.0, 43.0),
        Mm2::new(30.0, 43.0),
        Mm2::new(30.0, 40.0),
        Mm2::new(0.0, 40.0),
    ];

    #[test]
    fn turn_and_setback_agree_with_known_angles() {
        let quarter = turn_rad(Mm2::ZERO, Mm2::new(10.0, 0.0), Mm2::new(10.0, -7.0));
        assert!(near(quarter, std::f64::consts::FRAC_PI_2, 1e-12));
        assert!(near(setback_mm(3.0, quarter), 3.0, 1e-12));
        assert!(near(
            setback_mm(3.0, turn_rad(Mm2::ZERO, Mm2::new(1.0, 0.0), Mm2::new(5.0, 0.0))),
            0.0,
            1e-12
        ));
        assert!(is_above(Mm2::ZERO, Mm2::new(5.0, 1.0), Mm2::new(10.0, 0.0)));
        assert!(!is_above(Mm2::ZERO, Mm2::new(5.0, -1.0), Mm2::new(10.0, 0.0)));
        assert!(!is_above(Mm2::ZERO, Mm2::new(5.0, 0.0), Mm2::new(10.0, 0.0)));
    }

    /// Checks that each corner of the result has the distance R from the lines of the two segments there, on
    /// the correct side.
    fn assert_mitred(profile: &[Mm2], radius_mm: f64, side: MachinedSide) {
        let result = prohibited(profile, radius_mm, side).unwrap();
        assert_eq!(result.len(), profile.len());
        let counter_clockwise = segments(profile).map(|(a, b)| a.cross(b)).sum::<f64>() > 0.0;
        let away = if counter_clockwise == (side == MachinedSide::Inside) { radius_mm } else { -radius_mm };
        for (a, b) in segments(profile) {
            let left_of = |p: Mm2| (b - a).cross(p - a) / a.distance(b);
            let on_shifted = |p: &Mm2| near(left_of(*p), away, 1e-9);
            assert_eq!(result.iter().filter(|p| on_shifted(p)).count(), 2, "{result:?}");
            let along = |(p, q): &(Mm2, Mm2)| on_shifted(p) && on_shifted(q);
            assert_eq!(segments(&result).filter(along).count(), 1, "{result:?}");
        }
    }

    #[test]
    fn result_is_the_mitred_offset_for_both_route_directions() {
        let reversed = |profile: &[Mm2]| profile.iter().rev().copied().collect::<Vec<_>>();
        assert_mitred(&TRIANGLE, 4.0, MachinedSide::Outside);
        assert_mitred(&reversed(&TRIANGLE), 4.0, MachinedSide::Outside);
        assert_mitred(&QUADRILATERAL, 4.0, MachinedSide::Inside);
        assert_mitred(&reversed(&QUADRILATERAL), 4.0, MachinedSide::Inside);
        // A concave corner, machined from outside, uses eq. (13).
        let notched = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (20.0, 10.0), (0.0, 40.0)].map(Mm2::from);
        assert_mitred(&notched, 2.0, MachinedSide::Outside);
    }

    #[test]
    fn filter_removes_corners_closer_than_the_setback() {
        assert_eq!(filter_very_close(&STEPPED, 2.9), STEPPED);
        assert_eq!(filter_very_close(&SQUARE, 40.0), SQUARE);
        assert_eq!(filter_very_close(&SQUARE, 40.1).len(), 2);
        let whisker = [(0.0, 0.0), (40.0, 0.0), (60.0, 0.0), (40.0, 0.0), (0.0, 40.0)].map(Mm2::from);
        assert_eq!(filter_very_close(&whisker, 4.0).len(), 3);
    }

    #[test]
    fn invalid_profiles_are_rejected() {
        let rejected =
            |profile: &[Mm2], radius_mm| prohibited(profile, radius_mm, MachinedSide::Outside).unwrap_err();
        assert_eq!(rejected(&SQUARE, 0.0), RadiusError::Radius { radius_mm: 0.0 });
        assert_eq!(rejected(&SQUARE, 50.0), RadiusError::TooFew { left: 2, radius_mm: 50.0 });
        assert_eq!(rejected(&[], 1.0), RadiusError::TooFew { left: 0, radius_mm: 1.0 });
        let repeated = [(0.0, 0.0), (4.0, 0.0), (4.0, 0.0), (0.0, 4.0)].map(Mm2::from);
        assert_eq!(rejected(&repeated, 1.0), RadiusError::Repeats { index: 2, at: Mm2::new(4.0, 0.0) });
        let closed = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0), (0.0, 0.0)].map(Mm2::from);
        assert_eq!(rejected(&closed, 1.0), RadiusError::Repeats { index: 0, at: Mm2::ZERO });
        let error = rejected(&[Mm2::ZERO, Mm2::new(f64::INFINITY, 0.0), Mm2::new(0.0, 4.0)], 1.0);
        assert!(matches!(error, RadiusError::NotFinite { index: 1, .. }));
        let line = [(0.0, 0.0), (4.0, 0.0), (9.0, 0.0)].map(Mm2::from);
        assert!(matches!(rejected(&line, 1.0), RadiusError::TooFew { .. }));
    }

    #[test]
    fn defect_an_acute_corner_prohibits_a_long_spike() {
        let needle = [(0.0, 0.0), (100.0, -10.0), (100.0, 10.0)].map(Mm2::from);
        let result = prohibited(&needle, 5.0, MachinedSide::Outside).unwrap();
        let reach = result.iter().map(|&p| true_distance_mm(&needle, p)).fold(0.0, f64::max);
        let half_angle = 0.1_f64.atan();
        assert!(near(reach, 5.0 / half_angle.sin(), 1e-6));
        assert!(near(reach, 50.249, 1e-3), "{reach}");
    }

    #[test]
    fn defect_the_filter_removes_corners_of_the_part_and_the_path_cuts_it() {
        let path = prohibited(&STEPPED, 4.0, MachinedSide::Outside).unwrap();
        let step = [(33.0, 43.0), (30.0, 43.0)].map(Mm2::from);
        let kept = filter_very_close(&STEPPED, 4.0);
        assert!(step.iter().all(|corner| !kept.contains(corner)) && kept.len() == 6);
        // The tool cuts the whole step of 3 mm off: its centre passes 1 mm above the step.
        for corner in step {
            let depth_mm = 4.0 - true_distance_mm(&path, corner);
            assert!(near(depth_mm, 3.0, 1e-9), "{depth_mm}");
        }
        // With a smaller tool the filter removes no corner, and the tool does not cut the part.
        let unfiltered = prohibited(&STEPPED, 2.9, MachinedSide::Outside).unwrap();
        assert!(STEPPED.iter().all(|&corner| true_distance_mm(&unfiltered, corner) >= 2.9 - 1e-9));
    }
}

mod operations {
    use super::*;

    /// The counted formulas are those of the checks: the same verdicts everywhere.
    #[test]
    fn counted_checks_are_the_checks() {
        let matrix = PointMatrix::new(&TRIANGLE, 1.0).unwrap();
        let intervals = Intervals::new(&TRIANGLE, Classified::ByXOrY);
        let mut random = fastrand::Rng::with_seed(7);
        let mut found = [0; 3];
        for _ in 0..20_000 {
            let p = Mm2::new(random.f64() * 60.0 - 10.0, random.f64() * 50.0 - 10.0);
            let counted = [
                of_matrix(matrix.points(), p, 1.0).1,
                of_angles(&TRIANGLE, p).1,
                of_intervals(&TRIANGLE, p, 1.0).1,
            ];
            let checks = [matrix.invades(p, 1.0), angle_sum_invades(&TRIANGLE, p), intervals.invades(p, 1.0)];
            assert_eq!(counted, checks, "{p:?}");
            for (found, invades) in found.iter_mut().zip(checks) {
                *found += u32::from(invades);
            }
        }
        assert!(found.iter().all(|&found| found > 500), "{found:?}");
    }

    /// Operations of a triangle by hand. The second method looks for the nearest segment as the third does, and adds
    /// six differences, three cross and three dot products, three arctangents, two sums and a comparison.
    #[test]
    fn operations_are_those_counted_by_hand() {
        let inside = Mm2::new(15.0, 10.0);
        let (points, _) = of_matrix(&[Mm2::ZERO, SQUARE[1]], inside, 1.0);
        let each = Operations { sums: 3, products: 2, roots: 1, arctangents: 0, comparisons: 1 };
        assert_eq!(points.total(), 2 * each.total());
        assert_eq!((points.sums, points.products, points.roots, points.comparisons), (6, 4, 2, 2));
        let ((angles, _), (intervals, _)) =
            (of_angles(&TRIANGLE, inside), of_intervals(&TRIANGLE, inside, 1.0));
        // All three segments have the point in an interval: eq. (2) takes 6 sums, 5 products and a root for each.
        assert_eq!((intervals.sums, intervals.products, intervals.roots), (18, 15, 3));
        assert_eq!(angles.sums - intervals.sums, 6 + 6 + 2);
        assert_eq!((angles.products - intervals.products, angles.arctangents), (12, 3));
        assert_eq!(angles.comparisons, intervals.comparisons);
    }

    #[test]
    fn third_check_needs_the_fewest_operations() {
        for profile in [&TRIANGLE[..], &SQUARE] {
            let [angles, intervals] = mean_operations(profile);
            let matrix = PointMatrix::new(profile, 1.0).unwrap();
            let (points, _) = of_matrix(matrix.points(), Mm2::ZERO, 1.0);
            #[expect(clippy::cast_precision_loss, reason = "a count of operations")]
            let points = points.total() as f64;
            assert!(intervals < angles && angles < points, "{intervals} {angles} {points}");
        }
    }
}
