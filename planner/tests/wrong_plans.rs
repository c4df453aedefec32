//! Plans that are wrong on purpose. The checkers refuse each, and name the place.

use keepout_kernel::curve::fit_arc;
use keepout_kernel::{Arc, Curve, Length, Point, Segment, Vec2, Vector};
use keepout_planner::Mm2;
use keepout_planner::finish::{FinishingLoop, PathRefusal};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, Cut, PassParameters, Plan, PlanError, PlanParameters};
use keepout_planner::profile::{MachinedSide, ProfileError};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::point_from_mm;

/// A plate with a convex arc like a boss, a slot with round ends, an ellipse and a spline.
const PLATE: &[u8] = include_bytes!("../../tests/drawings/rounded_plate.dxf");

#[expect(clippy::unwrap_used, reason = "our own drawing has a plan")]
fn plan(side: MachinedSide) -> CertifiedPlan {
    let job = PlanParameters { tool_diameter_mm: 4.0, side, ..PlanParameters::default() };
    let request = PlanRequest { job, ..PlanRequest::default() };
    request.plan("plate", PLATE, &MachineProfile::simulated(), &mut |_| {}).unwrap()
}

fn moved(curve: &Curve, by: Vector) -> Curve {
    let point = |p: Point| p.translated(by).expect("near the origin");
    match curve {
        Curve::Line(Segment { from, to }) => Curve::Line(Segment { from: point(*from), to: point(*to) }),
        Curve::Arc(arc) => {
            let moved = Arc::new(point(arc.from()), point(arc.to()), point(arc.centre()), arc.turn());
            Curve::Arc(moved.expect("the same arc elsewhere"))
        }
    }
}

fn refusal(plan: Plan) -> PathRefusal {
    match error_of(plan.certify(), "a wrong plan") {
        PlanError::Pass { number: 1, refusal } => refusal,
        other => panic!("{other}"),
    }
}

const SIDES: [MachinedSide; 2] = [MachinedSide::Outside, MachinedSide::Inside];

#[test]
fn loop_moved_by_two_micrometres_is_refused() {
    for side in SIDES {
        let good = plan(side).plan;
        for index in 0..good.finish().loops.len() {
            for (dx, dy) in [(200, 0), (-200, 0), (0, 200), (0, -200)] {
                let mut wrong = good.clone();
                let each = &mut wrong.passes[0].path_mut().loops[index];
                each.curves = each.curves.iter().map(|curve| moved(curve, Vector { dx, dy })).collect();
                let refusal = refusal(wrong);
                let named = matches!(&refusal, PathRefusal::Gouge { number, .. } if *number == index + 1);
                assert!(named, "loop {index}, {dx} {dy}: {refusal}");
            }
        }
    }
}

/// A review found this: the program printed impossible figures of the rest material above the proved
/// statements.
#[test]
fn impossible_rest_material_figures_are_refused() {
    let good = plan(MachinedSide::Outside).plan;
    assert!(good.clone().certify().is_ok());
    for (residual, length, area) in [
        (f64::NAN, 1.0, 0.0),
        (-5.0, 1.0, 0.0),
        (1e9, 1.0, 0.0),
        (0.0, 0.5, 0.0),
        (0.0, f64::INFINITY, 0.0),
        (0.0, 1.0, f64::NAN),
        (0.0, 1.0, -1.0),
    ] {
        let mut wrong = good.clone();
        let path = wrong.passes[0].path_mut();
        path.residual_length_mm = residual;
        path.profile_length_mm *= length;
        path.residual_area_mm2 = Some(area);
        let refusal = refusal(wrong);
        assert!(matches!(refusal, PathRefusal::Residual { .. }), "{refusal}");
        assert!(refusal.to_string().contains(&format!("{area} mm²")), "{refusal}");
    }
}

