//! TRUSTED. Contours: certified whole, and handed out one by one. Implements SR-09, SR-12, SR-13, SR-15.

use alloc::vec::Vec;

use keepout_kernel::exact::segment::{Orientation, Window, orientation, points_within};
use keepout_kernel::offset::{Gouge, GougeCause, certify_path, shortest_arc};
use keepout_kernel::{Arc, Curve, FreePoint, Height, Length, Place, Point, Turn};

use crate::evidence::Evidence;
use crate::in_flight::{BELIEVED, BEYOND, at_level};
use crate::{Certified, FreePlace, Guard, HeightRules, Interpolation, Motion, Refusal, clear_box};

/// A motion of a contour, as the controller gets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourMotion {
    /// The line or arc. A line of length zero is a plunge or a rise.
    pub curve: Curve,
    /// The heights at its start and at its end. The height changes evenly along the curve.
    pub heights: [Height; 2],
    /// The feed, mm/min.
    pub feed_mm_min: u32,
}

impl ContourMotion {
    /// A motion at height zero: of a machine with two axes.
    #[must_use]
    pub const fn in_plane(curve: Curve, feed_mm_min: u32) -> Self {
        Self { curve, heights: [Height::ZERO; 2], feed_mm_min }
    }

    /// The start.
    #[must_use]
    pub fn from(&self) -> Place {
        self.curve.from().at_height(self.heights[0])
    }

    /// The end.
    #[must_use]
    pub fn to(&self) -> Place {
        self.curve.to().at_height(self.heights[1])
    }

    /// The lower of its two heights: no point of the motion is lower.
    #[must_use]
    pub fn lowest(&self) -> Height {
        self.heights[0].min(self.heights[1])
    }

    /// Whether a report gives a height of this motion, to `count` resolutions.
    fn passes(&self, height: Height, rules: &HeightRules, count: i64) -> bool {
        let nearest = height.clamp(self.lowest(), self.heights[0].max(self.heights[1]));
        rules.agree(height, nearest, count)
    }
}

/// A contour that the guard certifies and then hands out.
#[derive(Clone, Debug)]
pub(crate) struct Contour {
    motions: Vec<ContourMotion>,
    /// Number of certified motions, from the first.
    certified: usize,
    /// End of the certified motions.
    reached: FreePlace,
    /// Number of motions handed out.
    sent: usize,
    /// Index of the first motion on which the tool can still be.
    first: usize,
    /// Number of reports in a row that show the tool at rest at the end of the contour.
    rests_seen: u8,
    /// Number of reports in a row that show the tool at rest short of the end of the last motion sent.
    stops_seen: u8,
}

impl Contour {
    /// The changing parts of the contour, except the end of the certified motions.
    pub(crate) fn counts(&self) -> ContourCounts {
        ([self.certified, self.sent, self.first], [self.rests_seen, self.stops_seen])
    }

    pub(crate) fn end(&self) -> FreePlace {
        self.reached
    }
}

/// Counters of a contour: motions certified, motions sent, and the first motion on which the tool can be.
/// Then the reports at rest at its end, and short of the end of the last motion sent.
pub(crate) type ContourCounts = ([usize; 3], [u8; 2]);

/// Progress of the certification of a contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certification {
    /// The certification is not complete.
    Under {
        /// Number of certified motions.
        done: usize,
        /// Number of all motions.
        all: usize,
    },
    /// All motions are certified: the contour can run.
    Done,
}

impl Guard {
    /// Takes a contour. It begins where the tool is at rest, to the resolution.
    ///
    /// [`Guard::certify_contour`] must certify the whole contour before the guard hands out its first motion.
    ///
    /// # Errors
    /// [`Refusal`] with the reason. The guard then takes no contour.
    pub fn begin_contour(&mut self, motions: Vec<ContourMotion>) -> Result<(), Refusal> {
        if !self.in_position() {
            return Err(Refusal::InMotion);
        }
        let confirmed = self.set.confirmed.ok_or(Refusal::PositionUnknown)?;
        let Some(first) = motions.first().map(ContourMotion::from) else {
            return Err(Refusal::PositionUnknown);
        };
        let near = !points_within(first.point, confirmed.point(), self.rules.resolution).is_clear()
            && self.rules.heights.agree(first.height, confirmed.height, 1);
        if !near {
            return Err(Refusal::OffCertified(first.point));
        }
        let part = self.exact.at(self.rules.heights.certified_for(first.height));
        let free = part.free_point(first.point, self.rules.finishing_clearance).map_err(Refusal::Blocked)?;
        let reached = FreePlace { free, height: first.height };
        self.contour =
            Some(Contour { motions, certified: 0, reached, sent: 0, first: 0, rests_seen: 0, stops_seen: 0 });
        Ok(())
    }

