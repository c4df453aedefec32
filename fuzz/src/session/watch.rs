//! Checks of a session: the guard's invariant, by means other than the guard's.

use crate::oracle::xy;
use keepout_executor::supervisor::{Command, Phase};
use keepout_guard::{Interpolation, Motion};
use keepout_kernel::{Curve, Height, Place, Point, ProhibitedRegion, Segment};
use keepout_planner::job::LoopNumber;
use keepout_proofs::families::at;
use keepout_proofs::properties::Xy;
use keepout_proofs::soak::{segments_within, triangle_within};
use keepout_proofs::square::{off_box, plain};

use super::machine::Tip;
use super::{Play, Trouble};
use crate::job::Standing;
use crate::oracle;

/// Rounding of places in `f64`, and of nearest points, lattice units.
pub const ROUNDING: f64 = 4.0;
/// Largest distance of the tool from a cut point of a contour. The program finds reported positions within
/// 50 µm.
const CUT: f64 = 6_000.0;
/// Greatest height of the tool above the depth of a pass that counts as cut.
const CUT_HEIGHT: i64 = 2_000;
/// Number of sampled points on a retract move.
const PLACES: u32 = 16;
/// Number of sampled points on each curve of a completed contour. No curve of the plate is longer than 24
/// mm.
const PLACES_CUT: u32 = 96;

impl Play {
    /// Checks a command to the controller.
    pub(super) fn watch(&self, command: &Command, inside: bool) {
        let abilities = self.machine.abilities();
        match command {
            Command::Move(certified) => match certified.motion() {
                Motion::Jog { to, .. } if inside => self.watch_retract_move(*to),
                Motion::Jog { .. } => self.watch_set(),
                Motion::Contour { curve, heights, .. } => {
                    self.watch_contour(curve, heights[0].min(heights[1]))
                }
            },
            Command::Spindle { .. } if self.trouble != Trouble::FalseReplies => {
                let moves = self.machine.under_way().next();
                assert!(moves.is_none(), "the spindle is switched while {moves:?} is under way");
            }
            Command::Cancel(_) => assert!(abilities.cancels(), "the controller has no cancel"),
            _ => {}
        }
    }

    /// What stands above a tip at this height, lattice units.
    pub(super) fn standing(&self, tip: i64) -> Standing {
        Standing::above(self.heights.map(|_| tip))
    }

    /// The lowest tip that is certified for this height, lattice units.
    fn certified_tip(&self, height: Height) -> i64 {
        let tip =
            i64::from(height.units()) - i64::from(self.supervisor.guard().rules().heights.margin.units());
        let floor = self.heights.map_or(tip, |heights| heights.floor);
        assert!(tip >= floor, "a tip at {tip} is below the table at {floor}");
        tip
    }

    /// The walls above the tip that is certified for this height, as curves.
    fn walls(&self, height: Height) -> Vec<Curve> {
        let line = |(a, b)| Curve::Line(Segment { from: at(a), to: at(b) });
        self.standing(self.certified_tip(height)).walls().map(line).collect()
    }

    /// Checks that all motions that may be executed are clear of the part: each triangle of the in-flight
    /// set, or the whole box, by big integers over all edges.
    fn watch_set(&self) {
        let guard = self.supervisor.guard();
        let kept = i64::from(guard.rules().jogging_clearance.units()) - 1;
        let mut set: Vec<Xy> = guard.in_flight().map(plain).collect();
        if guard.rules().interpolation == Interpolation::Independent {
            set = corners(&set);
        }
        let Some(lowest) = guard.lowest() else { return };
        let standing = self.standing(self.certified_tip(lowest));
        for corners in triangles(&set) {
            let near = comes_near_to(&standing, corners, kept);
            assert!(!near, "{corners:?} of what may be executed come nearer than {kept}");
        }
    }

