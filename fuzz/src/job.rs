//! The small plans for logs and sessions.

use std::fmt::Write as _;
use std::sync::OnceLock;

use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::depth::{DepthParameters, FaceChoice, FaceDepth};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanParameters;
use keepout_planner::request::PlanRequest;
use keepout_planner::{plan_file, sha256};
use keepout_proofs::properties::Xy;

/// A plate of 24 × 16 mm with a slot that the tool enters and a step, mm.
const OUTLINE: [(i64, i64); 10] =
    [(0, 0), (24, 0), (24, 10), (18, 16), (14, 16), (14, 8), (6, 8), (6, 16), (3, 16), (0, 12)];
/// A pocket of the same plate, mm.
const POCKET: [(i64, i64); 4] = [(16, 1), (23, 1), (23, 9), (16, 9)];
/// Thickness of the plate and depth of its pocket, mm.
const THICKNESS: i64 = 4;
const POCKET_DEPTH: i64 = 2;
/// Lattice units of a millimetre.
const MM: i64 = 100_000;

/// The drawing of the plate, with its pocket on layer 1 or without it.
#[must_use]
pub fn plate(pocket: bool) -> String {
    let mut text =
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n".to_string();
    let loops: [(u8, &[(i64, i64)]); 2] = [(0, &OUTLINE), (1, &POCKET)];
    for (layer, corners) in &loops[..1 + usize::from(pocket)] {
        let _ = write!(text, "0\nLWPOLYLINE\n8\n{layer}\n90\n{}\n70\n1\n", corners.len());
        for (x, y) in *corners {
            let _ = write!(text, "10\n{x}\n20\n{y}\n");
        }
    }
    text + "0\nENDSEC\n0\nEOF\n"
}

/// The plate, planned for a tool of 6 mm on the simulated machine with two axes.
///
/// # Panics
/// Never: it can be planned.
#[must_use]
pub fn work() -> PreparedPlan {
    static WORK: OnceLock<PreparedPlan> = OnceLock::new();
    WORK.get_or_init(|| planned(false, &PlanRequest::default(), &MachineProfile::simulated())).clone()
}

/// The plate with its pocket, planned with depths for a tool of 6 mm on the simulated machine with three axes.
///
/// # Panics
/// Never: it can be planned.
#[must_use]
pub fn deep_work() -> PreparedPlan {
    static WORK: OnceLock<PreparedPlan> = OnceLock::new();
    #[expect(clippy::cast_precision_loss, reason = "the depths are single digits")]
    let depth = || DepthParameters {
        faces: vec![FaceDepth { of: FaceChoice::Layer("1".into()), depth_mm: Some(POCKET_DEPTH as f64) }],
        ..DepthParameters::of(THICKNESS as f64)
    };
    let request = || PlanRequest {
        job: PlanParameters { depth: Some(depth()), ..PlanParameters::default() },
        ..PlanRequest::default()
    };
    WORK.get_or_init(|| planned(true, &request(), &MachineProfile::simulated_three_axes())).clone()
}

fn planned(pocket: bool, request: &PlanRequest, machine: &MachineProfile) -> PreparedPlan {
    let plan = request.plan("plate", plate(pocket).as_bytes(), machine, &mut |_| {});
    PreparedPlan::new(plan.expect("the plate can be planned"))
}

/// What stands above a tip at this height: its walls, and whether a point is in it. From the corners alone; without
/// depths all of the plate stands.
#[derive(Clone, Debug)]
pub struct Standing {
    loops: Vec<Vec<Xy>>,
}

impl Standing {
    /// What stands above a tip at this height, lattice units. `None` in a session without depths.
    #[must_use]
    pub fn above(tip: Option<i64>) -> Self {
        let corners = |mm: &[(i64, i64)]| mm.iter().map(|&(x, y)| (x * MM, y * MM)).collect();
        let loops = match tip {
            Some(tip) if tip >= 0 => Vec::new(),
            Some(tip) if tip >= -POCKET_DEPTH * MM => vec![corners(&OUTLINE), corners(&POCKET)],
            _ => vec![corners(&OUTLINE)],
        };
        Self { loops }
    }

    /// The ends of its walls.
    pub fn walls(&self) -> impl Iterator<Item = (Xy, Xy)> {
        self.loops.iter().flat_map(|each| {
            let next = each.iter().cycle().skip(1);
            each.iter().copied().zip(next.copied())
        })
    }

    /// Whether the point is in it: a ray to the right crosses an odd number of walls.
    #[must_use]
    pub fn holds(&self, (x, y): Xy) -> bool {
        let crosses = |&((ax, ay), (bx, by)): &(Xy, Xy)| {
            let ahead = i128::from(bx - ax) * i128::from(y - ay) - i128::from(by - ay) * i128::from(x - ax);
            (ay > y) != (by > y) && (ahead > 0) == (by > ay)
        };
        self.walls().filter(crosses).count() % 2 == 1
    }
}

/// The hash of its plan file, as logs name it.
///
/// # Panics
/// Never: a plan in memory can be written.
#[must_use]
pub fn hash() -> &'static str {
    static HASH: OnceLock<String> = OnceLock::new();
    HASH.get_or_init(|| {
        let bytes = plan_file::encode(&work().plan.plan).expect("a plan in memory can be written");
        sha256::hex(&sha256::hash(&bytes))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The walls of the plate are the edges of its plan.
    #[test]
    fn walls_are_the_edges_of_the_plan() {
        let sorted = |mut walls: Vec<[Xy; 2]>| {
            walls.iter_mut().for_each(|ends| ends.sort_unstable());
            walls.sort_unstable();
            walls
        };
        let of = |tip| sorted(Standing::above(tip).walls().map(|(a, b)| [a, b]).collect());
        let edges = |region: &keepout_kernel::ProhibitedRegion| {
            let plain = keepout_proofs::square::plain;
            sorted(region.edges().iter().map(|edge| [plain(edge.chord.from), plain(edge.chord.to)]).collect())
        };
        assert_eq!(of(None), edges(&work().plan.part));
        let deep = deep_work();
        for tip in [1, 0, -1, -POCKET_DEPTH * MM, -POCKET_DEPTH * MM - 1, -THICKNESS * MM] {
            let height = keepout_proofs::square::height(tip);
            assert_eq!(of(Some(tip)), edges(deep.plan.levels.at(height)), "{tip}");
        }
    }
}
