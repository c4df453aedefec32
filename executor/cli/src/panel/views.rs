//! What the page shows of a job: its map, its contours and its problems.

use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::{Curve, Length};
use keepout_panel::bench::{
    BenchRequest, ContourState, ContourView, MapLine, MapView, PinView, PlanView, RemedyView,
};
use keepout_planner::contour::ContourRole;
use keepout_planner::drawing::{Chained, Drawing};
use keepout_planner::inspect::Inspection;
use keepout_planner::job::Progress;
use keepout_planner::plan::{CertifiedPlan, Walls};
use keepout_planner::planned::PlannedContour;
use keepout_planner::profile::ProfileLoop;
use keepout_planner::report::rest_beside;
use keepout_planner::units::{mm, point_mm};
use keepout_planner::{Box2, Mm2};

/// Distance of the map's lines from the curves: 2.5 µm.
const CHORD: Length = Length::small(250);
/// Distance of the polygons of the rest material from its contours, mm.
const REST_MM: f64 = 0.01;
/// Most pins of one drawing. A drawing with more problems than this is mended in the CAD system.
const PINS_MAX: usize = 40;

/// Curves as a line of the map.
fn line<'a>(curves: impl Iterator<Item = &'a Curve>) -> MapLine {
    let points = curves.flat_map(|curve| {
        let mut points = curve.chord_points(CHORD).unwrap_or_else(|_| vec![curve.from(), curve.to()]);
        points.pop();
        points
    });
    points.map(point_mm).flat_map(coordinates).collect()
}

fn loop_line(each: &ProfileLoop) -> MapLine {
    line(each.edges.iter().map(|edge| &edge.curve))
}

/// A point in the numbers of the map: a tenth of a micrometre on a table of a metre.
#[expect(clippy::cast_possible_truncation, reason = "the map is a picture")]
fn coordinates(at: Mm2) -> [f32; 2] {
    [at.x as f32, at.y as f32]
}

fn bounds(shown: Box2) -> [f64; 4] {
    [shown.low.x, shown.low.y, shown.high.x, shown.high.y]
}

/// The map of a drawing before it is planned.
pub fn map_of_drawing(found: &Inspection, drawing: &Drawing, chained: &Chained) -> MapView {
    let loops = chained.profile.loops.iter().map(loop_line).collect();
    let open = chained.open.iter().map(|open| line(open.curves.iter()));
    let aside =
        drawing.aside.iter().map(|curve| curve.points.iter().copied().flat_map(coordinates).collect());
    MapView {
        bounds: bounds(found.box_mm.unwrap_or(Box2 { low: Mm2::ZERO, high: Mm2::new(100.0, 100.0) })),
        faces: vec![(0.0, loops)],
        left_out: open.chain(aside).collect(),
        ..MapView::default()
    }
}

/// The map of a plan: the same faces, zones and contours as in its picture.
pub fn map_of_plan(plan: &CertifiedPlan) -> MapView {
    let mut faces = Vec::new();
    for (depth, walls) in plan.walls.iter().enumerate().rev() {
        if depth > 0 && plan.walls[depth - 1].contours == walls.contours {
            continue;
        }
        let height = mm(plan.plan.passes[walls.pass].height.units());
        faces.push((height, walls.outlines.iter().map(|outline| line(outline.curves.iter())).collect()));
    }
    let contours = plan.contours().iter().flat_map(|contour| {
        contour.loops.iter().map(|number| {
            let pass = &plan.plan.passes[number.pass];
            let path = line(pass.path.loops[number.index].curves.iter());
            (contour.name.number, mm(pass.height.units()), path)
        })
    });
    let left_out = plan.plan.provenance.left_out.iter();
    MapView {
        bounds: bounds(plan.part_box()),
        faces,
        zones: plan.plan.zones.loops.iter().map(loop_line).collect(),
        rest: rest_of(plan),
        contours: contours.collect(),
        left_out: left_out.map(|points| points.iter().copied().flat_map(coordinates).collect()).collect(),
        tool_radius_mm: Some(mm(plan.plan.tool_radius.units())),
    }
}

