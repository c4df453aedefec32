//! Figures are true: rest material, areas, contours that the tool does not cut.

use clipper2_rust::core::{Path64, Paths64, Point64};
use clipper2_rust::offset::{ClipperOffset, EndType, JoinType};
use keepout_kernel::exact::ring::Ring;
use keepout_planner::finish::centre_distance;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::profile::MachinedSide;
use keepout_tests::{oracle, order, plan_bytes, shared};

use crate::dxf::{PlainXy, SmallDrawing};
use crate::{inspected, plan, plan_with};

/// Largest number of edges of a part that the other library checks.
const EDGES_MAX: usize = 6000;

/// Twice the signed area of a polygon.
fn double_area(path: &Path64) -> i128 {
    let next = path.iter().cycle().skip(1);
    path.iter()
        .zip(next)
        .map(|(a, b)| i128::from(a.x) * i128::from(b.y) - i128::from(b.x) * i128::from(a.y))
        .sum()
}

/// The part, and the part with its rest material, by another library: the part, grown by the distance of the tool's
/// centre and shrunk again.
pub fn closed_by_clipper(plan: &CertifiedPlan) -> [Paths64; 2] {
    let ring = |ring: &Ring| -> Path64 {
        ring.vertices().iter().map(|at| Point64 { x: at.x.units().into(), y: at.y.units().into() }).collect()
    };
    let depths = plan.part.region().depths();
    let rings = plan.part.region().rings().iter().zip(depths);
    let mut part: Paths64 = rings
        .map(|(each, depth)| {
            let mut path = ring(each);
            if (double_area(&path) > 0) != (depth % 2 == 0) {
                path.reverse();
            }
            path
        })
        .collect();
    if plan.plan.side == MachinedSide::Inside {
        part.iter_mut().for_each(|path| path.reverse());
        let far = 400_000_000;
        let corner = |x, y| Point64 { x, y };
        part.push(vec![corner(-far, -far), corner(far, -far), corner(far, far), corner(-far, far)]);
    }
    let d = centre_distance(&plan.plan.profile, &plan.plan.zones, plan.finishing);
    let grown = |paths: &Paths64, by: f64| {
        let mut offset = ClipperOffset::new(2.0, 4.0, false, false);
        offset.add_paths(paths, JoinType::Round, EndType::Polygon);
        let mut out = Paths64::new();
        offset.execute(by, &mut out);
        out
    };
    let closed = grown(&grown(&part, d), -d);
    [part, closed]
}

/// The rest material by another library, mm².
fn by_clipper(plan: &CertifiedPlan) -> f64 {
    let [part, closed] = closed_by_clipper(plan);
    let area = |paths: &Paths64| paths.iter().map(double_area).sum::<i128>();
    let double = i64::try_from(area(&closed) - area(&part)).unwrap();
    #[expect(clippy::cast_precision_loss, reason = "areas are compared to a hundredth")]
    let double = double as f64;
    double / 2e10
}

fn agrees(plan: &CertifiedPlan) -> Result<(), String> {
    let stated = plan.plan.finish().residual_area_mm2.unwrap();
    let other = by_clipper(plan);
    let close = (stated - other).abs() <= (0.01 * other).max(0.01);
    if close { Ok(()) } else { Err(format!("{stated} mm² stated, {other} mm² by clipper")) }
}

/// The smallest case of the findings: 4.253 mm² were stated.
#[test]
fn rest_material_between_two_posts_is_counted_once() {
    let posts = SmallDrawing::mm().circle((0.0, 0.0), 1.3).circle((7.4246, 0.0), 1.3);
    let plan = plan(&posts, 6.0).unwrap();
    agrees(&plan).unwrap();
    let area = plan.plan.finish().residual_area_mm2.unwrap();
    assert!((area - 0.3156).abs() < 0.005, "{area}");
}

