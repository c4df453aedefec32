//! Names of contours: what a contour is, where it lies, and how long it is. `inspect`, `plan`, the pictures, the
//! view and the report all use these names and numbers.

use std::fmt;

use keepout_kernel::{ArcView, Curve, Height, Side, UNITS_PER_MM};
use serde::Serialize;

use crate::profile::{Profile, ProfileLoop};
use crate::units::{arc_mm, point_mm};
use crate::{Box2, Mm2};

/// Differences up to this are rounding, mm.
const SAME_MM: f64 = 0.002;
/// The same for the angle of an arc, radians.
const SAME_ANGLE: f64 = 0.01;

/// Shape of a contour that a machinist would name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ContourShape {
    /// A circle.
    Circle {
        /// Its diameter, mm.
        diameter_mm: f64,
    },
    /// Two parallel lines with a half circle at each end.
    Slot {
        /// Distance of the lines, mm.
        width_mm: f64,
        /// Length over all, mm.
        length_mm: f64,
    },
    /// Any other shape, by the box around it.
    Other {
        /// Size along x, mm.
        width_mm: f64,
        /// Size along y, mm.
        height_mm: f64,
    },
}

/// Role of a contour in the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ContourRole {
    /// Boundary of material that no other contour encloses.
    Outline,
    /// Boundary of material inside an opening.
    Island,
    /// Boundary of an opening in the material.
    Opening,
    /// Boundary of an opening that is machined from inside, or of a face below the one around it.
    Pocket,
    /// Boundary of a face above the one around it.
    Boss,
}

impl ContourRole {
    /// The role of a contour with `depth` others around it, of a part on this side.
    #[must_use]
    pub fn of(depth: usize, side: Side) -> Self {
        let material = depth.is_multiple_of(2) == (side == Side::Outside);
        match (material, side, depth) {
            (true, Side::Outside, 0) => Self::Outline,
            (true, _, _) => Self::Island,
            (false, Side::Inside, 0) => Self::Pocket,
            (false, _, _) => Self::Opening,
        }
    }

    /// The role of a contour between faces with these tops. `None`: the face goes through. Without another contour
    /// around it, it is `outermost`.
    #[must_use]
    pub fn between(outside: Option<Height>, inside: Option<Height>, outermost: bool) -> Self {
        match (outside, inside) {
            (None, _) if outermost => Self::Outline,
            (None, _) => Self::Island,
            (Some(_), None) => Self::Opening,
            (Some(outside), Some(inside)) if inside > outside => Self::Boss,
            _ => Self::Pocket,
        }
    }
}

/// Name of a contour.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContourName {
    /// Number of the contour in the drawing, from 1.
    pub number: usize,
    /// Its role.
    pub role: ContourRole,
    /// Its shape.
    pub shape: ContourShape,
    /// Middle of the box around it.
    pub middle_mm: Mm2,
    /// Its length, mm.
    pub length_mm: f64,
}

impl ContourName {
    /// The name of a contour. The drawing was turned by `degrees`; sizes are along its own axes.
    #[must_use]
    pub fn of(number: usize, each: &ProfileLoop, role: ContourRole, degrees: f64) -> Self {
        let length: f64 = each.curves().map(Curve::length).sum();
        Self {
            number,
            role,
            shape: shape(each, box_turned_back(each, degrees).unwrap_or_default()),
            middle_mm: exact_box(each).unwrap_or_default().middle(),
            length_mm: length / f64::from(UNITS_PER_MM),
        }
    }

