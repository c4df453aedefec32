//! A simulated controller for a described dialect.
//!
//! It echoes and prompts as described. It rejects unknown lines (error 1), motions while it moves if it has
//! no queue (2), and targets beyond the travel (3).

use std::collections::VecDeque;
use std::sync::Arc;

use keepout_drives::interpolator::Drives;
use keepout_executor::dialect::Description;
use keepout_executor::dialect::described::{Accepted, Figure, Slot, Template};
use keepout_executor::session::Sample;
use keepout_executor::supervisor::Mode;
use keepout_guard::{Interpolation, Time};
use keepout_planner::{Mm2, Mm3};

use super::controller::{Disturbance, SimulatedController};
use super::grbl::SimSettings;
use super::plant::Plant;

/// The simulated controller.
#[derive(Clone, Debug)]
pub struct DescribedSim {
    description: Arc<Description>,
    settings: SimSettings,
    plant: Plant,
    line: String,
    /// Received lines that wait for room in the queue, or for homing.
    waiting: VecDeque<String>,
    tx: Vec<u8>,
    homed: bool,
    fault: bool,
    /// The target that the lines of a motion have set so far, in written numbers.
    place: [f64; 3],
    feed: f64,
}

/// Longest line, characters.
const LINE_MAX: usize = 200;
/// Capacity of the motion queue.
const QUEUE_MAX: usize = 16;
/// Largest deviation of chords from an arc, mm.
const SAGITTA: f64 = 0.0005;

impl DescribedSim {
    /// A controller that was just switched on.
    #[must_use]
    pub fn new(description: &Arc<Description>, settings: SimSettings) -> Self {
        let drives = Drives::of(&settings.machine, 0.01);
        Self {
            description: Arc::clone(description),
            plant: Plant::new(drives, settings.start_mm),
            homed: settings.homed || description.home.is_empty(),
            settings,
            line: String::new(),
            waiting: VecDeque::new(),
            tx: Vec::new(),
            fault: false,
            place: [0.0; 3],
            feed: 1.0,
        }
    }

    fn say(&mut self, text: &str) {
        let space = if self.description.echo { " " } else { "" };
        self.tx.extend(space.bytes().chain(text.bytes()).chain(*b"\r\n"));
    }

    /// Takes lines until one has to wait: with a motion queue, lines wait while it is full.
    fn take_on(&mut self) {
        while !self.is_full() {
            let Some(line) = self.waiting.pop_front() else { break };
            self.take(&line);
        }
    }

    fn is_full(&self) -> bool {
        self.description.queues && self.plant.queued() >= QUEUE_MAX
    }

    fn take(&mut self, line: &str) {
        let description = Arc::clone(&self.description);
        match self.execute(&description, line) {
            Ok(Some(answer)) => self.say(&answer),
            Ok(None) => {
                if let Accepted::Answer(answer) = &description.accepted {
                    self.say(&written(answer, |_| String::new()));
                }
            }
            Err(code) => self.refuse(&description, code),
        }
        self.tx.extend(&description.prompt);
    }

    fn refuse(&mut self, description: &Description, code: u8) {
        let busy = code == 2;
        let errors = &description.errors;
        let fitting = errors.iter().find(|(_, transient)| *transient == busy).or(errors.first());
        if let Some((says, _)) = fitting {
            self.say(&written(says, |_| code.to_string()));
        }
    }

    /// Executes a line. Returns its answer besides the acknowledgement, or an error number.
    fn execute(&mut self, description: &Description, line: &str) -> Result<Option<String>, u8> {
        let is = |template: &Template| template.read(line).is_some();
        if line.trim().is_empty() {
            return Ok(None);
        }
        if is(&description.status.send) {
            return Ok(Some(self.answer(&description.status.answer)));
        }
        if let Some(position) = description.position.as_ref().filter(|position| is(&position.send)) {
            return Ok(Some(self.answer(&position.answer)));
        }
        if description.stop.as_ref().is_some_and(is) {
            match description.interpolation {
                Interpolation::Linear => self.plant.stop(),
                Interpolation::Independent => self.plant.stop_apart(),
            }
            return Ok(None);
        }
        if description.home.iter().any(is) {
            self.homed = true;
            self.plant.home(self.settings.homing);
            return Ok(None);
        }
        if description.prepare.iter().chain(&description.arm).any(is) {
            return Ok(None);
        }
        self.motion(description, line)
    }

