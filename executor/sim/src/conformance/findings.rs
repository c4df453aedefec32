//! The figures of a controller, from a recording.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter};
use std::time::Duration;

use keepout_executor::supervisor::Mode;
use keepout_planner::machine::ControllerProfile;

use super::observe::{Observed, Stop, observe};
use super::recording::{Recording, What};
use super::start::StatedIdentity;

/// Times from queries to their answers, without those at the end of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Latency {
    /// The median.
    pub median: Duration,
    /// The 99 % quantile.
    pub most: Duration,
    /// The longest.
    pub longest: Duration,
}

/// The findings about the controller of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Firmware and version, as the controller states them.
    pub firmware: String,
    /// Blocks of the planner, from two agreeing idle reports, otherwise from `$I`.
    pub planner_blocks: Option<u32>,
    /// Bytes of the receive buffer, likewise.
    pub receive_buffer: Option<u32>,
    /// The times to the answers of status queries.
    pub latency: Latency,
    /// Longest time without an answer at the end of a motion, minus the 99 % quantile of the other answers.
    pub idle_delay: Duration,
    /// The number of cancels with a known path after them.
    pub cancels: usize,
    /// Largest distance from the commanded path at a cancel, mm.
    pub largest_deviation_mm: f64,
    /// The same for the true position in all scenarios. Only a simulated machine provides it.
    pub true_deviation_mm: Option<f64>,
    /// Largest distance from the position before a cancel to the position at rest, mm.
    pub largest_stop_mm: f64,
    /// The tolerance, mm. Smaller distances do not count.
    pub tolerance_mm: f64,
    /// Whether a cancel discarded received lines.
    pub discards_lines: Option<bool>,
    /// Whether a hold stopped a jog.
    pub hold_stops_jog: Option<bool>,
    /// The reported states.
    pub states: BTreeSet<String>,
    /// The reported errors and alarms.
    pub errors: BTreeSet<String>,
}

impl Findings {
    /// The findings of a recording.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let (known, buffers) = (known(recording), buffers(recording));
        let observed = observe(recording);
        let stops: Vec<Stop> = observed.iter().filter_map(|each| each.cancel).collect();
        let latency = latency(&observed);
        let ends = observed.iter().flat_map(|each| &each.after_motion).copied().max().unwrap_or_default();
        let any =
            |found: fn(&Observed) -> Option<bool>| observed.iter().filter_map(found).reduce(|a, b| a || b);
        let largest = |figure: fn(&Stop) -> f64| stops.iter().map(figure).fold(0.0, f64::max);
        let wrong = |reply: &&String| reply.starts_with("error:") || reply.starts_with("ALARM:");
        Self {
            firmware: known.firmware(),
            planner_blocks: buffers.map(|free| free.0).or(known.blocks),
            receive_buffer: buffers.map(|free| free.1).or(known.receive_buffer),
            latency,
            idle_delay: ends.saturating_sub(latency.most),
            cancels: stops.len(),
            largest_deviation_mm: largest(|stop| stop.deviation_mm),
            true_deviation_mm: observed.iter().filter_map(|each| each.true_deviation_mm).reduce(f64::max),
            largest_stop_mm: largest(|stop| stop.distance_mm),
            tolerance_mm: recording.header.tolerance_mm(),
            discards_lines: any(|each| each.discards),
            hold_stops_jog: any(|each| each.hold_stops_jog),
            states: observed.iter().flat_map(|each| &each.states).map(|(state, _)| state.clone()).collect(),
            errors: observed.iter().flat_map(|each| &each.replies).filter(wrong).cloned().collect(),
        }
    }

    /// Whether every cancelled jog stopped on its path; `None` without a cancel.
    #[must_use]
    pub fn keeps_path_on_cancel(&self) -> Option<bool> {
        (self.cancels > 0).then_some(self.largest_deviation_mm <= self.tolerance_mm)
    }

    /// The findings as the machine profile stores them.
    #[must_use]
    pub fn profile(&self) -> ControllerProfile {
        ControllerProfile {
            firmware: self.firmware.clone(),
            keeps_path_on_cancel: self.keeps_path_on_cancel(),
            largest_deviation_mm: (self.cancels > 0).then(|| rounded(self.largest_deviation_mm)),
            idle_delay_ms: Some(rounded(ms(self.idle_delay))),
            planner_blocks: self.planner_blocks,
            receive_buffer: self.receive_buffer,
            report_latency_ms: Some(rounded(ms(self.latency.median))),
        }
    }
}

fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The identity that the controller states before the first scenario.
fn known(recording: &Recording) -> StatedIdentity {
    let mut known = StatedIdentity::default();
    let before = recording.events.iter().take_while(|event| !matches!(event.what, What::Begin { .. }));
    for event in before {
        if let What::Received(line) = &event.what {
            known.take(&String::from_utf8_lossy(line));
        }
    }
    known
}

/// The largest free blocks and bytes that two idle reports in a row agree on.
fn buffers(recording: &Recording) -> Option<(u32, u32)> {
    let (mut last, mut all) = (None, None);
    for event in &recording.events {
        let Some(status) = event.status().filter(|status| status.mode == Mode::Idle) else { continue };
        let Some((blocks, bytes)) = status.free else { continue };
        let free = (u32::try_from(blocks).ok()?, u32::try_from(bytes).ok()?);
        if last.replace(free) == Some(free) {
            all = all.max(Some(free));
        }
    }
    all
}

/// The distribution of the times to answers.
pub(super) fn latency(observed: &[Observed]) -> Latency {
    let mut times: Vec<Duration> = observed.iter().flat_map(|each| &each.answers).copied().collect();
    times.sort_unstable();
    let last = times.len().saturating_sub(1);
    let share = |percent: usize| times.get(last * percent / 100).copied().unwrap_or_default();
    Latency { median: share(50), most: share(99), longest: share(100) }
}

impl Display for Findings {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: String| writeln!(to, "{name:<44} {value}");
        let number = |value: Option<u32>| value.map_or("not stated".into(), |value| value.to_string());
        let answer = |value: Option<bool>, yes: &str, no: &str| {
            value.map_or("not observed", |value| if value { yes } else { no }).to_string()
        };
        row("firmware", self.firmware.clone())?;
        row("planner blocks", number(self.planner_blocks))?;
        row("receive buffer, bytes", number(self.receive_buffer))?;
        let Latency { median, most, longest } = self.latency;
        let (median, most, longest) = (ms(median), ms(most), ms(longest));
        row(
            "answer to a query",
            format!("{median:.1} ms median, {most:.1} ms for 99 %, {longest:.1} ms longest"),
        )?;
        row("idle delay", format!("{:.1} ms", ms(self.idle_delay)))?;
        // A real machine receives no stop, so it has no such rows.
        if self.cancels > 0 {
            let keeps = answer(self.keeps_path_on_cancel(), "yes", "NO");
            let (off, within) = (self.largest_deviation_mm, self.tolerance_mm);
            row(
                "keeps its path on cancel",
                format!(
                    "{keeps}: at most {off:.3} mm off in {} cancels, tolerance {within:.4} mm",
                    self.cancels
                ),
            )?;
            if let Some(off) = self.true_deviation_mm {
                row("true distance from the path", format!("{off:.4} mm"))?;
            }
            row("distance from a cancel to rest", format!("{:.2} mm at most", self.largest_stop_mm))?;
            row(
                "lines received before a cancel",
                answer(self.discards_lines, "discarded", "executed after the stop"),
            )?;
            row("hold in a jog", answer(self.hold_stops_jog, "stops it", "does not stop it"))?;
        }
        let list = |set: &BTreeSet<String>| set.iter().cloned().collect::<Vec<_>>().join(" ");
        row("states", list(&self.states))?;
        row("errors and alarms", list(&self.errors))
    }
}
