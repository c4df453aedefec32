//! Picture of a plan, with the traces of a run if there are any.

use std::fmt::Write as _;

use keepout_kernel::{Curve, Side, UNITS_PER_MM};

use super::view::{Entry, Mark, PAD, View, WIDTH, page, path_of};
use crate::finish::centre_distance;
use crate::job::{ContourJob, preview};
use crate::plan::CertifiedPlan;
use crate::profile::ProfileLoop;
use crate::units::{mm, point_mm};

/// A series of tool-centre positions, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// State of the machine in this series.
    pub kind: TraceKind,
    /// The positions, mm.
    pub points_mm: Vec<(f64, f64)>,
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
    pub at_mm: (f64, f64),
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
    let mut body = String::new();
    draw_part(&mut body, plan, &view);
    draw_zones(&mut body, plan, &view);
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
            let (x, y) = view.xy(point_mm(at));
            let _ = writeln!(
                body,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\" fill=\"none\" \
                 stroke=\"{REPAIR}\" stroke-width=\"2\"/>"
            );
        }
    }
    if let Some(last) = traces.last().and_then(|trace| trace.points_mm.last()) {
        draw_tool(&mut body, *last, mm(plan.plan.tool_radius.units()), &view);
    }
    spots.iter().for_each(|spot| draw_spot(&mut body, spot, &view));
    page(&view, title, &legend(plan, traces, spots), &body)
}

fn view_of(plan: &CertifiedPlan, traces: &[Trace]) -> View {
    let (low, high) = plan.part_box();
    let room = 2.0 * mm(plan.roughing.units()) + 2.0;
    let ((mut x0, mut y0), (mut x1, mut y1)) = (point_mm(low), point_mm(high));
    (x0, y0, x1, y1) = (x0 - room, y0 - room, x1 + room, y1 + room);
    // A run may use the whole table. The picture shows it up to half the part's size around the part.
    let reach = ((x1 - x0).max(y1 - y0)) / 2.0;
    let limits = (x0 - reach, y0 - reach, x1 + reach, y1 + reach);
    for &(x, y) in traces.iter().flat_map(|trace| &trace.points_mm) {
        (x0, x1) = (x0.min(x.max(limits.0)), x1.max(x.min(limits.2)));
        (y0, y1) = (y0.min(y.max(limits.1)), y1.max(y.min(limits.3)));
    }
    View::of((x0, y0), (x1, y1))
}

fn draw_part(out: &mut String, plan: &CertifiedPlan, view: &View) {
    let each = |ring: &ProfileLoop| path_of(ring.edges.iter().map(|edge| edge.curve), view) + "Z";
    let outline: String = plan.plan.profile.loops.iter().map(each).collect();
    let zones: String = plan.plan.zones.loops.iter().map(each).collect();
    for (threshold, colour) in [(plan.roughing, KEEP_OUT), (plan.finishing, KEEP_OUT_FINISH)] {
        let width = 2.0 * mm(threshold.units()) * view.scale;
        let _ = writeln!(
            out,
            "<path d=\"{outline}{zones}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width:.2}\" \
             stroke-linejoin=\"round\"/>"
        );
    }
    draw_rest_material(out, plan, view);
    let around = match plan.part.side() {
        Side::Outside => String::new(),
        Side::Inside => format!("M0 0H{WIDTH}V{:.1}H0Z", view.height + 2.0 * PAD),
    };
    let _ = writeln!(
        out,
        "<path d=\"{around}{outline}\" fill=\"{PART}\" fill-rule=\"evenodd\" stroke=\"{PART_EDGE}\" \
         stroke-width=\"1.3\"/>"
    );
}

fn draw_zones(out: &mut String, plan: &CertifiedPlan, view: &View) {
    let each = |ring: &ProfileLoop| path_of(ring.edges.iter().map(|edge| edge.curve), view) + "Z";
    let zones: String = plan.plan.zones.loops.iter().map(each).collect();
    if !zones.is_empty() {
        let _ = writeln!(
            out,
            "<path d=\"{zones}\" fill=\"{ZONE}\" stroke=\"{PART_EDGE}\" stroke-width=\"1.3\"/>"
        );
    }
}