/// The rest material of each depth, as the plan's picture hatches it.
fn rest_of(plan: &CertifiedPlan) -> Vec<(f64, Vec<MapLine>)> {
    let lines = |walls| {
        let polygons = rest_beside(plan, walls, REST_MM);
        let line =
            |ring: Vec<[f64; 2]>| ring.into_iter().flat_map(|[x, y]| coordinates(Mm2::new(x, y))).collect();
        polygons.into_iter().flatten().map(line).collect()
    };
    let depth = |walls: &Walls| mm(plan.plan.passes[walls.pass].height.units());
    plan.walls.iter().map(|walls| (depth(walls), lines(walls))).collect()
}

/// What a person wants to know of a plan whose contours are cut at this feed, mm/min.
pub fn plan_view(plan: &CertifiedPlan, feed_mm_min: u32) -> PlanView {
    let minutes = plan
        .plan
        .passes
        .iter()
        .map(|pass| pass.path.length_mm() / f64::from(pass.feed_mm_min.unwrap_or(feed_mm_min).max(1)));
    let shortfalls = plan.shortfalls();
    let fits = shortfalls.iter().map(|each| each.fits_mm).collect::<Option<Vec<f64>>>();
    PlanView {
        margin_mm: plan.plan.budget.terms.iter().map(|term| term.mm).sum(),
        terms: plan.plan.budget.terms.iter().map(|term| (term.kind.name().into(), term.mm)).collect(),
        minutes: minutes.sum(),
        short: shortfalls.len(),
        fits_mm: fits.and_then(|all| all.into_iter().reduce(f64::min)),
    }
}

/// The contours of a drawing before it is planned.
pub fn contours_of_drawing(found: &Inspection) -> Vec<ContourView> {
    let view = |name: &keepout_planner::contour::ContourName| ContourView {
        number: name.number,
        name: name.title(),
        opens: false,
        state: ContourState::ToDo,
    };
    found.contours.iter().map(|contour| view(&contour.name)).collect()
}

/// The contours of a plan after some progress.
pub fn contours_of_plan(work: &PreparedPlan, progress: &Progress) -> Vec<ContourView> {
    let state = |contour: &PlannedContour| {
        let cut = contour.loops.iter().filter(|number| progress.has_finished(**number)).count();
        let begun = progress.partial.iter().any(|partial| contour.loops.contains(&partial.number));
        match (contour.loops.len(), cut) {
            (0, _) => ContourState::NotReached,
            (all, cut) if all == cut => ContourState::Cut,
            (_, 0) if !begun => ContourState::ToDo,
            _ => ContourState::Begun,
        }
    };
    let walled = work.plan.contours().iter().filter(|contour| contour.has_wall());
    let view = |contour: &PlannedContour| ContourView {
        number: contour.name.number,
        name: contour.name.title(),
        opens: matches!(contour.name.role, ContourRole::Opening | ContourRole::Pocket),
        state: state(contour),
    };
    walled.map(view).collect()
}

/// The problems and the question of a drawing, as pins.
pub fn pins(found: &Inspection) -> Vec<PinView> {
    let leaves_out = found.open_chains > 0 && !found.contours.is_empty();
    let remedy = |text: &str| {
        (leaves_out && text.contains("--leave-out-open")).then(|| RemedyView {
            text: format!("Leave out {} open lines", found.open_chains),
            request: BenchRequest::LeaveOutOpen {},
        })
    };
    let pin = |at_mm: Option<Mm2>, text: &str| PinView {
        at_mm: at_mm.map(|at| [at.x, at.y]),
        text: text.to_string(),
        remedy: remedy(text),
    };
    let problems = found.problems.iter().take(PINS_MAX).map(|note| pin(Some(note.at_mm), &note.text));
    problems.chain(found.question.iter().map(|question| pin(None, question))).collect()
}

/// The summary of a plan as rows: name and value.
pub fn figures(plan: &CertifiedPlan) -> Vec<(String, String)> {
    let rows = plan.summary();
    let row = |line: &str| {
        let (name, value) = line.split_at_checked(13)?;
        (!name.trim().is_empty() && !line.starts_with(' ')).then(|| (name.trim().into(), value.trim().into()))
    };
    rows.lines().filter_map(row).collect()
}
