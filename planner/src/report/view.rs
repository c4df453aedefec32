//! Parts that all pictures share: the view, paths of curves, the scale, the legend.

use std::fmt::Write as _;

use keepout_kernel::{Curve, Turn};

use super::chart::round_steps;
use super::element::{Element, Lines, background, document, path, text};
use crate::profile::ProfileLoop;
use crate::units::point_mm;
use crate::{Box2, Mm2};

pub(super) const WIDTH: f64 = 1100.0;
pub(super) const PAD: f64 = 30.0;
pub(super) const PAPER: &str = "#ffffff";

/// Maps mm to pixels, y upward to y downward.
pub(super) struct View {
    pub left: f64,
    pub top: f64,
    pub scale: f64,
    pub height: f64,
}

impl View {
    /// View of a box, mm, as large as the page allows.
    pub fn of(shown: Box2) -> Self {
        let (w, h) = (shown.size().x.max(1e-3), shown.size().y.max(1e-3));
        let scale = ((WIDTH - 2.0 * PAD) / w).min(900.0 / h);
        let spare = (WIDTH - 2.0 * PAD) / scale - w;
        Self { left: shown.low.x - spare / 2.0, top: shown.high.y, scale, height: h * scale }
    }

    pub fn xy(&self, Mm2 { x, y }: Mm2) -> (f64, f64) {
        ((x - self.left) * self.scale + PAD, (self.top - y) * self.scale + PAD)
    }
}

/// SVG path of closed loops.
pub(super) fn outlines(loops: &[ProfileLoop], view: &View) -> String {
    loops.iter().map(|each| path_of(each.edges.iter().map(|edge| edge.curve), view) + "Z").collect()
}

/// SVG path of curves that join end to end.
pub(super) fn path_of(curves: impl Iterator<Item = Curve>, view: &View) -> String {
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
                // The picture is mirrored in y, so a counter-clockwise arc has a negative angle in SVG.
                let sweep = u8::from(arc.turn() == Turn::Clockwise);
                let _ = write!(path, "A{r:.3} {r:.3} 0 {large} {sweep} {x:.3} {y:.3}");
            }
        }
    }
    path
}

fn draw_scale(out: &mut Lines, view: &View) {
    let wanted = 160.0 / view.scale;
    let step = round_steps(wanted).into_iter().rfind(|&step| step <= wanted).unwrap_or(wanted);
    let (x, y, w) = (PAD + 16.0, PAD + view.height - 18.0, step * view.scale);
    let behind = Element::new("rect").fixed("x", x - 6.0, 1).fixed("y", y - 19.0, 1);
    let behind = behind.fixed("width", w + 12.0, 1).set("height", 26);
    let bar = path(format_args!("M{x} {}v10M{x} {y}h{w:.2}m0 -5v10", y - 5.0)).stroke("#111", 1.5);
    let length = text((x + w / 2.0, y - 6.0), 1, format_args!("{step} mm")).set("text-anchor", "middle");
    out.draw(&[behind.fill(PAPER).set("fill-opacity", 0.8), bar.fill("none"), length]);
}

/// Mark of a legend entry.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    Area,
    Line,
    Dash,
    Ring,
    Cross,
}

/// Entry of the legend.
pub(super) struct Entry {
    pub colour: &'static str,
    pub mark: Mark,
    pub text: String,
}

impl Entry {
    pub fn new(colour: &'static str, mark: Mark, text: impl Into<String>) -> Self {
        Self { colour, mark, text: text.into() }
    }
}

const ROW: f64 = 24.0;

/// The whole page: `body` in the field, a scale, and below it the title and the legend in two columns.
pub(super) fn page(view: &View, title: &str, legend: &[Entry], body: &Lines) -> String {
    let rows = legend.len().div_ceil(2);
    let legend_height = 40.0 + ROW * f64::from(u32::try_from(rows).unwrap_or(0));
    let (width, height) = (WIDTH, view.height + legend_height + 2.0 * PAD);
    let field = || {
        let corner = Element::new("rect").set("x", PAD).set("y", PAD);
        corner.fixed("width", WIDTH - 2.0 * PAD, 1).fixed("height", view.height, 1)
    };
    let mut out = Lines::default();
    out.draw(&[Element::new("title").text(title)]);
    out.draw(&[background(PAPER)]);
    out.draw(&[Element::new("clipPath").set("id", "field").with(&field())]);
    out.draw(&[Element::new("g").set("clip-path", "url(#field)").lines(body)]);
    out.draw(&[field().fill("none").set("stroke", "#9aa0a8")]);
    draw_scale(&mut out, view);
    let top = view.height + 2.0 * PAD;
    out.draw(&[Element::new("text").set("x", PAD).fixed("y", top + 8.0, 1).bold(17).text(title)]);
    for (k, entry) in legend.iter().enumerate() {
        let column = f64::from(u8::from(k >= rows));
        let row = f64::from(u32::try_from(k % rows.max(1)).unwrap_or(0));
        draw_entry(&mut out, entry, PAD + column * 520.0, top + 32.0 + ROW * row);
    }
    let page = document((width, height)).fixed("width", width, 0).fixed("height", height, 0);
    let page = page.set("font-family", "Helvetica, Arial, sans-serif").set("font-size", 13);
    format!("{}\n", page.lines(&out))
}

fn draw_entry(out: &mut Lines, entry: &Entry, x: f64, y: f64) {
    let colour = entry.colour;
    let mark = match entry.mark {
        Mark::Area => {
            let area = Element::new("rect").set("x", x).set("y", y - 11.0);
            area.set("width", 30).set("height", 14).fill(colour).stroke("#777", 0.5)
        }
        Mark::Ring => {
            let ring = Element::new("circle").set("cx", x + 15.0).set("cy", y - 4.0).set("r", 7);
            ring.fill(colour).set("fill-opacity", 0.15).stroke(colour, 1.5)
        }
        Mark::Cross => path(format_args!("M{} {}l12 12m0 -12l-12 12", x + 9.0, y - 10.0)).stroke(colour, 2.5),
        Mark::Line => path(format_args!("M{x} {}h30", y - 4.0)).stroke(colour, 2),
        Mark::Dash => {
            path(format_args!("M{x} {}h30", y - 4.0)).stroke(colour, 2).set("stroke-dasharray", "7 3")
        }
    };
    out.draw(&[mark, Element::new("text").set("x", x + 40.0).fixed("y", y, 1).text(&entry.text)]);
}
