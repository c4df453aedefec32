//! What happened in a session, as its log tells: when, and where the tool was reported.

use std::time::Duration;

use keepout_guard::Time;
use keepout_kernel::{Curve, Length, Point};
use keepout_planner::job::LoopNumber;
use keepout_planner::units::{mm, point_mm};

use crate::session::{LoggedEvent, Sample, SampleKind};
use crate::supervisor::{Phase, Supervisor};

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum TimelineEntry {
    /// The wall was touched, or the contour was asked for again.
    Touched,
    /// The contour began, or went on.
    Contouring,
    /// The contour was held.
    Held,
    /// A finishing loop was finished.
    Finished(LoopNumber),
    /// The operator was told something.
    Told(String),
    /// The machine was stopped by a fault.
    Fault(String),
    /// The controller was begun with anew.
    Recovered,
    /// The session was brought to its end.
    Ended,
}

/// How long the session was in what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhaseTimes {
    /// Connecting, reading settings, homing.
    pub starting: Duration,
    /// Steered by hand.
    pub by_hand: Duration,
    /// At the wall, while the contour was worked out and certified.
    pub touching: Duration,
    /// Contouring.
    pub contouring: Duration,
    /// A contour was held.
    pub held: Duration,
    /// After a fault, or coming to rest for the end.
    pub stopped: Duration,
}

/// What happened, in order, and the way of the tool as the controller reported it.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// What happened, when, and where the tool was last reported then, drawing coordinates.
    pub happenings: Vec<(Time, TimelineEntry, Option<Point>)>,
    /// How long the session was in what.
    pub spent: PhaseTimes,
    /// Where the tool was reported while it moved, drawing coordinates.
    pub samples: Vec<Sample>,
    /// The motions of contours as they were sent: chains of points, drawing coordinates, mm.
    pub contours: Vec<Vec<(f64, f64)>>,
    /// Of the reported positions, the nearest to the part: its distance and time.
    closest: Option<(Length, Time)>,
    radius: Length,
    phase: Phase,
    finished: usize,
    told: usize,
    last: Time,
}

/// Chords leave the arcs that they are drawn for by less than this: 1 µm.
const CHORD: Length = Length::small(100);

impl Timeline {
    /// Before anything happened.
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
            told: supervisor.notices().len(),
            last: Time::ZERO,
        }
    }

    /// Least distance of the tool's edge from the part at a reported position, mm, and when; negative in the part.
    #[must_use]
    pub fn closest_mm(&self) -> Option<(f64, Time)> {
        self.closest.map(|(closest, at)| (mm(closest.units()) - mm(self.radius.units()), at))
    }

    /// Time passes in a phase.
    pub(super) fn pass(&mut self, phase: Phase, now: Time) {
        let spent = match phase {
            Phase::Starting => &mut self.spent.starting,
            Phase::Manual | Phase::Sliding | Phase::Escaping => &mut self.spent.by_hand,
            Phase::Touching => &mut self.spent.touching,
            Phase::Contouring => &mut self.spent.contouring,
            Phase::Holding => &mut self.spent.held,
            Phase::Stopping | Phase::Done | Phase::Faulted => &mut self.spent.stopped,
        };
        *spent += now.since(self.last);
        self.last = self.last.max(now);
    }

    /// Looks at the supervisor after something went in.
    pub(super) fn see(&mut self, supervisor: &Supervisor, event: &LoggedEvent<'_>, now: Time) {
        if matches!(event, LoggedEvent::Received(_)) {
            self.see_position(supervisor, now);
        }
        let at = supervisor.position();
        let mut add = |happening| self.happenings.push((now, happening, at));
        supervisor.finished().iter().skip(self.finished).for_each(|each| add(TimelineEntry::Finished(*each)));
        supervisor.notices().iter().skip(self.told).for_each(|each| add(TimelineEntry::Told(each.clone())));
        self.finished = supervisor.finished().len();
        self.told = supervisor.notices().len();
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
            Phase::Manual | Phase::Sliding | Phase::Escaping | Phase::Stopping => return,
        };
        self.happenings.push((now, happening, at));
    }

    /// A motion of a contour was sent.
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
        let position_mm = point_mm(position);
        let kind = match supervisor.phase() {
            Phase::Contouring | Phase::Holding => SampleKind::Run,
            Phase::Starting => SampleKind::Rest,
            _ => SampleKind::Jog,
        };
        if self.samples.last().is_some_and(|last| last.position_mm == position_mm) {
            return;
        }
        self.samples.push(Sample { at, position_mm, kind });
        // While the machine starts, the tool may be raised, and where it is, is not known yet.
        if kind == SampleKind::Rest {
            return;
        }
        let clearance = supervisor.work().part().clearance(position).unwrap_or(Length::ZERO);
        if self.closest.is_none_or(|(least, _)| clearance < least) {
            self.closest = Some((clearance, at));
        }
    }
}
