//! The collision monitor: it knows only the part and the tool, and decides exactly how deep the tool entered
//! the part.

use std::fmt;
use std::sync::Arc;

use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_kernel::{Length, Point, ProhibitedRegion, Segment, Vector};
use keepout_planner::units::{mm, point_from_mm};

/// The deepest gouge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gouging {
    /// Depth, mm.
    pub depth_mm: f64,
    /// Time of the sample.
    pub at: Time,
    /// The tool's centre, drawing coordinates.
    pub centre: Point,
}

/// The first thing that the tool must not do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The tool was in the part.
    Gouge {
        /// Time of the sample.
        at: Time,
        /// The tool's centre, drawing coordinates.
        centre: Point,
    },
    /// While jogging, the tool came nearer than the stock to leave.
    StockToLeave {
        /// Time of the sample.
        at: Time,
        /// The tool's centre, drawing coordinates.
        centre: Point,
    },
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Gouge { at, centre } | Self::StockToLeave { at, centre }) = self;
        let what = match self {
            Self::Gouge { .. } => "a gouge",
            Self::StockToLeave { .. } => "a jog in the stock to leave",
        };
        write!(f, "{what} at {centre}, {:.3} s", at.since(Time::ZERO).as_secs_f64())
    }
}

/// What the tool keeps while jogging.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoggingRule {
    /// The distance of the tool's centre from the part.
    pub clearance: Length,
    /// Beyond this distance the tool is outside for certain, wherever the machine believes it is.
    pub outside: Length,
}

/// Checks the true tool positions against the part. It assumes a straight motion between two positions.
///
/// The part's true curves may deviate from their chords by the chord-error bound. The monitor counts this
/// bound against the tool, so a result without a gouge is exact, and a depth is at most 0.1 µm too large.
///
/// Without a [`JoggingRule`] the monitor measures depths and distances. With one it decides by thresholds
/// alone, which is quick.
#[derive(Debug)]
pub struct CollisionMonitor {
    part: Arc<ProhibitedRegion>,
    radius: Length,
    offset: Vector,
    rule: Option<JoggingRule>,
    verdict: Option<Verdict>,
    /// The tool stands nearer than the rule permits for a reason, and may leave: a contour ended there, or the
    /// session began there.
    excused: bool,
    last: Option<Point>,
    way_mm: f64,
    inside: bool,
    /// The smallest distance so far between the tool's edge and the part, at most [`FAR`].
    closest: Length,
    closest_by_hand: Length,
    deepest: Option<Gouging>,
    cut: Vec<Vec<Point>>,
    watched: u64,
}

/// Largest measured distance between the tool's edge and the part, lattice units (5 mm). A sample farther
/// away costs one cheap query.
const FAR: i64 = 500_000;
/// Largest measured depth inside the part, lattice units (5.3 m).
const DEEP: i64 = 1 << 29;

impl CollisionMonitor {
    /// A monitor for a tool of `radius` at a part placed at `offset` on the machine.
    #[must_use]
    pub fn new(part: impl Into<Arc<ProhibitedRegion>>, radius: Length, offset: Vector) -> Self {
        let closest = Length::from_units(FAR).unwrap_or(Length::ZERO);
        Self {
            part: part.into(),
            radius,
            offset,
            rule: None,
            verdict: None,
            excused: true,
            way_mm: 0.0,
            last: None,
            inside: false,
            closest,
            closest_by_hand: closest,
            deepest: None,
            cut: Vec::new(),
            watched: 0,
        }
    }

    /// Checks the next true position.
    pub fn watch(&mut self, sample: &Sample) {
        let back = Vector { dx: -self.offset.dx, dy: -self.offset.dy };
        let here = point_from_mm(sample.position_mm).and_then(|point| point.translated(back));
        let Ok(here) = here else {
            // A position off the lattice counts as a gouge.
            self.deepest = Some(Gouging { depth_mm: f64::INFINITY, at: sample.at, centre: Point::ORIGIN });
            self.find(Verdict::Gouge { at: sample.at, centre: Point::ORIGIN });
            return;
        };
        self.watched += 1;
        let from = self.last.replace(here).unwrap_or(here);
        let motion = Segment { from, to: here };
        let step = here.minus(from);
        self.way_mm += mm(step.dx).hypot(mm(step.dy));
        match self.rule {
            Some(_) if from == here && self.watched > 1 => {}
            Some(rule) => self.decide(rule, motion, sample),
            None => self.measure(motion, sample),
        }
    }

