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
use keepout_planner::Mm2;

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

    /// Travel in microsteps: the far end is machine zero.
    fn travel(&self) -> (f64, f64) {
        let [width, height] = self.settings.machine.travel_mm;
        (self.steps(width), self.steps(height))
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
        match command {
            "" => Ok("0".into()),
            "get pos" => {
                let (Mm2 { x, y }, (w, h)) = (self.plant.position(), self.travel());
                Ok(format!("{:.0} {:.0}", self.steps(x) + w, self.steps(y) + h))
            }
            "get limit.max" => Ok(format!("{:.0} {:.0}", self.travel().0, self.travel().1)),
            "get maxspeed" => {
                let speed = machine.max_rate_mm_s * machine.steps_per_mm * SPEED_UNIT;
                Ok(format!("{speed:.0} {speed:.0}"))
            }
            "get accel" => {
                let acceleration = machine.acceleration_mm_s2 * machine.steps_per_mm * SPEED_UNIT / 10_000.0;
                Ok(format!("{acceleration:.0} {acceleration:.0}"))
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
            "stream 1 setup live 1 2" if self.plant.is_busy() => Err("STATUSBUSY"),
            "stream 1 setup live 1 2" => {
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
        let (x, y) = target.split_once(' ').ok_or("BADDATA")?;
        let (x, y): (i64, i64) = (x.parse().map_err(|_| "BADDATA")?, y.parse().map_err(|_| "BADDATA")?);
        let (w, h) = self.travel();
        let axis = |value: i64, travel: f64| -> Result<f64, &'static str> {
            let value: f64 = i32::try_from(value).map_err(|_| "BADDATA")?.into();
            let inside = (0.0..=travel).contains(&value);
            if inside { Ok((value - travel) / self.settings.machine.steps_per_mm) } else { Err("BADDATA") }
        };
        let to = Mm2::new(axis(x, w)?, axis(y, h)?);
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
            work_offset_mm: Mm2::ZERO,
            ..SimSettings::of(MachineProfile::simulated(), Mm2::new(-100.0, -100.0))
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
