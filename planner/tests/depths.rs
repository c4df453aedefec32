//! Plans with depths, against heights and figures worked out here by plain arithmetic.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use keepout_kernel::{Height, Length};
use keepout_planner::Mm2;
use keepout_planner::contour::ContourRole;
use keepout_planner::depth::{DepthError, DepthParameters, EntryMove, FaceChoice, FaceDepth, Relief};
use keepout_planner::drawing::EntityFilter;
use keepout_planner::job::contour_job;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, Plan, PlanError, PlanParameters};
use keepout_planner::plan_file;
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{mm, point_from_mm};

/// Rectangles: from x, y to x, y.
const STEP: [f64; 4] = [0.0, 0.0, 80.0, 60.0];
const BOSS: [f64; 4] = [12.0, 10.0, 68.0, 50.0];
const POCKET: [f64; 4] = [25.0, 20.0, 55.0, 40.0];
const CLAMP: [f64; 4] = [-14.0, 20.0, -4.0, 40.0];
/// Middle and radius of the hole.
const HOLE: [f64; 3] = [40.0, 30.0, 5.0];
const THICKNESS: f64 = 10.0;
/// Depths of the step and of the pocket.
const DEPTHS: [f64; 2] = [4.0, 3.0];

/// A part with a step around a boss, a pocket in the boss, and a hole in the pocket.
fn drawing() -> String {
    let mut text =
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n".to_string();
    for (layer, [x0, y0, x1, y1]) in [("STEP", STEP), ("BOSS", BOSS), ("POCKET", POCKET), ("CLAMP", CLAMP)] {
        let _ = write!(text, "0\nLWPOLYLINE\n8\n{layer}\n90\n4\n70\n1\n");
        for (x, y) in [(x0, y0), (x1, y0), (x1, y1), (x0, y1)] {
            let _ = write!(text, "10\n{x}\n20\n{y}\n");
        }
    }
    let [x, y, r] = HOLE;
    let _ = write!(text, "0\nCIRCLE\n8\nHOLE\n10\n{x}\n20\n{y}\n40\n{r}\n0\nENDSEC\n0\nEOF\n");
    text
}

fn depths() -> DepthParameters {
    let face =
        |layer: &str, depth_mm| FaceDepth { of: FaceChoice::Layer(layer.into()), depth_mm: Some(depth_mm) };
    DepthParameters {
        faces: vec![face("STEP", DEPTHS[0]), face("BOSS", 0.0), face("POCKET", DEPTHS[1]), {
            FaceDepth { of: FaceChoice::Layer("HOLE".into()), depth_mm: None }
        }],
        clamps_mm: Some(2.0),
        entry: EntryMove::Plunge,
        ..DepthParameters::of(THICKNESS)
    }
}

fn planned(depth: DepthParameters) -> Result<CertifiedPlan, String> {
    planned_with(depth, PlanRequest { keep_out_layers: vec!["CLAMP".into()], ..PlanRequest::default() })
}

fn planned_with(depth: DepthParameters, request: PlanRequest) -> Result<CertifiedPlan, String> {
    let job = PlanParameters { depth: Some(depth), ..request.job.clone() };
    let request = PlanRequest { job, ..request };
    let machine = MachineProfile::simulated_three_axes();
    request.plan("step", drawing().as_bytes(), &machine, &mut |_| {}).map_err(|error| error.to_string())
}

fn is_in([x0, y0, x1, y1]: [f64; 4], at: Mm2) -> bool {
    x0 < at.x && at.x < x1 && y0 < at.y && at.y < y1
}

/// The top of what stands at a point, mm: from the rectangles and the circle alone.
fn top_mm(at: Mm2) -> Option<f64> {
    if is_in(CLAMP, at) {
        return Some(2.0);
    }
    if at.distance(Mm2::new(HOLE[0], HOLE[1])) < HOLE[2] || !is_in(STEP, at) {
        return None;
    }
    Some(if is_in(POCKET, at) {
        -DEPTHS[1]
    } else if is_in(BOSS, at) {
        0.0
    } else {
        -DEPTHS[0]
    })
}

