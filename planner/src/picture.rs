//! SVG pictures of a plan and of a run: part, prohibited region, paths, tool, scale and legend.

use std::fmt::Write as _;

use keepout_kernel::{Curve, Side, Turn};

use crate::plan::CertifiedPlan;
use crate::profile::ProfileLoop;
use crate::units::{mm, point_mm};

/// A stretch of tool-centre positions, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// What the machine was doing.
    pub kind: TraceKind,
    /// The positions, mm.
    pub points_mm: Vec<(f64, f64)>,
}

/// What a trace shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceKind {
    /// Steered by hand.
    Manual,
    /// Contouring by itself.
    Contour,
}

const WIDTH: f64 = 1100.0;
const PAD: f64 = 30.0;
const LEGEND: f64 = 132.0;

const PAPER: &str = "#ffffff";
const PART: &str = "#b9c0ca";
const PART_EDGE: &str = "#2b2f36";
const KEEP_OUT: &str = "#f9d5cf";
const KEEP_OUT_FINISH: &str = "#f0b0a6";
const FINISH: &str = "#0b7a3b";
const MANUAL: &str = "#2c6fd1";
const CONTOUR: &str = "#d97a00";
const TOOL: &str = "#5b21b6";

/// Maps mm to pixels, y upward to y downward.
struct View {
    left: f64,
    top: f64,
    scale: f64,
    height: f64,
}

impl View {
    fn xy(&self, (x, y): (f64, f64)) -> (f64, f64) {
        ((x - self.left) * self.scale + PAD, (self.top - y) * self.scale + PAD)
    }
}

/// The picture of a plan, with the traces of a run when there are any.
#[must_use]
pub fn svg(plan: &CertifiedPlan, title: &str, traces: &[Trace]) -> String {
    let view = view_of(plan, traces);
    let mut out = String::new();
    let (width, height) = (WIDTH, view.height + LEGEND + 2.0 * PAD);
    let _ = write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\">\n\
         <title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n\
         <clipPath id=\"field\"><rect x=\"{PAD}\" y=\"{PAD}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath>\n\
         <g clip-path=\"url(#field)\">\n",
        escape(title),
        WIDTH - 2.0 * PAD,
        view.height
    );
    draw_part(&mut out, plan, &view);
    for trace in traces {
        draw_trace(&mut out, trace, &view);
    }
    draw_finish(&mut out, plan, &view);
    if let Some(last) = traces.last().and_then(|trace| trace.points_mm.last()) {
        draw_tool(&mut out, *last, mm(plan.plan.tool_radius.units()), &view);
    }
    out.push_str("</g>\n");
    let frame = (WIDTH - 2.0 * PAD, view.height);
    let _ = writeln!(
        out,
        "<rect x=\"{PAD}\" y=\"{PAD}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#9aa0a8\"/>",
        frame.0, frame.1
    );
    draw_scale(&mut out, &view);
    draw_legend(&mut out, plan, title, traces, &view);
    out.push_str("</svg>\n");
    out
}

fn view_of(plan: &CertifiedPlan, traces: &[Trace]) -> View {
    let (low, high) = plan.part_box();
    let room = 2.0 * mm(plan.roughing.units()) + 2.0;
    let ((mut x0, mut y0), (mut x1, mut y1)) = (point_mm(low), point_mm(high));
    (x0, y0, x1, y1) = (x0 - room, y0 - room, x1 + room, y1 + room);
    // A wild run may roam the whole table: show it up to half the part's size around the part.
    let reach = ((x1 - x0).max(y1 - y0)) / 2.0;
    let limits = (x0 - reach, y0 - reach, x1 + reach, y1 + reach);
    for &(x, y) in traces.iter().flat_map(|trace| &trace.points_mm) {
        (x0, x1) = (x0.min(x.max(limits.0)), x1.max(x.min(limits.2)));
        (y0, y1) = (y0.min(y.max(limits.1)), y1.max(y.min(limits.3)));
    }
    let scale = ((WIDTH - 2.0 * PAD) / (x1 - x0)).min(900.0 / (y1 - y0));
    let spare = (WIDTH - 2.0 * PAD) / scale - (x1 - x0);
    View { left: x0 - spare / 2.0, top: y1, scale, height: (y1 - y0) * scale }
}

fn loop_path(curves: impl Iterator<Item = Curve>, view: &View) -> String {
    let mut path = String::new();
    for curve in curves {
        if path.is_empty() {
            let (x, y) = view.xy(point_mm(curve.from()));
            let _ = write!(path, "M{x:.3} {y:.3}");
        }
        let (x, y) = view.xy(point_mm(curve.to()));
        match curve {
            Curve::Line(_) => {
                let _ = write!(path, "L{x:.3} {y:.3}");
            }
            Curve::Arc(arc) => {
                let r = keepout_kernel::curve::radius(&arc) / f64::from(keepout_kernel::UNITS_PER_MM)
                    * view.scale;
                let large = u8::from(keepout_kernel::curve::sweep(&arc) > std::f64::consts::PI);
                // The picture is mirrored in y: a turn to the left runs against SVG's positive angle.
                let sweep = u8::from(arc.turn() == Turn::Right);
                let _ = write!(path, "A{r:.3} {r:.3} 0 {large} {sweep} {x:.3} {y:.3}");
            }
        }
    }
    path + "Z"
}

