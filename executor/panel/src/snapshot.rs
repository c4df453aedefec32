//! What the session shows to the panel: one value of fixed size, written after every round.

use arrayvec::ArrayVec;
use keepout_executor::session::free_way_mm;
use keepout_executor::supervisor::{Fault, Phase, Supervisor};
use keepout_guard::Hull;
use keepout_kernel::{Height, UNITS_PER_MM};
use keepout_planner::Mm2;
use keepout_planner::units::{mm, point_mm};
use serde::{Serialize, Serializer};

/// Most corners of the in-flight hull that are shown.
const CORNERS_MAX: usize = 32;

/// The state of a session at one moment. It holds no memory of its own, so the session loop writes it without
/// allocation.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SessionState {
    /// The supervisor's phase.
    pub phase: Phase,
    /// Whether the machine rests, and its place is confirmed.
    pub rests: bool,
    /// The tool's centre as reported, drawing coordinates, mm.
    pub position_mm: Option<Mm2>,
    /// The height of the tip, mm. `None` in a session with two axes.
    pub height_mm: Option<f64>,
    /// How far the tool may still move toward the nearest wall, mm.
    pub wall_mm: Option<f64>,
    /// Whether a touch starts the contour.
    pub armed: bool,
    /// Whether a contour was interrupted, and can go on.
    pub interrupted: bool,
    /// Whether the spindle runs, as stated or confirmed.
    pub spindle: Option<bool>,
    /// Share of the contour job that was sent, 0 to 1.
    pub share: Option<f64>,
    /// Feed override of the contours, per cent.
    pub feed_percent: u8,
    /// Time that the rest of the contour takes at its feeds, s.
    pub left_s: Option<f64>,
    /// The fault that stopped the session.
    #[serde(skip)]
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
        let mut found = Self { count: 0, at: [Mm2::ZERO; CORNERS_MAX] };
        for (slot, corner) in found.at.iter_mut().zip(corners) {
            *slot = corner;
            found.count += 1;
        }
        found
    }
}

impl Serialize for Corners {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.at.get(..self.count).unwrap_or(&[]).serialize(serializer)
    }
}

impl SessionState {
    /// The state of a supervisor. `left_s` is the time that the rest of the contour takes.
    #[must_use]
    pub fn of(supervisor: &Supervisor, left_s: Option<f64>) -> Self {
        let guard = supervisor.guard();
        let share = |(sent, all): (usize, usize)| {
            let count = |number: usize| f64::from(u32::try_from(number).unwrap_or(u32::MAX));
            if all == 0 { 1.0 } else { count(sent) / count(all) }
        };
        let set: ArrayVec<_, CORNERS_MAX> = guard.in_flight().take(CORNERS_MAX).collect();
        let hull = Hull::of(set.iter().copied());
        Self {
            phase: supervisor.phase(),
            rests: supervisor.is_at_rest() && guard.in_position(),
            position_mm: supervisor.position().map(|place| point_mm(place.point)),
            height_mm: supervisor.height_mm(),
            wall_mm: free_way_mm(supervisor),
            armed: supervisor.is_armed(),
            interrupted: supervisor.is_interrupted(),
            spindle: supervisor.spindle_runs(),
            share: guard.contour_progress().map(share),
            feed_percent: supervisor.feed_override().percent(),
            left_s,
            fault: supervisor.fault().copied(),
            hull_mm: Corners::of(hull.iter().flat_map(Hull::corners).copied().map(point_mm)),
        }
    }
}

/// The time that the rest of a contour takes at its feeds and the present override, without acceleration, s. `None`
/// without a contour.
#[must_use]
pub fn seconds_left(supervisor: &Supervisor) -> Option<f64> {
    let left = supervisor.guard().contour_left();
    let climb = |[from, to]: [Height; 2]| mm(from.units()) - mm(to.units());
    let minutes = left.iter().map(|motion| {
        let way = (motion.curve.length() / f64::from(UNITS_PER_MM)).hypot(climb(motion.heights));
        way / f64::from(supervisor.feed_override().of(motion.feed_mm_min).max(1))
    });
    (!left.is_empty()).then(|| minutes.sum::<f64>() * 60.0)
}
