//! Picture of a plan, with the traces of a run if there are any.

use keepout_kernel::Curve;

use super::element::{Lines, circle, path};
use super::part::{KEEP_OUT, KEEP_OUT_FINISH, PART, UNCUT, ZONE, draw_numbers, draw_part};
use super::view::{
    Mark, Sign, View, draw_dimensions, draw_left_out, draw_origin, left_out_entry, page, path_of, polyline_of,
};
use crate::contour::{profile_box, short};
use crate::job::{ContourJob, LoopNumber, Progress, preview};
use crate::plan::CertifiedPlan;
use crate::size::size;
use crate::units::{mm, point_mm};
use crate::{Box2, Mm2};

/// A series of tool-centre positions, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// State of the machine in this series.
    pub kind: TraceKind,
    /// The positions, mm.
    pub points_mm: Vec<Mm2>,
}

/// Kind of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceKind {
    /// Jogging.
    Manual,
    /// Contouring.
    Contour,
}

/// Marked place of a run, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Event at the place.
    pub kind: SpotKind,
    /// Position of the tool's centre, mm.
    pub at_mm: Mm2,
}

/// Kind of a marked place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpotKind {
    /// Contact start: the tool touched the part, and a contour began there.
    ProbePoint,
    /// The tool stopped, after a feed hold or a fault.
    Stop,
}

/// The run that a picture of a plan shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunDrawing<'a> {
    /// Series of positions.
    pub traces: &'a [Trace],
    /// Marked places.
    pub spots: &'a [Spot],
    /// The progress after the run. The picture then tells cut contours from uncut ones.
    pub progress: Option<&'a Progress>,
}

// Colours that differ for people who confuse red and green (Okabe and Ito, 2008). Lines also differ by their dashes,
// and rest material is hatched.
const TOUCH: &str = "#cc79a7";
const STOP: &str = "#111827";
const FINISH: &str = "#0072b2";
const LINK: &str = "#7a8594";
const REPAIR: &str = "#b45309";
const JOGGING: &str = "#56b4e9";
const CONTOUR: &str = "#009e73";
const TOOL: &str = "#5b21b6";

/// SVG of a plan, with a run if there is one. Without a run it shows the leads and the direction of the cuts for one
/// contact start in each free space.
#[must_use]
pub fn svg(plan: &CertifiedPlan, title: &str, run: &RunDrawing<'_>) -> String {
    let view = view_of(plan, run.traces);
    let mut body = Lines::default();
    draw_part(&mut body, plan, &view);
    draw_left_out(&mut body, plan.plan.provenance.left_out.iter().map(Vec::as_slice), &view);
    for trace in run.traces {
        draw_trace(&mut body, trace, &view);
    }
    draw_finish(&mut body, plan, run.progress, &view);
    if run.traces.is_empty() {
        for job in preview(plan) {
            draw_job(&mut body, &job, &view);
            let start = job.legs.first().and_then(|leg| leg.curves.first());
            if let Some(start) = start {
                draw_tool(&mut body, point_mm(start.from()), mm(plan.plan.tool_radius.units()), &view);
            }
        }
    }
    for remark in &plan.plan.provenance.remarks {
        if let Some(at) = remark.at {
            body.draw(&[circle(view.xy(point_mm(at)), 1, 6).outline(REPAIR, 2)]);
        }
    }
    draw_numbers(&mut body, plan, &view);
    // The box around a turned part has other sizes than the part.
    if plan.plan.provenance.turned_degrees() == 0.0 {
        draw_dimensions(&mut body, profile_box(&plan.plan.profile, 0.0), &view);
    }
    draw_origin(&mut body, &view);
    if let Some(last) = run.traces.last().and_then(|trace| trace.points_mm.last()) {
        draw_tool(&mut body, *last, mm(plan.plan.tool_radius.units()), &view);
    }
    run.spots.iter().for_each(|spot| draw_spot(&mut body, spot, &view));
    page(&view, title, &legend(plan, run), &body)
}

fn view_of(plan: &CertifiedPlan, traces: &[Trace]) -> View {
    let mut shown = plan.part_box().grown(2.0 * mm(plan.roughing.units()) + 2.0);
    // A run may use the whole table. The picture shows it up to half the part's size around the part.
    let limits = shown.grown(shown.longer_side() / 2.0);
    for &point in traces.iter().flat_map(|trace| &trace.points_mm) {
        let point = point.max(limits.low).min(limits.high);
        shown = shown.union(Box2 { low: point, high: point });
    }
    View::of(shown)
}

/// Draws the finishing toolpath. With a progress, finished loops are solid, and the others are dashed.
fn draw_finish(out: &mut Lines, plan: &CertifiedPlan, progress: Option<&Progress>, view: &View) {
    for (pass, each) in plan.plan.passes.iter().enumerate() {
        for (index, each) in each.path.loops.iter().enumerate() {
            let toolpath = path(path_of(each.curves.iter().copied(), view) + "Z");
            let number = LoopNumber { pass, index };
            out.draw(&[match progress.map(|progress| progress.has_finished(number)) {
                None => toolpath.outline(FINISH, 1.6).set("stroke-dasharray", "7 3"),
                Some(true) => toolpath.outline(FINISH, 2),
                Some(false) => toolpath.outline(UNCUT, 2).set("stroke-dasharray", "3 4"),
            }]);
        }
    }
}

