//! A simulated Zaber ASCII controller with streams, as far as a host can observe it.
//!
//! It follows the protocol's description, not a device. It drops messages with a wrong checksum without an
//! answer. A full stream answers `RJ … AGAIN`, a target beyond the travel `RJ … BADDATA`, and a stream that
//! was not set up `RJ … BADCOMMAND`.

use std::fmt::Write as _;

use keepout_drives::interpolator::Drives;
use keepout_executor::dialect::zaber::wire::{checksum, content};
use keepout_executor::session::Sample;
use keepout_guard::Time;
use keepout_planner::Mm3;

use super::controller::{Disturbance, SimulatedController};
use super::grbl::SimSettings;
use super::plant::Plant;

/// The simulated controller.
#[derive(Clone, Debug)]
pub struct ZaberSim {
    settings: SimSettings,
    plant: Plant,
    line: Vec<u8>,
    tx: Vec<u8>,
    checksums: bool,
    live: bool,
    homed: bool,
    fault: Option<&'static str>,
    feed: f64,
}

/// Longest message, bytes.
const LINE_MAX: usize = 80;
/// Capacity of a stream, lines.
const STREAM_MAX: usize = 16;
/// Speed units per microstep/s.
const SPEED_UNIT: f64 = 1.6384;

impl ZaberSim {
    /// A controller that was just switched on.
    #[must_use]
    pub fn new(settings: SimSettings) -> Self {
        let drives = Drives::of(&settings.machine, 0.01);
        Self {
            plant: Plant::new(drives, settings.start_mm),
            homed: settings.homed,
            feed: settings.machine.max_rate_mm_s,
            settings,
            line: Vec::new(),
            tx: Vec::new(),
            checksums: false,
            live: false,
            fault: None,
        }
    }

    fn steps(&self, mm: f64) -> f64 {
        (mm * self.settings.machine.steps_per_mm).round()
    }

    /// Travel of each axis in microsteps: the far end is machine zero.
    fn travel(&self) -> Vec<f64> {
        let machine = &self.settings.machine;
        let plane = machine.travel_mm.map(|travel| self.steps(travel));
        let up = machine.z.as_ref().map(|z| (z.travel_mm * z.steps_per_mm).round());
        plane.into_iter().chain(up).collect()
    }

    /// Microsteps per mm of each axis.
    fn steps_per_mm(&self) -> Vec<f64> {
        let machine = &self.settings.machine;
        let up = machine.z.as_ref().map(|z| z.steps_per_mm);
        [machine.steps_per_mm; 2].into_iter().chain(up).collect()
    }

    /// Handles a complete message.
    fn take(&mut self) {
        let line = std::mem::take(&mut self.line);
        let Ok(text) = std::str::from_utf8(&line) else { return };
        let Some(content) = text.strip_prefix('/').and_then(|_| content(text, false)) else { return };
        let mut fields = content.splitn(4, ' ');
        let (device, axis) = (fields.next(), fields.next());
        let (number, command) = (fields.next().unwrap_or(""), fields.next().unwrap_or(""));
        if device != Some("1") || axis != Some("0") || number.len() != 2 {
            return;
        }
        let outcome = self.execute(command);
        let (flag, data) = match &outcome {
            Ok(data) => ("OK", data.as_str()),
            Err(reason) => ("RJ", *reason),
        };
        let status = if self.plant.is_busy() { "BUSY" } else { "IDLE" };
        let warning = self.fault.unwrap_or(if self.homed { "--" } else { "WR" });
        self.say(&format!("@01 0 {number} {flag} {status} {warning} {data}"));
    }

    fn say(&mut self, message: &str) {
        self.tx.extend(message.bytes());
        if self.checksums {
            let mut sum = String::new();
            let _ = write!(sum, ":{:02X}", checksum(&message.as_bytes()[1..]));
            self.tx.extend(sum.bytes());
        }
        self.tx.extend(b"\r\n");
    }

    fn execute(&mut self, command: &str) -> Result<String, &'static str> {
        let machine = &self.settings.machine;
        let up = machine.z.as_ref();
        let set_up = if up.is_some() { "stream 1 setup live 1 2 3" } else { "stream 1 setup live 1 2" };
        match command {
            "" => Ok("0".into()),
            "get pos" => {
                let Mm3 { x, y, z } = self.plant.position();
                let axes = [x, y, z].into_iter().zip(self.steps_per_mm()).zip(self.travel());
                Ok(whole(axes.map(|((mm, steps), travel)| (mm * steps).round() + travel)))
            }
            "get limit.max" => Ok(whole(self.travel().into_iter())),
            "get maxspeed" => {
                let rates = [machine.max_rate_mm_s; 2].into_iter().chain(up.map(|z| z.max_rate_mm_s));
                Ok(whole(rates.zip(self.steps_per_mm()).map(|(rate, steps)| rate * steps * SPEED_UNIT)))
            }
            "get accel" => {
                let each =
                    [machine.acceleration_mm_s2; 2].into_iter().chain(up.map(|z| z.acceleration_mm_s2));
                let in_units = |(mm_s2, steps): (f64, f64)| mm_s2 * steps * SPEED_UNIT / 10_000.0;
                Ok(whole(each.zip(self.steps_per_mm()).map(in_units)))
            }
            "set comm.checksum 1" => {
                self.checksums = true;
                Ok("0".into())
            }
            "home" => {
                (self.live, self.homed) = (false, true);
                self.plant.home(self.settings.homing);
                Ok("0".into())
            }
            "stream 1 setup disable" => {
                self.live = false;
                Ok("0".into())
            }
            _ if command == set_up && self.plant.is_busy() => Err("STATUSBUSY"),
            _ if command == set_up => {
                self.live = true;
                Ok("0".into())
            }
            _ => self.stream(command),
        }
    }

    fn stream(&mut self, command: &str) -> Result<String, &'static str> {
        if !self.live {
            return Err("BADCOMMAND");
        }
        if let Some(speed) = command.strip_prefix("stream 1 set maxspeed ") {
            let speed: f64 = speed.parse().map_err(|_| "BADDATA")?;
            self.feed = speed / SPEED_UNIT / self.settings.machine.steps_per_mm;
            return Ok("0".into());
        }
        let Some(target) = command.strip_prefix("stream 1 line abs ") else { return Err("BADCOMMAND") };
        let axis = |(value, (travel, steps)): (&str, (f64, f64))| -> Option<f64> {
            let value = f64::from(value.parse::<i32>().ok()?);
            (0.0..=travel).contains(&value).then_some((value - travel) / steps)
        };
        let axes = self.travel().into_iter().zip(self.steps_per_mm());
        let values: Vec<&str> = target.split(' ').collect();
        let wanted = axes.len();
        let to: Option<Vec<f64>> = values.iter().copied().zip(axes).map(axis).collect();
        let to = to.filter(|_| values.len() == wanted).ok_or("BADDATA")?;
        let to = Mm3::new(to[0], to[1], to.get(2).copied().unwrap_or(0.0));
        if self.plant.is_homing() || self.fault.is_some() {
            return Err("STATUSBUSY");
        }
        if self.plant.queued() >= STREAM_MAX {
            return Err("AGAIN");
        }
        self.plant.push(to, self.feed);
        Ok("0".into())
    }
}