    /// The same monitor, which decides by thresholds whether jogs keep the rule. The part is best prepared for
    /// the distances of the rule.
    #[must_use]
    pub fn with_rule(self, rule: JoggingRule) -> Self {
        Self { rule: Some(rule), ..self }
    }

    fn decide(&mut self, rule: JoggingRule, motion: Segment, sample: &Sample) {
        let (at, centre) = (sample.at, motion.to);
        if self.part.motion_clear(motion, rule.clearance).is_clear() {
            // A contour can end between the two distances. Then the tool may already be too near by the
            // machine's own count, and its next motion is a retract move, however large the positioning error.
            let outside = self.part.motion_clear(motion, rule.outside).is_clear();
            self.excused = !outside && (self.excused || sample.kind == SampleKind::Run);
        } else if !self.part.motion_clear(motion, self.radius).is_clear() || self.part.holds(centre) {
            self.find(Verdict::Gouge { at, centre });
        } else if sample.kind == SampleKind::Jog && !self.excused {
            self.find(Verdict::StockToLeave { at, centre });
        } else {
            self.excused = true;
        }
    }

    /// Keeps the first verdict; a gouge replaces another verdict.
    fn find(&mut self, verdict: Verdict) {
        let gouge = matches!(verdict, Verdict::Gouge { .. });
        if self.verdict.is_none_or(|known| gouge && !matches!(known, Verdict::Gouge { .. })) {
            self.verdict = Some(verdict);
        }
    }

    fn measure(&mut self, motion: Segment, sample: &Sample) {
        // `look` detects a crossing between two samples. At the start, and after a crossing, this tests whether
        // the tool is inside.
        if self.inside || self.watched == 1 {
            self.inside = self.part.holds(motion.to);
        }
        self.look(motion, sample.at);
        if sample.kind == SampleKind::Jog {
            self.closest_by_hand = self.nearer(motion, self.closest_by_hand);
        }
        self.remember_cut(sample.kind, motion.from, motion.to);
    }

    /// The smaller of `known` and the distance between the tool's edge and the part on this motion.
    fn nearer(&self, motion: Segment, known: Length) -> Length {
        let clear = |r: Length| self.part.edges_clear(motion, r).is_ok();
        if clear(self.radius.saturating_plus(known)) {
            return known;
        }
        let reach = i64::from(self.radius.units()) + i64::from(known.units());
        let beyond = i64::from(largest_clear(reach + 1, clear)) - i64::from(self.radius.units());
        Length::from_units(beyond.max(0)).unwrap_or(Length::ZERO).min(known)
    }

    fn look(&mut self, motion: Segment, at: Time) {
        let clear = |r: Length| self.part.edges_clear(motion, r).is_ok();
        if !self.inside && clear(self.radius.saturating_plus(self.closest)) {
            return;
        }
        let reach = i64::from(self.radius.units()) + i64::from(self.closest.units());
        let distance = largest_clear(reach + 1, clear);
        let beyond = i64::from(distance) - i64::from(self.radius.units());
        if !self.inside && beyond >= 0 {
            self.closest = Length::from_units(beyond).unwrap_or(Length::ZERO).min(self.closest);
            return;
        }
        self.closest = Length::ZERO;
        let crossed = self.inside || self.part.holds(motion.to);
        let depth_mm = if crossed {
            let here = Segment { from: motion.to, to: motion.to };
            let within = largest_clear(DEEP, |r| self.part.edges_clear(here, r).is_ok());
            mm(self.radius.units()) + mm(within.max(0))
        } else {
            -mm(i32::try_from(beyond).unwrap_or(0))
        };
        self.inside = self.part.holds(motion.to);
        if self.deepest.is_none_or(|deepest| depth_mm > deepest.depth_mm) {
            self.deepest = Some(Gouging { depth_mm, at, centre: motion.to });
        }
    }