    /// What the contour is, such as `hole Ø 6.000`.
    #[must_use]
    pub fn title(&self) -> String {
        match (self.role, self.shape) {
            (ContourRole::Opening | ContourRole::Pocket, ContourShape::Circle { diameter_mm }) => {
                format!("hole Ø {diameter_mm:.3}")
            }
            (ContourRole::Opening | ContourRole::Pocket, ContourShape::Slot { width_mm, length_mm }) => {
                format!("slot {} × {}", short(width_mm), short(length_mm))
            }
            (role, ContourShape::Circle { diameter_mm }) => format!("{} Ø {diameter_mm:.3}", word(role)),
            (role, ContourShape::Slot { width_mm, length_mm }) => {
                format!("{} {} × {}, round ends", word(role), short(length_mm), short(width_mm))
            }
            (role, ContourShape::Other { width_mm, height_mm }) => {
                format!("{} {} × {}", word(role), short(width_mm), short(height_mm))
            }
        }
    }

    /// Number and title, such as `2 hole Ø 6.000`.
    #[must_use]
    pub fn short(&self) -> String {
        format!("{} {}", self.number, self.title())
    }
}

impl fmt::Display for ContourName {
    /// Number, title, place and length.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Mm2 { x, y } = self.middle_mm;
        write!(f, "{} at ({x:.3}, {y:.3}), {:.3} mm long", self.short(), self.length_mm)
    }
}

fn word(role: ContourRole) -> &'static str {
    match role {
        ContourRole::Outline => "outline",
        ContourRole::Island => "island",
        ContourRole::Opening => "cut-out",
        ContourRole::Pocket => "pocket",
        ContourRole::Boss => "boss",
    }
}

