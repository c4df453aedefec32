//! Part and air cannot be swapped silently.

use keepout_planner::select::InkSide;
use keepout_tests::order;

use crate::dxf::{PlainXy, SmallDrawing};
use crate::{inspected, plan, plan_with};

const PLATE: [PlainXy; 4] = [(0.0, 0.0), (60.0, 0.0), (60.0, 30.0), (0.0, 30.0)];

/// A plate whose lines end a little before its corners, with a hole.
fn plate_with_gaps(gap: f64) -> SmallDrawing {
    SmallDrawing::mm().lines(&PLATE, (-gap, 0.0)).circle((30.0, 15.0), 5.0)
}

// Evidence for SR-27.
#[test]
fn open_outline_around_a_hole_is_a_problem_even_with_leave_out_open() {
    let sketch = plate_with_gaps(0.1);
    let mut request = order(3.0);
    request.selection.leave_out_open = true;
    let error = plan_with(&sketch, &request).unwrap_err();
    assert!(error.contains("4 chains of open curves surround"), "{error}");
    assert!(error.contains("part and air would be swapped"), "{error}");
}

#[test]
fn message_about_an_open_contour_does_not_recommend_to_leave_it_out() {
    let error = plan(&plate_with_gaps(0.1), 3.0).unwrap_err();
    assert!(!error.contains("--leave-out-open"), "{error}");
}

#[test]
fn one_remedy_closes_all_gaps_and_does_so() {
    let sketch = plate_with_gaps(0.1);
    let error = plan(&sketch, 3.0).unwrap_err();
    assert!(
        error.starts_with("All 8 loose ends have another within 0.100 mm: --join-mm 0.11 closes"),
        "{error}"
    );
    assert!(inspected(&sketch).gaps.unwrap().contains("--join-mm 0.11"));
    let mut request = order(3.0);
    request.join_mm = 0.11;
    assert_eq!(plan_with(&sketch, &request).unwrap().contours().len(), 2);
}

#[test]
fn open_lines_beside_the_part_are_still_left_out() {
    let sketch = SmallDrawing::mm().plate(PLATE[0], PLATE[2]).line((70.0, 0.0), (80.0, 10.0));
    let mut request = order(3.0);
    request.selection.leave_out_open = true;
    let plan = plan_with(&sketch, &request).unwrap();
    assert_eq!((plan.contours().len(), plan.plan.provenance.left_out.len()), (1, 1));
}

// Evidence for SR-27.
#[test]
fn open_tab_on_the_outline_is_a_problem() {
    let tab = |sketch: SmallDrawing| {
        sketch
            .line((20.0, 30.0), (20.0, 40.0))
            .line((20.0, 40.0), (40.0, 40.0))
            .line((40.0, 40.0), (40.0, 30.0))
    };
    let mut request = order(3.0);
    request.selection.leave_out_open = true;
    let error = plan_with(&tab(SmallDrawing::mm().plate(PLATE[0], PLATE[2])), &request).unwrap_err();
    assert!(error.contains("begins and ends on a contour"), "{error}");
}

#[test]
fn dashed_outline_around_a_hole_is_a_problem_with_two_remedies() {
    let sketch = SmallDrawing::mm().loop_on("0", "6\nDASHED\n", &PLATE).circle((30.0, 15.0), 5.0);
    let error = plan(&sketch, 3.0).unwrap_err();
    assert!(error.contains("line type DASHED") && error.contains("--line-type DASHED"), "{error}");
    assert_eq!(inspected(&sketch).problems.len(), 1);
    let mut taken = order(3.0);
    taken.choice.line_types = vec!["DASHED".into()];
    assert_eq!(plan_with(&sketch, &taken).unwrap().contours().len(), 2);
    let mut stated = order(3.0);
    stated.choice.without_line_types = vec!["dashed".into()];
    assert_eq!(plan_with(&sketch, &stated).unwrap().contours().len(), 1);
}

/// A bolt circle and centre lines within a flange surround no outline.
#[test]
fn centre_lines_within_the_part_are_no_problem() {
    let ring: Vec<PlainXy> = (0..36).map(|k| (f64::from(k) * 10_f64.to_radians()).sin_cos()).collect();
    let scaled = |r: f64| ring.iter().map(|(x, y)| (r * x, r * y)).collect::<Vec<_>>();
    let sketch = SmallDrawing::mm()
        .circle((0.0, 0.0), 40.0)
        .circle((0.0, 0.0), 10.0)
        .circle((25.0, 0.0), 3.0)
        .loop_on("0", "6\nCENTER\n", &scaled(25.0))
        .loop_on("0", "6\nCENTER\n", &[(-50.0, 0.0), (50.0, 0.0)]);
    assert_eq!(plan(&sketch, 3.0).unwrap().contours().len(), 3);
}

