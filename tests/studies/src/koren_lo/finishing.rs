//! The finishing toolpath of a plan, as paths for the drives.

use keepout_drives::Axes;
use keepout_drives::path::PathPiece;
use keepout_kernel::{ArcView, Curve};
use keepout_planner::Mm2;
use keepout_planner::plan::Plan;
use keepout_planner::units::point_mm;

/// One loop of one pass, in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourPath {
    /// Pass and loop, counted from 1: "2:1". With a single pass, the loop alone.
    pub name: String,
    /// Feed of the pass, if the pass has its own feed.
    pub feed_mm_min: Option<u32>,
    /// The lines and arcs.
    pub pieces: Vec<PathPiece>,
}

/// All loops of all passes.
#[must_use]
pub fn loops(plan: &Plan) -> Vec<ContourPath> {
    let mut loops = Vec::new();
    for (pass, each) in plan.passes.iter().enumerate() {
        for (number, found) in each.path.loops.iter().enumerate() {
            let name = if plan.passes.len() > 1 {
                format!("{}:{}", pass + 1, number + 1)
            } else {
                format!("{}", number + 1)
            };
            let pieces = found.curves.iter().map(piece).collect();
            loops.push(ContourPath { name, feed_mm_min: each.feed_mm_min, pieces });
        }
    }
    loops
}

fn piece(curve: &Curve) -> PathPiece {
    let at = |point| {
        let Mm2 { x, y } = point_mm(point);
        Axes::new(x, y)
    };
    match curve {
        Curve::Line(segment) => PathPiece::Line { from: at(segment.from), to: at(segment.to) },
        Curve::Arc(arc) => PathPiece::arc(at(arc.centre()), at(curve.from()), ArcView::of(arc).sweep),
    }
}

#[cfg(test)]
mod tests {
    use keepout_planner::machine::MachineProfile;
    use keepout_planner::request::PlanRequest;

    use super::*;

    /// In each loop, every piece begins where the previous one ends.
    #[test]
    fn loops_are_closed_and_connected() {
        let bytes = include_bytes!("../../../../executor/cli/drawings/bracket.dxf");
        let plan =
            PlanRequest::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap();
        let found = loops(&plan.plan);
        assert_eq!(found.len(), plan.plan.loop_count());
        for each in &found {
            let ends = each.pieces.iter().map(|piece| (piece.at(0.0).point, piece.at(piece.length()).point));
            let ends: Vec<_> = ends.collect();
            for (number, (_, end)) in ends.iter().enumerate() {
                let next = ends[(number + 1) % ends.len()].0;
                assert!((end - next).norm() < 1e-4, "{} {number}: {end} {next}", each.name);
            }
        }
    }
}