#[test]
fn levels_stand_where_the_drawing_and_the_depths_say() {
    let plan = planned(depths()).unwrap();
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..20_000 {
        let at = Mm2::new(-20.0 + 110.0 * random.f64(), -10.0 + 80.0 * random.f64());
        let point = point_from_mm(at).unwrap();
        let top = top_mm(at);
        assert_eq!(plan.top_at(point).map(|top| mm(top.units())), top, "{at}");
        // A tip at a random height, often just at a top.
        let z = [0.0, 2.0, -DEPTHS[0], -DEPTHS[1], 3.0 - 14.0 * random.f64()][random.usize(0..5)];
        let tip = Height::from_units(keepout_kernel::curve::nearest_unit(z * 1e5)).unwrap();
        let touches = |tip: Height| plan.levels.at(tip).holds(point);
        let floor = mm(plan.plan.relief.as_ref().unwrap().floor.units());
        assert_eq!(touches(tip), top.is_some_and(|top| top > z) || z < floor, "{at} at {z}");
        if let Some(top) = top.filter(|&top| top == z) {
            assert!(touches(tip.lowered(Length::small(1))) && !touches(tip), "{at} at {top}");
        }
    }
}

#[test]
fn figures_of_a_part_with_depths_are_those_of_its_shapes() {
    // Beside clamps the rest material is not known.
    let choice = EntityFilter { without: vec!["CLAMP".into()], ..EntityFilter::default() };
    let plan = planned_with(depths(), PlanRequest { choice, ..PlanRequest::default() }).unwrap();
    let area = |[x0, y0, x1, y1]: [f64; 4]| (x1 - x0) * (y1 - y0);
    let hole = PI * HOLE[2] * HOLE[2];
    let volume = area(STEP) * (THICKNESS - DEPTHS[0]) + area(BOSS) * DEPTHS[0]
        - area(POCKET) * DEPTHS[1]
        - hole * (THICKNESS - DEPTHS[1]);
    let summary = plan.summary();
    assert!(summary.contains(&format!("{volume:.3} mm³ of material")), "{volume}\n{summary}");
    // The tool leaves the corners of the pocket: a square less a quarter disc each, down to the pocket's pass.
    let d = mm(plan.finishing.units()) + 0.000_4;
    let pass = plan.plan.passes.iter().map(|pass| -mm(pass.height.units())).filter(|depth| *depth < 3.0);
    let corners = 4.0 * (1.0 - PI / 4.0) * d * d * pass.fold(0.0, f64::max);
    let perimeter: f64 = [STEP, BOSS, POCKET].map(|[x0, y0, x1, y1]| 2.0 * (x1 - x0 + y1 - y0)).iter().sum();
    let whole = perimeter + 2.0 * PI * HOLE[2];
    let rest = plan.residual();
    let figures: Vec<f64> = rest.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    assert!(
        (figures[1] - whole).abs() < 0.06 && (figures[2] - corners).abs() < 0.02,
        "{rest} {whole} {corners}"
    );
    let roles: Vec<ContourRole> = plan.contours().iter().map(|contour| contour.name.role).collect();
    assert_eq!(roles, [ContourRole::Outline, ContourRole::Boss, ContourRole::Pocket, ContourRole::Opening]);
}

#[test]
fn each_wall_is_cut_at_each_depth_where_it_stands() {
    let plan = planned(depths()).unwrap();
    let margin_mm = mm(plan.height_margin.units());
    for walls in &plan.walls {
        let z = mm(plan.plan.passes[walls.pass].height.units()) - margin_mm;
        let mut standing = Vec::new();
        if z < -DEPTHS[0] - 1e-6 {
            standing.push(0);
        } else {
            standing.push(1);
        }
        if z >= -DEPTHS[1] - 1e-6 {
            standing.push(2);
        } else {
            standing.push(3);
        }
        let mut found = walls.contours.clone();
        found.sort_unstable();
        standing.sort_unstable();
        assert_eq!(found, standing, "z {z}");
    }
    // The tool stays above each face, by the height margin, and every through cut goes below the part.
    let lowest = plan.plan.passes.last().unwrap().height;
    assert!(mm(lowest.units()) < -THICKNESS);
}

// Evidence for SR-20.
#[test]
fn heights_that_cannot_be_are_refused_with_a_remedy() {
    let cases: [(DepthParameters, &str); 6] = [
        // Above the clamps, but not by the height margin.
        (DepthParameters { safe_mm: 2.02, ..depths() }, "--safe-height-mm"),
        (DepthParameters { clamps_mm: None, ..depths() }, "--clamp-height-mm"),
        (DepthParameters { safe_mm: 1.0, ..depths() }, "--safe-height-mm"),
        (DepthParameters { thickness_mm: f64::NAN, ..depths() }, "--thickness-mm"),
        (DepthParameters { table_mm: Some(10.2), ..depths() }, "--overcut-mm"),
        (DepthParameters { thickness_mm: 3.5, ..depths() }, "--thickness-mm"),
    ];
    for (depth, remedy) in cases {
        let message = planned(depth).unwrap_err();
        assert!(message.contains(remedy), "{message}");
    }
    assert!(DepthError::TwoAxes.to_string().contains("[z]"));
}