/// Draws link moves and leads of a contouring job, with the direction of its cuts.
fn draw_job(out: &mut Lines, job: &ContourJob, view: &View) {
    for leg in &job.legs {
        let colour = if leg.cuts.is_some() { FINISH } else { LINK };
        let travel = |out: &mut Lines, curves: &[Curve]| {
            out.draw(&[path(path_of(curves.iter().copied(), view)).outline(colour, 1.2)]);
        };
        let Some(cut) = leg.cuts else {
            travel(out, &leg.curves);
            continue;
        };
        // A tangential lead is two motions, a line and an arc. A straight lead is one; the picture then
        // draws one motion of the loop with it.
        let count = leg.curves.len();
        travel(out, &leg.curves[..count.min(2)]);
        travel(out, &leg.curves[count.saturating_sub(2)..]);
        let longest = leg.curves.iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        if let Some(curve) = longest {
            // Passes lie close together, so the arrows of different passes are drawn side by side.
            let earlier = u8::try_from(cut.pass).unwrap_or(u8::MAX).min(4);
            let (middle, direction) = crate::units::along_mm(curve, 0.5 - 0.1 * f64::from(earlier));
            arrow(out, view.xy(middle), direction);
        }
    }
}

/// Draws an arrow head in a direction of the drawing.
fn arrow(out: &mut Lines, (x, y): (f64, f64), direction: Mm2) {
    let (ux, uy) = (direction.x, -direction.y);
    let head = path(format_args!(
        "M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z",
        x + 7.0 * ux,
        y + 7.0 * uy,
        x - 5.0 * ux - 5.0 * uy,
        y - 5.0 * uy + 5.0 * ux,
        x - 5.0 * ux + 5.0 * uy,
        y - 5.0 * uy - 5.0 * ux,
    ));
    out.draw(&[head.fill(FINISH)]);
}

fn draw_trace(out: &mut Lines, trace: &Trace, view: &View) {
    let (colour, width) = match trace.kind {
        TraceKind::Manual => (JOGGING, 0.8),
        TraceKind::Contour => (CONTOUR, 2.4),
    };
    let positions = polyline_of(&trace.points_mm, view);
    out.draw(&[path(positions).outline(colour, width).set("stroke-linejoin", "round")]);
}

fn draw_tool(out: &mut Lines, at: Mm2, radius_mm: f64, view: &View) {
    let (centre, r) = (view.xy(at), radius_mm * view.scale);
    let tool = circle(centre, 2, format_args!("{r:.2}")).fill(TOOL).set("fill-opacity", 0.15);
    out.draw(&[tool.stroke(TOOL, 1.5), circle(centre, 2, 2).fill(TOOL)]);
}

/// Draws a ring for a contact start, a cross for a stop.
fn draw_spot(out: &mut Lines, spot: &Spot, view: &View) {
    let (x, y) = view.xy(spot.at_mm);
    out.draw(&[match spot.kind {
        SpotKind::ProbePoint => circle((x, y), 2, 7).outline(TOUCH, 2.5),
        SpotKind::Stop => {
            path(format_args!("M{:.2} {:.2}l12 12m0 -12l-12 12", x - 6.0, y - 6.0)).outline(STOP, 2.5)
        }
    }]);
}

fn legend(plan: &CertifiedPlan, run: &RunDrawing<'_>) -> Vec<Sign> {
    let (finishing, roughing) = (mm(plan.finishing.units()), mm(plan.roughing.units()));
    let diameter = short(2.0 * mm(plan.plan.tool_radius.units()));
    let mut entries = vec![
        Sign::new(
            PART,
            Mark::Area,
            format!(
                "the part, {} mm, {}, with the numbers of its contours",
                size(plan.profile_size_mm()),
                plan.side_words()
            ),
        ),
        Sign::new(
            KEEP_OUT,
            Mark::Area,
            format!("jogging: the tool's centre stays {roughing:.3} mm from the part"),
        ),
        Sign::new(
            KEEP_OUT_FINISH,
            Mark::Area,
            format!("finishing: the tool's centre stays {finishing:.3} mm from the part"),
        ),
        Sign::new(UNCUT, Mark::Hatched, format!("rest material: {}", plan.residual())),
    ];
    if !plan.plan.provenance.left_out.is_empty() {
        entries.push(left_out_entry(plan.plan.provenance.left_out.len()));
    }
    if !plan.plan.zones.loops.is_empty() {
        entries.push(Sign::new(ZONE, Mark::Area, "keep-out zones: clamps, a vice"));
    }
    if plan.plan.provenance.remarks.iter().any(|remark| remark.at.is_some()) {
        entries.push(Sign::new(REPAIR, Mark::Ring, "repaired in the drawing"));
    }
    if run.progress.is_some() {
        entries.push(Sign::new(FINISH, Mark::Line, "finishing toolpath of a contour that is cut"));
        entries.push(Sign::new(UNCUT, Mark::Dash, "finishing toolpath of a contour that is not cut"));
    } else {
        entries.push(Sign::new(
            FINISH,
            Mark::Dash,
            "finishing toolpath of the tool's centre, with its direction",
        ));
    }
    if run.traces.is_empty() {
        entries.push(Sign::new(LINK, Mark::Line, "link moves"));
        entries.push(Sign::new(TOOL, Mark::Ring, format!("tool Ø {diameter} mm, where a cut could start")));
    } else {
        entries.push(Sign::new(JOGGING, Mark::Line, "tool's centre, jogging"));
        entries.push(Sign::new(CONTOUR, Mark::Line, "tool's centre, contouring"));
        entries.push(Sign::new(TOOL, Mark::Ring, format!("tool Ø {diameter} mm, at its last position")));
    }
    let has = |kind| run.spots.iter().any(|spot| spot.kind == kind);
    if has(SpotKind::ProbePoint) {
        entries.push(Sign::new(TOUCH, Mark::Ring, "contact start: the contour begins"));
    }
    if has(SpotKind::Stop) {
        entries.push(Sign::new(STOP, Mark::Cross, "stop: feed hold or fault"));
    }
    entries
}
