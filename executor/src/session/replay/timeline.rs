//! The timeline of a session from its log: events, times, and reported positions of the tool.

use std::time::Duration;

use keepout_guard::Time;
use keepout_kernel::{Curve, Length, Point};
use keepout_planner::Mm2;
use keepout_planner::job::LoopNumber;
use keepout_planner::units::{mm, place_mm, point_mm};

use crate::session::{LoggedEvent, Sample, SampleKind};
use crate::supervisor::{Phase, Supervisor};

/// An entry of the timeline.
#[derive(Clone, Debug, PartialEq)]
pub enum TimelineEntry {
    /// The tool made contact with the part, or the operator requested the contour again.
    Touched,
    /// The contour began, or went on.
    Contouring,
    /// A feed hold paused the contour.
    Held,
    /// The machine finished a finishing loop.
    Finished(LoopNumber),
    /// The session showed a notice to the operator.
    Told(String),
    /// A fault stopped the session.
    Fault(String),
    /// The session began again with the controller after a fault.
    Recovered,
    /// The session ended.
    Ended,
}

/// Time per phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhaseTimes {
    /// Connecting, reading settings, homing.
    pub starting: Duration,
    /// Jogging.
    pub by_hand: Duration,
    /// At the contact point, during planning and certification of the contour.
    pub touching: Duration,
    /// Contouring.
    pub contouring: Duration,
    /// A contour in feed hold.
    pub held: Duration,
    /// After a fault, or while the machine stops for the end.
    pub stopped: Duration,
}

/// The timeline of a session, with the tool positions that the controller reported.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// The entries in order: time, entry, and the last reported position in drawing coordinates.
    pub happenings: Vec<(Time, TimelineEntry, Option<Point>)>,
    /// Time per phase.
    pub spent: PhaseTimes,
    /// The reported positions, each different from the one before, drawing coordinates.
    pub samples: Vec<Sample>,
    /// The contour motions as sent: chains of points, drawing coordinates, mm.
    pub contours: Vec<Vec<Mm2>>,
    /// The reported position nearest to the part: its clearance and its time.
    closest: Option<(Length, Time)>,
    radius: Length,
    phase: Phase,
    finished: usize,
    notices: usize,
    last: Time,
}

/// Chord-error bound of the drawn arcs: 1 µm.
const CHORD: Length = Length::small(100);

impl Timeline {
    /// The empty timeline of a session.
    pub(super) fn of(supervisor: &Supervisor) -> Self {
        Self {
            happenings: Vec::new(),
            spent: PhaseTimes::default(),
            samples: Vec::new(),
            contours: Vec::new(),
            closest: None,
            radius: supervisor.plan().plan.tool_radius,
            phase: supervisor.phase(),
            finished: supervisor.finished().len(),
            notices: supervisor.notices().len(),
            last: Time::ZERO,
        }
    }

    /// The least distance between the tool's edge and the part over all reported positions, mm, and its time.
    /// The distance is negative if the tool was in the part.
    #[must_use]
    pub fn closest_mm(&self) -> Option<(f64, Time)> {
        self.closest.map(|(closest, at)| (mm(closest.units()) - mm(self.radius.units()), at))
    }

    /// Adds the time since the last call to `phase`.
    pub(super) fn pass(&mut self, phase: Phase, now: Time) {
        let spent = match phase {
            Phase::Starting => &mut self.spent.starting,
            Phase::Manual | Phase::Sliding | Phase::Retracting => &mut self.spent.by_hand,
            Phase::Touching => &mut self.spent.touching,
            Phase::Contouring => &mut self.spent.contouring,
            Phase::Holding => &mut self.spent.held,
            Phase::Stopping | Phase::Done | Phase::Faulted => &mut self.spent.stopped,
        };
        *spent += now.since(self.last);
        self.last = self.last.max(now);
    }

    /// Adds the entries that the supervisor's last step caused.
    pub(super) fn see(&mut self, supervisor: &Supervisor, event: &LoggedEvent<'_>, now: Time) {
        if matches!(event, LoggedEvent::Received(_)) {
            self.see_position(supervisor, now);
        }
        let at = supervisor.position().map(|place| place.point);
        let mut add = |happening| self.happenings.push((now, happening, at));
        supervisor.finished().iter().skip(self.finished).for_each(|each| add(TimelineEntry::Finished(*each)));
        supervisor
            .notices()
            .iter()
            .skip(self.notices)
            .for_each(|each| add(TimelineEntry::Told(each.to_string())));
        self.finished = supervisor.finished().len();
        self.notices = supervisor.notices().len();
        let (before, after) = (self.phase, supervisor.phase());
        self.phase = after;
        if before == after {
            return;
        }
        let happening = match after {
            Phase::Touching => TimelineEntry::Touched,
            Phase::Contouring => TimelineEntry::Contouring,
            Phase::Holding => TimelineEntry::Held,
            Phase::Faulted => {
                TimelineEntry::Fault(supervisor.fault().map(ToString::to_string).unwrap_or_default())
            }
            Phase::Starting => TimelineEntry::Recovered,
            Phase::Done => TimelineEntry::Ended,
            Phase::Manual | Phase::Sliding | Phase::Retracting | Phase::Stopping => return,
        };
        self.happenings.push((now, happening, at));
    }

    /// Adds a contour motion that the engine sent.
    pub(super) fn sent(&mut self, curve: &Curve) {
        let points = curve.chord_points(CHORD).unwrap_or_else(|_| vec![curve.from(), curve.to()]);
        let from = point_mm(curve.from());
        if self.contours.last().is_none_or(|chain| chain.last() != Some(&from)) {
            self.contours.push(vec![from]);
        }
        if let Some(chain) = self.contours.last_mut() {
            chain.extend(points.into_iter().skip(1).map(point_mm));
        }
    }

    fn see_position(&mut self, supervisor: &Supervisor, at: Time) {
        let Some(position) = supervisor.position() else { return };
        let position_mm = place_mm(position);
        let kind = match supervisor.phase() {
            Phase::Contouring | Phase::Holding => SampleKind::Run,
            Phase::Starting => SampleKind::Rest,
            _ => SampleKind::Jog,
        };
        if self.samples.last().is_some_and(|last| last.position_mm == position_mm) {
            return;
        }
        self.samples.push(Sample { at, position_mm, kind });
        // While the machine starts, the tool may be raised, and its position is not yet known.
        if kind == SampleKind::Rest {
            return;
        }
        let part = supervisor.work().levels().at(position.height);
        // Above all that stands, nothing is near.
        if part.edges().is_empty() {
            return;
        }
        let clearance = part.clearance(position.point).unwrap_or(Length::ZERO);
        if self.closest.is_none_or(|(least, _)| clearance < least) {
            self.closest = Some((clearance, at));
        }
    }
}