/// A path that is clear of the part and complete can still differ from the request.
#[test]
fn reversed_misplaced_or_added_loops_are_refused() {
    for side in SIDES {
        let good = plan(side).plan;
        for index in 0..good.finish().loops.len() {
            let mut wrong = good.clone();
            let each = &mut wrong.passes[0].path_mut().loops[index];
            each.curves = each.curves.iter().rev().map(|curve| curve.reversed().expect("turned")).collect();
            let refusal = refusal(wrong);
            assert!(matches!(refusal, PathRefusal::WrongWay { number } if number == index + 1), "{refusal}");
            let mut wrong = good.clone();
            wrong.passes[0].path_mut().loops[index].component += 7;
            let refusal = self::refusal(wrong);
            assert!(
                matches!(refusal, PathRefusal::WrongSpace { number, .. } if number == index + 1),
                "{refusal}"
            );
        }
    }
    let mut wrong = plan(MachinedSide::Outside).plan;
    let loops = &mut wrong.passes[0].path_mut().loops;
    let far = Vector { dx: -20_000_000, dy: 0 };
    let away = loops[0].curves.iter().map(|curve| moved(curve, far)).collect();
    loops.push(FinishingLoop { curves: away, component: 0 });
    let (refusal, number) = (refusal(wrong.clone()), wrong.finish().loops.len());
    assert!(matches!(refusal, PathRefusal::Elsewhere { number: found, .. } if found == number), "{refusal}");
}

/// The sides of the triangle touch the path at their midpoints. The distance of its corners from the part is
/// about the path's radius.
#[test]
fn added_triangle_around_the_path_is_refused() {
    let circle = b"0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n10\n0\n20\n0\n40\n30\n0\nENDSEC\n0\nEOF\n";
    let job = PlanParameters { tool_diameter_mm: 4.0, ..PlanParameters::default() };
    let request = PlanRequest { job, ..PlanRequest::default() };
    let mut wrong =
        request.plan("circle", circle, &MachineProfile::simulated(), &mut |_| {}).expect("a circle").plan;
    let loops = &mut wrong.passes[0].path_mut().loops;
    let start = loops[0].curves[0].from();
    let radius = f64::from(start.x.units()).hypot(f64::from(start.y.units())) + 2.0;
    let corner = |third: u32| {
        let (sine, cosine) = (f64::from(third % 3) * 120.0).to_radians().sin_cos();
        point_from_mm(Mm2::new(2.0 * radius * cosine / 1e5, 2.0 * radius * sine / 1e5))
            .expect("near the origin")
    };
    let curves = (0..3).map(|k| Curve::Line(Segment { from: corner(k), to: corner(k + 1) })).collect();
    loops.push(FinishingLoop { curves, component: 0 });
    let refusal = refusal(wrong);
    assert!(matches!(refusal, PathRefusal::Elsewhere { number: 2, .. }), "{refusal}");
}

#[test]
fn feed_out_of_range_is_refused() {
    for mm_min in [0, 600_001, u32::MAX] {
        let mut wrong = plan(MachinedSide::Outside).plan;
        wrong.passes[0].feed_mm_min = Some(mm_min);
        let error = error_of(wrong.certify(), "a wrong feed").to_string();
        assert!(error.contains(&format!("a feed of {mm_min} mm/min")), "{error}");
    }
}

/// A plan file can state any tool and any margin. Without a check of these figures, a path that fits them
/// would be accepted.
#[test]
fn tool_of_zero_diameter_or_wrong_margin_terms_are_refused() {
    let good = plan(MachinedSide::Outside).plan;
    let wrong = |change: &dyn Fn(&mut Plan)| {
        let mut wrong = good.clone();
        change(&mut wrong);
        error_of(wrong.certify(), "a wrong plan").to_string()
    };
    let error = wrong(&|plan| plan.tool_radius = Length::ZERO);
    assert!(error.contains("a tool diameter of 0 mm is out of range"), "{error}");
    let error = wrong(&|plan| plan.budget.terms.clear());
    assert!(error.contains("\"lattice rounding\" does not fit the plan's machine"), "{error}");
    let error = wrong(&|plan| plan.budget.terms[2].mm = 0.0);
    assert!(error.contains("\"controller resolution: step\""), "{error}");
    let error = wrong(&|plan| plan.machine.report_digit_mm = 0.01);
    assert!(error.contains("\"controller resolution: report\""), "{error}");
    let error = wrong(&|plan| plan.budget.terms[5].mm += 0.01);
    assert!(error.contains("\"controller arcs\""), "{error}");
}