    /// Certifies up to `count` more motions of the contour. The contour must end outside the jogging
    /// clearance.
    ///
    /// # Errors
    /// [`Refusal`] with the motion or point that is not clear. The guard then drops the contour, before it
    /// has handed out a motion of it.
    pub fn certify_contour(&mut self, count: usize) -> Result<Certification, Refusal> {
        let Some(mut contour) = self.contour.take() else { return Err(Refusal::PositionUnknown) };
        let all = contour.motions.len();
        for index in contour.certified..all.min(contour.certified.saturating_add(count)) {
            let motion = contour.motions[index];
            contour.reached = self.certify_motion(index, &motion, contour.reached)?;
            contour.certified = index + 1;
        }
        let certified = contour.certified;
        let answer = if certified < all {
            Certification::Under { done: certified, all }
        } else {
            let Place { point, height } = contour.reached.place();
            let part = self.simplified.at(self.rules.heights.certified_for(height));
            let free = part.free_point(point, self.rules.jogging_clearance).map_err(Refusal::Blocked)?;
            contour.reached = FreePlace { free, height };
            Certification::Done
        };
        self.contour = Some(contour);
        Ok(answer)
    }

    /// Certifies a motion against everything that stands above its lowest height.
    fn certify_motion(
        &self,
        index: usize,
        motion: &ContourMotion,
        from: FreePlace,
    ) -> Result<FreePlace, Refusal> {
        let curve = &motion.curve;
        if motion.from() != from.place() {
            let gouge = Gouge { index, at: from.point(), cause: GougeCause::Discontinuous };
            return Err(Refusal::Gouge(gouge));
        }
        self.within_travel(curve)?;
        if let Some(&height) = motion.heights.iter().find(|&&height| !self.rules.heights.permit(height)) {
            return Err(Refusal::HeightLimit(height));
        }
        let part = self.exact.at(self.rules.heights.certified_for(motion.lowest()));
        match (self.rules.contours, curve) {
            (Interpolation::Linear, Curve::Arc(arc)) if is_too_short(arc) => {
                return Err(Refusal::ArcTooShort(arc.from()));
            }
            (Interpolation::Linear, Curve::Arc(arc)) if is_too_long(arc) => {
                return Err(Refusal::ArcTooLong(arc.from()));
            }
            (Interpolation::Linear, _) => {}
            (Interpolation::Independent, Curve::Arc(arc)) => return Err(Refusal::Slanted(arc.from())),
            (Interpolation::Independent, Curve::Line(line)) => {
                let window = Window::of(line.from).including(line.to);
                let start = at_level(part, from.free).map_err(Refusal::Blocked)?;
                clear_box(part, start, window).map_err(Refusal::Blocked)?;
            }
        }
        let end = certify_path(part, self.rules.finishing_clearance, core::slice::from_ref(curve));
        let end = end.map_err(|gouge| Refusal::Gouge(Gouge { index, ..gouge }))?;
        let free = end.and_then(|end: FreePoint| end.lowered(self.rules.finishing_clearance));
        let height = motion.heights[1];
        free.map(|free| FreePlace { free, height }).ok_or(Refusal::PositionUnknown)
    }

    fn within_travel(&self, curve: &Curve) -> Result<(), Refusal> {
        let travel = self.rules.travel;
        let beyond = |point: Point| (!travel.holds(point)).then_some(Refusal::SoftLimit(point));
        let inside = match curve {
            Curve::Line(_) => None,
            Curve::Arc(arc) => match curve.chord_points(Length::small(200)) {
                // The ends of the chords of an arc must lie in the travel. The chords leave the arc by at
                // most 2 µm.
                Ok(points) => points.into_iter().find_map(beyond),
                Err(_) => Some(Refusal::SoftLimit(arc.from())),
            },
        };
        [curve.from(), curve.to()].into_iter().find_map(beyond).or(inside).map_or(Ok(()), Err)
    }

    /// Whether the last report showed the tool at rest short of the end of the last motion sent.
    pub(crate) fn has_stopped_early(&self) -> bool {
        self.contour.as_ref().is_some_and(|contour| contour.stops_seen > 0)
    }