/// Draws the rest material: the area outside the part that no tool disc with a clear centre covers.
fn draw_rest_material(out: &mut String, plan: &CertifiedPlan, view: &View) {
    let loops = &plan.plan.finish().loops;
    let free: String = loops.iter().map(|each| path_of(each.curves.iter().copied(), view) + "Z").collect();
    // The clear centres are outside the loops when the part is inside them, else inside.
    let around = match plan.part.side() {
        Side::Outside => format!("M-9999 -9999H{0}V{0}H-9999Z", 9999.0 + view.height),
        Side::Inside => String::new(),
    };
    let touching =
        centre_distance(&plan.plan.profile, &plan.plan.zones, plan.finishing) / f64::from(UNITS_PER_MM);
    let _ = writeln!(
        out,
        "<mask id=\"left\" maskUnits=\"userSpaceOnUse\" x=\"0\" y=\"0\" \
         width=\"{WIDTH}\" height=\"{height:.1}\">\
         <rect width=\"{WIDTH}\" height=\"{height:.1}\" fill=\"#fff\"/>\
         <path d=\"{around}{free}\" fill=\"#000\" fill-rule=\"evenodd\" stroke=\"none\"/>\
         <path d=\"{free}\" fill=\"none\" stroke=\"#000\" stroke-width=\"{:.3}\" \
         stroke-linejoin=\"round\"/></mask>\n\
         <rect width=\"{WIDTH}\" height=\"{height:.1}\" fill=\"{REST_MATERIAL}\" mask=\"url(#left)\"/>",
        2.0 * touching * view.scale,
        height = view.height + 2.0 * PAD
    );
}

fn draw_finish(out: &mut String, plan: &CertifiedPlan, view: &View) {
    for each in plan.plan.passes.iter().flat_map(|pass| &pass.path.loops) {
        let path = path_of(each.curves.iter().copied(), view) + "Z";
        let _ = writeln!(
            out,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{FINISH}\" stroke-width=\"1.6\" \
             stroke-dasharray=\"7 3\"/>"
        );
    }
}

/// Draws link moves and leads of a contouring job, with the order and direction of its cuts.
fn draw_job(out: &mut String, job: &ContourJob, view: &View) {
    let mut number = 0;
    for leg in &job.legs {
        let colour = if leg.cuts.is_some() { FINISH } else { LINK };
        let travel = |out: &mut String, curves: &[Curve]| {
            let path = path_of(curves.iter().copied(), view);
            let _ =
                writeln!(out, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\"/>");
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
fn arrow(out: &mut String, (x, y): (f64, f64), (dx, dy): (f64, f64), number: u32) {
    let (ux, uy) = (dx, -dy);
    let _ = writeln!(
        out,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z\" fill=\"{FINISH}\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"12\" font-weight=\"bold\" fill=\"{FINISH}\" \
         stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">{number}</text>",
        x + 7.0 * ux,
        y + 7.0 * uy,
        x - 5.0 * ux - 5.0 * uy,
        y - 5.0 * uy + 5.0 * ux,
        x - 5.0 * ux + 5.0 * uy,
        y - 5.0 * uy - 5.0 * ux,
        x - 14.0 * uy - 4.0,
        y + 14.0 * ux + 4.0,
    );
}

fn draw_trace(out: &mut String, trace: &Trace, view: &View) {
    let (colour, width) = match trace.kind {
        TraceKind::Manual => (JOGGING, 0.8),
        TraceKind::Contour => (CONTOUR, 2.4),
    };
    let mut points = String::new();
    for &point in &trace.points_mm {
        let (x, y) = view.xy(point);
        let _ = write!(points, "{x:.2},{y:.2} ");
    }
    let _ = writeln!(
        out,
        "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
         stroke-linejoin=\"round\"/>"
    );
}

fn draw_tool(out: &mut String, at: (f64, f64), radius_mm: f64, view: &View) {
    let ((x, y), r) = (view.xy(at), radius_mm * view.scale);
    let _ = writeln!(
        out,
        "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\" fill=\"{TOOL}\" fill-opacity=\"0.15\" \
         stroke=\"{TOOL}\" stroke-width=\"1.5\"/>\
         <circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"2\" fill=\"{TOOL}\"/>"
    );
}

/// Draws a ring for a contact start, a cross for a stop.
fn draw_spot(out: &mut String, spot: &Spot, view: &View) {
    let (x, y) = view.xy(spot.at_mm);
    let _ = match spot.kind {
        SpotKind::ProbePoint => writeln!(
            out,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"7\" fill=\"none\" stroke=\"{TOUCH}\" \
             stroke-width=\"2.5\"/>"
        ),
        SpotKind::Stop => writeln!(
            out,
            "<path d=\"M{:.2} {:.2}l12 12m0 -12l-12 12\" fill=\"none\" stroke=\"{STOP}\" \
             stroke-width=\"2.5\"/>",
            x - 6.0,
            y - 6.0
        ),
    };
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
