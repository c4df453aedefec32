//! The whole simulated machine: two wires, the controller, and the tool's positioning error.

use std::time::Duration;

use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::DialectName;
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::{Mm2, Mm3};

use super::controller::{Disturbance, SimulatedController};
use super::line::Wire;
use super::servo_drive::ServoDrive;
use crate::faults::Faults;
use crate::{SimSettings, speaking};

/// A machine at the end of a serial line.
#[derive(Debug)]
pub struct SimMachine {
    controller: Box<dyn SimulatedController>,
    to_controller: Wire,
    to_host: Wire,
    drives: Option<ServoDrive>,
    positioning_error: PositioningError,
    fresh: Vec<Sample>,
    moved: Vec<Sample>,
    samples: Vec<Sample>,
    bytes: Vec<u8>,
    connected: bool,
}

/// The difference between the tool's true and commanded position, within the machine's repeatability.
#[derive(Clone, Debug)]
pub struct PositioningError {
    random: fastrand::Rng,
    band_mm: f64,
    now: Mm2,
    goal: Mm2,
    steps_per_mm: f64,
    /// Band and steps per mm of the third axis.
    up: Option<[f64; 2]>,
    sudden: bool,
}

/// Step of a wandering error per sample, mm.
const DRIFT: f64 = 1e-5;

impl PositioningError {
    /// An error that drifts inside the band while the machine moves.
    #[must_use]
    pub fn wandering(band_mm: f64, steps_per_mm: f64, seed: u64) -> Self {
        let random = fastrand::Rng::with_seed(seed);
        Self { random, band_mm, now: Mm2::ZERO, goal: Mm2::ZERO, steps_per_mm, up: None, sudden: false }
    }

    /// An error that jumps inside the band, as when drives lose steps and regain them.
    #[must_use]
    pub fn sudden(band_mm: f64, steps_per_mm: f64, seed: u64) -> Self {
        Self { sudden: true, ..Self::wandering(band_mm, steps_per_mm, seed) }
    }

    /// The same error, with one of the third axis.
    #[must_use]
    pub fn of_three_axes(self, z: Option<&ZProfile>) -> Self {
        Self { up: z.map(|z| [z.repeatability_mm, z.steps_per_mm]), ..self }
    }

    fn step(&mut self) -> Mm2 {
        let left = self.now.distance(self.goal);
        if self.sudden {
            if self.random.u8(0..8) == 0 {
                self.choose();
                self.now = self.goal;
            }
        } else if left < DRIFT {
            self.choose();
        } else {
            self.now = self.now + (self.goal - self.now) / left * DRIFT;
        }
        self.now
    }

    /// Chooses the next error to reach, uniform in the disc.
    fn choose(&mut self) {
        let (r, phi) = (self.random.f64().sqrt() * self.band_mm, self.random.f64() * std::f64::consts::TAU);
        self.goal = Mm2::new(r * phi.cos(), r * phi.sin());
    }

    /// Replaces the commanded position by the true one: on a step of the drive, plus the error.
    pub fn apply(&mut self, sample: &mut Sample) {
        let step = |c: f64, steps_per_mm: f64| (c * steps_per_mm).round() / steps_per_mm;
        let Mm3 { x, y, z } = sample.position_mm;
        let error = if sample.kind == SampleKind::Rest { self.now } else { self.step() };
        // The height errs with the error along x: downward as often as upward.
        let share = if self.band_mm > 0.0 { error.x / self.band_mm } else { 0.0 };
        let z = self.up.map_or(z, |[band_mm, steps_per_mm]| step(z, steps_per_mm) + band_mm * share);
        let (x, y) = (step(x, self.steps_per_mm), step(y, self.steps_per_mm));
        sample.position_mm = Mm3::new(x + error.x, y + error.y, z);
    }
}

impl SimMachine {
    /// A machine behind a line of `baud` that delays each byte by `latency` each way.
    #[must_use]
    pub fn new(
        controller: Box<dyn SimulatedController>,
        baud: u32,
        latency: Duration,
        positioning_error: PositioningError,
    ) -> Self {
        Self {
            controller,
            to_controller: Wire::new(baud, latency),
            to_host: Wire::new(baud, latency),
            drives: None,
            positioning_error,
            fresh: Vec::new(),
            moved: Vec::new(),
            samples: Vec::new(),
            bytes: Vec::new(),
            connected: true,
        }
    }

    /// A machine whose positioning error wanders within its repeatability, behind a line of a baud rate and a delay
    /// each way. Feed drives move it, if `servo` gives them.
    #[must_use]
    pub fn wandering(
        settings: SimSettings,
        dialect: &DialectName,
        (baud, latency): (u32, Duration),
        seed: u64,
        servo: Option<&DriveProfile>,
    ) -> Self {
        let MachineProfile { repeatability_mm, steps_per_mm, z, .. } = &settings.machine;
        let error =
            PositioningError::wandering(*repeatability_mm, *steps_per_mm, seed).of_three_axes(z.as_ref());
        let drives = servo.and_then(|servo| ServoDrive::new(servo, settings.start_mm.plane()));
        Self::new(speaking(dialect, settings), baud, latency, error).driven(drives)
    }

    /// Whether the machine has a third axis.
    #[must_use]
    pub fn has_height(&self) -> bool {
        self.positioning_error.up.is_some()
    }

