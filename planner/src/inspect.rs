//! The report on a drawing: layers, contours, nesting, repairs, problems.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use keepout_kernel::exact::region::RegionError;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::{Edge, build};
use keepout_kernel::{Curve, Length, Point, Region, Ring, Segment, UNITS_PER_MM};
use serde::Serialize;

use crate::drawing::{Chained, Drawing};
use crate::profile::{ProfileError, ProfileLoop};
use crate::select::ContourPolygon;
use crate::units::{mm, point_from_mm, point_mm};
use crate::{Box2, Mm2};

/// The report on a drawing. Lengths are in mm, areas in mm².
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// The unit of the drawing, and its source.
    pub unit: String,
    /// Number of curves taken from each visible layer.
    pub layers: BTreeMap<String, usize>,
    /// Number of all curves taken.
    pub curves: usize,
    /// The closed contours, in file order.
    pub contours: Vec<ContourFacts>,
    /// Number of contours that lie within an even number of others.
    pub outer: usize,
    /// Number of contours that lie within an odd number of others.
    pub inner: usize,
    /// The area within an odd number of contours.
    pub area_mm2: f64,
    /// The box around the contours; `None` without contours.
    pub box_mm: Option<Box2>,
    /// Number of pieces of splines and ellipses, which arcs and lines replace.
    pub free_curves: usize,
    /// Chord-error bound of these arcs and lines.
    pub curve_bound_mm: f64,
    /// Number of chains of curves that do not close.
    pub open_chains: usize,
    /// The repairs of the drawing.
    pub repairs: Vec<Note>,
    /// The problems that prevent a plan of all contours.
    pub problems: Vec<Note>,
    /// Number of entities left out for each reason.
    pub left_out: BTreeMap<String, usize>,
    /// Other notes on the file.
    pub remarks: Vec<String>,
}

/// A closed contour.
#[derive(Clone, Debug, Serialize)]
pub struct ContourFacts {
    /// The layer of its first curve.
    pub layer: String,
    /// Number of contours around it.
    pub depth: usize,
    /// The area within it.
    pub area_mm2: f64,
    /// Its length.
    pub length_mm: f64,
    /// Number of straight edges.
    pub lines: usize,
    /// Number of arcs.
    pub arcs: usize,
    /// The box around it.
    pub box_mm: Box2,
    /// A point within it, for `--at`; `None` if the search found no point.
    pub inside_mm: Option<Mm2>,
}

/// A note with its place.
#[derive(Clone, Debug, Serialize)]
pub struct Note {
    /// The place, mm.
    pub at_mm: Mm2,
    /// The text.
    pub text: String,
}

/// Largest number of listed contacts between contours.
const CONTACTS_MAX: usize = 50;
/// Largest number of straight pieces to compare for that list. Each contact compares all pieces.
const PIECES_MAX: usize = 5_000_000;

/// Makes the report on a drawing and its contours.
#[must_use]
pub fn inspect(drawing: &Drawing, chained: &Chained) -> Inspection {
    let loops = &chained.profile.loops;
    let outlines: Vec<ContourPolygon> = loops.iter().map(ContourPolygon::of).collect();
    let depths = depths(&outlines);
    let signed = |(outline, depth): (&ContourPolygon, &usize)| {
        if depth % 2 == 0 { outline.area_mm2 } else { -outline.area_mm2 }
    };
    let contours: Vec<ContourFacts> = loops
        .iter()
        .zip(&outlines)
        .enumerate()
        .map(|(i, (each, outline))| contour(each, outline, &chained.layers[i], depths[i]))
        .collect();
    let note = |at: Point, text: String| Note { at_mm: point_mm(at), text };
    let mut repairs: Vec<Note> =
        chained.repairs.iter().map(|repair| note(repair.at(), repair.to_string())).collect();
    for each in loops.iter().filter(|each| each.is_flat()) {
        let text = "a line drawn there and back, which encloses no area, is left out".into();
        repairs.push(note(each.edges[0].curve.from(), text));
    }
    let mut problems: Vec<Note> =
        chained.problems.iter().map(|problem| note(problem.at(), problem.to_string())).collect();
    problems.extend(contacts(loops).into_iter().map(|(at, text)| note(at, text)));
    Inspection {
        unit: drawing.unit.clone(),
        layers: drawing.layers.iter().map(|(name, &count)| (name.to_string(), count)).collect(),
        curves: drawing.curves.len(),
        outer: depths.iter().zip(loops).filter(|(depth, each)| *depth % 2 == 0 && !each.is_flat()).count(),
        inner: depths.iter().filter(|&depth| depth % 2 == 1).count(),
        area_mm2: outlines.iter().zip(&depths).map(signed).fold(0.0, |sum, area| sum + area),
        box_mm: contours.iter().map(|contour| contour.box_mm).reduce(Box2::union),
        contours,
        free_curves: chained.profile.source_count(),
        curve_bound_mm: mm(chained.profile.chord_error().units()),
        open_chains: chained.open.len(),
        repairs,
        problems,
        left_out: drawing.left_out.clone(),
        remarks: drawing.remarks.clone(),
    }
}