    /// Checks a retract move: it does not lower the tool, and comes nearer to no edge within the jogging clearance.
    /// Non-interpolated axes move one at a time.
    fn watch_retract_move(&self, to: Place) {
        let guard = self.supervisor.guard();
        let confirmed = guard.confirmed().expect("it stands inside").place();
        assert!(to.height >= confirmed.height, "a retract move from {confirmed:?} lowers the tool to {to:?}");
        let walls = self.walls(confirmed.height);
        let (from, to) = (confirmed.point, to.point);
        let straight =
            guard.rules().interpolation == Interpolation::Linear || from.x == to.x || from.y == to.y;
        assert!(straight, "a retract move from {from:?} to {to:?} is not along an axis");
        let (a, b, manual) = (xy(from), xy(to), f64::from(guard.rules().jogging_clearance.units()));
        for wall in &walls {
            let least = oracle::distance(a, [wall].into_iter()).min(manual);
            for k in 1..=PLACES {
                let t = f64::from(k) / f64::from(PLACES);
                let left = oracle::distance(oracle::on_the_way(a, b, t), [wall].into_iter());
                assert!(
                    left > least - ROUNDING,
                    "a retract move from {from:?} to {to:?} comes to {left} of {wall:?}"
                );
            }
        }
    }

    fn watch_contour(&self, curve: &Curve, lowest: Height) {
        let rules = self.supervisor.guard().rules();
        let kept = f64::from(rules.finishing_clearance.units()) - ROUNDING;
        let mut places = oracle::places(curve);
        if rules.contours == Interpolation::Independent {
            assert!(matches!(curve, Curve::Line(_)), "axes that run apart drive no arc");
            let (a, b) = (xy(curve.from()), xy(curve.to()));
            places.extend([a, b, (a.0, b.1), (b.0, a.1)]);
        }
        keep_away(curve, &places, kept, &self.walls(lowest));
        let standing = self.standing(self.certified_tip(lowest));
        let inside = [curve.from(), curve.to()].into_iter().find(|&at| standing.holds(plain(at)));
        assert!(inside.is_none(), "{curve:?} of a contour comes to {inside:?}, inside what stands");
    }

    /// Checks that the tool and the targets in transit are in the hull of the guard's in-flight set.
    pub(super) fn watch_hull(&self) {
        let guard = self.supervisor.guard();
        let by_hand = matches!(self.supervisor.phase(), Phase::Manual | Phase::Sliding | Phase::Retracting);
        let contour = self.machine.under_way().any(|motion| matches!(motion, Motion::Contour { .. }));
        if !by_hand || contour || guard.confirmed().is_none() {
            return;
        }
        let set: Vec<Xy> = guard.in_flight().map(plain).collect();
        let is_in = |place: Xy, r: i64| match guard.rules().interpolation {
            Interpolation::Linear => triangles(&set).any(|corners| comes_near(corners, place, place, r)),
            Interpolation::Independent => off_box(&set, place) <= r,
        };
        let (tool, most) = (self.machine.tool, 3 * i64::from(guard.rules().resolution.units()) + 4);
        assert!(is_in(tool.at, most), "the tool is more than {most} off {set:?}, at {tool:?}");
        let lowest = guard.lowest().map_or(i64::MAX, |lowest| lowest.units().into());
        let sunk = 3 * i64::from(guard.rules().heights.resolution.units()) + 4;
        assert!(tool.height >= lowest - sunk, "the tool is at {tool:?}, more than {sunk} below {lowest}");
        for motion in self.machine.under_way() {
            if let Motion::Jog { to, .. } = motion {
                assert!(is_in(plain(to.point), 4), "{to:?} is under way, and not in {set:?}");
                assert!(
                    i64::from(to.height.units()) >= lowest,
                    "{to:?} is under way, and lower than {lowest}"
                );
            }
        }
    }

    /// Checks that the tool was at the resume point. The supervisor does not accept one false report, but
    /// it accepts several consistent ones.
    pub(super) fn watch_cut(&mut self) {
        if self.trouble == Trouble::FalseReplies
            || !matches!(self.supervisor.phase(), Phase::Contouring | Phase::Holding)
        {
            return;
        }
        let progress = self.supervisor.progress();
        let resume_point = progress.partial.first().map(|partial| (partial.number, partial.resume_point));
        if resume_point != self.resume_point {
            self.resume_point = resume_point;
            resume_point.into_iter().for_each(|(number, point)| self.has_cut(number, xy(point)));
        }
    }