    fn remember_cut(&mut self, kind: SampleKind, from: Point, here: Point) {
        if kind != SampleKind::Run {
            if self.cut.last().is_none_or(|path| !path.is_empty()) {
                self.cut.push(Vec::new());
            }
            return;
        }
        if self.cut.is_empty() {
            self.cut.push(Vec::new());
        }
        let Some(path) = self.cut.last_mut() else { return };
        if path.is_empty() {
            path.push(from);
        }
        if path.last() != Some(&here) {
            path.push(here);
        }
    }

    /// The deepest gouge, if there was one.
    #[must_use]
    pub fn deepest(&self) -> Option<Gouging> {
        self.deepest
    }

    /// The smallest distance between the tool's edge and the part, mm; zero after a gouge, `None` beyond 5
    /// mm.
    #[must_use]
    pub fn closest_mm(&self) -> Option<f64> {
        (i64::from(self.closest.units()) < FAR).then(|| mm(self.closest.units()))
    }

    /// The smallest distance between the tool's edge and the part while jogging, mm; `None` beyond 5 mm.
    #[must_use]
    pub fn closest_by_hand_mm(&self) -> Option<f64> {
        (i64::from(self.closest_by_hand.units()) < FAR).then(|| mm(self.closest_by_hand.units()))
    }

    /// The paths of the tool's centre in programmed motions, one path for each run.
    pub fn cut_paths(&self) -> impl Iterator<Item = &[Point]> + '_ {
        self.cut.iter().filter(|path| path.len() > 1).map(Vec::as_slice)
    }

    /// The verdict under a [`JoggingRule`].
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    /// The way that the tool has gone, mm.
    #[must_use]
    pub fn way_mm(&self) -> f64 {
        self.way_mm
    }

    /// The number of checked positions.
    #[must_use]
    pub fn watched(&self) -> u64 {
        self.watched
    }
}

/// The largest length in lattice units, up to `most`, for which `clear` holds; −1 if it does not hold even
/// for zero.
fn largest_clear(most: i64, clear: impl Fn(Length) -> bool) -> i32 {
    let holds = |units: i64| Length::from_units(units).is_ok_and(&clear);
    let (mut low, mut high) = (-1_i64, most);
    while high - low > 1 {
        let middle = i64::midpoint(low, high);
        if holds(middle) { low = middle } else { high = middle }
    }
    i32::try_from(low).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use keepout_kernel::{Region, Ring, Side};
    use keepout_planner::Mm2;

    use super::*;

    fn monitor() -> CollisionMonitor {
        let at = |x, y| point_from_mm(Mm2::new(x, y)).unwrap();
        let ring = Ring::new(vec![at(0.0, 0.0), at(40.0, 0.0), at(40.0, 30.0), at(0.0, 30.0)]).unwrap();
        let part = ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap();
        CollisionMonitor::new(part, Length::from_units(300_000).unwrap(), Vector { dx: 0, dy: 0 })
    }

    fn at(x: f64, y: f64) -> Sample {
        Sample { at: Time::ZERO, position_mm: Mm2::new(x, y), kind: SampleKind::Jog }
    }

    #[test]
    fn contact_is_found_to_a_lattice_unit() {
        let mut monitor = monitor();
        [at(-10.0, 10.0), at(-3.000_02, 10.0)].iter().for_each(|sample| monitor.watch(sample));
        assert_eq!(monitor.deepest(), None);
        assert_eq!(monitor.closest_mm(), Some(0.000_01), "a distance equal to the threshold is not clear");
        monitor.watch(&at(-2.999, 12.0));
        let depth = monitor.deepest().unwrap().depth_mm;
        assert!((depth - 0.001).abs() < 2e-5, "{depth}");
    }

    #[test]
    fn crossing_between_samples_is_a_gouge() {
        let mut monitor = monitor();
        [at(-10.0, 15.0), at(50.0, 15.0)].iter().for_each(|sample| monitor.watch(sample));
        assert!(monitor.deepest().unwrap().depth_mm >= 3.0);
    }

    #[test]
    fn depth_inside_the_part_adds_the_radius() {
        let mut monitor = monitor();
        [at(-10.0, 15.0), at(1.0, 15.0), at(10.0, 15.0)].iter().for_each(|sample| monitor.watch(sample));
        let depth = monitor.deepest().unwrap().depth_mm;
        assert!((depth - 13.0).abs() < 1e-4, "radius 3 mm, 10 mm inside: {depth}");
    }
}