    /// The next motion of the contour, counted as sent. `None` until the controller has acknowledged and read
    /// the motion before it.
    ///
    /// A contour is never held or cancelled. It stops when the supervisor requests no more motions.
    pub fn next_of_contour(&mut self) -> Option<Certified> {
        let waits = self.unacknowledged() > 0 || self.unread() > 0 || self.has_stopped_early();
        if waits {
            return None;
        }
        let contour = self.contour.as_mut()?;
        if contour.certified < contour.motions.len() {
            return None;
        }
        let &ContourMotion { curve, heights, feed_mm_min } = contour.motions.get(contour.sent)?;
        contour.sent += 1;
        contour.rests_seen = 0;
        self.sent += 1;
        self.set.moving();
        Some(Certified { motion: Motion::Contour { curve, heights, feed_mm_min } })
    }

    /// Number of motions of the contour that were sent, and number of all its motions.
    #[must_use]
    pub fn contour_progress(&self) -> Option<(usize, usize)> {
        self.contour.as_ref().map(|contour| (contour.sent, contour.motions.len()))
    }

    /// Index of the first motion of the contour on which the tool can still be.
    #[must_use]
    pub fn contour_at(&self) -> Option<usize> {
        self.contour.as_ref().map(|contour| contour.first)
    }

    /// The motions of the contour whose execution is not certain, from the motion under way on.
    #[must_use]
    pub fn contour_left(&self) -> &[ContourMotion] {
        self.contour.as_ref().map_or(&[], |contour| contour.motions.get(contour.first..).unwrap_or(&[]))
    }

    /// Takes a report while the machine executes the contour.
    pub(crate) fn reported_in_contour(&mut self, evidence: &Evidence<'_>) -> Result<(), Refusal> {
        let feedback = evidence.feedback;
        let (resolution, interpolation) = (self.rules.resolution, self.rules.contours);
        let (heights, Place { point, height }) = (self.rules.heights, feedback.position);
        let Some(contour) = self.contour.as_mut() else { return Ok(()) };
        if contour.sent == 0 {
            return Ok(());
        }
        // The first motion begins where the tool was reported at rest, so its tolerance is larger. Each other
        // motion begins where the motion before it ended.
        let tolerance = |k: usize| if k == 0 { self.set.resolutions(BELIEVED) } else { resolution };
        let on = (contour.first..contour.sent).find(|&k| {
            let motion = &contour.motions[k];
            lies_on(point, &motion.curve, tolerance(k), interpolation)
                && motion.passes(height, &heights, if k == 0 { BELIEVED } else { 1 })
        });
        contour.first = on.ok_or(Refusal::OffCertified(point))?;
        let rests = evidence.rests();
        let reached = contour.motions.get(contour.sent - 1).is_some_and(|motion| {
            !points_within(motion.curve.to(), point, self.set.resolutions(BEYOND)).is_clear()
                && heights.agree(motion.heights[1], height, BEYOND)
        });
        contour.stops_seen = if rests && !reached { contour.stops_seen.saturating_add(1) } else { 0 };
        if contour.stops_seen >= 2 {
            return Err(Refusal::Dropped(point));
        }
        let done = contour.sent == contour.motions.len();
        let arrived = !points_within(contour.reached.point(), point, resolution).is_clear()
            && heights.agree(contour.reached.height, height, 1);
        if !(rests && done && arrived) {
            contour.rests_seen = 0;
            return Ok(());
        }
        contour.rests_seen += 1;
        if self.set.checked || contour.rests_seen >= 2 {
            let end = contour.reached;
            self.contour = None;
            self.set.place(Some(end));
        }
        Ok(())
    }

    /// Drops a contour if the guard has handed out no motion of it.
    pub fn withdraw_contour(&mut self) {
        self.contour = self.contour.take().filter(|contour| contour.sent > 0);
    }
}

/// Whether the ends of an arc are too near each other. A controller that computes in 32-bit floats can then
/// mistake the sweep for a full turn. GRBL adds a turn when the computed angle is below 5e-7.
fn is_too_short(arc: &Arc) -> bool {
    !points_within(arc.from(), arc.to(), shortest_arc(arc.radius())).is_clear()
}

