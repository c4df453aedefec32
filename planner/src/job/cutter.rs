//! Cuts along one loop: lead-in, the loop or its remaining contour, lead-out.

use keepout_kernel::curve::fit_arc;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, FreePoint, Point, Segment, UNITS_PER_MM, Vec2};

use super::progress::RemainingContour;
use super::track::{Entry, Joint, Track, length_mm};
use super::{Leg, LoopNumber};
use crate::Mm2;
use crate::plan::CertifiedPlan;
use crate::route::route;
use crate::units::{mm, point_mm};

/// Distance of an approach point outside the jogging clearance, mm.
pub(super) const STAND_OFF_MM: f64 = 0.05;
/// The tool enters a loop directly from its present place within this distance, in tool radii.
const BESIDE: f64 = 4.0;
/// Points of a loop that are tried for the lead-in.
pub(super) const TRIES: u32 = 64;
/// Radii that are tried for the arcs of lead-in and lead-out, as shares of the tool's radius.
const LEAD_SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.06];
/// Number of places along one tool radius of cut contour that are tried when the tool cannot enter or
/// leave an interrupted loop at its resume point or its entry.
const BACK_TRIES: u32 = 16;

/// Legs of one loop, with their result.
pub(super) struct LoopLegs {
    /// The link move to the loop, if any, and the cut.
    pub legs: Vec<Leg>,
    /// Place of the tool after the cut.
    pub end: FreePoint,
    /// Whether lead-in and lead-out are tangential to the contour.
    pub tangential: bool,
    /// Length of contour that is recut, mm.
    pub recut_mm: f64,
}

/// Planner of the cuts along one loop.
pub(super) struct Cutter<'a> {
    /// The plan.
    pub plan: &'a CertifiedPlan,
    /// The loop.
    pub number: LoopNumber,
    /// The loop in the direction of the cut.
    pub track: &'a Track,
    /// Window in which the tool's centre must stay.
    pub within: Window,
}

/// A lead-in or a lead-out.
struct Lead {
    curves: Vec<Curve>,
    tangential: bool,
}