#[test]
fn layer_that_surrounds_the_selected_layer_is_a_problem_until_it_is_named() {
    let sketch = SmallDrawing::mm().loop_on("OUTLINE", "", &PLATE).circle_on("HOLES", (30.0, 15.0), 5.0);
    let mut request = order(3.0);
    request.choice.layers = vec!["HOLES".into()];
    let error = plan_with(&sketch, &request).unwrap_err();
    assert!(error.contains("--without-layer \"OUTLINE\""), "{error}");
    request.choice.without = vec!["outline".into()];
    assert_eq!(plan_with(&sketch, &request).unwrap().contours().len(), 1);
}

// Evidence for SR-27.
/// As KiCad plots the edge of a board: the boundary of the ink.
#[test]
fn outline_drawn_as_a_stroke_is_recognised_and_a_side_is_offered() {
    let rectangle = |o: f64| [(-o, -o), (60.0 + o, -o), (60.0 + o, 30.0 + o), (-o, 30.0 + o)];
    let sketch = SmallDrawing::mm()
        .loop_on("0", "", &rectangle(0.05))
        .loop_on("0", "", &rectangle(-0.05))
        .circle((30.0, 15.0), 5.05)
        .circle((30.0, 15.0), 4.95);
    let error = plan(&sketch, 3.0).unwrap_err();
    assert!(error.contains("2 contours are drawn as strokes 0.100 mm wide"), "{error}");
    assert_eq!(inspected(&sketch).problems.len(), 1);
    for (stroke, titles) in [
        (InkSide::Outer, ["1 outline 60.1 × 30.1", "3 hole Ø 10.100"]),
        (InkSide::Inner, ["2 outline 59.9 × 29.9", "4 hole Ø 9.900"]),
    ] {
        let mut request = order(3.0);
        request.selection.stroke = Some(stroke);
        let plan = plan_with(&sketch, &request).unwrap();
        let names: Vec<String> = plan.contours().iter().map(|contour| contour.name.short()).collect();
        assert_eq!(names, titles);
    }
}

// Evidence for SR-27.
#[test]
fn part_below_two_millimetres_is_asked_about_until_the_unit_is_stated() {
    let sketch = SmallDrawing::mm().plate((0.0, 0.0), (0.9, 0.5));
    let error = plan(&sketch, 0.1).unwrap_err();
    assert!(
        error.contains("smaller than 2 mm") && error.contains("as inches it is 22.86 × 12.7 mm"),
        "{error}"
    );
    let mut request = order(0.1);
    request.job.margin_mm = Some(0.01);
    request.choice.unit = Some("mm".into());
    assert!(plan_with(&sketch, &request).is_ok());
}

#[test]
fn missing_unit_is_asked_about() {
    let found = inspected(&SmallDrawing::without_unit().plate(PLATE[0], PLATE[2]));
    let question = found.question.unwrap();
    assert!(
        question.contains("states no unit") && question.contains("as inches it is 1524 × 762 mm"),
        "{question}"
    );
    assert!(found.problems.is_empty());
}

#[test]
fn micrometres_mils_and_a_scale_are_units() {
    let size = |unit: Option<&str>, scale: Option<f64>, side: f64| {
        let mut request = order(3.0);
        request.choice.unit = unit.map(Into::into);
        request.choice.scale = scale;
        plan_with(&SmallDrawing::mm().plate((0.0, 0.0), (side, side)), &request)
            .map(|plan| plan.profile_size_mm().x)
    };
    for (unit, scale, side) in
        [(Some("µm"), None, 20_000.0), (Some("um"), None, 20_000.0), (None, Some(0.001), 20_000.0)]
    {
        let found = size(unit, scale, side).unwrap();
        assert!((found - 20.0).abs() < 1e-6, "{unit:?} {scale:?}: {found}");
    }
    assert!((size(Some("mil"), None, 1000.0).unwrap() - 25.4).abs() < 1e-6);
    assert!((size(Some("inches"), None, 1.0).unwrap() - 25.4).abs() < 1e-6);
    assert!(size(None, Some(0.0), 10.0).unwrap_err().contains("--scale 0 is out of range"));
}