#[test]
fn pockets_of_a_part_around_them_have_their_volume() {
    let face = FaceDepth { of: FaceChoice::Layer("BOSS".into()), depth_mm: Some(6.0) };
    let depth = DepthParameters { faces: vec![face], entry: EntryMove::Plunge, ..DepthParameters::of(8.0) };
    let job = PlanParameters { depth: Some(depth), side: MachinedSide::Inside, ..PlanParameters::default() };
    let without = ["STEP", "POCKET", "CLAMP", "HOLE"].map(String::from).to_vec();
    let choice = EntityFilter { without, ..EntityFilter::default() };
    let request = PlanRequest { job, choice, ..PlanRequest::default() };
    let machine = MachineProfile::simulated_three_axes();
    let plan = request.plan("pocket", drawing().as_bytes(), &machine, &mut |_| {}).unwrap();
    let summary = plan.summary();
    assert!(summary.contains("pockets of 13440.000 mm³"), "{summary}");
}

/// The plan after a round trip through its file.
#[expect(clippy::unwrap_used, reason = "the test reads the file that it wrote")]
fn from_file(plan: &Plan) -> Result<CertifiedPlan, PlanError> {
    plan_file::decode(&plan_file::encode(plan).unwrap()).unwrap().certify()
}

// Evidence for SR-20.
#[test]
fn changed_heights_of_a_plan_file_are_refused() {
    let good = planned(depths()).unwrap().plan;
    assert!(from_file(&good).is_ok());
    type Change = (&'static str, fn(&mut Relief));
    let changes: [Change; 5] = [
        ("a clamp ends below the top", |relief| relief.clamps = Height::ZERO.lowered(Length::whole_mm(1))),
        ("it crosses through the clamps", |relief| relief.safe = Height::ZERO),
        ("a contour has no top", |relief| relief.tops.truncate(1)),
        ("no height margin", |relief| relief.budget.terms.clear()),
        ("the table lies above the deepest cut", |relief| {
            relief.floor = relief.deepest.raised(Length::whole_mm(1))
        }),
    ];
    for (what, change) in changes {
        let mut wrong = good.clone();
        change(wrong.relief.as_mut().unwrap());
        assert!(from_file(&wrong).is_err(), "{what}");
    }
}

/// Passes that repeat at every depth of a section are certified once. A later one must not claim more.
// Evidence for SR-20.
#[test]
fn a_later_pass_with_the_same_path_keeps_its_own_promise() {
    let good = planned(DepthParameters { step_down_mm: Some(1.0), ..depths() }).unwrap().plan;
    let mut tried = 0;
    for later in 1..good.passes.len() {
        if good.passes[later].path != good.passes[later - 1].path {
            continue;
        }
        let mut wrong = good.clone();
        wrong.passes[later].stock_to_leave = wrong.stock_to_leave;
        assert!(from_file(&wrong).is_err(), "pass {later} leaves stock that its path cuts off");
        tried += 1;
    }
    assert!(tried > 2, "{tried}");
}

/// A joint of a ramp beside the end of an arc was rounded off its circle. Then the job left the hole out.
#[test]
fn a_turned_cover_is_cut_whole_from_anywhere() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../executor/cli/drawings/cover.dxf");
    let (cover, machine) = (std::fs::read(path).unwrap(), MachineProfile::simulated_three_axes());
    let pocket = FaceDepth { of: FaceChoice::Layer("POCKET".into()), depth_mm: Some(2.0) };
    let depth = DepthParameters { faces: vec![pocket], step_down_mm: Some(2.0), ..DepthParameters::of(5.0) };
    let mut random = fastrand::Rng::with_seed(8);
    for turned_deg in [0.0, 0.596_971_1, 30.0 * random.f64(), -30.0 * random.f64()] {
        let choice = EntityFilter { placed: Some((turned_deg, Mm2::ZERO)), ..EntityFilter::default() };
        let job = PlanParameters { depth: Some(depth.clone()), ..PlanParameters::default() };
        let request = PlanRequest { choice, job, ..PlanRequest::default() };
        let plan = request.plan("cover", &cover, &machine, &mut |_| {}).unwrap();
        let within = plan.part.region().bounds().grown(Length::from_units(6_000_000).unwrap());
        for _ in 0..200 {
            let from = point_from_mm(Mm2::new(100.0 * random.f64(), 60.0 * random.f64())).unwrap();
            let from = from.at_height(plan.plan.relief.as_ref().unwrap().safe);
            let job = contour_job(&plan, from, within).unwrap();
            assert!(job.unreached.is_empty(), "turned by {turned_deg} degrees, from {from}");
        }
    }
}
