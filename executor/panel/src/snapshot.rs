//! What the session shows to the panel: one value of fixed size, written after every round.

use arrayvec::ArrayVec;
use keepout_executor::session::nearest_wall;
use keepout_executor::supervisor::{Fault, Phase, Supervisor};
use keepout_guard::{Hull, Time};
use keepout_kernel::{Height, UNITS_PER_MM};
use keepout_planner::Mm2;
use keepout_planner::units::{mm, point_mm};

/// Most corners of the in-flight hull that are shown.
const CORNERS_MAX: usize = 32;

/// The state of a session at one moment. It holds no memory of its own, so the session loop writes it without
/// allocation.
#[derive(Clone, Copy, Debug)]
pub struct SessionState {
    /// Time of the session.
    pub at: Time,
    /// The supervisor's phase.
    pub phase: Phase,
    /// Whether the machine rests.
    pub rests: bool,
    /// The tool's centre as reported, drawing coordinates, mm.
    pub position_mm: Option<Mm2>,
    /// The height of the tip, mm. `None` in a session with two axes.
    pub height_mm: Option<f64>,
    /// How far the tool may still move toward the nearest wall, mm.
    pub wall_mm: Option<f64>,
    /// Whether a touch starts the contour.
    pub armed: bool,
    /// Whether the spindle runs, as stated or confirmed.
    pub spindle: Option<bool>,
    /// Motions of the contour that were sent, and all of them.
    pub contour: Option<(usize, usize)>,
    /// Time that the rest of the contour takes at its feeds, s.
    pub left_s: Option<f64>,
    /// Number of finished loops.
    pub finished: usize,
    /// Number of notices so far.
    pub notices: usize,
    /// The fault that stopped the session.
    pub fault: Option<Fault>,
    /// Corners of the hull of everything that may still be executed, mm.
    pub hull_mm: Corners,
}

/// Corners of a polygon, of fixed size.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    count: usize,
    at: [Mm2; CORNERS_MAX],
}

impl Corners {
    /// The corners, as far as there is room.
    fn of(corners: impl Iterator<Item = Mm2>) -> Self {
        let found: ArrayVec<Mm2, CORNERS_MAX> = corners.take(CORNERS_MAX).collect();
        let mut at = [Mm2::ZERO; CORNERS_MAX];
        at.iter_mut().zip(&found).for_each(|(slot, corner)| *slot = *corner);
        Self { count: found.len(), at }
    }

    /// The corners in order.
    #[must_use]
    pub fn points(&self) -> &[Mm2] {
        self.at.get(..self.count).unwrap_or(&[])
    }
}

impl SessionState {
    /// The state of a supervisor. `left_s` is the time that the rest of the contour takes.
    #[must_use]
    pub fn of(supervisor: &Supervisor, at: Time, left_s: Option<f64>) -> Self {
        let (plan, guard) = (supervisor.plan(), supervisor.guard());
        let position = supervisor.position();
        let position_mm = position.map(|place| point_mm(place.point));
        let contouring = matches!(supervisor.phase(), Phase::Contouring | Phase::Holding);
        let clearance = if contouring { plan.finishing } else { plan.roughing };
        let wall = position.and_then(|place| nearest_wall(plan, place)).zip(position_mm);
        let set: ArrayVec<_, CORNERS_MAX> = guard.in_flight().take(CORNERS_MAX).collect();
        let hull = Hull::of(set.iter().copied());
        Self {
            at,
            phase: supervisor.phase(),
            rests: supervisor.is_at_rest(),
            position_mm,
            height_mm: supervisor.height_mm(),
            wall_mm: wall.map(|(wall, at)| (at.distance(wall) - mm(clearance.units())).max(0.0)),
            armed: supervisor.is_armed(),
            spindle: supervisor.spindle_runs(),
            contour: guard.contour_progress(),
            left_s,
            finished: supervisor.finished().len(),
            notices: supervisor.notices().len(),
            fault: supervisor.fault().copied(),
            hull_mm: Corners::of(hull.iter().flat_map(Hull::corners).copied().map(point_mm)),
        }
    }
}

/// The time that the rest of a contour takes at its feeds, without acceleration, s. `None` without a contour.
#[must_use]
pub fn seconds_left(supervisor: &Supervisor) -> Option<f64> {
    let left = supervisor.guard().contour_left();
    let climb = |[from, to]: [Height; 2]| mm(from.units()) - mm(to.units());
    let minutes = left.iter().map(|motion| {
        let way = (motion.curve.length() / f64::from(UNITS_PER_MM)).hypot(climb(motion.heights));
        way / f64::from(motion.feed_mm_min.max(1))
    });
    (!left.is_empty()).then(|| minutes.sum::<f64>() * 60.0)
}