    /// Adds feed drives that follow the commanded positions in their own time. Without drives, the tool is
    /// always at its commanded position.
    #[must_use]
    pub fn driven(mut self, drives: Option<ServoDrive>) -> Self {
        self.drives = drives;
        self
    }

    /// Adds faults to both directions of the line.
    #[must_use]
    pub fn hurt(mut self, to_controller: Faults, to_host: Faults) -> Self {
        self.to_controller = self.to_controller.hurt(to_controller);
        self.to_host = self.to_host.hurt(to_host);
        self
    }

    /// Sets the two ends of the line to different baud rates, or back to the same.
    pub fn mistune(&mut self, wrong: bool) {
        for wire in [&mut self.to_controller, &mut self.to_host] {
            if let Some(faults) = wire.faults() {
                faults.rubbish(wrong);
            }
        }
    }

    /// The number of faults so far on the line.
    pub fn faults(&mut self) -> u64 {
        let mut sum = 0;
        for wire in [&mut self.to_controller, &mut self.to_host] {
            sum += wire.faults().map_or(0, |faults| faults.happened());
        }
        sum
    }

    /// Pulls the cable, or puts it back.
    pub fn connect(&mut self, connected: bool) {
        self.connected = connected;
        if !connected {
            self.to_controller.cut();
            self.to_host.cut();
        }
    }

    /// Whether the cable is plugged in.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.connected
    }

    /// Applies a disturbance to the controller at `now`.
    pub fn disturb(&mut self, disturbance: Disturbance, now: Time) {
        self.advance(now);
        self.controller.disturb(disturbance);
        self.pass_on(now);
    }

    /// Takes bytes that the host writes.
    pub fn host_writes(&mut self, bytes: &[u8], now: Time) {
        if self.connected && !bytes.is_empty() {
            self.to_controller.send(bytes, now);
        }
    }

    /// Moves the bytes that have reached the host into `into`.
    pub fn host_reads(&mut self, into: &mut Vec<u8>, now: Time) {
        while let Some((_, byte)) = self.to_host.receive(now) {
            into.push(byte);
        }
    }

    /// Runs until `now`.
    pub fn advance(&mut self, now: Time) {
        loop {
            let arrival = self.to_controller.next_arrival().filter(|&at| at <= now);
            let drives = self.drives.as_ref();
            let tick = drives.map_or(Time::NEVER, |drives| drives.next_tick(self.controller.is_moving()));
            let event = self.controller.next_event().min(tick);
            match arrival {
                Some(at) if at <= event => {
                    if let Some((_, byte)) = self.to_controller.receive(now) {
                        self.take(byte, at);
                    }
                }
                _ if event <= now => {
                    self.controller.advance(event);
                    self.pass_on(event);
                    // The controller may have reached this time before, and then sends no sample.
                    if let Some(drives) = &mut self.drives {
                        drives.go_on(event, &mut self.moved);
                    }
                    if event < tick && self.controller.next_event() <= event {
                        break;
                    }
                }
                _ => break,
            }
        }
        self.controller.advance(now);
        self.pass_on(now);
    }

    /// Passes a byte to the controller. Most bytes only wait in its buffer, so the machine advances only for
    /// realtime characters.
    fn take(&mut self, byte: u8, at: Time) {
        if self.controller.is_realtime(byte) {
            self.controller.advance(at);
            self.controller.receive(byte);
            self.pass_on(at);
        } else {
            self.controller.receive(byte);
        }
    }

    fn pass_on(&mut self, now: Time) {
        self.controller.transmit(&mut self.bytes);
        if self.connected && !self.bytes.is_empty() {
            self.to_host.send(&self.bytes, now);
        }
        self.bytes.clear();
        self.controller.take_samples(&mut self.fresh);
        match &mut self.drives {
            None => self.moved.append(&mut self.fresh),
            Some(drives) => {
                self.fresh.drain(..).for_each(|sample| drives.follow(&sample, &mut self.moved));
            }
        }
        for mut sample in self.moved.drain(..) {
            self.positioning_error.apply(&mut sample);
            self.samples.push(sample);
        }
    }

    /// The time of the machine's next action that the host can notice, or a later time.
    #[must_use]
    pub fn next_event(&self) -> Time {
        let controller = self.controller.next_event();
        let there =
            self.to_controller.next_minded(|byte| self.controller.is_realtime(byte)).unwrap_or(Time::NEVER);
        let here = self.to_host.next_line().unwrap_or(Time::NEVER);
        controller.min(there).min(here)
    }

    /// Moves the true tool positions since the last call into `into`. The tool moves straight between them.
    pub fn take_samples(&mut self, into: &mut Vec<Sample>) {
        into.append(&mut self.samples);
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
        if !self.machine.is_connected() {
            return Err(PortError::Lost { name: "simulated".into(), reason: "unplugged".into() });
        }
        self.machine.host_writes(bytes, now);
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        self.machine.advance(now);
        self.machine.host_reads(into, now);
        if self.machine.is_connected() {
            return Ok(());
        }
        Err(PortError::Lost { name: "simulated".into(), reason: "unplugged".into() })
    }

    fn next_event(&self) -> Time {
        self.machine.next_event()
    }
}
