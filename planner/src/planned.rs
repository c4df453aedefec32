//! The contours of a plan: their names, the finishing loops that cut them, and what the tool leaves uncut.

use std::collections::BTreeSet;

use keepout_kernel::offset::Outline;
use keepout_kernel::{Height, Point, ProhibitedRegion, Side, UNITS_PER_MM};

use crate::Mm2;
use crate::contour::{ContourName, ContourRole, ContourShape, short};
use crate::depth::around;
use crate::finish::{FinishingLoop, centre_distance};
use crate::job::LoopNumber;
use crate::mesh::Mesh;
use crate::plan::{CertifiedPlan, Provenance, Walls};
use crate::reach::{Reach, reaches};
use crate::units::{along_mm, length_up_from_mm, mm, point_from_mm};

/// The tool does not fit along a contour if it leaves more than this share of the contour. A corner leaves less.
const SHARE_LEFT: f64 = 0.1;
/// Largest number of contours for which the largest tool is searched.
const SEARCHED_MAX: usize = 64;
/// A disc touches a place of the contour if it is nearer than this to every other, mm.
const TOUCHES_MM: f64 = 0.003;
/// Steps of the search for the largest disc at a place.
const HALVINGS: usize = 30;

/// A contour of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedContour {
    /// Its name.
    pub name: ContourName,
    /// How much of it the last pass cuts.
    pub reach: Reach,
    /// The loops of all passes that cut it.
    pub loops: Vec<LoopNumber>,
}

impl PlannedContour {
    /// Whether the contour is the foot of a wall. Between faces of the same height there is none.
    #[must_use]
    pub fn has_wall(&self) -> bool {
        self.reach.length_mm > 0.0
    }
}

impl std::fmt::Display for PlannedContour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, reach, loops } = self;
        if !self.has_wall() {
            return write!(f, "{name}: no wall, the faces on both sides have the same height");
        }
        match (loops.len(), reach.is_whole()) {
            (0, _) => write!(f, "{name}: WILL NOT BE CUT, the tool does not fit"),
            (_, true) => write!(f, "{name}: planned"),
            (_, false) => write!(f, "{name}: planned, but for {:.3} mm beside rest material", reach.left_mm),
        }
    }
}

/// A contour along which the tool does not fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// Index of the contour in [`CertifiedPlan::contours`].
    pub contour: usize,
    /// Diameter of the largest tool that enters, or that cuts the longest stretch that is left, mm.
    pub fits_mm: Option<f64>,
}

impl CertifiedPlan {
    /// The contours of the profile, in its order.
    #[must_use]
    pub fn contours(&self) -> &[PlannedContour] {
        self.contours.get_or_init(|| planned(self))
    }

    /// The contour with this number in the drawing.
    #[must_use]
    pub fn contour_numbered(&self, number: usize) -> Option<&PlannedContour> {
        self.contours().iter().find(|contour| contour.name.number == number)
    }

    /// The name of the contour that a loop cuts, such as `2 hole Ø 6.000`, and its pass if there are several.
    #[must_use]
    pub fn loop_name(&self, number: LoopNumber) -> String {
        let contours = self.contours().iter().filter(|contour| contour.loops.contains(&number));
        let names: Vec<String> = contours.map(|contour| contour.name.short()).collect();
        let pass = match self.plan.passes.len() {
            1 => String::new(),
            _ => format!(", pass {}", number.pass + 1),
        };
        if names.is_empty() { format!("{number}") } else { format!("{}{pass}", names.join(" with ")) }
    }

    /// The contours along which the tool does not fit.
    #[must_use]
    pub fn shortfalls(&self) -> Vec<Shortfall> {
        let contours = self.contours().iter().enumerate();
        let short = contours
            .filter(|(_, each)| each.has_wall() && each.reach.left_mm > SHARE_LEFT * each.reach.length_mm);
        let mut mesh: Option<Option<Mesh>> = None;
        let outlines = self.plan.profile.outlines(&self.part);
        let fits = |(number, (contour, each)): (usize, (usize, &PlannedContour))| {
            let fits_mm = (number < SEARCHED_MAX).then(|| {
                if each.reach.is_none() {
                    let mesh = mesh.get_or_insert_with(|| Mesh::of(&self.part).ok());
                    self.enters_mm(each, &outlines[contour], mesh.as_ref())
                } else {
                    self.touches_mm(each, &outlines[contour])
                }
            });
            Shortfall { contour, fits_mm: fits_mm.flatten() }
        };
        short.enumerate().map(fits).collect()
    }

