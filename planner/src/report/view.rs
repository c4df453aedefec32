//! Parts that all pictures share: the view, paths of curves, the scale, dimensions, the legend.

use std::fmt::Write as _;

use keepout_kernel::{Curve, Turn};

use super::chart::round_below;
use super::element::{Element, Lines, background, document, path, text};
use crate::contour::short;
use crate::profile::ProfileLoop;
use crate::units::point_mm;
use crate::{Box2, Mm2};

pub(super) const WIDTH: f64 = 1100.0;
pub(super) const PAD: f64 = 30.0;
pub(super) const PAPER: &str = "#ffffff";
const INK: &str = "#1d2025";
const LEFT_OUT: &str = "#9aa0a8";
/// Pixels around the part for its dimensions.
const DIMENSIONS: f64 = 46.0;
/// Largest distance of a drawn polyline from its points, pixels.
const THINNED: f64 = 0.25;

/// Maps mm to pixels, y upward to y downward.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// X of the field's left side, mm.
    pub left: f64,
    /// Y of the field's upper side, mm.
    pub top: f64,
    /// Pixels for a millimetre.
    pub scale: f64,
    /// Height of the field, pixels.
    pub height: f64,
}

impl View {
    /// View of a box, mm, as large as the page allows, with room for the dimensions.
    #[must_use]
    pub fn of(shown: Box2) -> Self {
        let (w, h) = (shown.size().x.max(1e-3), shown.size().y.max(1e-3));
        let scale = ((WIDTH - 2.0 * (PAD + DIMENSIONS)) / w).min(800.0 / h);
        let spare = (WIDTH - 2.0 * PAD) / scale - w;
        let room = DIMENSIONS / scale;
        Self {
            left: shown.low.x - spare / 2.0,
            top: shown.high.y + room,
            scale,
            height: (h + 2.0 * room) * scale,
        }
    }

    /// A place of the drawing, mm, in pixels.
    #[must_use]
    pub fn xy(&self, Mm2 { x, y }: Mm2) -> (f64, f64) {
        ((x - self.left) * self.scale + PAD, (self.top - y) * self.scale + PAD)
    }

    /// A length of the picture, mm, that one pixel shows.
    #[must_use]
    pub fn pixel_mm(&self) -> f64 {
        1.0 / self.scale
    }

    /// SVG path of the whole field, and more.
    #[must_use]
    pub fn everything(&self) -> String {
        format!("M-9999 -9999H{0:.0}V{0:.0}H-9999Z", 9999.0 + self.height)
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
            let _ = write!(path, "M{x:.2} {y:.2}");
        }
        let (x, y) = view.xy(point_mm(curve.to()));
        match curve {
            Curve::Line(_) => {
                let _ = write!(path, "L{x:.2} {y:.2}");
            }
            Curve::Arc(arc) => {
                let r = keepout_kernel::curve::radius(&arc) / f64::from(keepout_kernel::UNITS_PER_MM)
                    * view.scale;
                let large = u8::from(keepout_kernel::curve::sweep(&arc) > std::f64::consts::PI);
                // The picture is mirrored in y, so a counter-clockwise arc has a negative angle in SVG.
                let sweep = u8::from(arc.turn() == Turn::Clockwise);
                let _ = write!(path, "A{r:.2} {r:.2} 0 {large} {sweep} {x:.2} {y:.2}");
            }
        }
    }
    path
}

/// SVG path of polygons, mm.
pub(super) fn polygons(polygons: &[Vec<Vec<[f64; 2]>>], view: &View) -> String {
    let mut path = String::new();
    for contour in polygons.iter().flatten() {
        for (k, &[x, y]) in contour.iter().enumerate() {
            let (x, y) = view.xy(Mm2::new(x, y));
            let _ = write!(path, "{}{x:.2} {y:.2}", if k == 0 { 'M' } else { 'L' });
        }
        path.push('Z');
    }
    path
}

/// SVG path of a polyline, mm. It leaves out points that a quarter of a pixel hides.
#[must_use]
pub fn polyline_of(points: &[Mm2], view: &View) -> String {
    let pixels: Vec<Mm2> = points.iter().map(|&at| view.xy(at)).map(|(x, y)| Mm2::new(x, y)).collect();
    let mut path = String::new();
    for (k, at) in thinned(&pixels).into_iter().enumerate() {
        let _ = write!(path, "{}{:.1} {:.1}", if k == 0 { 'M' } else { 'L' }, at.x, at.y);
    }
    path
}

