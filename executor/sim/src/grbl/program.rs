//! Lines of the simulated GRBL: system commands, jogs and G-code.

use std::collections::VecDeque;

use super::{GrblSim, Mode, MotionMode, Waiting};
use keepout_planner::Mm3;

impl GrblSim {
    /// Executes a line. Returns whether its `ok` is due now.
    pub(super) fn execute(&mut self, line: &str) -> Result<bool, u8> {
        match line {
            "" => Ok(true),
            "$H" => {
                self.mode = Mode::Home(self.now.after(self.settings.homing));
                Ok(false)
            }
            _ if line.starts_with("$J=") => self.jog(&line[3..]),
            _ if line.starts_with('$') => match line.split_once('=') {
                Some((name, value)) => self.set(name, value).map(|()| true),
                None => self.list(line).map(|()| true),
            },
            _ if matches!(self.mode, Mode::Alarm | Mode::Jog) => Err(9),
            _ => self.program(line),
        }
    }

    /// Stores a setting.
    fn set(&mut self, name: &str, value: &str) -> Result<(), u8> {
        match name {
            "$10" => self.report_mask = value.parse().map_err(|_| 2_u8)?,
            "$12" => self.arc_tolerance_mm = value.parse().map_err(|_| 2_u8)?,
            // GRBL stores startup lines at rest only, and not while it is locked.
            "$N0" | "$N1" if self.mode != Mode::Idle && !self.is_hal() => return Err(8),
            "$N0" => self.startup[0] = value.into(),
            "$N1" => self.startup[1] = value.into(),
            _ => return Err(3),
        }
        Ok(())
    }

    /// Answers a query, or unlocks the alarm.
    fn list(&mut self, line: &str) -> Result<(), u8> {
        match line {
            "$" => self.reply("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]"),
            "$I" => {
                let hal = self.is_hal();
                self.reply(if hal { "[VER:1.1f.20260817:]" } else { "[VER:1.1h.20190825:simulated]" });
                let letters = if self.settings.quirks.wakes_unlocked { "VL" } else { "V" };
                self.reply(&format!("[OPT:{letters},{},{}]", self.firmware.blocks, self.firmware.rx_buffer));
                if hal {
                    self.reply("[FIRMWARE:grblHAL]");
                }
            }
            "$G" => {
                let (place, units) = (if self.in_g54 { 54 } else { 55 }, if self.absolute { 90 } else { 91 });
                let feed = self.feed * 60.0;
                let (spindle, rpm) = (if self.spindle_rpm > 0.0 { 3 } else { 5 }, self.spindle_rpm);
                self.reply(&format!(
                    "[GC:G1 G{place} G17 G21 G{units} G94 M{spindle} M9 T0 F{feed:.0} S{rpm:.0}]"
                ));
            }
            "$$" => self.list_settings(),
            "$#" => self.list_parameters(),
            "$N" => {
                let [first, second] = self.startup.clone();
                self.reply(&format!("$N0={first}"));
                self.reply(&format!("$N1={second}"));
            }
            "$X" => self.mode = if self.mode == Mode::Alarm { Mode::Idle } else { self.mode },
            _ => return Err(3),
        }
        Ok(())
    }

    fn list_parameters(&mut self) {
        let Mm3 { x, y, z } = self.settings.work_offset_mm;
        self.reply(&format!("[G54:{x:.3},{y:.3},{z:.3}]"));
        for name in ["G55", "G56", "G57", "G58", "G59", "G28", "G30", "G92"] {
            self.reply(&format!("[{name}:0.000,0.000,0.000]"));
        }
        self.reply("[TLO:0.000]");
        self.reply("[PRB:0.000,0.000,0.000:0]");
    }

    fn list_settings(&mut self) {
        let machine = self.settings.machine.clone();
        let per_minute = machine.max_rate_mm_s * 60.0;
        let up = machine.z.iter().flat_map(|z| {
            [
                (102, z.steps_per_mm),
                (112, z.max_rate_mm_s * 60.0),
                (122, z.acceleration_mm_s2),
                (132, z.travel_mm),
            ]
        });
        let values = [
            (10, f64::from(self.report_mask)),
            (11, 0.01),
            (12, self.arc_tolerance_mm),
            (13, 0.0),
            (20, 1.0),
            (21, 1.0),
            (22, 1.0),
            (100, machine.steps_per_mm),
            (101, machine.steps_per_mm),
            (110, per_minute),
            (111, per_minute),
            (120, machine.acceleration_mm_s2),
            (121, machine.acceleration_mm_s2),
            (130, machine.travel_mm[0]),
            (131, machine.travel_mm[1]),
        ];
        let mut values: Vec<(u16, f64)> = values.into_iter().chain(up).collect();
        values.sort_by_key(|(number, _)| *number);
        for (number, value) in values {
            let text = if [10, 13, 20, 21, 22].contains(&number) {
                format!("${number}={value:.0}")
            } else {
                format!("${number}={value:.3}")
            };
            self.reply(&text);
        }
    }