/// Whole numbers, with a space between.
fn whole(values: impl Iterator<Item = f64>) -> String {
    values.map(|value| format!("{value:.0}")).collect::<Vec<_>>().join(" ")
}

impl SimulatedController for ZaberSim {
    fn receive(&mut self, byte: u8) {
        match byte {
            b'\n' | b'\r' if self.line.is_empty() => {}
            b'\n' | b'\r' => self.take(),
            b'/' => {
                self.line.clear();
                self.line.push(byte);
            }
            0x20..0x7f if self.line.len() < LINE_MAX => self.line.push(byte),
            // Drops the message.
            _ => self.line.clear(),
        }
    }

    fn is_realtime(&self, byte: u8) -> bool {
        matches!(byte, b'\n' | b'\r')
    }

    fn advance(&mut self, now: Time) {
        self.plant.advance(now);
    }

    fn next_event(&self) -> Time {
        Time::NEVER
    }

    fn transmit(&mut self, into: &mut Vec<u8>) {
        into.append(&mut self.tx);
    }

    fn take_samples(&mut self, into: &mut Vec<Sample>) {
        self.plant.take_samples(into);
    }

    fn is_moving(&self) -> bool {
        self.plant.is_moving()
    }

    fn disturb(&mut self, disturbance: Disturbance) {
        self.plant.kill();
        (self.live, self.homed) = (false, false);
        match disturbance {
            Disturbance::Reset | Disturbance::BrownOut => self.checksums = false,
            Disturbance::Alarm => self.fault = Some("FS"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use keepout_planner::machine::MachineProfile;

    use super::*;

    fn sim() -> ZaberSim {
        ZaberSim::new(SimSettings {
            work_offset_mm: Mm3::ZERO,
            ..SimSettings::of(MachineProfile::simulated(), Mm3::new(-100.0, -100.0, 0.0))
        })
    }

    fn say(sim: &mut ZaberSim, command: &str, ms: u64) -> String {
        let message = format!("/1 0 07 {command}");
        let line = format!("{message}:{:02X}\n", checksum(&message.as_bytes()[1..]));
        line.bytes().for_each(|byte| sim.receive(byte));
        sim.advance(sim.plant.now().after(Duration::from_millis(ms)));
        let mut bytes = Vec::new();
        sim.transmit(&mut bytes);
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn stream_runs_lines_and_rejects_bad_targets_and_overflow() {
        let mut sim = sim();
        assert_eq!(say(&mut sim, "get pos", 1), "@01 0 07 OK IDLE -- 120000 100000\r\n");
        assert_eq!(say(&mut sim, "stream 1 line abs 0 0", 1), "@01 0 07 RJ IDLE -- BADCOMMAND\r\n");
        assert_eq!(say(&mut sim, "set comm.checksum 1", 1), "@01 0 07 OK IDLE -- 0:06\r\n");
        assert!(say(&mut sim, "stream 1 setup live 1 2", 1).contains("OK IDLE"));
        assert!(say(&mut sim, "stream 1 line abs 120400 100400", 1).contains("OK BUSY -- 0"));
        assert!(say(&mut sim, "stream 1 line abs 900000 0", 500).contains("RJ BUSY -- BADDATA"));
        assert!(say(&mut sim, "get pos", 1).contains("OK IDLE -- 120400 100400"));
        for k in 0..20 {
            let answer = say(&mut sim, &format!("stream 1 line abs {} 100000", 110_000 - 100 * k), 0);
            assert_eq!(answer.contains("AGAIN"), k >= 16, "{k} {answer}");
        }
    }

    #[test]
    fn damaged_messages_are_dropped_and_faults_are_flagged() {
        let mut sim = sim();
        b"/1 0 07 get pos:00\n".iter().for_each(|&byte| sim.receive(byte));
        assert_eq!(say(&mut sim, "", 1), "@01 0 07 OK IDLE -- 0\r\n");
        sim.disturb(Disturbance::Reset);
        assert!(say(&mut sim, "", 1).contains(" WR "));
        sim.disturb(Disturbance::Alarm);
        assert!(say(&mut sim, "", 1).contains(" FS "));
        assert!(say(&mut sim, "home", 2000).contains("BUSY"));
    }
}