fn contour(each: &ProfileLoop, outline: &ContourPolygon, layer: &str, depth: usize) -> ContourFacts {
    let length: f64 = each.edges.iter().map(|edge| edge.curve.length()).sum();
    let lines = each.edges.iter().filter(|edge| matches!(edge.curve, Curve::Line(_))).count();
    ContourFacts {
        layer: layer.into(),
        depth,
        area_mm2: outline.area_mm2,
        length_mm: length / f64::from(UNITS_PER_MM),
        lines,
        arcs: each.edges.len() - lines,
        box_mm: outline.bounds,
        inside_mm: inside(outline),
    }
}

/// A point within the contour: the middle of its widest stretch on the horizontal line at half its height.
fn inside(outline: &ContourPolygon) -> Option<Mm2> {
    let y = outline.bounds.middle().y;
    let next = outline.points.iter().cycle().skip(1);
    let mut crossings: Vec<f64> = outline
        .points
        .iter()
        .zip(next)
        .filter(|(a, b)| (a.y > y) != (b.y > y))
        .map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
        .collect();
    crossings.sort_by(f64::total_cmp);
    let widest = crossings.chunks_exact(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    Some(Mm2::new(f64::midpoint(widest[0], widest[1]), y))
}

/// The number of contours around the first corner of each contour.
fn depths(outlines: &[ContourPolygon]) -> Vec<usize> {
    // An index of the diagonals of the boxes leaves few outlines to test for each corner.
    let point = |p: Mm2| point_from_mm(p).unwrap_or(Point::ORIGIN);
    let diagonal = |outline: &ContourPolygon| Segment {
        from: point(outline.bounds.low),
        to: point(outline.bounds.high),
    };
    let edge = |outline: &ContourPolygon| Edge { chord: diagonal(outline), chord_error: Length::ZERO };
    let Ok(index) = build::build(outlines.iter().map(edge).collect()) else { return vec![0; outlines.len()] };
    let depth = |(i, outline): (usize, &ContourPolygon)| {
        let Some(&corner) = outline.points.first().filter(|_| outline.area_mm2 > 0.0) else { return 0 };
        let mut around = 0;
        let _ = index.visit(Window::of(point(corner)), |j, _| {
            around += usize::from(j != i && outlines[j].holds(corner));
            ControlFlow::<()>::Continue(())
        });
        around
    };
    outlines.iter().enumerate().map(depth).collect()
}

/// The places where contours touch or cross themselves or each other, and the degenerate contours.
fn contacts(loops: &[ProfileLoop]) -> Vec<(Point, String)> {
    let mut found = Vec::new();
    let mut rings: Vec<Ring> = Vec::new();
    for each in loops.iter().filter(|each| !each.is_flat()) {
        match each.ring() {
            Ok(ring) => rings.push(ring),
            Err(error) => found.push((error.at().unwrap_or(each.edges[0].curve.from()), error.to_string())),
        }
    }
    let mut looked_at = 0;
    while let Err(RegionError::RingsTouch { second, at, .. }) = Region::new(rings.clone()) {
        let text = ProfileError::ContoursTouch { at }.to_string();
        if found.len() >= CONTACTS_MAX || looked_at > PIECES_MAX {
            found.push((
                at,
                format!("{text} There may be more such places: repair these, then inspect again."),
            ));
            break;
        }
        found.push((at, text));
        looked_at += rings.iter().flat_map(Ring::segments).count();
        rings.remove(second);
    }
    found
}

impl std::fmt::Display for Inspection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "unit         {}", self.unit)?;
        let layers: Vec<String> =
            self.layers.iter().map(|(name, count)| format!("\"{name}\" {count}")).collect();
        writeln!(f, "layers       {} (curves taken from each)", layers.join(", "))?;
        if self.free_curves > 0 {
            let (count, bound) = (self.free_curves, self.curve_bound_mm);
            writeln!(
                f,
                "curves       {count} pieces of splines and ellipses, as arcs and lines within {bound:.5} mm"
            )?;
        }
        let (closed, open) = (self.contours.len(), self.open_chains);
        writeln!(
            f,
            "contours     {closed} closed ({} outer, {} inner), {open} open",
            self.outer, self.inner
        )?;
        writeln!(f, "area         {:.3} mm² within an odd number of contours", self.area_mm2)?;
        if let Some(bounds) = self.box_mm {
            let (Box2 { low, high }, size) = (bounds, bounds.size());
            write!(f, "box          ({:.3}, {:.3}) to {high}: ", low.x, low.y)?;
            writeln!(f, "{:.3} × {:.3}", size.x, size.y)?;
        }
        for (number, contour) in self.contours.iter().enumerate().take(LISTED) {
            let at = contour.inside_mm.map_or(String::new(), |Mm2 { x, y }| format!(", --at {x:.3},{y:.3}"));
            writeln!(
                f,
                "  {:>4}  depth {}  {:>12.3} mm²  {:>10.3} mm  {} lines, {} arcs, layer \"{}\"{at}",
                number + 1,
                contour.depth,
                contour.area_mm2,
                contour.length_mm,
                contour.lines,
                contour.arcs,
                contour.layer
            )?;
        }
        more(f, self.contours.len())?;
        for (what, count) in &self.left_out {
            writeln!(f, "left out     {count} {what}")?;
        }
        self.remarks.iter().try_for_each(|remark| writeln!(f, "note         {remark}"))?;
        self.repairs.iter().take(LISTED).try_for_each(|note| writeln!(f, "repaired     {}", note.text))?;
        more(f, self.repairs.len())?;
        self.problems.iter().take(LISTED).try_for_each(|note| writeln!(f, "PROBLEM      {}", note.text))?;
        more(f, self.problems.len())?;
        match self.problems.len() {
            0 => write!(f, "A plan can be made of this drawing."),
            n => write!(f, "{n} problems keep a plan from being made of all contours."),
        }
    }
}

