//! The report on a drawing: layers, contours, nesting, repairs, problems.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::ops::ControlFlow;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use keepout_kernel::exact::region::RegionError;
use keepout_kernel::index::build;
use keepout_kernel::{Curve, Edge, Length, Point, Region, Ring, Segment, Side};
use serde::Serialize;

use crate::contour::{ContourName, ContourRole, exact_box};
use crate::drawing::{Chained, Drawing, EntityFilter};
use crate::left_out::surrounds;
use crate::nesting::Nesting;
use crate::profile::{ProfileError, ProfileLoop, corners};
use crate::ribbon::ribbons;
use crate::select::{ContourPolygon, SelectError};
use crate::size::{SizeQuestion, size};
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
    /// The area of the part if the tool works outside it: the area within an odd number of contours.
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
    /// One remedy for all gaps.
    pub gaps: Option<String>,
    /// A question about the size.
    pub question: Option<String>,
    /// Number of entities left out for each reason.
    pub left_out: BTreeMap<String, usize>,
    /// Other notes on the file.
    pub remarks: Vec<String>,
}

/// A closed contour.
#[derive(Clone, Debug, Serialize)]
pub struct ContourFacts {
    /// Its name, if the tool works outside the part.
    pub name: ContourName,
    /// The layer of its first curve.
    pub layer: String,
    /// Number of contours around it.
    pub depth: usize,
    /// The area within it.
    pub area_mm2: f64,
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

/// Makes the report on a drawing and its contours, which `filter` took.
#[must_use]
pub fn inspect(drawing: &Drawing, chained: &Chained, filter: &EntityFilter) -> Inspection {
    let loops = &chained.profile.loops;
    let outlines: Vec<ContourPolygon> = loops.iter().map(ContourPolygon::of).collect();
    let nesting = Nesting::of(&outlines);
    let contours: Vec<ContourFacts> = loops
        .iter()
        .zip(&outlines)
        .enumerate()
        .map(|(i, (each, outline))| contour((i + 1, each), outline, &chained.layers[i], nesting.depths[i]))
        .collect();
    let note = |at: Point, text: String| Note { at_mm: point_mm(at), text };
    let repairs = chained.repairs.iter().map(|repair| note(repair.at(), repair.to_string())).collect();
    let contacts = contacts(loops);
    let area_mm2 = if contacts.is_empty() {
        let signed = |(outline, depth): (&ContourPolygon, &usize)| {
            if depth % 2 == 0 { outline.area_mm2 } else { -outline.area_mm2 }
        };
        outlines.iter().zip(&nesting.depths).map(signed).fold(0.0, |sum, area| sum + area)
    } else {
        even_odd_area_mm2(&outlines)
    };
    let mut problems: Vec<Note> =
        chained.problems.iter().map(|problem| note(problem.at(), problem.to_string())).collect();
    problems.extend(contacts.into_iter().map(|(at, text)| note(at, text)));
    problems.extend(swaps(drawing, filter, &outlines, &nesting));
    let question = SizeQuestion::of_part(&outlines, drawing, filter);
    if let Some(question) = question.as_ref().filter(|question| question.is_problem()) {
        let at_mm = outlines.first().map_or(Mm2::ZERO, |outline| outline.bounds.low);
        problems.push(Note { at_mm, text: question.to_string() });
    }
    Inspection {
        unit: drawing.unit.clone(),
        layers: drawing.layers.iter().map(|(name, &count)| (name.to_string(), count)).collect(),
        curves: drawing.curves.len(),
        outer: nesting.depths.iter().filter(|&depth| depth % 2 == 0).count(),
        inner: nesting.depths.iter().filter(|&depth| depth % 2 == 1).count(),
        area_mm2,
        box_mm: contours.iter().map(|contour| contour.box_mm).reduce(Box2::union),
        contours,
        free_curves: chained.profile.source_count(),
        curve_bound_mm: mm(chained.profile.chord_error().units()),
        open_chains: chained.open.len(),
        repairs,
        problems,
        gaps: chained.gaps.map(|gaps| gaps.to_string()),
        question: question.filter(|question| !question.is_problem()).map(|question| question.to_string()),
        left_out: drawing.left_out.clone(),
        remarks: drawing.remarks.clone(),
    }
}

/// Problems that swap part and air: curves that are left out around the part, and strokes with width.
fn swaps(
    drawing: &Drawing,
    filter: &EntityFilter,
    outlines: &[ContourPolygon],
    nesting: &Nesting,
) -> Vec<Note> {
    let around = surrounds(outlines, &nesting.depths, &drawing.aside, filter);
    let mut notes: Vec<Note> =
        around.into_iter().map(|found| Note { at_mm: found.at(), text: found.to_string() }).collect();
    if let Some(stroke) = SelectError::of_strokes(outlines, &ribbons(outlines, nesting)) {
        notes.push(Note { at_mm: stroke.at().unwrap_or_default(), text: stroke.to_string() });
    }
    notes
}

/// The area within an odd number of contours, which may cross.
fn even_odd_area_mm2(outlines: &[ContourPolygon]) -> f64 {
    let contours: Vec<Vec<[f64; 2]>> =
        outlines.iter().map(|outline| outline.points.iter().map(|at| [at.x, at.y]).collect()).collect();
    let shapes = contours.simplify_shape(FillRule::EvenOdd);
    let area = |contour: &Vec<[f64; 2]>| {
        let next = contour.iter().cycle().skip(1);
        contour.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>() / 2.0
    };
    shapes.iter().flatten().map(area).sum()
}

fn contour(
    (number, each): (usize, &ProfileLoop),
    outline: &ContourPolygon,
    layer: &str,
    depth: usize,
) -> ContourFacts {
    let lines = each.edges.iter().filter(|edge| matches!(edge.curve, Curve::Line(_))).count();
    ContourFacts {
        name: ContourName::of(number, each, ContourRole::of(depth, Side::Outside), 0.0),
        layer: layer.into(),
        depth,
        area_mm2: outline.area_mm2,
        lines,
        arcs: each.edges.len() - lines,
        box_mm: exact_box(each).unwrap_or(outline.bounds),
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

/// Chord error of the coarse polygons that tell which contours may touch, lattice units (50 µm).
const COARSE: i64 = 5000;

/// The contours that may touch themselves or others, by coarse polygons. The exact check of all contours of a large
/// drawing takes seconds.
fn may_touch(loops: &[ProfileLoop]) -> BTreeSet<usize> {
    let Ok(error) = Length::from_units(COARSE) else { return (0..loops.len()).collect() };
    let (mut owners, mut edges) = (Vec::new(), Vec::new());
    for (number, each) in loops.iter().enumerate() {
        let corners = corners(each.curves(), error);
        let next = corners.iter().cycle().skip(1);
        for (place, (&from, &to)) in corners.iter().zip(next).enumerate() {
            owners.push((number, place, corners.len()));
            edges.push(Edge { chord: Segment { from, to }, chord_error: error });
        }
    }
    // A contour without width, or with splines, has more faults than a contact.
    let special = |each: &ProfileLoop| each.edges.len() < 3 && !each.is_round() || !each.sources.is_empty();
    let mut found: BTreeSet<usize> =
        loops.iter().enumerate().filter(|(_, each)| special(each)).map(|(number, _)| number).collect();
    let reach = error.saturating_plus(error);
    let Ok(index) = build::build(edges.clone()) else { return (0..loops.len()).collect() };
    for (edge, &(number, place, count)) in edges.iter().zip(&owners) {
        let _ = index.visit(edge.chord.bounds().grown(reach), |at, other| {
            let Some(&(other_number, other_place, _)) = owners.get(at) else {
                return ControlFlow::Continue(());
            };
            let apart = place.abs_diff(other_place);
            let adjacent = number == other_number && (apart <= 1 || apart + 1 == count);
            if !adjacent && !edge.chord.near_segment(other.chord, reach).is_clear() {
                found.extend([number, other_number]);
            }
            ControlFlow::<()>::Continue(())
        });
    }
    found
}

/// The places where contours touch or cross themselves or each other, and the degenerate contours.
fn contacts(loops: &[ProfileLoop]) -> Vec<(Point, String)> {
    let mut found = Vec::new();
    let mut rings: Vec<Ring> = Vec::new();
    for each in may_touch(loops).into_iter().filter_map(|number| loops.get(number)) {
        match each.ring() {
            Ok(ring) => rings.push(ring),
            Err(error) => found.push((error.at().unwrap_or(each.edges[0].curve.from()), error.to_string())),
        }
    }
    let (at, more) = touching(&rings);
    let text = |at: Point| ProfileError::ContoursTouch { at }.to_string();
    found.extend(at.iter().map(|&at| (at, text(at))));
    if let (true, Some(&at)) = (more, at.last()) {
        let more = "There may be more such places: repair these, then inspect again.";
        found.push((at, format!("{} {more}", text(at))));
    }
    found
}

/// Places where two rings touch, one for each pair of rings, and whether there may be more.
fn touching(rings: &[Ring]) -> (Vec<Point>, bool) {
    // The check of the region is fast, and it finds no contact in most drawings.
    if rings.is_empty() || !matches!(Region::new(rings.to_vec()), Err(RegionError::RingsTouch { .. })) {
        return (Vec::new(), false);
    }
    let mut owners = Vec::new();
    let mut edges = Vec::new();
    for (ring, each) in rings.iter().enumerate() {
        for chord in each.segments() {
            owners.push((ring, chord));
            edges.push(Edge { chord, chord_error: Length::ZERO });
        }
    }
    let Ok(index) = build::build(edges) else { return (Vec::new(), true) };
    let (mut pairs, mut places) = (HashSet::new(), Vec::new());
    for &(ring, chord) in &owners {
        let _ = index.visit(chord.bounds(), |number, edge| {
            let other = owners.get(number).map_or(ring, |&(other, _)| other);
            let touch = other > ring && !chord.near_segment(edge.chord, Length::ZERO).is_clear();
            if touch && pairs.insert((ring, other)) {
                places.push(meeting(chord, edge.chord));
            }
            if places.len() > CONTACTS_MAX { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if places.len() > CONTACTS_MAX {
            places.pop();
            return (places, true);
        }
    }
    (places, false)
}

/// The place where two segments that touch meet, about.
fn meeting(one: Segment, other: Segment) -> Point {
    let (a, b, c, d) = (point_mm(one.from), point_mm(one.to), point_mm(other.from), point_mm(other.to));
    let across = (b - a).cross(d - c);
    let at = if across == 0.0 { a.nearest_on(c, d) } else { a + (b - a) * ((c - a).cross(d - c) / across) };
    point_from_mm(at).unwrap_or(one.from)
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
        if let Some(bounds) = self.box_mm {
            let Box2 { low, high } = bounds;
            let size = size(bounds.size());
            writeln!(f, "part         {size} mm, from {low} to {high}")?;
            writeln!(
                f,
                "solid        inside the outlines, less the openings: {:.3} mm² (for a tool outside the part)",
                self.area_mm2
            )?;
        }
        for contour in self.contours.iter().take(LISTED) {
            let at = contour.inside_mm.map_or(String::new(), |Mm2 { x, y }| format!(", --at {x:.3},{y:.3}"));
            let ContourFacts { name, area_mm2, layer, .. } = contour;
            writeln!(f, "  {name}, {area_mm2:.3} mm², layer \"{layer}\"{at}")?;
        }
        more(f, self.contours.len())?;
        for (what, count) in &self.left_out {
            writeln!(f, "left out     {count} {what}")?;
        }
        self.remarks.iter().try_for_each(|remark| writeln!(f, "note         {remark}"))?;
        self.repairs.iter().take(LISTED).try_for_each(|note| writeln!(f, "repaired     {}", note.text))?;
        more(f, self.repairs.len())?;
        self.question.iter().try_for_each(|question| writeln!(f, "QUESTION     {question}"))?;
        self.gaps.iter().try_for_each(|gaps| writeln!(f, "REMEDY       {gaps}"))?;
        self.problems.iter().take(LISTED).try_for_each(|note| writeln!(f, "PROBLEM      {}", note.text))?;
        more(f, self.problems.len())?;
        match self.problems.len() {
            0 => write!(f, "A plan can be made of this drawing."),
            n => write!(f, "Problems that keep a plan from being made of all contours: {n}."),
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
        let request = PlanRequest::default();
        let (drawing, chained) = request.contours(dxf.as_bytes()).expect("circles are read");
        inspect(&drawing, &chained, &request.choice).problems.into_iter().map(|note| note.text).collect()
    }

    #[test]
    fn contacts_above_the_limit_are_reported_as_not_listed() {
        let few = problems_of_circles(8, 30.0);
        assert!(few.len() == 28 && few.iter().all(|text| text.contains("cross or touch at")), "{few:?}");
        let many = problems_of_circles(60, 40.0);
        assert_eq!(many.len(), CONTACTS_MAX + 1);
        assert!(many[CONTACTS_MAX].contains("There may be more") && !many[0].contains("There may be more"));
    }
}