/// The points that a polyline needs to stay within [`THINNED`] of all points (Douglas and Peucker, 1973).
fn thinned(points: &[Mm2]) -> Vec<Mm2> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    (keep[0], keep[points.len() - 1]) = (true, true);
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let off = |k: usize| points[k].distance(points[k].nearest_on(points[first], points[last]));
        let farthest = (first + 1..last).map(|k| (off(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((off, k)) = farthest.filter(|(off, _)| *off > THINNED) {
            debug_assert!(off.is_finite(), "points are finite");
            keep[k] = true;
            open.extend([(first, k), (k, last)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(at, _)| *at).collect()
}

/// Draws curves that were left out of the drawing, faintly.
pub(super) fn draw_left_out<'a>(out: &mut Lines, curves: impl Iterator<Item = &'a [Mm2]>, view: &View) {
    let all: String = curves.map(|points| polyline_of(points, view)).collect();
    if !all.is_empty() {
        out.draw(&[path(all).outline(LEFT_OUT, 0.8).set("stroke-dasharray", "2 3")]);
    }
}

/// Legend entry of [`draw_left_out`].
pub(super) fn left_out_entry(count: usize) -> Sign {
    Sign::new(LEFT_OUT, Mark::Dash, format!("left out of the drawing: {count} curves"))
}

/// Draws width and height beside a box.
pub(super) fn draw_dimensions(out: &mut Lines, around: Box2, view: &View) {
    let ((x0, y1), (x1, y0)) = (view.xy(around.low), view.xy(around.high));
    let size = around.size();
    let (below, left) = (PAD + view.height - 14.0, (x0 - 34.0).max(PAD + 14.0));
    let arrows = |from: (f64, f64), to: (f64, f64)| {
        let line = format!("M{:.1} {:.1}L{:.1} {:.1}", from.0, from.1, to.0, to.1);
        path(line).outline(INK, 0.9).set("marker-start", "url(#tip)").set("marker-end", "url(#tip)")
    };
    let extension = format!(
        "M{x0:.1} {:.1}V{:.1}M{x1:.1} {:.1}V{:.1}M{:.1} {y0:.1}H{:.1}M{:.1} {y1:.1}H{:.1}",
        y1 + 3.0,
        below + 4.0,
        y1 + 3.0,
        below + 4.0,
        x0 - 3.0,
        left - 4.0,
        x0 - 3.0,
        left - 4.0
    );
    let label = |at: (f64, f64), mm: f64| {
        text(at, 1, short(mm))
            .set("text-anchor", "middle")
            .stroke(PAPER, 4)
            .set("paint-order", "stroke")
            .fill(INK)
    };
    let (middle, across) = (f64::midpoint(x0, x1), f64::midpoint(y0, y1));
    out.draw(&[
        path(extension).outline(INK, 0.5),
        arrows((x0, below), (x1, below)),
        arrows((left, y1), (left, y0)),
        label((middle, below - 5.0), size.x),
        label((left - 5.0, across), size.y)
            .set("transform", format_args!("rotate(-90 {:.1} {across:.1})", left - 5.0)),
    ]);
}

/// Draws the drawing's origin.
pub(super) fn draw_origin(out: &mut Lines, view: &View) {
    let (x, y) = view.xy(Mm2::ZERO);
    let in_field = (PAD..=WIDTH - PAD).contains(&x) && (PAD..=PAD + view.height).contains(&y);
    if in_field {
        let datum = path(format_args!("M{:.1} {y:.1}h18M{x:.1} {:.1}v18", x - 9.0, y - 9.0));
        let ring = super::element::circle((x, y), 1, 5).outline(INK, 1.2);
        let name = text((x + 8.0, y + 14.0), 1, "0").stroke(PAPER, 3).set("paint-order", "stroke").fill(INK);
        out.draw(&[datum.outline(INK, 1.2), ring, name]);
    }
}

/// Draws a number or a word at a place, readable on any colour.
pub(super) fn draw_label(out: &mut Lines, at: (f64, f64), label: &str, colour: &str) {
    let label = text(at, 1, label).bold(13).fill(colour).set("text-anchor", "middle");
    out.draw(&[label.stroke(PAPER, 4).set("paint-order", "stroke")]);
}

/// Draws the scale in the row of the title, beside the field.
fn draw_scale(out: &mut Lines, view: &View, y: f64) {
    let step = round_below(160.0 / view.scale);
    let w = step * view.scale;
    let x = WIDTH - PAD - w - 4.0;
    let bar =
        path(format_args!("M{x:.1} {:.1}v10M{x:.1} {y:.1}h{w:.2}m0 -5v10", y - 5.0)).outline("#111", 1.5);
    let length = text((x - 8.0, y + 4.0), 1, format_args!("{} mm", short(step))).set("text-anchor", "end");
    out.draw(&[bar, length]);
}

/// The mark of a sign.
#[derive(Clone, Copy, Debug)]
pub enum Mark {
    /// A filled rectangle.
    Area,
    /// A hatched rectangle.
    Hatched,
    /// A solid line.
    Line,
    /// A dashed line.
    Dash,
    /// A ring.
    Ring,
    /// A cross.
    Cross,
}

/// Sign of the legend.
#[derive(Clone, Debug)]
pub struct Sign {
    /// Colour of the mark.
    pub colour: &'static str,
    /// The mark.
    pub mark: Mark,
    /// What it stands for.
    pub text: String,
}

impl Sign {
    /// A sign.
    #[must_use]
    pub fn new(colour: &'static str, mark: Mark, text: impl Into<String>) -> Self {
        Self { colour, mark, text: text.into() }
    }
}

const ROW: f64 = 24.0;
/// Pattern of hatched areas, so that they differ without colour, and the tips of dimension lines.
const DEFINITIONS: &str = "<defs><pattern id=\"hatch\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" \
    patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"#f4b183\"/><rect width=\"2.4\" \
    height=\"6\" fill=\"#d55e00\"/></pattern><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"8\" refY=\"4\" \
    markerWidth=\"8\" markerHeight=\"8\" orient=\"auto-start-reverse\"><path d=\"M0 1.5L8 4L0 6.5Z\" \
    fill=\"#1d2025\"/></marker></defs>";
/// Fill of a hatched area.
pub(super) const HATCH: &str = "url(#hatch)";

/// The whole page: `body` in the field, and below it the title, the scale and the legend. They never cover the
/// body.
#[must_use]
pub fn page(view: &View, title: &str, legend: &[Sign], body: &Lines) -> String {
    let rows = f64::from(u32::try_from(legend.len()).unwrap_or(0));
    let (width, height) = (WIDTH, view.height + 44.0 + ROW * rows + 2.0 * PAD);
    let field = || {
        let corner = Element::new("rect").set("x", PAD).set("y", PAD);
        corner.fixed("width", WIDTH - 2.0 * PAD, 1).fixed("height", view.height, 1)
    };
    let mut out = Lines::default();
    out.draw(&[Element::new("title").text(title)]);
    out.raw(DEFINITIONS);
    out.draw(&[background(PAPER)]);
    out.draw(&[Element::new("clipPath").set("id", "field").with(&field())]);
    out.draw(&[Element::new("g").set("clip-path", "url(#field)").lines(body)]);
    out.draw(&[field().fill("none").set("stroke", "#9aa0a8")]);
    let top = view.height + 2.0 * PAD;
    draw_scale(&mut out, view, top + 4.0);
    out.draw(&[Element::new("text").set("x", PAD).fixed("y", top + 8.0, 1).bold(17).text(title)]);
    let mut y = top + 34.0;
    for entry in legend {
        draw_entry(&mut out, entry, PAD, y);
        y += ROW;
    }
    let page = document((width, height)).fixed("width", width, 0).fixed("height", height, 0);
    let page = page.set("font-family", "Helvetica, Arial, sans-serif").set("font-size", 13);
    format!("{}\n", page.lines(&out))
}

/// The page with names of its own, so that it can stand beside another in one document.
pub(super) fn beside_another(page: &str) -> String {
    page.replace(DEFINITIONS, "")
        .replace("id=\"field\"", "id=\"section-field\"")
        .replace("url(#field)", "url(#section-field)")
}

fn draw_entry(out: &mut Lines, entry: &Sign, x: f64, y: f64) {
    let colour = entry.colour;
    let area = |fill: &str| {
        let area = Element::new("rect").set("x", x).fixed("y", y - 11.0, 1);
        area.set("width", 30).set("height", 14).fill(fill).stroke("#777", 0.5)
    };
    let mark = match entry.mark {
        Mark::Area => area(colour),
        Mark::Hatched => area(HATCH),
        Mark::Ring => {
            let ring = Element::new("circle").set("cx", x + 15.0).fixed("cy", y - 4.0, 1).set("r", 7);
            ring.fill(colour).set("fill-opacity", 0.15).stroke(colour, 1.5)
        }
        Mark::Cross => {
            path(format_args!("M{} {:.1}l12 12m0 -12l-12 12", x + 9.0, y - 10.0)).stroke(colour, 2.5)
        }
        Mark::Line => path(format_args!("M{x} {:.1}h30", y - 4.0)).stroke(colour, 2.5),
        Mark::Dash => {
            path(format_args!("M{x} {:.1}h30", y - 4.0)).stroke(colour, 2).set("stroke-dasharray", "7 3")
        }
    };
    out.draw(&[mark, Element::new("text").set("x", x + 40.0).fixed("y", y, 1).text(&entry.text)]);
}
