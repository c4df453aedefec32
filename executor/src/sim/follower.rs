//! Feed drives under a simulated controller: the tool follows the commanded positions as a servo does, a little later and never
//! quite on them.

use std::collections::VecDeque;
use std::time::Duration;

use super::motion::{Sample, SampleKind};
use crate::servo::Axes;
use crate::servo::controllers::Controller;
use crate::servo::controllers::kind::Kind;
use crate::servo::controllers::selection::Environment;
use crate::servo::plant::{Load, Plant};
use crate::servo::profile::DriveProfile;
use crate::servo::reference::Window;
use crate::servo::stream::Stream;
use crate::time::Time;

/// Two drives and their controller.
#[derive(Debug)]
pub struct Follower {
    stream: Stream,
    plant: Plant,
    controller: Box<dyn Controller>,
    /// Samples by which the tool is behind, so that the controller can look ahead.
    preview: usize,
    kinds: VecDeque<SampleKind>,
    pulses_per_mm: f64,
    period: Duration,
    next: Time,
}

impl Follower {
    /// Drives at rest at `start_mm`, machine coordinates, under a controller of this kind. `None` where there is none of it.
    #[must_use]
    pub fn new(profile: &DriveProfile, kind: Kind, start_mm: (f64, f64)) -> Option<Self> {
        let environment = Environment::of_hand(profile);
        let controller = kind.built(&profile.setting(environment))?;
        let preview = kind.preview();
        let start = Axes::new(start_mm.0, start_mm.1) * profile.pulses_per_mm;
        Some(Self {
            stream: Stream::at_rest(start, 2 * preview + 4),
            plant: Plant::at_rest(profile.plant(), start),
            controller,
            preview,
            kinds: VecDeque::from(vec![SampleKind::Rest; preview]),
            pulses_per_mm: profile.pulses_per_mm,
            period: Duration::from_secs_f64(profile.period_s),
            next: Time::ZERO,
        })
    }

    /// When the next sample is due.
    #[must_use]
    pub fn next_tick(&self) -> Time {
        self.next
    }

    /// The commanded position at its time; the tool's true positions are added to `into`.
    pub fn follow(&mut self, sample: &Sample, into: &mut Vec<Sample>) {
        let (x, y) = sample.position_mm;
        self.stream.pass(Axes::new(x, y) * self.pulses_per_mm);
        while self.next <= sample.at {
            self.kinds.push_back(sample.kind);
            let kind = self.kinds.pop_front().unwrap_or(sample.kind);
            let position = self.tick() / self.pulses_per_mm;
            into.push(Sample { at: self.next, position_mm: (position.x, position.y), kind });
            self.next = self.next.after(self.period);
        }
    }

    /// A sampling period: where the tool is at its end, pulses.
    fn tick(&mut self) -> Axes {
        self.stream.tick(self.period.as_secs_f64());
        let samples = self.stream.samples();
        let window = Window::new(samples, samples.len().saturating_sub(1 + self.preview));
        let command = self.controller.step(&window, self.plant.measured());
        let load = Load { reference_velocity: window.ahead(0).velocity(), ..Load::default() };
        self.plant.step(command, &load);
        self.plant.position()
    }
}
