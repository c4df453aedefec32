//! Picture of a plan, with the traces of a run if there are any.

use keepout_kernel::{Curve, Side, UNITS_PER_MM};

use super::element::{Element, Lines, circle, path, points, polyline, text};
use super::view::{Entry, Mark, PAD, View, WIDTH, outlines, page, path_of};
use crate::finish::centre_distance;
use crate::job::{ContourJob, preview};
use crate::plan::CertifiedPlan;
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

const TOUCH: &str = "#be185d";
const STOP: &str = "#111827";
const PART: &str = "#b9c0ca";
const PART_EDGE: &str = "#2b2f36";
const KEEP_OUT: &str = "#f9d5cf";
const KEEP_OUT_FINISH: &str = "#f0b0a6";
const ZONE: &str = "#6b7280";
const REST_MATERIAL: &str = "#c8102e";
const FINISH: &str = "#0b7a3b";
const LINK: &str = "#7a8594";
const REPAIR: &str = "#b45309";
const JOGGING: &str = "#2c6fd1";
const CONTOUR: &str = "#d97a00";
const TOOL: &str = "#5b21b6";

/// SVG of a plan, with the traces of a run. Without traces it shows the leads and the order of the cuts
/// for one contact start.
#[must_use]
pub fn svg(plan: &CertifiedPlan, title: &str, traces: &[Trace]) -> String {
    svg_of_run(plan, title, traces, &[])
}

/// SVG as [`svg`], with marked places of the run.
#[must_use]
pub fn svg_of_run(plan: &CertifiedPlan, title: &str, traces: &[Trace], spots: &[Spot]) -> String {
    let view = view_of(plan, traces);
    let mut body = Lines::default();
    draw_part(&mut body, plan, &view);
    for trace in traces {
        draw_trace(&mut body, trace, &view);
    }
    draw_finish(&mut body, plan, &view);
    if traces.is_empty() {
        for job in preview(plan) {
            draw_job(&mut body, &job, &view);
        }
    }
    for remark in &plan.plan.provenance.remarks {
        if let Some(at) = remark.at {
            body.draw(&[circle(view.xy(point_mm(at)), 1, 6).outline(REPAIR, 2)]);
        }
    }
    if let Some(last) = traces.last().and_then(|trace| trace.points_mm.last()) {
        draw_tool(&mut body, *last, mm(plan.plan.tool_radius.units()), &view);
    }
    spots.iter().for_each(|spot| draw_spot(&mut body, spot, &view));
    page(&view, title, &legend(plan, traces, spots), &body)
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

/// Draws the part and the keep-out zones, with their clearances.
fn draw_part(out: &mut Lines, plan: &CertifiedPlan, view: &View) {
    let outline = outlines(&plan.plan.profile.loops, view);
    let zones = outlines(&plan.plan.zones.loops, view);
    for (threshold, colour) in [(plan.roughing, KEEP_OUT), (plan.finishing, KEEP_OUT_FINISH)] {
        let width = 2.0 * mm(threshold.units()) * view.scale;
        let both = path(format_args!("{outline}{zones}"));
        out.draw(&[both.outline(colour, format_args!("{width:.2}")).set("stroke-linejoin", "round")]);
    }
    draw_rest_material(out, plan, view);
    let around = match plan.part.side() {
        Side::Outside => String::new(),
        Side::Inside => format!("M0 0H{WIDTH}V{:.1}H0Z", view.height + 2.0 * PAD),
    };
    let part = path(format_args!("{around}{outline}"));
    out.draw(&[part.fill(PART).set("fill-rule", "evenodd").stroke(PART_EDGE, 1.3)]);
    if !zones.is_empty() {
        out.draw(&[path(zones).fill(ZONE).stroke(PART_EDGE, 1.3)]);
    }
}

/// Draws the rest material: the area outside the part that no tool disc with a clear centre covers.
fn draw_rest_material(out: &mut Lines, plan: &CertifiedPlan, view: &View) {
    let loops = &plan.plan.finish().loops;
    let free: String = loops.iter().map(|each| path_of(each.curves.iter().copied(), view) + "Z").collect();
    // The clear centres are outside the loops when the part is inside them, else inside.
    let around = match plan.part.side() {
        Side::Outside => format!("M-9999 -9999H{0}V{0}H-9999Z", 9999.0 + view.height),
        Side::Inside => String::new(),
    };
    let touching =
        centre_distance(&plan.plan.profile, &plan.plan.zones, plan.finishing) / f64::from(UNITS_PER_MM);
    let sized = |element: Element| element.set("width", WIDTH).fixed("height", view.height + 2.0 * PAD, 1);
    let all = || sized(Element::new("rect"));
    let width = 2.0 * touching * view.scale;
    let centres =
        path(format_args!("{around}{free}")).fill("#000").set("fill-rule", "evenodd").set("stroke", "none");
    let tool = path(free).outline("#000", format_args!("{width:.3}")).set("stroke-linejoin", "round");
    let mask = Element::new("mask").set("id", "left").set("maskUnits", "userSpaceOnUse");
    let mask = sized(mask.set("x", 0).set("y", 0)).with(&all().fill("#fff")).with(&centres).with(&tool);
    out.draw(&[mask]);
    out.draw(&[all().fill(REST_MATERIAL).set("mask", "url(#left)")]);
}

fn draw_finish(out: &mut Lines, plan: &CertifiedPlan, view: &View) {
    for each in plan.plan.passes.iter().flat_map(|pass| &pass.path.loops) {
        let toolpath = path_of(each.curves.iter().copied(), view) + "Z";
        out.draw(&[path(toolpath).outline(FINISH, 1.6).set("stroke-dasharray", "7 3")]);
    }
}

/// Draws link moves and leads of a contouring job, with the order and direction of its cuts.
fn draw_job(out: &mut Lines, job: &ContourJob, view: &View) {
    let mut number = 0;
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
        number += 1;
        let longest = leg.curves.iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        if let Some(curve) = longest {
            // Passes lie close together, so the numbers of different passes are drawn side by side.
            let earlier = u8::try_from(cut.pass).unwrap_or(u8::MAX).min(4);
            let (middle, direction) = crate::units::along_mm(curve, 0.5 - 0.1 * f64::from(earlier));
            arrow(out, view.xy(middle), direction, number);
        }
    }
}

