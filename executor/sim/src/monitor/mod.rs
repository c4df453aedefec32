//! The collision monitor: it knows only the part and the tool, and decides exactly how deep the tool entered
//! the part.
//!
//! A motion that changes its height is cut where it passes the top of a level, to the lattice unit. Each piece is
//! compared with everything that stands above it.

use std::fmt;
use std::sync::Arc;

use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_kernel::{Height, Length, Levels, Place, Point, ProhibitedRegion, Segment, Vector};
use keepout_planner::units::{mm, place_from_mm};

/// The deepest gouge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gouging {
    /// Depth, mm: the shortest distance out of it, aside or upward.
    pub depth_mm: f64,
    /// Time of the sample.
    pub at: Time,
    /// The tool's centre, drawing coordinates.
    pub centre: Point,
    /// The height of the tool's tip.
    pub height: Height,
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
    levels: Arc<Levels>,
    radius: Length,
    /// Machine coordinates minus drawing coordinates.
    offset: (Vector, Height),
    rule: Option<JoggingRule>,
    verdict: Option<Verdict>,
    /// The tool stands nearer than the rule permits for a reason, and may leave: a contour ended there, or the
    /// session began there.
    excused: bool,
    last: Option<Place>,
    /// The level of the last piece of motion.
    level: Option<u16>,
    way_mm: f64,
    inside: bool,
    /// The smallest distance so far between the tool's edge and the part, at most [`FAR`].
    closest: Length,
    closest_by_hand: Length,
    deepest: Option<Gouging>,
    cut: Vec<Vec<Place>>,
    watched: u64,
}

/// Largest measured distance between the tool's edge and the part, lattice units (5 mm). A sample farther
/// away costs one cheap query.
const FAR: i64 = 500_000;
/// Largest measured depth inside the part, lattice units (5.3 m).
const DEEP: i64 = 1 << 29;

