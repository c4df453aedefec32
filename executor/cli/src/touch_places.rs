//! The places of a drawing that the operator touches to align the part.

use clap::ValueEnum;
use keepout_kernel::Curve;
use keepout_planner::Mm2;
use keepout_planner::contour::{ContourName, ContourRole, ContourShape};
use keepout_planner::profile::{MachinedSide, Profile, ProfileLoop};
use keepout_planner::units::{along_mm, point_mm};

use super::CliError;

/// Places that the operator touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TakeMethod {
    /// Two touches of one straight edge, and one of another: offset and rotation.
    Edges,
    /// The tool's centre on two points of the drawing: offset and rotation.
    Points,
    /// Three touches of the wall of one or two round holes: their centres give offset and rotation.
    Hole,
    /// The tool's tip on paper on the top of the part, on a machine with three axes: its height.
    Top,
}

/// Least angle between two edges that measure both axes, degrees.
const ACROSS_DEG: f64 = 30.0;
/// Least angle between two curves at a corner, degrees.
const CORNER_DEG: f64 = 15.0;
/// Least distance between two places that give the rotation, mm.
const APART_MM: f64 = 1.0;
/// Touches of a hole's wall.
pub const TOUCHES: usize = 3;
/// A place to touch.
pub struct TouchPlace {
    /// Text for the operator. The place follows.
    pub words: &'static str,
    /// The place. `None`: anywhere on the top of the part.
    pub drawing_mm: Option<Mm2>,
}

/// The places of the drawing for a method.
pub fn places(
    method: TakeMethod,
    profile: &Profile,
    side: MachinedSide,
) -> Result<Vec<TouchPlace>, CliError> {
    match method {
        TakeMethod::Edges => edges(profile),
        TakeMethod::Points => corners(profile),
        TakeMethod::Hole => holes(profile, side),
        TakeMethod::Top => {
            let words = "lower the tool onto the paper on the top of the part, until it just grips";
            Ok(vec![TouchPlace { words, drawing_mm: None }])
        }
    }
}

fn edges(profile: &Profile) -> Result<Vec<TouchPlace>, CliError> {
    let curves = profile.loops.iter().flat_map(|each| &each.edges).map(|edge| edge.curve);
    let mut lines: Vec<(Mm2, Mm2)> = curves
        .filter_map(|curve| match curve {
            Curve::Line(line) => Some((point_mm(line.from), point_mm(line.to))),
            Curve::Arc(_) => None,
        })
        .collect();
    lines.sort_by(|a, b| b.0.distance(b.1).total_cmp(&a.0.distance(a.1)));
    let none = || {
        let reason =
            "the drawing has no two straight edges across each other: align by --take points or --take hole";
        CliError::Argument(reason.into())
    };
    let &(a, b) = lines.first().ok_or_else(none)?;
    let along = a.direction_to(b);
    let across =
        |line: &&(Mm2, Mm2)| along.cross(line.0.direction_to(line.1)).abs() >= ACROSS_DEG.to_radians().sin();
    let &(c, d) = lines.iter().find(across).ok_or_else(none)?;
    let place = |words, drawing_mm| TouchPlace { words, drawing_mm: Some(drawing_mm) };
    Ok(vec![
        place("touch the long edge near", a + (b - a) * 0.15),
        place("touch the same edge near", a + (b - a) * 0.85),
        place("touch the edge across it near", c.midpoint(d)),
    ])
}

fn corners(profile: &Profile) -> Result<Vec<TouchPlace>, CliError> {
    let ends: Vec<Mm2> = profile.loops.iter().flat_map(corners_of).collect();
    let farthest =
        |from: Mm2| ends.iter().copied().max_by(|a, b| a.distance(from).total_cmp(&b.distance(from)));
    let pair = ends.first().and_then(|&first| farthest(first)).and_then(|one| Some((one, farthest(one)?)));
    let (one, other) = pair.filter(|(one, other)| one.distance(*other) > APART_MM).ok_or_else(|| {
        let reason =
            "the drawing has no two corners to bring the tool to: align by --take edges or --take hole";
        CliError::Argument(reason.into())
    })?;
    let place = |drawing_mm| TouchPlace {
        words: "bring the tool's centre to the corner at",
        drawing_mm: Some(drawing_mm),
    };
    Ok(vec![place(one), place(other)])
}

/// The corners of a contour. A line that runs into an arc without a bend has none there.
fn corners_of(each: &ProfileLoop) -> Vec<Mm2> {
    let curves: Vec<Curve> = each.edges.iter().map(|edge| edge.curve).collect();
    let before = curves.iter().cycle().skip(curves.len().saturating_sub(1));
    let bends = |(before, curve): &(&Curve, &Curve)| {
        let (arrives, leaves) = (along_mm(before, 1.0).1, along_mm(curve, 0.0).1);
        arrives.cross(leaves).atan2(arrives.dot(leaves)).abs() >= CORNER_DEG.to_radians()
    };
    before.zip(&curves).filter(bends).map(|(_, curve)| point_mm(curve.from())).collect()
}

fn holes(profile: &Profile, side: MachinedSide) -> Result<Vec<TouchPlace>, CliError> {
    let round = |(number, each): (usize, &ProfileLoop)| {
        let name = ContourName::of(number + 1, each, ContourRole::of(1, side.into()), 0.0);
        matches!(name.shape, ContourShape::Circle { .. }).then_some(name)
    };
    let holes: Vec<ContourName> = profile.loops.iter().enumerate().filter_map(round).collect();
    let first = holes.first().ok_or_else(|| {
        CliError::Argument("the drawing has no round hole: align by --take edges or --take points".into())
    })?;
    let off = |name: &&ContourName| name.middle_mm.distance(first.middle_mm);
    let other = holes.iter().max_by(|a, b| off(a).total_cmp(&off(b))).filter(|other| off(other) > APART_MM);
    let each = |name: &ContourName| {
        let drawing_mm = name.middle_mm;
        let words = "touch three places far apart on the wall of the hole at";
        (0..TOUCHES).map(move |_| TouchPlace { words, drawing_mm: Some(drawing_mm) }).collect::<Vec<_>>()
    };
    Ok([Some(first), other].into_iter().flatten().flat_map(each).collect())
}

#[cfg(test)]
mod tests {
    use keepout_planner::request::PlanRequest;

    use super::*;

    /// The lines of a plate with one round corner: their ends at the arc are no corners.
    #[test]
    fn tangent_points_are_no_corners() {
        let entity = "0\nLWPOLYLINE\n8\n0\n70\n1\n";
        let corner = |x: f64, y: f64, bulge: f64| format!("10\n{x}\n20\n{y}\n42\n{bulge}\n");
        let quarter = (std::f64::consts::PI / 8.0).tan();
        let corners =
            [(0.0, 0.0, 0.0), (50.0, 0.0, quarter), (60.0, 10.0, 0.0), (60.0, 30.0, 0.0), (0.0, 30.0, 0.0)];
        let corners: String = corners.into_iter().map(|(x, y, bulge)| corner(x, y, bulge)).collect();
        let drawing = format!("0\nSECTION\n2\nENTITIES\n{entity}{corners}0\nENDSEC\n0\nEOF\n");
        let (_, chained) = PlanRequest::default().contours(drawing.as_bytes()).unwrap();
        let found = corners_of(&chained.profile.loops[0]);
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(!found.contains(&Mm2::new(50.0, 0.0)) && !found.contains(&Mm2::new(60.0, 10.0)), "{found:?}");
    }
}
