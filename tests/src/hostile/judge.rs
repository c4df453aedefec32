//! The judge: knows the part and the tool, and decides exactly whether the tool was in the part.

use std::sync::Arc;

use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_kernel::{Length, Point, ProhibitedRegion, Segment, Vector};
use keepout_planner::units::point_from_mm;

/// What the tool must not do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The tool was in the part.
    Gouging {
        /// When.
        at: Time,
        /// Where its centre was, drawing coordinates.
        centre: Point,
    },
    /// Steered by hand, the tool came nearer than the roughing stock_to_leave.
    Allowance {
        /// When.
        at: Time,
        /// Where its centre was, drawing coordinates.
        centre: Point,
    },
}

/// Watches the true way of the tool: straight between one sample and the next.
///
/// The part's curves may leave their chords by the chord_error, which counts against the tool.
#[derive(Clone, Debug)]
pub struct Judge {
    part: Arc<ProhibitedRegion>,
    back: Vector,
    radius: Length,
    by_hand: Length,
    /// Beyond this the tool has left for certain, wherever the machine believes it is.
    outside: Length,
    last: Option<Point>,
    /// The tool stands nearer than the stock_to_leave already, and may leave.
    excused: bool,
    verdict: Option<Verdict>,
    /// Way of the tool, mm.
    way_mm: f64,
}

impl Judge {
    /// A judge for a tool of `radius`, which keeps `by_hand` while it is steered, once it was beyond `outside`; `part` is best
    /// prepared for these.
    #[must_use]
    pub fn new(
        part: Arc<ProhibitedRegion>,
        offset: Vector,
        radius: Length,
        (by_hand, outside): (Length, Length),
    ) -> Self {
        let back = Vector { dx: -offset.dx, dy: -offset.dy };
        Self { part, back, radius, by_hand, outside, last: None, excused: true, verdict: None, way_mm: 0.0 }
    }

    /// Watches the next true position.
    pub fn watch(&mut self, sample: &Sample) {
        let place = point_from_mm(sample.position_mm).and_then(|point| point.translated(self.back));
        let Ok(here) = place else {
            self.find(Verdict::Gouging { at: sample.at, centre: Point::ORIGIN });
            return;
        };
        let from = self.last.replace(here).unwrap_or(here);
        if from == here && self.way_mm > 0.0 {
            return;
        }
        let d = here.minus(from);
        self.way_mm += f64::from(d.dx).hypot(f64::from(d.dy)) / 1e5;
        let motion = Segment { from, to: here };
        if self.part.motion_clear(motion, self.by_hand).is_clear() {
            // A contour that ends between the two leaves a tool that may already be too near by the machine's own count: what it
            // goes from there is an retract, however much the machine slips.
            let outside = self.part.motion_clear(motion, self.outside).is_clear();
            self.excused = !outside && (self.excused || sample.kind == SampleKind::Run);
            return;
        }
        if !self.part.motion_clear(motion, self.radius).is_clear() || self.part.holds(here) {
            self.find(Verdict::Gouging { at: sample.at, centre: here });
        } else if sample.kind == SampleKind::Jog && !self.excused {
            self.find(Verdict::Allowance { at: sample.at, centre: here });
        } else {
            self.excused = true;
        }
    }

    fn find(&mut self, verdict: Verdict) {
        let worse = matches!(
            (self.verdict, verdict),
            (None, _) | (Some(Verdict::Allowance { .. }), Verdict::Gouging { .. })
        );
        if worse {
            self.verdict = Some(verdict);
        }
    }

    /// What was found.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    /// The way that the tool has gone, mm.
    #[must_use]
    pub fn way_mm(&self) -> f64 {
        self.way_mm
    }
}
