//! The part in the picture of a plan: its faces, its clearances, the rest material and the contours' numbers.

use keepout_kernel::offset::Outline;
use keepout_kernel::{Curve, Height, Length, Side};

use super::element::{Element, Lines, path};
use super::view::{HATCH, View, draw_label, outlines, path_of, polygons};
use crate::Mm2;
use crate::contour::{ContourName, ContourRole, short};
use crate::finish::{centre_distance, offset_among};
use crate::plan::{CertifiedPlan, Walls};
use crate::profile::{ProfileLoop, free_outlines};
use crate::rest;
use crate::units::{along_mm, mm, point_mm};

pub(super) const PART: &str = "#b9c0ca";
pub(super) const PART_EDGE: &str = "#2b2f36";
pub(super) const KEEP_OUT: &str = "#fbf3d0";
pub(super) const KEEP_OUT_FINISH: &str = "#f3e19c";
pub(super) const ZONE: &str = "#6b7280";
const REST: &str = "#f4b183";
pub(super) const UNCUT: &str = "#d55e00";
/// Opacity of a face below the top of the part.
const FACE: f64 = 0.45;
/// Polygons of the rest material leave its true edge by less than this, pixels.
const REST_PIXELS: f64 = 0.1;

/// Draws the part and the keep-out zones, with their clearances as areas. What stands above each depth lies over what
/// stands above the next one, so higher faces are darker.
pub(super) fn draw_part(out: &mut Lines, plan: &CertifiedPlan, view: &View) {
    for (depth, walls) in plan.walls.iter().enumerate().rev() {
        if depth > 0 && plan.walls[depth - 1].contours == walls.contours {
            continue;
        }
        draw_clearances(out, plan, walls, view);
        let face = path(format_args!("{}{}", around(plan, view), outlines_of(walls, view)))
            .fill(PART)
            .set("fill-rule", "evenodd");
        out.draw(&[if depth > 0 { face.set("fill-opacity", FACE) } else { face }.stroke(PART_EDGE, 1.3)]);
    }
    draw_face_heights(out, plan, view);
    let zones = outlines(&plan.plan.zones.loops, view);
    if !zones.is_empty() {
        out.draw(&[path(zones).fill(ZONE).stroke(PART_EDGE, 1.3)]);
    }
}

/// The outlines of the walls at a depth, and of the zones that stand there.
fn all_outlines(plan: &CertifiedPlan, walls: &Walls) -> Vec<Outline> {
    let part = plan.region(plan.plan.passes[walls.pass].height);
    let zones: Vec<Outline> = if part.zones().is_empty() {
        Vec::new()
    } else {
        let all = free_outlines(&plan.plan.profile, &plan.plan.zones, &plan.part);
        all.into_iter().skip(plan.plan.profile.loops.len()).collect()
    };
    walls.outlines.iter().cloned().chain(zones).collect()
}

/// The rest material beside the walls of a depth, as polygons within `tolerance_mm` of its contours, mm. Each begins
/// with its outer contour; its holes follow.
#[must_use]
pub fn rest_beside(plan: &CertifiedPlan, walls: &Walls, tolerance_mm: f64) -> Vec<Vec<Vec<[f64; 2]>>> {
    let part = plan.region(plan.plan.passes[walls.pass].height);
    let d = centre_distance(&plan.plan.profile, &plan.plan.zones, plan.finishing);
    let finishing = offset_among(&all_outlines(plan, walls), part, d);
    rest::polygons(&walls.outlines, &finishing.loops, plan.part.side(), tolerance_mm)
}

/// Draws the clearances of the walls at a depth, and the rest material there.
fn draw_clearances(out: &mut Lines, plan: &CertifiedPlan, walls: &Walls, view: &View) {
    let pass = &plan.plan.passes[walls.pass];
    let part = plan.region(pass.height);
    let all = all_outlines(plan, walls);
    let stands = outlines_of(walls, view);
    let jogging = offset_among(&all, part, f64::from(plan.roughing.units()));
    if jogging.loose_ends.is_empty() {
        let loops: Vec<&[Curve]> = jogging.loops.iter().map(|each| &each.curves[..]).collect();
        out.draw(&[beyond(&loops, &stands, view).fill(KEEP_OUT)]);
    }
    let loops: Vec<&[Curve]> = pass.path.loops.iter().map(|each| &each.curves[..]).collect();
    out.draw(&[beyond(&loops, &stands, view).fill(KEEP_OUT_FINISH)]);
    let rest = rest_beside(plan, walls, REST_PIXELS * view.pixel_mm());
    if !rest.is_empty() {
        // Renderers blend the edges of the hatching's tiles, so a plain area lies below it.
        let area = |fill| path(polygons(&rest, view)).fill(fill).set("fill-rule", "evenodd");
        out.draw(&[area(REST), area(HATCH)]);
    }
}