    fn jog(&mut self, text: &str) -> Result<bool, u8> {
        if !matches!(self.mode, Mode::Idle | Mode::Jog) {
            return Err(8);
        }
        let words = words(text)?;
        if words.iter().any(|&(letter, value)| letter == 'G' && (value == 0.0 || value == 1.0)) {
            return Err(16);
        }
        let feed = value_of(&words, 'F').ok_or(22_u8)?;
        let relative = words.contains(&('G', 91.0));
        let offset = if words.contains(&('G', 53.0)) { Mm3::ZERO } else { self.work_offset() };
        let to = self.target(&words, !relative, offset)?;
        if self.settings.is_beyond(to) {
            return Err(15);
        }
        self.waiting = Some(Waiting { targets: VecDeque::from([to]), feed: feed / 60.0, jog: true });
        Ok(false)
    }

    pub(super) fn program(&mut self, text: &str) -> Result<bool, u8> {
        let words = words(text)?;
        for &(letter, value) in &words {
            if letter == 'G' {
                match value {
                    0.0 | 1.0 => self.motion_mode = MotionMode::Straight,
                    2.0 | 3.0 => self.motion_mode = MotionMode::Arc { left: value > 2.5 },
                    80.0 => self.motion_mode = MotionMode::Cancelled,
                    90.0 | 91.0 => self.absolute = value < 90.5,
                    // The next report carries a change of work coordinates.
                    20.0 | 21.0 => self.inches = value < 20.5,
                    54.0 => (self.in_g54, self.reports) = (true, 0),
                    55.0 => (self.in_g54, self.reports) = (false, 0),
                    50.0 if self.is_hal() => {}
                    17.0 | 40.0 | 49.0 | 53.0 | 94.0 => {}
                    _ => return Err(20),
                }
            }
            if letter == 'M' {
                match value {
                    3.0 => self.spindle_rpm = value_of(&words, 'S').unwrap_or(self.spindle_rpm),
                    5.0 => self.spindle_rpm = 0.0,
                    9.0 => {}
                    _ => return Err(20),
                }
            }
        }
        let unit_mm = if self.inches { 25.4 } else { 1.0 };
        if let Some(feed) = value_of(&words, 'F') {
            self.feed = feed * unit_mm / 60.0;
        }
        let words: Vec<(char, f64)> = words
            .into_iter()
            .map(|(letter, value)| (letter, if "XYZIJR".contains(letter) { value * unit_mm } else { value }))
            .collect();
        if ['X', 'Y', 'Z'].into_iter().all(|axis| value_of(&words, axis).is_none()) {
            return Ok(true);
        }
        if self.motion_mode == MotionMode::Cancelled {
            return Err(31);
        }
        if self.feed <= 0.0 {
            return Err(22);
        }
        let in_machine = words.contains(&('G', 53.0));
        let offset = if in_machine { Mm3::ZERO } else { self.work_offset() };
        let to = self.target(&words, self.absolute, offset)?;
        let targets = match self.motion_mode {
            MotionMode::Arc { left } => self.arc_chords(to, &words, left)?,
            _ => VecDeque::from([to]),
        };
        if targets.iter().any(|&target| self.settings.is_beyond(target)) {
            self.motion.kill();
            self.mode = Mode::Locked;
            self.reply("ALARM:2");
            self.reply("[MSG:Reset to continue]");
            return Ok(false);
        }
        self.waiting = Some(Waiting { targets, feed: self.feed, jog: false });
        Ok(false)
    }

    fn target(&self, words: &[(char, f64)], absolute: bool, offset: Mm3) -> Result<Mm3, u8> {
        let end = self.motion.planned_end();
        let axis = |letter, from: f64, offset: f64| match value_of(words, letter) {
            Some(value) if absolute => value + offset,
            Some(value) => from + value,
            None => from,
        };
        let (x, y) = (axis('X', end.x, offset.x), axis('Y', end.y, offset.y));
        let to = Mm3::new(single(x), single(y), single(axis('Z', end.z, offset.z)));
        if to.length().is_finite() { Ok(to) } else { Err(2) }
    }