    fn motion(&mut self, description: &Description, line: &str) -> Result<Option<String>, u8> {
        let kinds = [Some(&description.line), description.arcs.as_ref().map(|[left, _]| left)];
        let right = description.arcs.as_ref().map(|[_, right]| right);
        for (kind, lines) in kinds.into_iter().chain([right]).enumerate() {
            for (index, template) in lines.into_iter().flatten().enumerate() {
                let Some(captures) = template.read(line) else { continue };
                for (axis, slot) in [Slot::X, Slot::Y, Slot::Z].into_iter().enumerate() {
                    self.place[axis] = captures.number(slot).unwrap_or(self.place[axis]);
                }
                let feed = captures.number(Slot::Feed);
                self.feed = feed
                    .map_or(self.feed, |feed| feed * description.speed.ten() / description.speed.per_mm());
                if lines.is_some_and(|lines| index + 1 == lines.len()) {
                    let centre = captures.number(Slot::I).zip(captures.number(Slot::J)).map(Mm2::from);
                    self.drive(description, centre.filter(|_| kind > 0), kind == 1)?;
                }
                return Ok(None);
            }
        }
        Err(1)
    }

    fn drive(&mut self, description: &Description, centre: Option<Mm2>, left: bool) -> Result<(), u8> {
        let [x, y, z] = self.place;
        let to = self.machine_mm([x, y], description.zero).at_height(self.height_mm(z));
        if self.settings.is_beyond(to) {
            return Err(3);
        }
        if self.fault || !self.homed || self.plant.is_homing() || self.plant.is_busy() && !description.queues
        {
            return Err(2);
        }
        match (centre, description.contours) {
            (Some(Mm2 { x: i, y: j }), _) => self.arc(to, self.machine_mm([i, j], [0, 0]), left),
            // A controller whose contour motions are linear also drives jogs straight, unless it is stopped.
            (None, Interpolation::Linear) => self.plant.push(to, self.feed),
            (None, Interpolation::Independent) => self.plant.push_apart(to, self.feed),
        }
        Ok(())
    }

    /// Drives chords of an arc. Its centre lies at `ij` from the end of the last motion.
    fn arc(&mut self, end: Mm3, ij: Mm2, left: bool) {
        let from = self.plant.planned_end();
        let (to, centre) = (end.plane(), from.plane() + ij);
        let (radius, first, last) = (ij.length(), (-ij).angle(), (to - centre).angle());
        let turn = if left { last - first } else { first - last }.rem_euclid(std::f64::consts::TAU);
        let turn = if turn < 1e-9 { std::f64::consts::TAU } else { turn };
        let step = (8.0 * SAGITTA / radius.max(1e-6)).sqrt().min(0.5);
        let mut swept = step;
        while swept < turn {
            let phi = if left { first + swept } else { first - swept };
            let z = from.z + (end.z - from.z) * swept / turn;
            self.plant.push((centre + Mm2::unit(phi) * radius).at_height(z), self.feed);
            swept += step;
        }
        self.plant.push(end, self.feed);
    }

    /// Converts written numbers to machine coordinates, mm.
    fn machine_mm(&self, written: [f64; 2], zero: [i64; 2]) -> Mm2 {
        let Description { coordinate, swap, invert, .. } = *self.description;
        let axis = |k: usize| {
            let zero = f64::from(i32::try_from(zero[k]).unwrap_or(0));
            let mm = (written[k] * coordinate.ten() - zero) / coordinate.per_mm();
            if invert[k] { -mm } else { mm }
        };
        if swap { Mm2::new(axis(1), axis(0)) } else { Mm2::new(axis(0), axis(1)) }
    }