/// A path 2 µm farther out everywhere: it gouges no part, but the checker finds the stock that it leaves.
#[test]
fn path_two_micrometres_too_far_out_is_refused() {
    for side in SIDES {
        let good = plan(side).plan;
        let job = PlanParameters {
            tool_diameter_mm: 4.0,
            side,
            passes: vec![PassParameters { stock_to_leave_mm: 0.002, feed_mm_min: None }],
            ..PlanParameters::default()
        };
        let request = PlanRequest { job, ..PlanRequest::default() };
        let farther = request.plan("plate", PLATE, &MachineProfile::simulated(), &mut |_| {}).unwrap().plan;
        let mut wrong = good.clone();
        wrong.passes[0].path = farther.passes[0].path.clone();
        let refusal = refusal(wrong);
        assert!(matches!(refusal, PathRefusal::Incomplete(_)), "{refusal}");
    }
}

#[test]
fn missing_loop_is_refused_with_its_place() {
    for side in SIDES {
        let good = plan(side).plan;
        for index in 0..good.finish().loops.len() {
            let mut wrong = good.clone();
            let gone = wrong.passes[0].path_mut().loops.remove(index);
            let PathRefusal::Incomplete(missing) = refusal(wrong) else { panic!("a loop is missing") };
            let nearest = gone
                .curves
                .iter()
                .flat_map(|curve| curve.chord_points(keepout_kernel::Length::small(200)).unwrap())
                .map(|p| p.minus(missing.at))
                .map(|d| f64::from(d.dx).hypot(f64::from(d.dy)))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest < 200_000.0, "loop {index}: the place is {nearest} units from the loop");
        }
    }
}

/// The chord replaces each arc with a sagitta above 2 µm. It is too near the part where the arc runs around
/// the part, and too far away in hollows.
#[test]
fn arc_replaced_by_its_chord_is_refused() {
    let (mut gouged, mut missing) = (0, 0);
    for side in SIDES {
        let good = plan(side).plan;
        for (index, each) in good.finish().loops.iter().enumerate() {
            for (k, curve) in each.curves.iter().enumerate() {
                let Curve::Arc(arc) = curve else { continue };
                let chord = Segment { from: arc.from(), to: arc.to() };
                let length = Curve::Line(chord).length();
                if length * length / (8.0 * keepout_kernel::curve::radius(arc)) < 200.0 {
                    continue;
                }
                let mut wrong = good.clone();
                wrong.passes[0].path_mut().loops[index].curves[k] = Curve::Line(chord);
                match refusal(wrong) {
                    PathRefusal::Gouge { number, gouge } => {
                        assert_eq!((number, gouge.index), (index + 1, k));
                        gouged += 1;
                    }
                    PathRefusal::Incomplete(_) => missing += 1,
                    other => panic!("{other}"),
                }
            }
        }
    }
    assert!(gouged > 10 && missing > 5, "{gouged} gouges, {missing} stretches missing");
}

#[test]
fn open_loop_is_refused() {
    let mut wrong = plan(MachinedSide::Outside).plan;
    wrong.passes[0].path_mut().loops[0].curves.pop();
    assert!(matches!(refusal(wrong), PathRefusal::OpenLoop { number: 1 }));
}

/// Edges that leave the spline or ellipse that they replace by more than their chord-error bound.
#[test]
fn edges_that_leave_their_curve_are_refused() {
    let good = plan(MachinedSide::Outside).plan;
    let mut tampered = 0;
    for index in 0..good.profile.loops.len() {
        for source in 0..good.profile.loops[index].sources.len() {
            // The edges claim a chord-error bound of 0.05 µm, a twentieth of the bound that they keep.
            let mut wrong = good.clone();
            let each = &mut wrong.profile.loops[index];
            let (first, end) = (each.sources[source].first, each.sources[source].end);
            for edge in &mut each.edges[first..end] {
                edge.chord_error = keepout_kernel::Length::small(5);
            }
            let error = error_of(wrong.certify(), "a chord-error bound that is too small");
            assert!(matches!(error, PlanError::Profile(ProfileError::Curve { .. })), "{error}");
            // The centre of an arc in the middle moves half-way to its chord.
            let mut wrong = good.clone();
            let each = &mut wrong.profile.loops[index];
            let edge = &mut each.edges[usize::midpoint(first, end)];
            if let Curve::Arc(arc) = edge.curve {
                let c = arc.centre();
                let off = Vec2::from(arc.from()).midpoint(arc.to().into()) - Vec2::from(c);
                let nearer = Vec2::from(c) + off * 0.5;
                edge.curve = Curve::Arc(fit_arc(arc.from(), arc.to(), nearer, arc.turn()).unwrap());
                let error = error_of(wrong.certify(), "an arc that leaves the curve");
                assert!(matches!(error, PlanError::Profile(ProfileError::Curve { .. })), "{error}");
                tampered += 1;
            }
        }
    }
    assert!(tampered >= 5, "only {tampered} arcs were bent");
}