/// Writes the heights of faces below the top of the part beside the numbers of their contours.
fn draw_face_heights(out: &mut Lines, plan: &CertifiedPlan, view: &View) {
    let Some(relief) = &plan.plan.relief else { return };
    let faces = plan.plan.profile.loops.iter().zip(&relief.tops).zip(plan.contours());
    for ((each, top), contour) in faces {
        let Some(top) = top.filter(|&top| top < Height::ZERO) else { continue };
        let Some((x, y)) = number_at(each, plan, &contour.name, view) else { continue };
        draw_label(out, (x, y + 20.0), &format!("z {}", short(mm(top.units()))), PART_EDGE);
    }
}

/// SVG path of what stands at the depth of walls.
fn outlines_of(walls: &Walls, view: &View) -> String {
    walls.outlines.iter().map(|each| path_of(each.curves.iter().copied(), view) + "Z").collect()
}

/// The whole picture for a part around its contours.
fn around(plan: &CertifiedPlan, view: &View) -> String {
    match plan.part.side() {
        Side::Outside => String::new(),
        Side::Inside => view.everything(),
    }
}

/// The area beside what stands that the tool's centre does not enter: beyond loops that bound its free space.
fn beyond(loops: &[&[Curve]], stands: &str, view: &View) -> Element {
    let free: String = loops.iter().map(|curves| path_of(curves.iter().copied(), view) + "Z").collect();
    path(format_args!("{free}{stands}")).set("fill-rule", "evenodd")
}

/// Pixels about the middle of a pocket in which its number does not lie beside that of another contour.
const CROWDED_PIXELS: f64 = 40.0;

/// Place of a contour's number: in the middle of an opening or an empty pocket, or just inside the contour.
fn number_at(
    each: &ProfileLoop,
    plan: &CertifiedPlan,
    name: &ContourName,
    view: &View,
) -> Option<(f64, f64)> {
    let is_near = |other: &ContourName| {
        let open = matches!(other.role, ContourRole::Opening | ContourRole::Pocket);
        open && other != name && other.middle_mm.distance(name.middle_mm) < CROWDED_PIXELS * view.pixel_mm()
    };
    let crowded = || plan.plan.relief.is_some() && plan.contours().iter().any(|other| is_near(&other.name));
    if name.role == ContourRole::Opening || name.role == ContourRole::Pocket && !crowded() {
        return Some(view.xy(name.middle_mm));
    }
    let curve = each.curves().max_by(|a, b| a.length().total_cmp(&b.length()))?;
    let (at, direction) = along_mm(curve, 0.5);
    let inward = if is_counter_clockwise(each) { direction.left() } else { -direction.left() };
    Some(view.xy(at + inward * (16.0 * view.pixel_mm())))
}

/// Draws the number of each contour.
pub(super) fn draw_numbers(out: &mut Lines, plan: &CertifiedPlan, view: &View) {
    for (contour, each) in plan.contours().iter().zip(&plan.plan.profile.loops) {
        let number = contour.name.number;
        let Some(at) = number_at(each, plan, &contour.name, view) else { continue };
        let uncut = if contour.loops.is_empty() { " uncut" } else { "" };
        let colour = if contour.loops.is_empty() { UNCUT } else { PART_EDGE };
        draw_label(out, (at.0, at.1 + 5.0), &format!("{number}{uncut}"), colour);
    }
}

/// Whether a loop runs counter-clockwise, by the chords of its curves.
fn is_counter_clockwise(each: &ProfileLoop) -> bool {
    let points: Vec<Mm2> =
        crate::profile::corners(each.curves(), Length::small(250)).into_iter().map(point_mm).collect();
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum::<f64>() > 0.0
}