impl CollisionMonitor {
    /// A monitor for a tool of `radius` at a part. `offset` is machine coordinates minus drawing coordinates,
    /// in the plane and upward.
    #[must_use]
    pub fn new(levels: Arc<Levels>, radius: Length, offset: (Vector, Height)) -> Self {
        let closest = Length::from_units(FAR).unwrap_or(Length::ZERO);
        Self {
            levels,
            radius,
            offset,
            rule: None,
            verdict: None,
            excused: true,
            way_mm: 0.0,
            last: None,
            level: None,
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
        let Some(here) = self.in_drawing(sample) else {
            // A position off the lattice counts as a gouge.
            let (at, centre) = (sample.at, Point::ORIGIN);
            self.deepest = Some(Gouging { depth_mm: f64::INFINITY, at, centre, height: Height::ZERO });
            self.find(Verdict::Gouge { at, centre });
            return;
        };
        self.watched += 1;
        let from = self.last.replace(here).unwrap_or(here);
        let step = here.point.minus(from.point);
        let climb = mm(here.height.units()) - mm(from.height.units());
        self.way_mm += mm(step.dx).hypot(mm(step.dy)).hypot(climb);
        if self.rule.is_some() && from == here && self.watched > 1 {
            return;
        }
        let levels = Arc::clone(&self.levels);
        for_each_piece(&levels, from, here, |motion, height| {
            let part = levels.at(height);
            match self.rule {
                // A tool that rose beside a wall is outside only well above its top: its height errs, too.
                Some(rule) => self.decide([part, levels.at(below(height))], rule, motion, sample),
                None => self.measure(part, motion, height, sample),
            }
            self.level = Some(part.level());
        });
        if self.rule.is_none() {
            self.remember_cut(sample.kind, from, here);
        }
    }

    /// The place of a sample in drawing coordinates. `None` off the lattice.
    fn in_drawing(&self, sample: &Sample) -> Option<Place> {
        let (Vector { dx, dy }, up) = self.offset;
        let Place { point, height } = place_from_mm(sample.position_mm).ok()?;
        let height = i64::from(height.units()) - i64::from(up.units());
        let point = point.translated(Vector { dx: -dx, dy: -dy }).ok()?;
        Some(point.at_height(Height::from_units(height).ok()?))
    }

    /// The same monitor, which decides by thresholds whether jogs keep the rule. The part is best prepared for
    /// the distances of the rule.
    #[must_use]
    pub fn with_rule(self, rule: JoggingRule) -> Self {
        Self { rule: Some(rule), ..self }
    }

    /// Decides by the region at the height of the tip, and the one below it.
    fn decide(
        &mut self,
        [part, under]: [&ProhibitedRegion; 2],
        rule: JoggingRule,
        motion: Segment,
        sample: &Sample,
    ) {
        let (at, centre) = (sample.at, motion.to);
        // Below another level, the tool may stand in the middle of a part whose edges are far away.
        let sunk = self.level.is_some_and(|level| level < part.level()) && part.holds(motion.from);
        if sunk {
            self.find(Verdict::Gouge { at, centre });
        } else if part.motion_clear(motion, rule.clearance).is_clear() {
            // A contour can end between the two distances. Then the tool may already be too near by the
            // machine's own count, and its next motion is a retract move, however large the positioning error.
            let outside = under.motion_clear(motion, rule.outside).is_clear();
            self.excused = !outside && (self.excused || sample.kind == SampleKind::Run);
        } else if !part.motion_clear(motion, self.radius).is_clear() || part.holds(centre) {
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

    fn measure(&mut self, part: &ProhibitedRegion, motion: Segment, height: Height, sample: &Sample) {
        // `look` detects a crossing between two samples. At the start, at another level, and after a crossing,
        // this tests whether the tool is inside.
        if self.inside || self.level != Some(part.level()) {
            self.inside = part.holds(motion.to);
        }
        self.look(part, motion, height, sample.at);
        if sample.kind == SampleKind::Jog {
            self.closest_by_hand = self.nearer(part, motion, self.closest_by_hand);
        }
    }

    /// The smaller of `known` and the distance between the tool's edge and the part on this motion.
    fn nearer(&self, part: &ProhibitedRegion, motion: Segment, known: Length) -> Length {
        let clear = |r: Length| part.edges_clear(motion, r).is_ok();
        if clear(self.radius.saturating_plus(known)) {
            return known;
        }
        let reach = i64::from(self.radius.units()) + i64::from(known.units());
        let beyond = i64::from(largest_clear(reach + 1, clear)) - i64::from(self.radius.units());
        Length::from_units(beyond.max(0)).unwrap_or(Length::ZERO).min(known)
    }

    fn look(&mut self, part: &ProhibitedRegion, motion: Segment, height: Height, at: Time) {
        let clear = |r: Length| part.edges_clear(motion, r).is_ok();
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
        let crossed = self.inside || part.holds(motion.to);
        let aside_mm = if crossed {
            let here = Segment { from: motion.to, to: motion.to };
            let within = largest_clear(DEEP, |r| part.edges_clear(here, r).is_ok());
            mm(self.radius.units()) + mm(within.max(0))
        } else {
            -mm(i32::try_from(beyond).unwrap_or(0))
        };
        self.inside = part.holds(motion.to);
        let depth_mm = self.way_up_mm(motion, height).map_or(aside_mm, |up_mm| aside_mm.min(up_mm));
        if self.deepest.is_none_or(|deepest| depth_mm > deepest.depth_mm) {
            self.deepest = Some(Gouging { depth_mm, at, centre: motion.to, height });
        }
    }

    /// The way up to the lowest height at which the motion is clear of the part, mm. `None` for a part without
    /// tops.
    fn way_up_mm(&self, motion: Segment, height: Height) -> Option<f64> {
        let clear =
            |part: &ProhibitedRegion| part.edges_clear(motion, self.radius).is_ok() && !part.holds(motion.to);
        let above = self.levels.tops().filter(|&top| top > height && clear(self.levels.at(top)));
        above.last().map(|top| mm(top.units()) - mm(height.units()))
    }

    fn remember_cut(&mut self, kind: SampleKind, from: Place, here: Place) {
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

    /// The paths of the tool in programmed motions, one path for each run.
    pub fn cut_paths(&self) -> impl Iterator<Item = &[Place]> + '_ {
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

/// A height that is certainly below the tip, whatever the error of its height (0.5 mm).
fn below(height: Height) -> Height {
    height.lowered(Length::from_units(50_000).unwrap_or(Length::ZERO))
}

/// Calls `visit` with the pieces of a motion, in order, each with its lowest height. The motion is cut at the
/// tops that it passes, and a place on it is rounded to the lattice.
fn for_each_piece(levels: &Levels, from: Place, to: Place, mut visit: impl FnMut(Segment, Height)) {
    let (low, high) = (from.height.min(to.height), from.height.max(to.height));
    let mut cuts: Vec<Height> = levels.tops().filter(|&top| low < top && top < high).collect();
    if from.height < to.height {
        cuts.reverse();
    }
    let climb = i128::from(to.height.units()) - i128::from(from.height.units());
    let (d, mut last) = (to.point.minus(from.point), from);
    for top in cuts {
        let gone = i128::from(top.units()) - i128::from(from.height.units());
        let part = |whole: i32| i32::try_from((i128::from(whole) * gone).div_euclid(climb)).unwrap_or(0);
        let point = from.point.translated(Vector { dx: part(d.dx), dy: part(d.dy) }).unwrap_or(to.point);
        visit(Segment { from: last.point, to: point }, last.height.min(top));
        last = point.at_height(top);
    }
    visit(Segment { from: last.point, to: to.point }, last.height.min(to.height));
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
mod tests;