/// Largest number of listed lines of each kind; the report counts the rest.
const LISTED: usize = 40;

fn more(f: &mut std::fmt::Formatter<'_>, count: usize) -> std::fmt::Result {
    if count > LISTED { writeln!(f, "  … and {} more (--json lists all)", count - LISTED) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use crate::request::PlanRequest;

    /// The problems of `count` circles that all cross each other.
    fn problems_of_circles(count: u32, radius_mm: f64) -> Vec<String> {
        let mut dxf = "0\nSECTION\n2\nENTITIES\n".to_string();
        for x in 0..count {
            let _ = write!(dxf, "0\nCIRCLE\n10\n{x}\n20\n0\n40\n{radius_mm}\n");
        }
        dxf.push_str("0\nENDSEC\n0\nEOF\n");
        let (drawing, chained) = PlanRequest::default().contours(dxf.as_bytes()).expect("circles are read");
        inspect(&drawing, &chained).problems.into_iter().map(|note| note.text).collect()
    }

    #[test]
    fn contacts_above_the_limit_are_reported_as_not_listed() {
        let few = problems_of_circles(20, 30.0);
        assert!(few.len() == 19 && few.iter().all(|text| text.contains("cross or touch at")), "{few:?}");
        let many = problems_of_circles(60, 40.0);
        assert_eq!(many.len(), CONTACTS_MAX + 1);
        assert!(many[CONTACTS_MAX].contains("There may be more") && !many[0].contains("There may be more"));
    }

    /// The fuzzer found this: a few hundred curves of half a million straight pieces were compared fifty
    /// times.
    #[test]
    fn work_on_contacts_between_curves_of_many_pieces_is_bounded() {
        let large = problems_of_circles(60, 4500.0);
        assert!(
            large.len() < 30 && large.last().is_some_and(|text| text.contains("There may be more")),
            "{large:?}"
        );
    }
}