    /// Converts a written height to machine coordinates, mm. Without a third axis it is zero.
    fn height_mm(&self, written: f64) -> f64 {
        self.description.z.map_or(0.0, |z| {
            let zero = f64::from(i32::try_from(z.zero).unwrap_or(0));
            let mm = (written * z.coordinate.ten() - zero) / z.coordinate.per_mm();
            if z.invert { -mm } else { mm }
        })
    }

    /// The tool's position, as written numbers.
    fn position(&self) -> [String; 3] {
        let Description { coordinate, swap, invert, zero, .. } = *self.description;
        let steps = self.settings.machine.steps_per_mm;
        let Mm3 { x, y, z } = self.plant.position();
        let (a, b) = if swap { (y, x) } else { (x, y) };
        let axis = |mm: f64, invert: bool, zero: i64, (steps, figure): (f64, Figure)| {
            let on_step = (if invert { -mm } else { mm } * steps).round() / steps;
            let zero = f64::from(i32::try_from(zero).unwrap_or(0));
            figure.written((on_step * figure.per_mm()).round() + zero)
        };
        let up = self.description.z.zip(self.settings.machine.z.as_ref());
        let plane = (steps, coordinate);
        [
            axis(a, invert[0], zero[0], plane),
            axis(b, invert[1], zero[1], plane),
            up.map_or_else(String::new, |(form, axis_z)| {
                axis(z, form.invert, form.zero, (axis_z.steps_per_mm, form.coordinate))
            }),
        ]
    }

    fn state(&self) -> String {
        let modes = if self.fault || !self.homed && !self.plant.is_homing() {
            [Mode::Alarm, Mode::Other]
        } else if self.plant.is_homing() {
            [Mode::Homing, Mode::Moving]
        } else if self.plant.is_busy() {
            [Mode::Moving, Mode::Other]
        } else {
            [Mode::Idle, Mode::Other]
        };
        modes.into_iter().find_map(|mode| self.description.state(mode)).unwrap_or_default()
    }

    fn answer(&self, template: &Template) -> String {
        let [x, y, z] = self.position();
        written(template, |slot| match slot {
            Slot::X => x.clone(),
            Slot::Y => y.clone(),
            Slot::Z => z.clone(),
            Slot::Status => self.state(),
            _ => "0".into(),
        })
    }
}

/// A template with its slots filled in.
fn written(template: &Template, value: impl Fn(Slot) -> String) -> String {
    let mut bytes = Vec::new();
    template.write(&mut bytes, |slot, out: &mut Vec<u8>| out.extend(value(slot).bytes()));
    bytes.into_iter().map(char::from).collect()
}

impl SimulatedController for DescribedSim {
    fn receive(&mut self, byte: u8) {
        if self.description.echo {
            self.tx.push(byte);
            self.tx.extend((byte == b'\r').then_some(b'\n'));
        }
        if self.description.end.last() == Some(&byte) {
            let line = std::mem::take(&mut self.line);
            if self.waiting.len() < QUEUE_MAX {
                self.waiting.push_back(line);
            }
            self.take_on();
        } else if (0x20..0x7f).contains(&byte) && self.line.len() < LINE_MAX {
            self.line.push(char::from(byte));
        }
    }

    fn is_realtime(&self, byte: u8) -> bool {
        self.description.echo || self.description.end.last() == Some(&byte)
    }

    fn advance(&mut self, now: Time) {
        while let Some(event) =
            self.plant.next_event().filter(|&event| event < now && !self.waiting.is_empty())
        {
            self.plant.advance(event);
            self.take_on();
        }
        self.plant.advance(now);
        self.take_on();
    }

    fn next_event(&self) -> Time {
        self.plant.next_event().filter(|_| !self.waiting.is_empty()).unwrap_or(Time::NEVER)
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
        self.line.clear();
        self.waiting.clear();
        self.homed = self.description.home.is_empty();
        self.fault = disturbance == Disturbance::Alarm;
    }
}
