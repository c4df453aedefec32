//! The checks of a killed session: its log, the session that resumes it, and the true positions of the tool.

use std::path::Path;
use std::sync::Arc;

use keepout_drives::controllers::kind::Kind;
use keepout_drives::profile::DriveProfile;
use keepout_executor::session::log::{Log, LogReadError};
use keepout_executor::session::replay::{Replay, replay};
use keepout_executor::session::{LoggedEvent, Sample, coverage};
use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_kernel::{Height, Vector};
use keepout_planner::job::Progress;
use keepout_planner::units::mm;
use keepout_sim::monitor::CollisionMonitor;

use super::FEED_MM_MIN;
use crate::most_left_mm;

/// A log that passed its checks.
pub struct JudgedLog {
    /// The replay of the log.
    pub replay: Replay,
    /// The last phase before a fault or the end.
    pub phase: Phase,
    /// The bytes that the session sent.
    pub sent: Vec<u8>,
    /// The progress at the beginning of the session.
    pub before: Progress,
}

impl JudgedLog {
    /// Reads a log, compares it with the bytes that the machine received, and replays it. An earlier session
    /// sent the bytes `earlier`. Returns `None` if the session ended before its first line.
    ///
    /// # Errors
    /// The failed check.
    pub fn of(
        path: &Path,
        received: &[u8],
        earlier: &[u8],
        may_be_torn: bool,
        work: &PreparedPlan,
    ) -> Result<Option<Self>, String> {
        let log = match Log::load(path) {
            Ok(log) => log,
            Err(LogReadError::File(_) | LogReadError::NoLog { .. }) if received.is_empty() => {
                return Ok(None);
            }
            Err(error) => return Err(format!("{}: {error}", path.display())),
        };
        if log.torn > 0 && !may_be_torn {
            return Err(format!(
                "{}: an incomplete last line, but the executor was not killed",
                path.display()
            ));
        }
        let sent = log.entries.iter().filter_map(|entry| match &entry.event {
            LoggedEvent::Sent(bytes) => Some(&**bytes),
            _ => None,
        });
        let sent: Vec<u8> = sent.flatten().copied().collect();
        if !follows(received, earlier, &sent) {
            return Err(format!("{}: the machine received bytes that are not in the log", path.display()));
        }
        let mut phases = log.entries.iter().rev().filter_map(|entry| match entry.event {
            LoggedEvent::Phase { phase, .. } => Some(phase),
            _ => None,
        });
        let phase =
            phases.find(|phase| ![Phase::Faulted, Phase::Done].contains(phase)).unwrap_or(Phase::Starting);
        let replay = replay(&log, work.clone());
        let replay = replay.map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Some(Self { replay, phase, sent, before: log.header.progress }))
    }

    /// Checks that the session began with the progress of the first session.
    ///
    /// # Errors
    /// Both, if they differ.
    pub fn goes_on_from(&self, first: Option<&Self>) -> Result<(), String> {
        let left = first.map_or_else(Progress::default, |first| first.replay.supervisor.progress());
        if self.before == left {
            return Ok(());
        }
        Err(format!("resumed with {:?}, but the first session ended with {left:?}", self.before))
    }
}

/// Whether `received` can come from two sessions: a beginning of the first, then a beginning of the second.
/// Bytes of the killed session may still arrive when the second one opens the port.
fn follows(received: &[u8], first: &[u8], second: &[u8]) -> bool {
    let of_first = received.iter().zip(first).take_while(|(a, b)| a == b).count();
    (0..=of_first).rev().any(|count| second.starts_with(&received[count..]))
}

/// Extra material that a controller may leave on the part if it loses power during a cut, mm.
///
/// The controller reports the commanded position. The drives lag behind it by the samples of their preview.
/// The second session resumes at the commanded position, so the tool skips the path of that lag. The material
/// is the ridge between two discs at that distance.
fn ridge_mm(work: &PreparedPlan) -> f64 {
    let Ok(servo) = DriveProfile::simulated() else { return 0.0 };
    let samples = u32::try_from(servo.controller.map_or(0, Kind::preview) + 1).unwrap_or(u32::MAX);
    let behind_mm = f64::from(samples) * servo.period_s * f64::from(FEED_MM_MIN) / 60.0;
    let radius_mm = mm(work.plan.finishing.units());
    radius_mm.hypot(behind_mm / 2.0) - radius_mm
}

/// The collision monitor's figures of a tool that passed its checks.
#[derive(Clone, Copy, Debug)]
pub struct Watched {
    /// Positions that the monitor checked.
    pub positions: u64,
    /// Least distance of tool and part, mm.
    pub closest_mm: f64,
    /// Largest distance of the cut contour from the profile, mm.
    pub worst_mm: f64,
}

impl Watched {
    /// Checks the true positions of the tool, on each machine of the moment.
    ///
    /// # Errors
    /// The gouge if the tool was in the part, or the coverage if the contour is not cut.
    pub fn of(
        machines: &[Vec<Sample>],
        work: &PreparedPlan,
        offset: (Vector, Height),
    ) -> Result<Self, String> {
        let mut cut = Vec::new();
        let (mut watched, mut closest_mm) = (0, f64::INFINITY);
        for samples in machines {
            let levels = Arc::clone(work.levels());
            let mut monitor = CollisionMonitor::new(levels, work.plan.plan.tool_radius, offset);
            samples.iter().for_each(|sample| monitor.watch(sample));
            if let Some(gouge) = monitor.deepest() {
                return Err(format!("the tool was in the part: {gouge:?}"));
            }
            watched += monitor.watched();
            closest_mm = closest_mm.min(monitor.closest_mm().unwrap_or(closest_mm));
            cut.extend(monitor.cut_paths().map(<[_]>::to_vec));
        }
        let covered = coverage(&work.plan, cut.iter().map(Vec::as_slice));
        let ridge_mm = if machines.len() > 1 { ridge_mm(work) } else { 0.0 };
        if covered.reachable == 0
            || covered.missed > 0
            || covered.worst_mm > most_left_mm(&work.plan) + ridge_mm
        {
            return Err(format!("the contour is not cut: {covered:?}"));
        }
        Ok(Self { positions: watched, closest_mm, worst_mm: covered.worst_mm })
    }
}
