//! Feed drives under a simulated controller: the tool follows the commanded positions as a servo does, with a
//! small delay and a small error.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_drives::Axes;
use keepout_drives::controllers::Controller;
use keepout_drives::controllers::selection::Environment;
use keepout_drives::plant::{Load, Plant};
use keepout_drives::profile::DriveProfile;
use keepout_drives::reference::ReferenceWindow;
use keepout_drives::stream::Stream;
use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::{Mm2, Mm3};

/// Two drives and their controller in motion.
#[derive(Debug)]
pub struct ServoDrive {
    stream: Stream,
    plant: Plant,
    controller: Box<dyn Controller>,
    /// Delay of the tool, samples. The controller looks this far ahead.
    preview: usize,
    /// The last commanded position, pulses, and its time.
    commanded: Axes,
    since: Time,
    kinds: VecDeque<SampleKind>,
    /// The kind of the last command.
    kind: SampleKind,
    pulses_per_mm: f64,
    period: Duration,
    next: Time,
    /// Samples since the commanded place last changed.
    rested: u32,
    /// The height at the last sample, mm.
    height: f64,
    /// Commanded heights with their times, mm. The third axis follows them exactly, as late as the other two.
    heights: VecDeque<(Time, f64)>,
}

/// Samples at rest after which the drives are in position. They are then no longer simulated, so hours of waiting cost
/// no time. The command of the built-in machine's controller settles in 200 samples.
const SETTLED: u32 = 300;

impl ServoDrive {
    /// Drives at rest at `start_mm`, machine coordinates. `None` if the profile names no controller, or one that does
    /// not suit its drives.
    #[must_use]
    pub fn new(profile: &DriveProfile, start_mm: Mm2) -> Option<Self> {
        let kind = profile.controller?;
        let environment = Environment::of_hand(profile);
        let controller = kind.built(&profile.setting(environment))?;
        let preview = kind.preview();
        let start = Axes::new(start_mm.x, start_mm.y) * profile.pulses_per_mm;
        Some(Self {
            stream: Stream::at_rest(start, 2 * preview + 4),
            plant: Plant::at_rest(profile.plant(), start),
            controller,
            preview,
            commanded: start,
            since: Time::ZERO,
            kind: SampleKind::Rest,
            kinds: VecDeque::from(vec![SampleKind::Rest; preview]),
            pulses_per_mm: profile.pulses_per_mm,
            period: Duration::from_secs_f64(profile.period_s),
            next: Time::ZERO,
            rested: 0,
            height: 0.0,
            heights: VecDeque::new(),
        })
    }

    /// The time until which the drives need the next commanded position: that of their next sample. Drives in position
    /// need none before the command `moves`.
    #[must_use]
    pub fn next_tick(&self, moves: bool) -> Time {
        match (self.rested >= SETTLED, moves) {
            (false, _) => self.next,
            (true, true) => self.since.after(self.period),
            (true, false) => Time::NEVER,
        }
    }

    /// Follows a commanded position, and adds the tool's true positions to `into`.
    pub fn follow(&mut self, sample: &Sample, into: &mut Vec<Sample>) {
        let Mm3 { x, y, z } = sample.position_mm;
        // Two equal heights hold a whole rest.
        let rests = self.heights.iter().rev().take(2).filter(|(_, height)| *height == z).count() == 2;
        match self.heights.back_mut().filter(|_| rests) {
            Some(last) => last.0 = sample.at,
            None => self.heights.push_back((sample.at, z)),
        }
        self.kind = sample.kind;
        self.lead(Axes::new(x, y) * self.pulses_per_mm, sample.at, into);
    }

    /// Holds the last commanded position until `at`.
    pub fn go_on(&mut self, at: Time, into: &mut Vec<Sample>) {
        self.lead(self.commanded, at, into);
    }

    /// Moves the command from the last commanded position straight to `to`, at constant speed until `at`.
    fn lead(&mut self, to: Axes, at: Time, into: &mut Vec<Sample>) {
        let (from, began) = (self.commanded, self.since);
        let lasts = at.since(began).as_secs_f64();
        let moves = to != from || self.heights.iter().any(|(_, height)| *height != self.height);
        if moves {
            if self.rested >= SETTLED {
                self.skip_to(began);
            }
            self.rested = 0;
        }
        while self.next <= at {
            if self.rested >= SETTLED {
                self.skip_to(at);
                break;
            }
            let gone = self.next.since(began).as_secs_f64();
            let share = if lasts > 0.0 { (gone / lasts).min(1.0) } else { 1.0 };
            self.stream.pass(from + (to - from) * share);
            self.kinds.push_back(self.kind);
            let kind = self.kinds.pop_front().unwrap_or(self.kind);
            self.rested += 1;
            let position = self.tick() / self.pulses_per_mm;
            self.height = self.height_at(self.next);
            let position_mm = Mm3::new(position.x, position.y, self.height);
            into.push(Sample { at: self.next, position_mm, kind });
            self.next = self.next.after(self.period);
        }
        self.stream.pass(to);
        (self.commanded, self.since) = (to, at);
    }

