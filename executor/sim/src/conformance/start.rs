//! The start of a recording: the controller's identity, the tool's position, and the place of the box in the
//! travel.

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::session::Clock;
use keepout_executor::session::port::Port;
use keepout_executor::supervisor::Mode;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;

use super::error::RecordError;
use super::record::{Bench, ScenarioRecorder};
use super::recording::RecordingHeader;
use super::scenario::Frame;

/// The choice of the middle of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The tool's present position.
    Standing,
    /// The machine is homed first. Then the tool moves to the nearest position around which the box lies in
    /// the travel.
    Homed,
}

/// The set-up of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The dialect.
    pub language: DialectName,
    /// The machine's figures.
    pub machine: MachineProfile,
    /// Side of the box, mm.
    pub box_mm: f64,
    /// The choice of the middle of the box.
    pub start: Start,
    /// Least time between two status queries.
    pub interval: Duration,
}

impl Setup {
    /// The usual set-up for a machine: a box of 20 mm around the tool.
    #[must_use]
    pub fn of(language: DialectName, machine: MachineProfile) -> Self {
        Self { language, machine, box_mm: 20.0, start: Start::Standing, interval: Duration::from_millis(2) }
    }

    /// The figures for scenarios, with a planner of `blocks` blocks.
    #[must_use]
    pub fn frame(&self, blocks: u32) -> Frame {
        let MachineProfile { max_rate_mm_s, acceleration_mm_s2, .. } = self.machine;
        Frame { box_mm: self.box_mm, max_rate_mm_s, acceleration_mm_s2, blocks }
    }

    /// The nearest position around which the box lies in the travel [−width, 0] × [−height, 0]; `None` if the
    /// box is larger than the travel.
    #[must_use]
    pub fn nearest_inside(&self, at: Mm2) -> Option<Mm2> {
        let half = self.box_mm / 2.0;
        let axis = |value: f64, travel: f64| {
            let (least, most) = (half - travel, -half);
            (least <= most).then(|| value.clamp(least, most))
        };
        let [width, height] = self.machine.travel_mm;
        Some(Mm2::new(axis(at.x, width)?, axis(at.y, height)?))
    }
}

/// The identity that a controller states.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StatedIdentity {
    /// Its version.
    pub version: String,
    /// The name of its firmware, if stated.
    pub firmware: String,
    /// Blocks of its planner.
    pub blocks: Option<u32>,
    /// Bytes of its receive buffer.
    pub receive_buffer: Option<u32>,
    /// `$13`: whether it reports inches.
    pub inches: Option<bool>,
}

impl StatedIdentity {
    /// Takes a received line.
    pub(super) fn take(&mut self, line: &str) {
        let inner = |before: &str| line.strip_prefix(before)?.strip_suffix(']');
        if let Some(version) = inner("[VER:") {
            self.version = version.into();
        } else if let Some(firmware) = inner("[FIRMWARE:") {
            self.firmware = firmware.into();
        } else if let Some(options) = inner("[OPT:") {
            let mut numbers = options.split(',').skip(1).map(|number| number.parse().ok());
            self.blocks = numbers.next().flatten();
            self.receive_buffer = numbers.next().flatten();
        } else if let Some(value) = line.strip_prefix("$13=") {
            self.inches = Some(!value.starts_with('0'));
        }
    }

    /// Version and firmware in one line.
    #[must_use]
    pub fn firmware(&self) -> String {
        format!("{} {}", self.firmware, self.version).trim().into()
    }
}

/// Checks that the dialect has scenarios.
///
/// # Errors
/// [`RecordError::Dialect`] when it has none.
pub fn check_dialect(language: &DialectName) -> Result<(), RecordError> {
    match language {
        DialectName::Grbl | DialectName::GrblHal => Ok(()),
        other => Err(RecordError::Dialect { name: other.name().into() }),
    }
}

/// Longest silence after the port is opened, because opening may reset the controller.
const WAKES_WITHIN: Duration = Duration::from_secs(4);
/// Longest time for the answer to a query.
const ANSWERS_WITHIN: Duration = Duration::from_secs(3);
/// Longest duration of homing.
const HOMES_WITHIN: Duration = Duration::from_secs(180);

impl<'a, P: Port, C: Clock> ScenarioRecorder<'a, P, C> {
    /// Queries the controller's identity and the tool's position, and homes if the set-up wants it. Stores no
    /// setting.
    ///
    /// # Errors
    /// [`RecordError`] when the dialect has no scenarios, the controller does not answer or is not at rest,
    /// its positions are not machine positions in mm, or the box leaves the travel.
    pub fn begin(bench: Bench<'a, P, C>, setup: Setup) -> Result<Self, RecordError> {
        check_dialect(&setup.language)?;
        let header = RecordingHeader {
            dialect: setup.language.name().into(),
            digit_mm: setup.machine.report_digit_mm,
            step_mm: 1.0 / setup.machine.steps_per_mm,
        };
        let mut recorder = Self::new(bench, setup, header);
        recorder.wake()?;
        if recorder.setup.start == Start::Homed {
            recorder.ask("$H", HOMES_WITHIN)?;
        }
        // The first line makes the controller reject a partial line left in its buffer.
        for line in ["$", "$I", "$$"] {
            recorder.ask(line, ANSWERS_WITHIN)?;
        }
        recorder.find_place()?;
        Ok(recorder)
    }

    fn wake(&mut self) -> Result<(), RecordError> {
        if self.pump(WAKES_WITHIN, |recorder| recorder.reported.is_some())? {
            Ok(())
        } else {
            Err(RecordError::Silent)
        }
    }

    /// Sends a line and waits for its answer.
    pub(super) fn ask(&mut self, line: &str, within: Duration) -> Result<(), RecordError> {
        self.send_line(line)?;
        if self.pump(within, |recorder| recorder.open.is_empty())? {
            return Ok(());
        }
        Err(RecordError::Unanswered { line: line.into() })
    }

    fn find_place(&mut self) -> Result<(), RecordError> {
        match self.known.inches {
            None => return Err(RecordError::Units),
            Some(true) => return Err(RecordError::Inches),
            Some(false) => {}
        }
        self.act();
        self.pump(ANSWERS_WITHIN, |recorder| recorder.agreeing >= 2)?;
        let reported = self.reported.ok_or(RecordError::Silent)?;
        if self.agreeing < 2 || reported.mode != Mode::Idle {
            return Err(RecordError::NotIdle { mode: reported.mode });
        }
        let at = reported.at.ok_or(RecordError::NoPosition)?;
        let inside = self.setup.nearest_inside(at).ok_or(RecordError::SmallTravel)?;
        if inside.distance(at) > self.recording.header.tolerance_mm() {
            if self.setup.start != Start::Homed {
                return Err(RecordError::BeyondTravel { at, inside });
            }
            self.origin = inside;
            return self.go_to_origin();
        }
        self.origin = at;
        Ok(())
    }
}