    /// Checks that the tool was at every point of the completed contours.
    pub(super) fn watch_progress(&self) {
        let progress = self.supervisor.progress();
        if self.trouble == Trouble::FalseReplies {
            return;
        }
        let plan = &self.work.plan.plan;
        let places = |number: LoopNumber| -> Vec<oracle::Xy> {
            let curves = &plan.passes[number.pass].path.loops[number.index].curves;
            curves.iter().flat_map(|curve| oracle::places_along(curve, PLACES_CUT)).collect()
        };
        for &number in &progress.finished {
            places(number).into_iter().for_each(|place| self.has_cut(number, place));
        }
        for partial in &progress.partial {
            let places = places(partial.number);
            let nearest = |to: Point| {
                let away = |k: &usize| oracle::between(places[*k], xy(to));
                (0..places.len()).min_by(|a, b| away(a).total_cmp(&away(b))).expect("a loop has places")
            };
            // From the point after the entry to the point before the end.
            let (entry, resume_point) = (nearest(partial.entry), nearest(partial.resume_point));
            let count = (resume_point + places.len() - entry) % places.len();
            let whole = partial.entry == partial.resume_point;
            let count = if whole { places.len() } else { count };
            for k in 1..count {
                self.has_cut(partial.number, places[(entry + k) % places.len()]);
            }
        }
    }

    /// Checks that the tool was at a point of a loop, at the depth of its pass.
    fn has_cut(&self, number: LoopNumber, place: oracle::Xy) {
        let real = |tip: Tip| xy(at(tip.at));
        let pass = i64::from(self.work.plan.plan.passes[number.pass].height.units());
        let deep = |[a, b]: &&[Tip; 2]| a.height.max(b.height) <= pass + CUT_HEIGHT;
        let away = self.cut.iter().filter(deep).map(|&[a, b]| oracle::to_chord(place, (real(a), real(b))));
        let away = away.fold(f64::INFINITY, f64::min);
        assert!(away < CUT, "{place:?} counts as cut, and the tool was {away} from it at the nearest");
    }
}

/// Checks that points of a contour's motion are farther from the walls than `kept`.
pub fn keep_away(curve: &Curve, places: &[oracle::Xy], kept: f64, walls: &[Curve]) {
    for &place in places {
        let left = oracle::distance(place, walls.iter());
        assert!(left > kept, "{curve:?} of a contour comes to {left}, not {kept}");
    }
}

/// The ends of the part's edges.
pub fn ends_of_edges(part: &ProhibitedRegion) -> Vec<(Xy, Xy)> {
    part.edges().iter().map(|edge| (plain(edge.chord.from), plain(edge.chord.to))).collect()
}

/// The corners of the smallest box around the points.
fn corners(points: &[Xy]) -> Vec<Xy> {
    let ends = |of: fn(&Xy) -> i64| points.iter().map(of).min().zip(points.iter().map(of).max());
    let (Some((x0, x1)), Some((y0, y1))) = (ends(|p| p.0), ends(|p| p.1)) else { return Vec::new() };
    vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
}

/// All triangles of the points, also flat ones. Together they are the convex hull.
pub fn triangles(set: &[Xy]) -> impl Iterator<Item = [Xy; 3]> {
    let from = |i: usize| set[i..].iter().enumerate().map(move |(k, &point)| (i + k, point));
    from(0).flat_map(move |(i, a)| from(i).flat_map(move |(j, b)| set[j..].iter().map(move |&c| [a, b, c])))
}

/// Whether the triangle comes so near to what stands, or lies in it.
pub fn comes_near_to(standing: &Standing, corners: [Xy; 3], r: i64) -> bool {
    standing.holds(corners[0]) || standing.walls().any(|(d, e)| comes_near(corners, d, e, r))
}

/// Whether the triangle comes so near to the segment from `d` to `e`, by big integers where floats are in
/// doubt.
pub fn comes_near([a, b, c]: [Xy; 3], d: Xy, e: Xy, r: i64) -> bool {
    if b == c { segments_within(a, b, d, e, r) } else { triangle_within([a, b, c], d, e, r) }
}