fn draw_part(out: &mut String, plan: &CertifiedPlan, view: &View) {
    let each = |ring: &ProfileLoop| loop_path(ring.edges.iter().map(|edge| edge.curve), view);
    let outline: String = plan.plan.profile.loops.iter().map(each).collect();
    for (threshold, colour) in [(plan.roughing, KEEP_OUT), (plan.finishing, KEEP_OUT_FINISH)] {
        let width = 2.0 * mm(threshold.units()) * view.scale;
        let _ = writeln!(
            out,
            "<path d=\"{outline}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width:.2}\" \
             stroke-linejoin=\"round\"/>"
        );
    }
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

fn draw_finish(out: &mut String, plan: &CertifiedPlan, view: &View) {
    for each in &plan.plan.finish.loops {
        let path = loop_path(each.curves.iter().copied(), view);
        let _ = writeln!(
            out,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{FINISH}\" stroke-width=\"1.6\" stroke-dasharray=\"7 3\"/>"
        );
        let longest = each.curves.iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        if let Some(Curve::Line(segment)) = longest {
            arrow(out, view.xy(point_mm(segment.from)), view.xy(point_mm(segment.to)));
        }
    }
}

fn arrow(out: &mut String, a: (f64, f64), b: (f64, f64)) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = dx.hypot(dy);
    if length < 24.0 {
        return;
    }
    let (ux, uy) = (dx / length, dy / length);
    let (x, y) = (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1));
    let _ = writeln!(
        out,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z\" fill=\"{FINISH}\"/>",
        x + 7.0 * ux,
        y + 7.0 * uy,
        x - 5.0 * ux - 5.0 * uy,
        y - 5.0 * uy + 5.0 * ux,
        x - 5.0 * ux + 5.0 * uy,
        y - 5.0 * uy - 5.0 * ux
    );
}

fn draw_trace(out: &mut String, trace: &Trace, view: &View) {
    let (colour, width) = match trace.kind {
        TraceKind::Manual => (MANUAL, 0.8),
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
        "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\" fill=\"{TOOL}\" fill-opacity=\"0.15\" stroke=\"{TOOL}\" \
         stroke-width=\"1.5\"/><circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"2\" fill=\"{TOOL}\"/>"
    );
}

fn draw_scale(out: &mut String, view: &View) {
    let wanted = 160.0 / view.scale;
    let decade = 10_f64.powf(wanted.log10().floor());
    let step =
        [1.0, 2.0, 5.0].into_iter().rev().map(|k| k * decade).find(|&step| step <= wanted).unwrap_or(decade);
    let (x, y, w) = (PAD + 16.0, PAD + view.height - 18.0, step * view.scale);
    let _ = writeln!(
        out,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"26\" fill=\"{PAPER}\" fill-opacity=\"0.8\"/>\
         <path d=\"M{x} {}v10M{x} {y}h{w:.2}m0 -5v10\" stroke=\"#111\" stroke-width=\"1.5\" fill=\"none\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{step} mm</text>",
        x - 6.0,
        y - 19.0,
        w + 12.0,
        y - 5.0,
        x + w / 2.0,
        y - 6.0
    );
}

fn draw_legend(out: &mut String, plan: &CertifiedPlan, title: &str, traces: &[Trace], view: &View) {
    let top = view.height + 2.0 * PAD;
    let _ = writeln!(
        out,
        "<text x=\"{PAD}\" y=\"{:.1}\" font-size=\"17\" font-weight=\"bold\">{}</text>",
        top + 8.0,
        escape(title)
    );
    let (finishing, roughing) = (mm(plan.finishing.units()), mm(plan.roughing.units()));
    let mut entries = vec![
        (PART, "box", "the part".to_string()),
        (KEEP_OUT, "box", format!("roughing: centre kept out, {roughing:.3} mm around the part")),
        (KEEP_OUT_FINISH, "box", format!("finishing: centre kept out, {finishing:.3} mm around the part")),
        (FINISH, "dash", "finishing path of the tool centre".to_string()),
    ];
    if !traces.is_empty() {
        entries.push((MANUAL, "line", "tool centre, steered by hand".to_string()));
        entries.push((CONTOUR, "line", "tool centre, contouring by itself".to_string()));
        let diameter = 2.0 * mm(plan.plan.tool_radius.units());
        entries.push((TOOL, "ring", format!("tool, {diameter:.3} mm diameter, where it ended")));
    }
    for (k, (colour, mark, text)) in entries.iter().enumerate() {
        let column = if k < 4 { 0.0 } else { 1.0 };
        let row = if k < 4 { k } else { k - 4 };
        let x = PAD + column * 520.0;
        let y = top + 32.0 + 24.0 * f64::from(u8::try_from(row).unwrap_or(0));
        let mark = match *mark {
            "box" => format!(
                "<rect x=\"{x}\" y=\"{}\" width=\"30\" height=\"14\" fill=\"{colour}\" stroke=\"#777\" stroke-width=\"0.5\"/>",
                y - 11.0
            ),
            "ring" => format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"7\" fill=\"{colour}\" fill-opacity=\"0.15\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
                x + 15.0,
                y - 4.0
            ),
            style => {
                let dash = if style == "dash" { " stroke-dasharray=\"7 3\"" } else { "" };
                format!("<path d=\"M{x} {}h30\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>", y - 4.0)
            }
        };
        let _ = writeln!(out, "{mark}<text x=\"{}\" y=\"{y:.1}\">{}</text>", x + 40.0, escape(text));
    }
}

/// Text made safe for XML.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
