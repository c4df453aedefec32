//! Picture of an inspected drawing: contours, repairs, problems, and curves that are left out.

use super::element::{Lines, circle, path, text};
use super::view::{
    Mark, Sign, View, draw_dimensions, draw_label, draw_left_out, draw_origin, left_out_entry, outlines,
    page, path_of,
};
use crate::contour::short;
use crate::drawing::{Chained, Drawing};
use crate::inspect::{Inspection, Note};
use crate::units::point_mm;
use crate::{Box2, Mm2};

const INSIDE: &str = "#d5dae1";
const EDGE: &str = "#2b2f36";
const OPEN: &str = "#d55e00";
const REPAIR: &str = "#0072b2";
/// Largest number of marks with a number, and of contours with one.
const NUMBERED: usize = 60;
/// Radius of a mark among few, and among many, pixels.
const RADII: (f64, f64) = (7.0, 3.0);

/// SVG of the contours with their numbers, filled by the even-odd rule, of open curves, and of repairs and problems
/// with their numbers in the report.
#[must_use]
pub fn inspection_svg(found: &Inspection, drawing: &Drawing, chained: &Chained, title: &str) -> String {
    let view = view_of(found, drawing, chained);
    let mut body = Lines::default();
    let outline = outlines(&chained.profile.loops, &view);
    body.draw(&[path(outline).fill(INSIDE).set("fill-rule", "evenodd").stroke(EDGE, 1.2)]);
    draw_left_out(&mut body, drawing.aside.iter().map(|curve| &curve.points[..]), &view);
    for open in &chained.open {
        let curves = path_of(open.curves.iter().copied(), &view);
        body.draw(&[path(curves).outline(OPEN, 1.8).set("stroke-dasharray", "5 3")]);
    }
    for contour in found.contours.iter().take(NUMBERED) {
        let (x, y) = view.xy(contour.inside_mm.unwrap_or(contour.name.middle_mm));
        draw_label(&mut body, (x, y + 5.0), &contour.name.number.to_string(), EDGE);
    }
    if let Some(around) = found.box_mm {
        draw_dimensions(&mut body, around, &view);
        draw_origin(&mut body, &view);
    }
    marks(&mut body, &found.repairs, REPAIR, &view);
    marks(&mut body, &found.problems, OPEN, &view);
    let size = found.box_mm.map_or(String::new(), |around| {
        let size = around.size();
        format!(", {} × {} mm", short(size.x), short(size.y))
    });
    let mut legend = vec![
        Sign::new(
            INSIDE,
            Mark::Area,
            format!(
                "{} contours{size}; the material if the tool works outside: {:.3} mm²",
                found.contours.len(),
                found.area_mm2
            ),
        ),
        Sign::new(OPEN, Mark::Dash, format!("{} chains of open curves", found.open_chains)),
        Sign::new(REPAIR, Mark::Ring, format!("{} repairs, in the order of the report", found.repairs.len())),
        Sign::new(OPEN, Mark::Ring, format!("{} problems, in the order of the report", found.problems.len())),
    ];
    if !drawing.aside.is_empty() {
        legend.push(left_out_entry(drawing.aside.len()));
    }
    page(&view, title, &legend, &body)
}

fn view_of(found: &Inspection, drawing: &Drawing, chained: &Chained) -> View {
    let ends = chained.open.iter().flat_map(|open| &open.curves).flat_map(|curve| [curve.from(), curve.to()]);
    let around = Box2::around(ends.map(point_mm)).into_iter().chain(found.box_mm).reduce(Box2::union);
    let aside = Box2::around(drawing.aside.iter().flat_map(|curve| curve.points.iter().copied()));
    let around = match (around, aside) {
        // Curves that are left out may lie far away. The picture shows them up to the size of the part around it.
        (Some(around), Some(aside)) => {
            let limits = around.grown(around.longer_side());
            let near = Box2 { low: aside.low.max(limits.low), high: aside.high.min(limits.high) };
            if near.low.x <= near.high.x && near.low.y <= near.high.y { around.union(near) } else { around }
        }
        (Some(around), None) | (None, Some(around)) => around,
        (None, None) => Box2 { low: Mm2::ZERO, high: Mm2::new(1.0, 1.0) },
    };
    View::of(around.grown(0.04 * around.longer_side().max(1.0)))
}

fn marks(out: &mut Lines, notes: &[Note], colour: &str, view: &View) {
    let radius = if notes.len() <= NUMBERED { RADII.0 } else { RADII.1 };
    for (k, note) in notes.iter().enumerate() {
        let (x, y) = view.xy(note.at_mm);
        out.draw(&[circle((x, y), 1, radius).fill(colour).set("fill-opacity", 0.12).stroke(colour, 1.5)]);
        if k < NUMBERED {
            out.draw(&[text((x + 8.0, y - 6.0), 1, k + 1).bold(11).fill(colour)]);
        }
    }
}