/// A length without zeros at its end.
#[must_use]
pub fn short(mm: f64) -> String {
    let text = format!("{mm:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// The box around a loop, with the extreme points of its arcs.
#[must_use]
pub fn exact_box(each: &ProfileLoop) -> Option<Box2> {
    box_turned_back(each, 0.0)
}

/// The box around a loop along the axes of its drawing, which was turned by `degrees`, mm.
#[must_use]
pub fn box_turned_back(each: &ProfileLoop, degrees: f64) -> Option<Box2> {
    let turned = degrees.to_radians();
    let back = |at: Mm2| at.turned(-turned);
    let boxes = each.curves().filter_map(|curve| {
        let ends = [point_mm(curve.from()), point_mm(curve.to())];
        let extremes: Vec<Mm2> = match curve {
            Curve::Line(_) => Vec::new(),
            Curve::Arc(arc) => extremes(&arc_mm(arc), turned),
        };
        Box2::around(ends.into_iter().chain(extremes).map(back))
    });
    boxes.reduce(Box2::union)
}

/// The box around a profile along the axes of its drawing, which was turned by `degrees`, mm.
#[must_use]
pub fn profile_box(profile: &Profile, degrees: f64) -> Box2 {
    let boxes = profile.loops.iter().filter_map(|each| box_turned_back(each, degrees));
    boxes.reduce(Box2::union).unwrap_or_default()
}

/// The points of an arc where it runs along an axis of a drawing that was turned by `turned`, radians.
fn extremes(arc: &ArcView, turned: f64) -> Vec<Mm2> {
    use std::f64::consts::{FRAC_PI_2, TAU};
    let (from, to) =
        if arc.sweep < 0.0 { (arc.start + arc.sweep, arc.start) } else { (arc.start, arc.start + arc.sweep) };
    let quarters = [0.0, 1.0, 2.0, 3.0].map(|k| k * FRAC_PI_2 + turned);
    let within = |angle: &f64| (angle - from).rem_euclid(TAU) <= to - from;
    quarters.into_iter().filter(within).map(|angle| arc.at_angle(angle).into()).collect()
}

fn shape(each: &ProfileLoop, bounds: Box2) -> ContourShape {
    let size = bounds.size();
    let other = ContourShape::Other { width_mm: size.x, height_mm: size.y };
    let mut lines: Vec<(Mm2, Mm2)> = Vec::new();
    let mut rounds: Vec<(Mm2, f64)> = Vec::new();
    let mut radius = None;
    for edge in &each.edges {
        match &edge.curve {
            Curve::Line(line) => lines.push((point_mm(line.from), point_mm(line.to))),
            Curve::Arc(arc) => {
                let arc = arc_mm(arc);
                let (centre, first) = (Mm2::from(arc.centre), *radius.get_or_insert(arc.radius));
                if (arc.radius - first).abs() > SAME_MM {
                    return other;
                }
                match rounds.iter_mut().find(|(other, _)| other.distance(centre) <= SAME_MM) {
                    Some((_, sweep)) => *sweep += arc.sweep,
                    None => rounds.push((centre, arc.sweep)),
                }
            }
        }
    }
    let Some(radius) = radius else { return other };
    let turns = |(_, sweep): &(Mm2, f64), turn: f64| (sweep.abs() - turn).abs() <= SAME_ANGLE;
    match rounds[..] {
        [only] if lines.is_empty() && turns(&only, std::f64::consts::TAU) => {
            ContourShape::Circle { diameter_mm: 2.0 * radius }
        }
        [one, other_end]
            if turns(&one, std::f64::consts::PI)
                && turns(&other_end, std::f64::consts::PI)
                && !lines.is_empty()
                && lines.iter().all(|&line| is_side(line, (one.0, other_end.0), radius)) =>
        {
            let length_mm = one.0.distance(other_end.0) + 2.0 * radius;
            ContourShape::Slot { width_mm: 2.0 * radius, length_mm }
        }
        _ => other,
    }
}

/// Whether a line runs beside the axis of a slot, at the distance of its radius.
fn is_side((from, to): (Mm2, Mm2), axis: (Mm2, Mm2), radius: f64) -> bool {
    let along = axis.0.direction_to(axis.1);
    [from, to].into_iter().all(|end| (along.cross(end - axis.0).abs() - radius).abs() <= SAME_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::PlanRequest;

    fn titles(entities: &str, side: Side) -> Vec<String> {
        let dxf = format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
        let (_, chained) = PlanRequest::default().contours(dxf.as_bytes()).unwrap();
        let loops = chained.profile.loops.iter().enumerate();
        let name = |(k, each): (usize, &ProfileLoop)| {
            ContourName::of(k + 1, each, ContourRole::of(k, side), 0.0).short()
        };
        loops.map(name).collect()
    }

    const PLATE: &str = "0\nLWPOLYLINE\n70\n1\n10\n0\n20\n0\n10\n60\n20\n0\n10\n60\n20\n30\n10\n0\n20\n30\n";
    const SLOT: &str =
        "0\nLWPOLYLINE\n70\n1\n10\n14\n20\n6\n10\n46\n20\n6\n42\n1\n10\n46\n20\n14\n10\n14\n20\n14\n42\n1\n";

    #[test]
    fn outline_hole_and_slot_are_named() {
        let circle = "0\nCIRCLE\n10\n10\n20\n22\n40\n3\n";
        assert_eq!(
            titles(&format!("{PLATE}{circle}"), Side::Outside),
            ["1 outline 60 × 30", "2 hole Ø 6.000"]
        );
        assert_eq!(titles(&format!("{PLATE}{SLOT}"), Side::Outside)[1], "2 slot 8 × 40");
        assert_eq!(titles(SLOT, Side::Outside), ["1 outline 40 × 8, round ends"]);
        assert_eq!(titles(PLATE, Side::Inside), ["1 pocket 60 × 30"]);
    }

    /// The box of the chords of a circle is smaller than the circle.
    #[test]
    fn box_of_a_circle_is_exact() {
        assert_eq!(titles("0\nCIRCLE\n10\n1\n20\n2\n40\n50\n", Side::Outside), ["1 outline Ø 100.000"]);
        let dxf = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n10\n1\n20\n2\n40\n50\n0\nENDSEC\n0\nEOF\n";
        let (_, chained) = PlanRequest::default().contours(dxf.as_bytes()).unwrap();
        let size = exact_box(&chained.profile.loops[0]).unwrap().size();
        assert!((size.x - 100.0).abs() < 1e-6 && (size.y - 100.0).abs() < 1e-6, "{size:?}");
    }
}
