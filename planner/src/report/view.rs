//! Parts that all pictures share: the view, paths of curves, the scale, the legend.

use std::fmt::Write as _;

use keepout_kernel::{Curve, Turn};

use crate::units::point_mm;

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
    pub fn of((x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> Self {
        let (w, h) = ((x1 - x0).max(1e-3), (y1 - y0).max(1e-3));
        let scale = ((WIDTH - 2.0 * PAD) / w).min(900.0 / h);
        let spare = (WIDTH - 2.0 * PAD) / scale - w;
        Self { left: x0 - spare / 2.0, top: y1, scale, height: h * scale }
    }

    pub fn xy(&self, (x, y): (f64, f64)) -> (f64, f64) {
        ((x - self.left) * self.scale + PAD, (self.top - y) * self.scale + PAD)
    }
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

/// Text escaped for XML. XML permits no control characters.
#[must_use]
pub fn escape(text: &str) -> String {
    let shown = |letter: char| if letter.is_control() && letter != '\n' { '\u{fffd}' } else { letter };
    let text: String = text.chars().map(shown).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
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
pub(super) fn page(view: &View, title: &str, legend: &[Entry], body: &str) -> String {
    let rows = legend.len().div_ceil(2);
    let legend_height = 40.0 + ROW * f64::from(u32::try_from(rows).unwrap_or(0));
    let (width, height) = (WIDTH, view.height + legend_height + 2.0 * PAD);
    let (title, field) = (escape(title), WIDTH - 2.0 * PAD);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\">\n\
         <title>{title}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n\
         <clipPath id=\"field\">\
         <rect x=\"{PAD}\" y=\"{PAD}\" width=\"{field:.1}\" height=\"{:.1}\"/></clipPath>\n\
         <g clip-path=\"url(#field)\">\n{body}</g>\n\
         <rect x=\"{PAD}\" y=\"{PAD}\" width=\"{field:.1}\" height=\"{:.1}\" fill=\"none\" \
         stroke=\"#9aa0a8\"/>\n",
        view.height, view.height
    );
    draw_scale(&mut out, view);
    let top = view.height + 2.0 * PAD;
    let _ = writeln!(
        out,
        "<text x=\"{PAD}\" y=\"{:.1}\" font-size=\"17\" font-weight=\"bold\">{title}</text>",
        top + 8.0
    );
    for (k, entry) in legend.iter().enumerate() {
        let column = f64::from(u8::from(k >= rows));
        let row = f64::from(u32::try_from(k % rows.max(1)).unwrap_or(0));
        draw_entry(&mut out, entry, PAD + column * 520.0, top + 32.0 + ROW * row);
    }
    out.push_str("</svg>\n");
    out
}

fn draw_entry(out: &mut String, entry: &Entry, x: f64, y: f64) {
    let colour = entry.colour;
    let mark = match entry.mark {
        Mark::Area => format!(
            "<rect x=\"{x}\" y=\"{}\" width=\"30\" height=\"14\" fill=\"{colour}\" \
             stroke=\"#777\" stroke-width=\"0.5\"/>",
            y - 11.0
        ),
        Mark::Ring => format!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"7\" fill=\"{colour}\" fill-opacity=\"0.15\" \
             stroke=\"{colour}\" stroke-width=\"1.5\"/>",
            x + 15.0,
            y - 4.0
        ),
        Mark::Cross => format!(
            "<path d=\"M{} {}l12 12m0 -12l-12 12\" stroke=\"{colour}\" stroke-width=\"2.5\"/>",
            x + 9.0,
            y - 10.0
        ),
        Mark::Line | Mark::Dash => {
            let dash = if matches!(entry.mark, Mark::Dash) { " stroke-dasharray=\"7 3\"" } else { "" };
            format!("<path d=\"M{x} {}h30\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>", y - 4.0)
        }
    };
    let _ = writeln!(out, "{mark}<text x=\"{}\" y=\"{y:.1}\">{}</text>", x + 40.0, escape(&entry.text));
}