/// Whether an arc turns by more than about a quarter circle: 97°, where the cosine is −1/8.
fn is_too_long(arc: &Arc) -> bool {
    let (c, from, to) = (arc.centre(), arc.from(), arc.to());
    let ahead = if arc.turn() == Turn::CounterClockwise { Orientation::Left } else { Orientation::Right };
    let (a, b) = (from.minus(c), to.minus(c));
    let product = |p: i32, q: i32| i128::from(p) * i128::from(q);
    let cosine = product(a.dx, b.dx) + product(a.dy, b.dy);
    let radius_2 = product(arc.radius().units(), arc.radius().units());
    orientation(c, from, to) != ahead || 8 * cosine < -radius_2
}

/// Greatest distance of a controller's chords from an arc, lattice units (2 µm).
const CHORDED: Length = Length::small(200);

/// Whether the tool can be at `p` while it follows the curve, to `tolerance`. The tool is then on the curve,
/// or in its certified box with non-interpolated axes. A controller may drive an arc as chords within 2 µm.
fn lies_on(p: Point, curve: &Curve, tolerance: Length, interpolation: Interpolation) -> bool {
    match curve {
        Curve::Line(line) if interpolation == Interpolation::Independent => {
            Window::of(line.from).including(line.to).grown(tolerance).holds(p)
        }
        Curve::Line(line) => !line.near_point(p, tolerance).is_clear(),
        Curve::Arc(arc) => lies_on_arc(p, arc, tolerance.saturating_plus(CHORDED)),
    }
}

fn lies_on_arc(p: Point, arc: &Arc, reach: Length) -> bool {
    let near = |q: Point| !points_within(p, q, reach).is_clear();
    if near(arc.from()) || near(arc.to()) {
        return true;
    }
    let radius = i64::from(arc.radius().units());
    let within = |r: i64| Length::from_units(r).is_ok_and(|r| !points_within(p, arc.centre(), r).is_clear());
    let ring =
        within(radius + i64::from(reach.units()) + 1) && !within(radius - i64::from(reach.units()) - 1);
    ring && in_wedge(p, arc)
}

/// Whether `p` lies in the sector between the centre and the arc.
fn in_wedge(p: Point, arc: &Arc) -> bool {
    let (c, from, to) = (arc.centre(), arc.from(), arc.to());
    let (first, last) = if arc.turn() == Turn::CounterClockwise { (from, to) } else { (to, from) };
    // Counter-clockwise from `first` to `last`.
    let after_first = orientation(c, first, p) != Orientation::Right;
    let before_last = orientation(c, last, p) != Orientation::Left;
    match orientation(c, first, last) {
        Orientation::Left => after_first && before_last,
        _ => after_first || before_last,
    }
}

#[cfg(test)]
mod tests {
    use keepout_kernel::Segment;

    use super::*;

    #[test]
    fn only_points_near_an_arc_lie_on_it() {
        let at = |x, y| Point::from_units(x, y).unwrap();
        let three_quarters =
            Arc::new(at(100_000, 0), at(0, -100_000), at(0, 0), Turn::CounterClockwise).unwrap();
        let quarter = Arc::new(at(0, 100_000), at(100_000, 0), at(0, 0), Turn::Clockwise).unwrap();
        let tolerance = Length::small(10);
        for (point, long, short) in [
            (at(70_710, 70_710), true, true),
            (at(-70_710, 70_710), true, false),
            (at(70_710, -70_710), false, false),
            (at(100_000, 0), true, true),
            (at(50_000, 50_000), false, false),
            (at(0, 100_150), true, true),
        ] {
            assert_eq!(
                lies_on_arc(point, &three_quarters, tolerance.saturating_plus(CHORDED)),
                long,
                "{point:?}"
            );
            assert_eq!(lies_on_arc(point, &quarter, tolerance.saturating_plus(CHORDED)), short, "{point:?}");
        }
        let line = Curve::Line(Segment { from: at(0, 0), to: at(100, 0) });
        let on = |p, interpolation| lies_on(p, &line, tolerance, interpolation);
        assert!(on(at(50, 10), Interpolation::Linear) && !on(at(50, 11), Interpolation::Linear));
        let line = Curve::Line(Segment { from: at(0, 0), to: at(100, 60) });
        let on = |p, interpolation| lies_on(p, &line, tolerance, interpolation);
        assert!(on(at(99, -9), Interpolation::Independent) && !on(at(99, -9), Interpolation::Linear));
        assert!(!on(at(99, -11), Interpolation::Independent) && !on(at(111, 60), Interpolation::Independent));
    }
}
