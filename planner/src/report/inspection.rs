//! Picture of an inspected drawing: contours, repairs, problems.

use super::element::{Lines, circle, path, text};
use super::view::{Entry, Mark, View, outlines, page, path_of};
use crate::drawing::Chained;
use crate::inspect::{Inspection, Note};
use crate::units::point_mm;
use crate::{Box2, Mm2};

const INSIDE: &str = "#d5dae1";
const EDGE: &str = "#2b2f36";
const OPEN: &str = "#c8102e";
const REPAIR: &str = "#b45309";
/// Largest number of marks with a number.
const NUMBERED: usize = 60;

/// SVG of the contours, filled by the even-odd rule, of open curves, and of repairs and problems with
/// their numbers in the report.
#[must_use]
pub fn inspection_svg(found: &Inspection, chained: &Chained, title: &str) -> String {
    let view = view_of(found, chained);
    let mut body = Lines::default();
    let outline = outlines(&chained.profile.loops, &view);
    body.draw(&[path(outline).fill(INSIDE).set("fill-rule", "evenodd").stroke(EDGE, 1.2)]);
    for open in &chained.open {
        let curves = path_of(open.curves.iter().copied(), &view);
        body.draw(&[path(curves).outline(OPEN, 1.8).set("stroke-dasharray", "5 3")]);
    }
    marks(&mut body, &found.repairs, REPAIR, &view);
    marks(&mut body, &found.problems, OPEN, &view);
    let legend = [
        Entry::new(
            INSIDE,
            Mark::Area,
            format!(
                "within an odd number of contours: {} closed, {:.3} mm²",
                found.contours.len(),
                found.area_mm2
            ),
        ),
        Entry::new(OPEN, Mark::Dash, format!("{} chains of open curves", found.open_chains)),
        Entry::new(
            REPAIR,
            Mark::Ring,
            format!("{} repairs, in the order of the report", found.repairs.len()),
        ),
        Entry::new(
            OPEN,
            Mark::Ring,
            format!("{} problems, in the order of the report", found.problems.len()),
        ),
    ];
    page(&view, title, &legend, &body)
}

fn view_of(found: &Inspection, chained: &Chained) -> View {
    let ends = chained.open.iter().flat_map(|open| &open.curves).flat_map(|curve| [curve.from(), curve.to()]);
    let around = Box2::around(ends.map(point_mm)).into_iter().chain(found.box_mm).reduce(Box2::union);
    let around = around.unwrap_or(Box2 { low: Mm2::ZERO, high: Mm2::new(1.0, 1.0) });
    View::of(around.grown(0.04 * around.longer_side().max(1.0)))
}

fn marks(out: &mut Lines, notes: &[Note], colour: &str, view: &View) {
    for (k, note) in notes.iter().enumerate() {
        let (x, y) = view.xy(note.at_mm);
        out.draw(&[circle((x, y), 1, 7).fill(colour).set("fill-opacity", 0.12).stroke(colour, 1.8)]);
        if k < NUMBERED {
            out.draw(&[text((x + 8.0, y - 6.0), 1, k + 1).bold(11).fill(colour)]);
        }
    }
}