/// A keep-out zone that was not part of the request when the path was planned.
#[test]
fn keep_out_zone_on_the_path_is_refused() {
    let clamps = include_bytes!("../../tests/drawings/clamps.dxf");
    let mut request = PlanRequest { travel_layer: Some("TABLE".into()), ..PlanRequest::default() };
    request.choice.without.push("CLAMPS".into());
    let bare = request.plan("clamps", clamps, &MachineProfile::simulated(), &mut |_| {}).unwrap().plan;
    request.choice.without.clear();
    request.keep_out_layers.push("CLAMPS".into());
    let clamped = request.plan("clamps", clamps, &MachineProfile::simulated(), &mut |_| {}).unwrap().plan;
    let mut wrong = bare;
    wrong.zones = clamped.zones;
    assert!(matches!(refusal(wrong), PathRefusal::Gouge { .. }));
}

/// Climb milling has the part on the right, conventional milling has it on the left. Lead-in and lead-out are
/// tangential in both.
#[test]
fn climb_and_conventional_cuts_run_in_opposite_directions() {
    for (cut, left) in [(Cut::Conventional, true), (Cut::Climb, false)] {
        let job = PlanParameters { tool_diameter_mm: 4.0, cut, ..PlanParameters::default() };
        let request = PlanRequest { job, ..PlanRequest::default() };
        let plan = request.plan("plate", PLATE, &MachineProfile::simulated(), &mut |_| {}).unwrap();
        let field = plan.part.region().bounds();
        let (x, y, ..) = field.corners();
        let room = keepout_kernel::Length::from_units(3_000_000).unwrap();
        let from = Point::from_units(i64::from(x) - 1_000_000, y.into()).unwrap();
        let job = keepout_planner::job::contour_job(&plan, from.in_plane(), field.grown(room)).unwrap();
        let cuts: Vec<_> = job.legs.iter().filter(|leg| leg.cuts.is_some()).collect();
        assert_eq!((cuts.len(), job.tangential), (1, 1));
        let curves = &cuts[0].curves;
        assert!(curves.windows(2).all(|pair| pair[0].to() == pair[1].from()), "no jumps");
        // Twice the area within the cut, which goes around the part once. It is positive if the part is on
        // the left.
        let xy = keepout_kernel::Vec2::from;
        let area: f64 = curves
            .iter()
            .flat_map(|curve| {
                curve
                    .chord_points(keepout_kernel::Length::small(200))
                    .unwrap()
                    .windows(2)
                    .map(|p| (xy(p[0]), xy(p[1])))
                    .collect::<Vec<_>>()
            })
            .map(|(a, b)| a.x * b.y - a.y * b.x)
            .sum();
        assert_eq!(area > 0.0, left, "{cut:?}");
        // The lead-in is a line and an arc that ends in the direction of the contour.
        let Curve::Arc(lead) = curves[1] else { panic!("{:?}", curves[1]) };
        let (_, at_end) = keepout_planner::units::along_mm(&Curve::Arc(lead), 1.0);
        let (_, at_begin) = keepout_planner::units::along_mm(&curves[2], 0.0);
        assert!((at_end.cross(at_begin)).abs() < 0.01, "{at_end:?} {at_begin:?}");
    }
}

/// The error. A result without an error is too long to print.
fn error_of<T, E>(result: Result<T, E>, what: &str) -> E {
    match result {
        Err(error) => error,
        Ok(_) => panic!("{what} was accepted"),
    }
}