/// Draws an arrow head in a direction of the drawing, with the number of the cut beside it.
fn arrow(out: &mut Lines, (x, y): (f64, f64), direction: Mm2, number: u32) {
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
    let beside = text((x - 14.0 * uy - 4.0, y + 14.0 * ux + 4.0), 1, number).bold(12).fill(FINISH);
    out.draw(&[head.fill(FINISH), beside.stroke("#fff", 3).set("paint-order", "stroke")]);
}

fn draw_trace(out: &mut Lines, trace: &Trace, view: &View) {
    let (colour, width) = match trace.kind {
        TraceKind::Manual => (JOGGING, 0.8),
        TraceKind::Contour => (CONTOUR, 2.4),
    };
    let positions = points(trace.points_mm.iter().map(|&point| view.xy(point)), 2);
    out.draw(&[polyline(&positions).outline(colour, width).set("stroke-linejoin", "round")]);
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

fn legend(plan: &CertifiedPlan, traces: &[Trace], spots: &[Spot]) -> Vec<Entry> {
    let (finishing, roughing) = (mm(plan.finishing.units()), mm(plan.roughing.units()));
    let finish = plan.plan.finish();
    let mut entries = vec![
        Entry::new(PART, Mark::Area, "the part"),
        Entry::new(
            KEEP_OUT,
            Mark::Area,
            format!("jogging clearance of the tool centre, {roughing:.3} mm around the part"),
        ),
        Entry::new(
            KEEP_OUT_FINISH,
            Mark::Area,
            format!("finishing clearance of the tool centre, {finishing:.3} mm around the part"),
        ),
        Entry::new(REST_MATERIAL, Mark::Area, format!("rest material: {}", finish.residual())),
        Entry::new(FINISH, Mark::Dash, "finishing toolpath of the tool centre"),
    ];
    if !plan.plan.zones.loops.is_empty() {
        entries.push(Entry::new(ZONE, Mark::Area, "keep-out zones: clamps, a vice"));
    }
    if plan.plan.provenance.remarks.iter().any(|remark| remark.at.is_some()) {
        entries.push(Entry::new(REPAIR, Mark::Ring, "repaired in the drawing"));
    }
    if traces.is_empty() {
        entries.push(Entry::new(FINISH, Mark::Line, "leads, order and direction, for one contact start"));
        entries.push(Entry::new(LINK, Mark::Line, "link moves"));
    } else {
        entries.push(Entry::new(JOGGING, Mark::Line, "tool centre, jogging"));
        entries.push(Entry::new(CONTOUR, Mark::Line, "tool centre, contouring"));
        let diameter = 2.0 * mm(plan.plan.tool_radius.units());
        entries.push(Entry::new(
            TOOL,
            Mark::Ring,
            format!("tool, {diameter:.3} mm diameter, at its last position"),
        ));
    }
    let has = |kind| spots.iter().any(|spot| spot.kind == kind);
    if has(SpotKind::ProbePoint) {
        entries.push(Entry::new(TOUCH, Mark::Ring, "contact start: the contour begins"));
    }
    if has(SpotKind::Stop) {
        entries.push(Entry::new(STOP, Mark::Cross, "stop: feed hold or fault"));
    }
    entries
}