    /// Warnings about the contours along which the tool does not fit.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let shortfalls = self.shortfalls();
        if shortfalls.is_empty() {
            return Vec::new();
        }
        let contours = self.contours();
        let tool_mm = short(2.0 * mm(self.plan.tool_radius.units()));
        let uncut = shortfalls.iter().filter(|each| contours[each.contour].reach.is_none()).count();
        let mut lines = vec![format!(
            "the {tool_mm} mm tool does not fit along {} of {} contours; {uncut} of them stay wholly uncut:",
            shortfalls.len(),
            contours.len()
        )];
        let line = |each: &Shortfall| {
            let PlannedContour { name, reach, .. } = &contours[each.contour];
            let fits = match each.fits_mm {
                Some(fits_mm) => format!("largest tool that fits: {fits_mm:.2} mm"),
                None => "largest tool that fits: not searched".into(),
            };
            match (reach.is_none(), reach.left_at) {
                (true, _) | (_, None) => format!("  {name}: uncut; {fits}"),
                (false, Some(at)) => {
                    format!("  {name}: {:.1} mm uncut, most of it near {at}; {fits}", reach.left_mm)
                }
            }
        };
        lines.extend(shortfalls.iter().take(LISTED).map(line));
        if shortfalls.len() > LISTED {
            lines.push(format!("  … and {} more", shortfalls.len() - LISTED));
        }
        let all = shortfalls.iter().map(|each| each.fits_mm).collect::<Option<Vec<f64>>>();
        if let Some(least) = all.and_then(|all| all.into_iter().reduce(f64::min)) {
            lines.push(format!("  a tool of at most {least:.2} mm fits all of them"));
        }
        lines
    }

    /// Diameter of the largest tool that enters the free space beside a contour, mm.
    fn enters_mm(&self, each: &PlannedContour, outline: &Outline, mesh: Option<&Mesh>) -> Option<f64> {
        let clearance = |at: Point| self.part.clearance(at).filter(|_| !self.part.holds(at));
        let middle = point_from_mm(each.name.middle_mm).ok();
        let radius = match each.name.shape {
            ContourShape::Circle { diameter_mm } => middle
                .and_then(clearance)
                .filter(|radius| (mm(radius.units()) - diameter_mm / 2.0).abs() < 0.01),
            _ => None,
        };
        let radius = radius.or_else(|| {
            let (at, normal) = beside(outline, None)?;
            let inside = point_from_mm(at + normal * 0.001).ok().filter(|&at| !self.part.holds(at))?;
            Some(mesh?.largest_disc(&self.part, Some(inside))?.radius)
        })?;
        Some(self.diameter_mm(mm(radius.units()))).filter(|diameter| *diameter > 0.0)
    }

    /// Diameter of the largest tool that touches the contour in the longest stretch that is left, mm.
    fn touches_mm(&self, each: &PlannedContour, outline: &Outline) -> Option<f64> {
        let (at, normal) = beside(outline, each.reach.left_at)?;
        let fits = |radius: f64| {
            let clear = length_up_from_mm((radius - TOUCHES_MM).max(0.0)).ok();
            let centre = point_from_mm(at + normal * radius).ok().filter(|&at| !self.part.holds(at));
            matches!((centre, clear), (Some(at), Some(clear)) if self.part.clearance(at) >= Some(clear))
        };
        let (mut low, mut high) = (0.0, self.centre_distance_mm());
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if fits(middle) { low = middle } else { high = middle }
        }
        Some(self.diameter_mm(low)).filter(|diameter| *diameter > 0.0)
    }

    /// Distance of the finishing toolpath from the profile, mm.
    fn centre_distance_mm(&self) -> f64 {
        centre_distance(&self.plan.profile, &self.plan.zones, self.finishing) / f64::from(UNITS_PER_MM)
    }

    /// Diameter of a tool whose centre keeps this distance, rounded down to 0.01 mm.
    fn diameter_mm(&self, distance_mm: f64) -> f64 {
        let more_mm = self.centre_distance_mm() - mm(self.plan.tool_radius.units());
        (2.0 * (distance_mm - more_mm) * 100.0).floor() / 100.0
    }
}

/// Largest number of contours that a warning lists.
const LISTED: usize = 12;

/// A place on an outline and the direction to its free side: the place nearest to `near`, or any.
fn beside(outline: &Outline, near: Option<Mm2>) -> Option<(Mm2, Mm2)> {
    let sign = if outline.free_on_left { 1.0 } else { -1.0 };
    let places = outline.curves.iter().map(|curve| {
        let share = near.map_or(0.5, |near| crate::job::share_nearest(curve, near));
        let (at, direction) = along_mm(curve, share);
        (at, direction.left() * sign)
    });
    match near {
        None => places.into_iter().next(),
        Some(near) => places.min_by(|a, b| a.0.distance(near).total_cmp(&b.0.distance(near))),
    }
}