    /// The commanded height before the controller's delay, mm: straight between two commanded heights.
    fn height_at(&mut self, now: Time) -> f64 {
        let late = self.period * u32::try_from(self.preview).unwrap_or(0);
        let at = Time::ZERO.after(now.since(Time::ZERO).saturating_sub(late));
        while self.heights.len() > 1 && self.heights[1].0 <= at {
            self.heights.pop_front();
        }
        match (self.heights.front(), self.heights.get(1)) {
            (Some(&(from, low)), Some(&(to, high))) if at > from => {
                let share = at.since(from).as_secs_f64() / to.since(from).as_secs_f64().max(1e-9);
                low + (high - low) * share
            }
            (Some(&(_, height)), _) => height,
            _ => 0.0,
        }
    }

    /// Moves the next sample to the first one after `at`.
    fn skip_to(&mut self, at: Time) {
        if self.next > at {
            return;
        }
        let behind = at.since(self.next).as_micros();
        let periods = u32::try_from(behind / self.period.as_micros().max(1)).unwrap_or(u32::MAX);
        self.next = self.next.after(self.period * periods).after(self.period);
    }

    /// Runs one sampling period. Returns the tool's position at its end, pulses.
    fn tick(&mut self) -> Axes {
        self.stream.tick(self.period.as_secs_f64());
        let samples = self.stream.samples();
        let window = ReferenceWindow::new(samples, samples.len().saturating_sub(1 + self.preview));
        let command = self.controller.step(&window, self.plant.measured());
        let load = Load { reference_velocity: window.ahead(0).velocity(), ..Load::default() };
        self.plant.step(command, &load);
        self.plant.position()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> ServoDrive {
        ServoDrive::new(&DriveProfile::simulated().unwrap(), Mm2::new(10.0, 20.0)).unwrap()
    }

    fn sample(ms: u64, x: f64, kind: SampleKind) -> Sample {
        Sample { at: Time::from_micros(ms * 1000), position_mm: Mm2::new(x, 20.0).at_height(0.0), kind }
    }

    /// The tool takes the same path, delayed by the controller's preview, and within the machine's contour
    /// error.
    #[test]
    fn tool_follows_a_little_later() {
        let (mut drive, mut found) = (drive(), Vec::new());
        let speed = 0.05;
        for ms in 0..1000_u32 {
            let way = f64::from(ms).min(600.0) * speed;
            drive.follow(&sample(ms.into(), 10.0 + way, SampleKind::Run), &mut found);
        }
        let last = found.last().unwrap();
        assert!((last.position_mm.x - 40.0).abs() < 0.002, "{last:?}");
        let lag = 10.0 + 400.0 * speed - found[400].position_mm.x;
        assert!((0.5..2.5).contains(&lag), "{lag} mm behind");
        assert!(found.iter().all(|sample| (sample.position_mm.y - 20.0).abs() < 0.005));
    }

    /// After a long rest the tool has not moved, no sample is due, and motion starts again on time.
    #[test]
    fn drives_at_rest_produce_no_samples() {
        let (mut drive, mut found) = (drive(), Vec::new());
        for ms in 0..5000 {
            drive.follow(&sample(ms, 10.0, SampleKind::Rest), &mut found);
        }
        assert_eq!(found.len(), 300);
        assert_eq!(drive.next_tick(false), Time::NEVER);
        found.clear();
        drive.follow(&sample(3_600_000, 10.0, SampleKind::Rest), &mut found);
        assert!(found.is_empty());
        drive.follow(&sample(3_600_001, 10.01, SampleKind::Jog), &mut found);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].at, Time::from_micros(3_600_001_000));
    }

    /// A plunge of five seconds, while the other two axes rest.
    #[test]
    fn height_is_followed_while_the_other_axes_rest() {
        let (mut drive, mut found) = (drive(), Vec::new());
        for ms in 0..12_000_u32 {
            let depth = (f64::from(ms.max(3000)) - 3000.0).min(5000.0) * 1e-3;
            let rest = sample(ms.into(), 10.0, SampleKind::Rest);
            drive.follow(&Sample { position_mm: Mm2::new(10.0, 20.0).at_height(-depth), ..rest }, &mut found);
        }
        assert_eq!(drive.next_tick(false), Time::NEVER);
        let at = |ms: u64| found.iter().rfind(|sample| sample.at <= Time::from_micros(ms * 1000)).unwrap();
        assert_eq!(at(2900).position_mm.z, 0.0);
        assert!((at(5500).position_mm.z + 2.5).abs() < 0.1, "{:?}", at(5500));
        assert_eq!(found.last().unwrap().position_mm.z, -5.0);
    }

    /// The tool moves to a late position at constant speed, without a jump.
    #[test]
    fn late_positions_cause_no_jumps() {
        let (mut often, mut seldom) = (drive(), drive());
        let (mut fine, mut coarse) = (Vec::new(), Vec::new());
        for ms in 0..5000 {
            let rest = sample(ms, 10.0, SampleKind::Rest);
            often.follow(&rest, &mut fine);
            seldom.follow(&rest, &mut coarse);
        }
        let way = |ms: u64| 10.0 + f64::from(u32::try_from(ms).unwrap()) * 0.02;
        for ms in 1..=50 {
            often.follow(&sample(4999 + ms, way(ms), SampleKind::Jog), &mut fine);
        }
        seldom.follow(&sample(5049, way(50), SampleKind::Jog), &mut coarse);
        let off = |a: &Sample, b: &Sample| (a.position_mm.x - b.position_mm.x).abs();
        assert_eq!(fine.len(), coarse.len());
        assert!(fine.iter().zip(&coarse).all(|(a, b)| off(a, b) < 0.001));
    }
}
