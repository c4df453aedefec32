//! The simulated machine as a whole: two wires and the controller, with the tool's own error.

use std::time::Duration;

use super::grbl::{GrblSim, SimSettings};
use super::line::Wire;
use super::motion::{Sample, SampleKind};
use crate::link::port::{Port, PortError};
use crate::time::Time;

/// A machine at the end of a serial line.
#[derive(Clone, Debug)]
pub struct SimMachine {
    controller: GrblSim,
    to_controller: Wire,
    to_host: Wire,
    error: ToolError,
    steps_per_mm: f64,
    samples: Vec<Sample>,
}

/// The tool's own error: it wanders inside the repeatability band while the machine moves.
#[derive(Clone, Debug)]
struct ToolError {
    random: fastrand::Rng,
    band_mm: f64,
    now: (f64, f64),
    goal: (f64, f64),
}

/// How far the error moves in a sample, mm.
const DRIFT: f64 = 5e-6;

impl ToolError {
    fn step(&mut self) -> (f64, f64) {
        let (dx, dy) = (self.goal.0 - self.now.0, self.goal.1 - self.now.1);
        let left = dx.hypot(dy);
        if left < DRIFT {
            // The next error to reach, uniform in the disc.
            let (r, phi) =
                (self.random.f64().sqrt() * self.band_mm, self.random.f64() * std::f64::consts::TAU);
            self.goal = (r * phi.cos(), r * phi.sin());
        } else {
            self.now = (self.now.0 + dx / left * DRIFT, self.now.1 + dy / left * DRIFT);
        }
        self.now
    }
}

impl SimMachine {
    /// A machine behind a line of `baud` that delays each byte by `latency` each way. `seed` makes the tool's error
    /// reproducible.
    #[must_use]
    pub fn new(settings: SimSettings, baud: u32, latency: Duration, seed: u64) -> Self {
        let machine = &settings.machine;
        let error = ToolError {
            random: fastrand::Rng::with_seed(seed),
            band_mm: machine.repeatability_mm,
            now: (0.0, 0.0),
            goal: (0.0, 0.0),
        };
        Self {
            steps_per_mm: machine.steps_per_mm,
            controller: GrblSim::new(settings),
            to_controller: Wire::new(baud, latency),
            to_host: Wire::new(baud, latency),
            error,
            samples: Vec::new(),
        }
    }

    /// Bytes that the host writes.
    pub fn host_writes(&mut self, bytes: &[u8], now: Time) {
        self.to_controller.send(bytes, now);
    }

    /// Bytes that have reached the host.
    pub fn host_reads(&mut self, into: &mut Vec<u8>, now: Time) {
        while let Some((_, byte)) = self.to_host.receive(now) {
            into.push(byte);
        }
    }

    /// Runs until `now`.
    pub fn advance(&mut self, now: Time) {
        while let Some((at, byte)) = self.to_controller.receive(now) {
            self.controller.advance(at);
            self.controller.receive(byte);
            self.pass_on(at);
        }
        self.controller.advance(now);
        self.pass_on(now);
    }

    fn pass_on(&mut self, now: Time) {
        let bytes = self.controller.transmit();
        self.to_host.send(&bytes, now);
        let step = |c: f64| (c * self.steps_per_mm).round() / self.steps_per_mm;
        for mut sample in self.controller.take_samples() {
            let error = if sample.kind == SampleKind::Rest { self.error.now } else { self.error.step() };
            let (x, y) = sample.position_mm;
            sample.position_mm = (step(x) + error.0, step(y) + error.1);
            self.samples.push(sample);
        }
    }

    /// The true tool positions since the last call.
    pub fn take_samples(&mut self) -> Vec<Sample> {
        std::mem::take(&mut self.samples)
    }

    /// Bytes that found the controller's receive buffer full.
    #[must_use]
    pub fn lost_bytes(&self) -> u64 {
        self.controller.lost_bytes()
    }
}

/// The machine as a port in virtual time.
#[derive(Debug)]
pub struct VirtualPort {
    /// The machine.
    pub machine: SimMachine,
}

impl Port for VirtualPort {
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError> {
        self.machine.host_writes(bytes, now);
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        self.machine.advance(now);
        self.machine.host_reads(into, now);
        Ok(())
    }
}