#[test]
fn rest_material_agrees_with_another_library_on_all_shared_drawings() {
    let Some(shared) = shared() else { return };
    let (mut compared, mut wrong) = (0, Vec::new());
    for (number, (name, _)) in oracle::read(&shared).unwrap().into_iter().enumerate() {
        let bytes = keepout_planner::drawing::read_file(&shared.join("dxf").join(&name)).unwrap();
        // Each drawing with each tool would take minutes: the other library is slow with many edges.
        for tool in [[1.0, 3.0], [3.0, 6.0], [1.0, 6.0]][number % 3] {
            let side = if number % 2 == 0 { MachinedSide::Outside } else { MachinedSide::Inside };
            let mut request = order(tool);
            request.job.side = side;
            let Ok(plan) = plan_bytes(&name, &bytes, &request) else { continue };
            if plan.part.edges().len() > EDGES_MAX {
                continue;
            }
            compared += 1;
            if let Err(difference) = agrees(&plan) {
                wrong.push(format!("{name}, {tool} mm, {side:?}: {difference}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {compared}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(compared >= 40, "only {compared} plans were compared");
}

/// A hole drawn with facets counted as uncut over most of its length.
#[test]
fn facets_of_a_hole_are_no_rest_material() {
    let facets: Vec<PlainXy> = (0..180)
        .map(|k| f64::from(k) * 2_f64.to_radians())
        .map(|angle| (15.0 + 4.0 * angle.cos(), 15.0 + 4.0 * angle.sin()))
        .collect();
    let plan =
        plan(&SmallDrawing::mm().plate((0.0, 0.0), (30.0, 30.0)).loop_on("0", "", &facets), 6.0).unwrap();
    let finish = plan.plan.finish();
    assert!(finish.residual_area_mm2.unwrap() < 0.05, "{:?}", finish.residual_area_mm2);
    assert!(finish.residual_length_mm < 1e-9, "{}", finish.residual_length_mm);
}

#[test]
fn uncut_hole_is_rest_material_and_a_warning_names_the_largest_tool() {
    let holes = [(10.0, 8.0), (10.0, 22.0), (50.0, 8.0), (50.0, 22.0)];
    let plate = holes
        .iter()
        .fold(SmallDrawing::mm().plate((0.0, 0.0), (60.0, 30.0)), |sketch, &at| sketch.circle(at, 3.0));
    let made = plan(&plate, 6.0).unwrap();
    let area = made.plan.finish().residual_area_mm2.unwrap();
    assert!((area - 4.0 * std::f64::consts::PI * 9.0).abs() < 0.01, "{area}");
    let summary = made.summary();
    assert!(
        summary.starts_with("WARNING      the 6 mm tool does not fit along 4 of 5 contours"),
        "{summary}"
    );
    assert!(
        summary.contains("2 hole Ø 6.000 at (10.000, 8.000)") && summary.contains("WILL NOT BE CUT"),
        "{summary}"
    );
    let largest = made.shortfalls()[0].fits_mm.unwrap();
    // The claim holds: this tool cuts all contours, and a larger one does not.
    assert!(plan(&plate, largest).unwrap().shortfalls().is_empty());
    assert_eq!(plan(&plate, largest + 0.02).unwrap().shortfalls().len(), 4);
}

#[test]
fn tool_that_does_not_pass_a_neck_is_a_warning_with_the_place() {
    // Two rooms, and a dead end of 4 mm width.
    let corners = [
        (0.0, 0.0),
        (60.0, 0.0),
        (60.0, 40.0),
        (32.0, 40.0),
        (32.0, 15.0),
        (28.0, 15.0),
        (28.0, 40.0),
        (0.0, 40.0),
    ];
    let made = plan(&SmallDrawing::mm().loop_on("0", "", &corners), 6.0).unwrap();
    let shortfalls = made.shortfalls();
    assert_eq!(shortfalls.len(), 1, "{:?}", made.warnings());
    let fits = shortfalls[0].fits_mm.unwrap();
    assert!((3.9..4.0).contains(&fits), "{fits}");
    assert!(made.warnings()[1].contains("mm uncut, most of it near ("), "{:?}", made.warnings());
}

/// Crossing contours gave an area of −403 mm², and lines to and fro counted as contours.
#[test]
fn areas_of_drawings_with_problems_are_true() {
    let crossing = SmallDrawing::mm().plate((0.0, 0.0), (20.0, 20.0)).plate((10.0, 5.0), (30.0, 15.0));
    let found = inspected(&crossing);
    assert!((found.area_mm2 - 400.0).abs() < 1e-3, "{}", found.area_mm2);
    let to_and_fro = SmallDrawing::mm().plate((0.0, 0.0), (20.0, 20.0)).loop_on(
        "0",
        "",
        &[(40.0, 0.0), (90.0, 0.0), (40.0, 0.0)],
    );
    let found = inspected(&to_and_fro);
    assert_eq!((found.contours.len(), found.outer), (1, 1), "{:?}", found.contours);
    assert!((found.box_mm.unwrap().size().x - 20.0).abs() < 1e-9);
}

#[test]
fn numbers_stay_the_same_when_contours_are_left_out() {
    let plate = SmallDrawing::mm()
        .plate((0.0, 0.0), (60.0, 30.0))
        .circle((10.0, 15.0), 1.0)
        .circle((40.0, 15.0), 5.0);
    let found = inspected(&plate);
    let mut request = order(3.0);
    request.selection.least_area_mm2 = Some(10.0);
    let plan = plan_with(&plate, &request).unwrap();
    let names: Vec<String> = plan.contours().iter().map(|contour| contour.name.to_string()).collect();
    assert_eq!(names, [0, 2].map(|index: usize| found.contours[index].name.to_string()));
}
