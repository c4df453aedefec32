//! Remarks about what the view from above does not show.

use keepout_planner::request::PlanRequest;
use keepout_tests::order;

use crate::dxf::SmallDrawing;
use crate::{inspected, plan_with};

fn plate() -> SmallDrawing {
    SmallDrawing::mm().plate((0.0, 0.0), (60.0, 30.0))
}

fn remarks(sketch: &SmallDrawing) -> String {
    inspected(sketch).remarks.join("\n")
}

#[test]
fn ordinary_drawing_has_no_remark() {
    assert_eq!(remarks(&plate().circle((20.0, 15.0), 5.0)), "");
}

#[test]
fn width_of_a_polyline_is_remarked() {
    let square = [(10.0, 10.0), (20.0, 10.0), (20.0, 20.0), (10.0, 20.0)];
    let text = remarks(&plate().loop_on("0", "43\n0.5\n", &square));
    assert!(text.contains("polylines with a width: 1, up to 0.5 mm wide"), "{text}");
    let vertex = |(x, y): (f64, f64)| format!("0\nVERTEX\n8\n0\n10\n{x}\n20\n{y}\n40\n0.25\n41\n0.75\n");
    let vertices: String = square.into_iter().map(vertex).collect();
    let text = remarks(&plate().entity("POLYLINE", "0", &format!("66\n1\n70\n1\n{vertices}0\nSEQEND\n")));
    assert!(text.contains("polylines with a width: 1, up to 0.75 mm wide"), "{text}");
}

#[test]
fn sloped_polyline_is_remarked() {
    let vertex = |(x, y, z)| format!("0\nVERTEX\n8\n0\n10\n{x}\n20\n{y}\n30\n{z}\n70\n32\n");
    let vertices: String =
        [(10, 10, 0), (20, 10, 3), (20, 20, 3), (10, 20, 0)].into_iter().map(vertex).collect();
    let text = remarks(&plate().entity("POLYLINE", "0", &format!("66\n1\n70\n9\n{vertices}0\nSEQEND\n")));
    assert!(text.contains("sloped lines or curves: 1, by up to 3 mm in height"), "{text}");
}

#[test]
fn tilted_circle_is_remarked_and_a_mirrored_one_is_not() {
    let circle = |normal: &str| plate().entity("CIRCLE", "0", &format!("10\n20\n20\n15\n40\n5\n{normal}"));
    let text = remarks(&circle("210\n0.5\n220\n0\n230\n0.866\n"));
    assert!(text.contains("circles, arcs or polylines in tilted planes: 1"), "{text}");
    let mirrored = plate().entity("CIRCLE", "0", "10\n-20\n20\n15\n40\n5\n210\n0\n220\n0\n230\n-1\n");
    assert_eq!(remarks(&mirrored), "");
}

#[test]
fn hole_on_a_layer_that_is_not_plotted_is_remarked_unless_the_user_names_it() {
    let sketch = plate().circle_on("Defpoints", (15.0, 15.0), 3.0).circle_on("GUIDE", (30.0, 15.0), 3.0);
    let text = remarks(&sketch.clone().without_plot("GUIDE"));
    for layer in ["Defpoints", "GUIDE"] {
        let wanted =
            format!("layer \"{layer}\" is not plotted, but its curves (1) are taken. --without-layer");
        assert!(text.contains(&wanted), "{text}");
    }
    assert!(!remarks(&sketch).contains("GUIDE"));
}

#[test]
fn unknown_layer_is_named_without_another_option() {
    let sketch = plate();
    for (option, request) in [
        ("travel", PlanRequest { travel_layer: Some("TABLE".into()), ..order(3.0) }),
        ("keep-out", PlanRequest { keep_out_layers: vec!["TABLE".into()], ..order(3.0) }),
    ] {
        let error = plan_with(&sketch, &request).unwrap_err();
        assert!(error.starts_with("layer \"TABLE\" has no visible curves"), "{option}: {error}");
    }
}

#[test]
fn keep_out_layer_is_not_left_out() {
    let request = PlanRequest { keep_out_layers: vec!["CLAMP".into()], ..order(3.0) };
    let sketch = plate().circle_on("CLAMP", (80.0, 15.0), 5.0);
    let plan = plan_with(&sketch, &request).unwrap().plan;
    assert_eq!((plan.zones.loops.len(), plan.provenance.left_out.len()), (1, 0));
    assert!(plan.provenance.remarks.is_empty(), "{:?}", plan.provenance.remarks);
}

/// A clamp on a layer that is also left out stays a clamp, and its width is remarked.
#[test]
fn keep_out_layer_is_protected_though_it_is_left_out_of_the_part() {
    let mut request = PlanRequest { keep_out_layers: vec!["CLAMP".into()], ..order(3.0) };
    request.choice.without = vec!["CLAMP".into()];
    let corners = [(75.0, 5.0), (85.0, 5.0), (85.0, 15.0), (75.0, 15.0)];
    let plan = plan_with(&plate().loop_on("CLAMP", "43\n2\n", &corners), &request).unwrap().plan;
    assert_eq!(plan.zones.loops.len(), 1);
    let remarks: Vec<&str> = plan.provenance.remarks.iter().map(|remark| remark.text.as_str()).collect();
    assert!(
        remarks.iter().any(|text| text.starts_with("keep-out zone: polylines with a width: 1")),
        "{remarks:?}"
    );
}