    /// GRBL's `mc_arc`, in 32-bit floats as in the firmware. The number of chords is rounded down. A sweep on
    /// the wrong side of ±5e-7 rad becomes a full turn.
    #[expect(clippy::cast_possible_truncation, reason = "the firmware computes in f32")]
    fn arc_chords(&self, to: Mm3, words: &[(char, f64)], left: bool) -> Result<VecDeque<Mm3>, u8> {
        const EPSILON: f32 = 5e-7;
        let from = self.motion.planned_end();
        let (x, y, to_x, to_y) = (from.x as f32, from.y as f32, to.x as f32, to.y as f32);
        let (i, j) = match value_of(words, 'R') {
            Some(radius) => centre_of(to_x - x, to_y - y, radius as f32, left)?,
            None => (value_of(words, 'I').unwrap_or(0.0) as f32, value_of(words, 'J').unwrap_or(0.0) as f32),
        };
        let (cx, cy) = (x + i, y + j);
        let radius = i.hypot(j);
        let miss = ((to_x - cx).hypot(to_y - cy) - radius).abs();
        if radius == 0.0 || miss > 0.005 && (miss > 0.5 || miss > 0.001 * radius) {
            return Err(33);
        }
        let (rx, ry, tx, ty) = (-i, -j, to_x - cx, to_y - cy);
        let turned = (rx * ty - ry * tx).atan2(rx * tx + ry * ty);
        let turned = match left {
            false if turned >= -EPSILON => turned - std::f32::consts::TAU,
            true if turned <= EPSILON => turned + std::f32::consts::TAU,
            _ => turned,
        };
        let tolerance = (self.arc_tolerance_mm as f32).min(radius);
        let count = (0.5 * turned * radius).abs() / (tolerance * (2.0 * radius - tolerance)).sqrt();
        // The firmware counts in 16 bits.
        let count = count.floor().min(f32::from(u16::MAX));
        let mut targets = VecDeque::new();
        let mut k = 1.0;
        while k < count {
            let phi = ry.atan2(rx) + turned * (k / count);
            let (x, y) = (f64::from(cx + radius * phi.cos()), f64::from(cy + radius * phi.sin()));
            let z = single(from.z + (to.z - from.z) * f64::from(k / count));
            targets.push_back(Mm3::new(x, y, z));
            k += 1.0;
        }
        targets.push_back(to);
        Ok(targets)
    }
}

/// The centre of an arc given by its radius, relative to the start, as GRBL computes it.
fn centre_of(x: f32, y: f32, radius: f32, left: bool) -> Result<(f32, f32), u8> {
    if x == 0.0 && y == 0.0 {
        return Err(33);
    }
    let inside = 4.0 * radius * radius - x * x - y * y;
    if inside < 0.0 {
        return Err(34);
    }
    let h = -inside.sqrt() / x.hypot(y);
    let h = if left { -h } else { h };
    let h = if radius < 0.0 { -h } else { h };
    Ok((0.5 * (x - y * h), 0.5 * (y + x * h)))
}

/// A coordinate in the firmware's precision.
#[expect(clippy::cast_possible_truncation, reason = "the firmware computes in f32")]
fn single(value: f64) -> f64 {
    f64::from(value as f32)
}

/// The words of a line.
///
/// # Errors
/// GRBL's error number if a word is malformed or repeated, or if two words belong to one modal group.
fn words(text: &str) -> Result<Vec<(char, f64)>, u8> {
    let mut words: Vec<(char, f64)> = Vec::new();
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_uppercase() {
            return Err(1);
        }
        let number = &rest[1..];
        let end = number.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(number.len());
        let value = number[..end].parse().map_err(|_| 2_u8)?;
        for &(other, before) in words.iter().filter(|word| word.0 == letter) {
            match other {
                'G' if modal_group(before) == modal_group(value) => return Err(21),
                'G' => {}
                _ => return Err(25),
            }
        }
        words.push((letter, value));
        rest = &number[end..];
    }
    Ok(words)
}

/// The modal group of a G word, as the firmware numbers them.
fn modal_group(value: f64) -> u8 {
    match value {
        0.0 | 1.0 | 2.0 | 3.0 | 80.0 => 1,
        17.0..=19.0 => 2,
        90.0 | 91.0 => 3,
        93.0 | 94.0 => 5,
        20.0 | 21.0 => 6,
        40.0 => 7,
        49.0 => 8,
        54.0..=59.0 => 12,
        // Words that act on one line only: G4, G10, G53 and more.
        _ => 0,
    }
}

fn value_of(words: &[(char, f64)], letter: char) -> Option<f64> {
    words.iter().find(|word| word.0 == letter).map(|word| word.1)
}