impl Cutter<'_> {
    /// A cut once around the loop. The tool enters directly from `here` when that is near and clear, else
    /// from an approach point, else directly from farther away.
    pub fn whole(&self, here: FreePoint) -> Option<LoopLegs> {
        let (distance, touched) = self.track.nearest(here.point());
        let from_here = || {
            let (cut, tangential) = self.around(touched, here.point())?;
            Some(LoopLegs { legs: vec![cut], end: here, tangential, recut_mm: 0.0 })
        };
        // From farther away the job should not lead the tool back to its start.
        let beside = distance <= self.radius_mm() * BESIDE;
        if let Some(legs) = beside.then(from_here).flatten() {
            return Some(legs);
        }
        let share = self.track.length_mm() / f64::from(TRIES);
        let mut entries: Vec<Entry> = (0..TRIES).map(|k| self.track.at(f64::from(k) * share)).collect();
        let far = |entry: &Entry| entry.distance_mm(here.point());
        entries.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let by_approach = entries.iter().find_map(|entry| {
            let end = self.approach(entry)?;
            let (cut, tangential) = self.around(*entry, end.point())?;
            let legs = vec![self.link_move(here, end.point())?, cut];
            Some(LoopLegs { legs, end, tangential, recut_mm: 0.0 })
        });
        by_approach.or_else(from_here)
    }

    /// The cut along the remaining contour of an interrupted loop. Where the tool cannot enter or leave
    /// it exactly, the cut recuts up to one tool radius at that end.
    pub fn remaining(&self, here: FreePoint, remaining: &RemainingContour) -> Option<LoopLegs> {
        let (begin, end) = remaining.joints(self.track)?;
        let step = self.radius_mm() / f64::from(BACK_TRIES);
        let tries =
            || (0..=BACK_TRIES).map(|k| step * f64::from(k)).take_while(|tried| *tried < remaining.cut_mm());
        let entered = |back: f64| {
            let first = if back > 0.0 { remaining.joint_before(self.track, back)? } else { begin };
            Some((first, self.entered(here, &first)?))
        };
        let (first, (link, free, lead_in)) = tries().find_map(entered)?;
        let left = |beyond: f64| {
            let last = if beyond > 0.0 { remaining.joint_behind(self.track, beyond)? } else { end };
            Some((last, self.left(free, &last)?))
        };
        let (last, (free, lead_out)) = tries().find_map(left)?;
        let tangential = lead_in.tangential && lead_out.tangential;
        let (before, behind) = (self.again(&first, &begin)?, self.again(&end, &last)?);
        let remaining_curves = self.track.stretch(&begin, &end)?;
        let cut_mm: f64 = [&before, &remaining_curves, &behind].into_iter().flatten().map(length_mm).sum();
        let into: Vec<Curve> = lead_in.curves.into_iter().chain(before).collect();
        let out: Vec<Curve> = behind.into_iter().chain(lead_out.curves).collect();
        let cut = self.leg(into, remaining_curves, out, end.point);
        let certified = certify_path(&self.plan.part, self.plan.finishing, &cut.curves).is_ok();
        let legs = link.into_iter().chain([cut]).collect();
        let recut_mm = (cut_mm - remaining.left_mm()).max(0.0);
        certified.then_some(LoopLegs { legs, end: free, tangential, recut_mm })
    }

    fn radius_mm(&self) -> f64 {
        mm(self.plan.plan.tool_radius.units())
    }

    /// An approach point: a place beside the loop, outside the jogging clearance.
    fn approach(&self, entry: &Entry) -> Option<FreePoint> {
        let pass = &self.plan.plan.passes[self.number.pass];
        let left_by_roughing = self.plan.plan.stock_to_leave.units() - pass.stock_to_leave.units();
        let place = entry.aside(0.0, mm(left_by_roughing) + STAND_OFF_MM)?;
        self.plan.part.free_point(place, self.plan.roughing).ok().filter(|_| self.within.holds(place))
    }

    fn link_move(&self, here: FreePoint, to: Point) -> Option<Leg> {
        let points = route(self.plan, here, to, self.within)?;
        let starts = std::iter::once(here.point()).chain(points.iter().copied());
        let lines = starts.zip(&points).filter_map(|(from, &to)| line_between(from, to));
        Some(Leg { cuts: None, curves: lines.collect(), heights: Vec::new(), on_loop: 0..0, entry: None })
    }

    fn leg(&self, lead_in: Vec<Curve>, on_loop: Vec<Curve>, lead_out: Vec<Curve>, entry: Point) -> Leg {
        let range = lead_in.len()..lead_in.len() + on_loop.len();
        let curves = lead_in.into_iter().chain(on_loop).chain(lead_out).collect();
        Leg { cuts: Some(self.number), curves, heights: Vec::new(), on_loop: range, entry: Some(entry) }
    }

    /// The cut once around from the entry, with lead-in from `outside` and lead-out back to it, and
    /// whether both are tangential. `None` when no lead keeps the finishing clearance.
    fn around(&self, entry: Entry, outside: Point) -> Option<(Leg, bool)> {
        let at = self.track.joint(entry)?;
        let round = self.track.stretch(&at, &at)?;
        let (lead_in, lead_out) = (self.lead_in(&at, outside)?, self.lead_out(&at, outside)?);
        let tangential = lead_in.tangential && lead_out.tangential;
        Some((self.leg(lead_in.curves, round, lead_out.curves, at.point), tangential))
    }

    /// The contour that is recut between two places.
    fn again(&self, from: &Joint, to: &Joint) -> Option<Vec<Curve>> {
        if from.point == to.point { Some(Vec::new()) } else { self.track.stretch(from, to) }
    }

    /// Lead-in to a place on the track: directly from `here` when that is near, else from an approach
    /// point after a link move, else directly from far away.
    fn entered(&self, here: FreePoint, at: &Joint) -> Option<(Option<Leg>, FreePoint, Lead)> {
        let direct = || Some((None, here, self.lead_in(at, here.point())?));
        let beside = at.entry.distance_mm(here.point()) <= self.radius_mm() * BESIDE;
        let by_approach = || {
            let free = self.approach(&at.entry)?;
            let lead = self.lead_in(at, free.point())?;
            Some((Some(self.link_move(here, free.point())?), free, lead))
        };
        beside.then(direct).flatten().or_else(by_approach).or_else(direct)
    }

    /// Lead-out from a place on the track: to an approach point beside it, or back to `came_from`.
    fn left(&self, came_from: FreePoint, at: &Joint) -> Option<(FreePoint, Lead)> {
        let ends = self.approach(&at.entry).into_iter().chain([came_from]);
        ends.into_iter().find_map(|end| Some((end, self.lead_out(at, end.point())?)))
    }

    fn lead_in(&self, at: &Joint, outside: Point) -> Option<Lead> {
        let by_arc = |share: &f64| {
            let radius = self.radius_mm() * share;
            let begin = at.entry.aside(-radius, radius)?;
            let arc = fit_arc(begin, at.point, centre(at, radius)?, self.track.lead_turn()).ok()?;
            Some(line_between(outside, begin).into_iter().chain([Curve::Arc(arc)]).collect())
        };
        self.lead(LEAD_SHARES.iter().filter_map(by_arc), || line_between(outside, at.point))
    }

    fn lead_out(&self, at: &Joint, outside: Point) -> Option<Lead> {
        let by_arc = |share: &f64| {
            let radius = self.radius_mm() * share;
            let end = at.entry.aside(radius, radius)?;
            let arc = fit_arc(at.point, end, centre(at, radius)?, self.track.lead_turn()).ok()?;
            Some(std::iter::once(Curve::Arc(arc)).chain(line_between(end, outside)).collect())
        };
        self.lead(LEAD_SHARES.iter().filter_map(by_arc), || line_between(at.point, outside))
    }

    /// The first clear tangential lead, else the straight one.
    fn lead(
        &self,
        mut by_arc: impl Iterator<Item = Vec<Curve>>,
        straight: impl FnOnce() -> Option<Curve>,
    ) -> Option<Lead> {
        if let Some(curves) = by_arc.find(|curves| self.is_clear(curves)) {
            return Some(Lead { curves, tangential: true });
        }
        let curves: Vec<Curve> = straight().into_iter().collect();
        self.is_clear(&curves).then_some(Lead { curves, tangential: false })
    }

    /// Whether a lead keeps the finishing clearance. It cannot keep the jogging clearance, because one of
    /// its ends is on the toolpath.
    fn is_clear(&self, lead: &[Curve]) -> bool {
        let mut ends = lead.iter().flat_map(|curve| [curve.from(), curve.to()]);
        ends.all(|end| self.within.holds(end))
            && certify_path(&self.plan.part, self.plan.finishing, lead).is_ok()
    }
}

/// Centre of a quarter circle that touches the track on the tool's side, lattice units.
fn centre(at: &Joint, radius_mm: f64) -> Option<Vec2> {
    let Mm2 { x, y } = point_mm(at.entry.aside(0.0, radius_mm)?);
    Some(Vec2::new(x * f64::from(UNITS_PER_MM), y * f64::from(UNITS_PER_MM)))
}

fn line_between(from: Point, to: Point) -> Option<Curve> {
    (from != to).then_some(Curve::Line(Segment { from, to }))
}