impl Provenance {
    /// Angle by which the drawing was turned, degrees.
    #[must_use]
    pub fn turned_degrees(&self) -> f64 {
        self.placed.map_or(0.0, |(degrees, _)| degrees)
    }
}

fn planned(plan: &CertifiedPlan) -> Vec<PlannedContour> {
    let profile = &plan.plan.profile;
    let roles = roles(plan);
    let numbers = &plan.plan.provenance.numbers;
    let degrees = plan.plan.provenance.turned_degrees();
    let d = centre_distance(profile, &plan.plan.zones, plan.finishing);
    let reaches = wall_reaches(plan, d);
    let mut contours: Vec<PlannedContour> = profile
        .loops
        .iter()
        .zip(roles)
        .zip(reaches)
        .enumerate()
        .map(|(index, ((each, role), reach))| {
            let number = numbers.get(index).copied().unwrap_or(index + 1);
            PlannedContour { name: ContourName::of(number, each, role, degrees), reach, loops: Vec::new() }
        })
        .collect();
    let at_a_depth = plan.plan.passes_at_a_depth();
    for (walls, first) in plan.walls.iter().zip((0..).step_by(at_a_depth)) {
        let rings = RingOf::new(plan, walls);
        for (pass, each) in plan.plan.passes.iter().enumerate().skip(first).take(at_a_depth) {
            for (index, each) in each.path.loops.iter().enumerate() {
                for contour in rings.beside(each) {
                    contours[contour].loops.push(LoopNumber { pass, index });
                }
            }
        }
    }
    contours
}

/// The roles of the contours: by their nesting, or by the heights of the faces on both sides.
fn roles(plan: &CertifiedPlan) -> Vec<ContourRole> {
    let (region, side) = (plan.part.region(), Side::from(plan.plan.side));
    let Some(relief) = &plan.plan.relief else {
        return region.depths().into_iter().map(|depth| ContourRole::of(depth, side)).collect();
    };
    let role = |(inside, parent): (&Option<Height>, Option<usize>)| {
        let outside = parent.map_or(around(side), |parent| relief.tops[parent]);
        ContourRole::between(outside, *inside, parent.is_none())
    };
    relief.tops.iter().zip(region.parents()).map(role).collect()
}

/// How much of each contour the last pass at its greatest depth cuts. A contour at no depth, such as that of a face
/// as high as the stock around it, has no wall: nothing of it is left.
fn wall_reaches(plan: &CertifiedPlan, d: f64) -> Vec<Reach> {
    let mut found: Vec<Option<Reach>> = vec![None; plan.plan.profile.loops.len()];
    for walls in plan.walls.iter().rev() {
        let deepest: Vec<usize> =
            (0..walls.contours.len()).filter(|&index| found[walls.contours[index]].is_none()).collect();
        let outlines: Vec<Outline> = deepest.iter().map(|&index| walls.outlines[index].clone()).collect();
        let loops = &plan.plan.passes[walls.pass].path.loops;
        for (index, reach) in deepest.into_iter().zip(reaches(&outlines, loops, d)) {
            found[walls.contours[index]] = Some(reach);
        }
    }
    found.into_iter().map(Option::unwrap_or_default).collect()
}

/// The contour of each edge of what stands at a depth. Edges of keep-out zones come after them.
struct RingOf<'a> {
    region: &'a ProhibitedRegion,
    contours: Vec<usize>,
}

impl<'a> RingOf<'a> {
    fn new(plan: &'a CertifiedPlan, walls: &Walls) -> Self {
        let region = plan.region(plan.plan.passes[walls.pass].height);
        let rings = region.region().rings().iter().zip(&walls.contours);
        let contours = rings.flat_map(|(ring, &contour)| ring.segments().map(move |_| contour)).collect();
        Self { region, contours }
    }

    /// The contours that a loop cuts: those nearest to its motions.
    fn beside(&self, each: &FinishingLoop) -> BTreeSet<usize> {
        let mut hint = None;
        let mut found = BTreeSet::new();
        for curve in &each.curves {
            let Some(middle) = point_from_mm(along_mm(curve, 0.5).0).ok() else { continue };
            let Some(nearest) = self.region.index().nearest(middle, hint) else { continue };
            hint = Some(nearest.edge);
            found.extend(self.contours.get(nearest.edge));
        }
        found
    }
}
