//! The reader of a device: follows it when it is unplugged and plugged in.

use std::io;
use std::time::Duration;

use keepout_executor::operator::Panel;
use keepout_executor::supervisor::OperatorCommand;
use keepout_planner::{Mm2, Mm3};

use super::DeviceError;
use super::map::Mapping;
use super::pad::{Pad, RawEvent, Snapshot};

/// The devices that can be plugged in.
pub trait Devices {
    /// An open device.
    type Device: Device;

    /// Opens the requested device.
    ///
    /// # Errors
    /// [`DeviceError`] when the device is missing.
    fn find(&mut self) -> Result<Self::Device, DeviceError>;
}

/// An open device. Its calls do not wait for events.
pub trait Device {
    /// Its name.
    fn name(&self) -> String;

    /// Reads its whole state.
    ///
    /// # Errors
    /// The system's error, when the device is gone.
    fn snapshot(&mut self) -> io::Result<Snapshot>;

    /// Appends the events since the last call. An empty result is not an error.
    ///
    /// # Errors
    /// The system's error, when the device is gone.
    fn read(&mut self, events: &mut Vec<RawEvent>) -> io::Result<()>;
}

/// State of the device at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Number of the connection. It changes when the device is plugged in or unplugged, or loses events. A
    /// stick that is held across a change may not move the tool.
    pub connection: u64,
    /// Whether the device is present and its state is known.
    pub known: bool,
    /// The stick's raw axes, −1 to 1. Up is +y.
    pub axes: Mm2,
    /// Whether a dead-man button is held.
    pub dead_man: bool,
    /// Speed along the third axis, as a share of full speed, upward.
    pub up: f64,
    /// Whether the cycle is armed.
    pub armed: bool,
    /// Commands since the last reading, in order.
    pub commands: Vec<OperatorCommand>,
    /// Distance that the handwheels were turned since the session loop last took it, mm.
    pub turned_mm: Mm3,
    /// Status line with the handwheel's axis and step size.
    pub status: String,
}

/// Time between two searches for a missing device.
pub const LOOK_EVERY: Duration = Duration::from_millis(500);

/// Reads a device, and finds it again after it was unplugged. Time is an argument.
#[derive(Debug)]
pub struct Reader<D: Devices> {
    devices: D,
    device: Option<D::Device>,
    pad: Pad,
    look_at: Duration,
    connection: u64,
    panel: Panel,
    events: Vec<RawEvent>,
}

impl<D: Devices> Reader<D> {
    /// Opens the requested device. A session begins only with its operator's device plugged in.
    ///
    /// # Errors
    /// [`DeviceError`] when the device is missing.
    pub fn open(mut devices: D, mapping: Mapping, panel: Panel) -> Result<Self, DeviceError> {
        let device = devices.find()?;
        panel.say(format!("jogging with {}", device.name()));
        let device = Some(device);
        let pad = Pad::new(mapping);
        Ok(Self { devices, device, pad, look_at: Duration::ZERO, connection: 1, panel, events: Vec::new() })
    }

    /// Takes the distance that the handwheels were turned since the last call, mm.
    ///
    /// [`Self::round`] leaves it out of its readings. So the bound on pulses holds for each input, for any
    /// number of readings between two inputs.
    pub fn take_turned_mm(&mut self) -> Mm3 {
        self.pad.wheel().take_mm()
    }

    /// Disarms the cycle.
    pub fn disarm(&mut self) {
        self.pad.disarm();
    }

    /// Reads the events of the device, or searches for a missing device. `now` counts from any fixed time.
    pub fn round(&mut self, now: Duration) -> Reading {
        match &mut self.device {
            Some(_) => {
                if let Err(reason) = self.follow() {
                    self.unplug(&reason, now);
                }
            }
            None if now >= self.look_at => self.look(now),
            None => {}
        }
        self.reading()
    }

    fn follow(&mut self) -> io::Result<()> {
        let Some(device) = &mut self.device else { return Ok(()) };
        self.events.clear();
        device.read(&mut self.events)?;
        let was_in_step = self.pad.in_step();
        for &event in &self.events {
            self.pad.take(event);
        }
        if !self.pad.in_step() {
            if was_in_step {
                self.connection += 1;
                self.panel
                    .say("events of the device were lost: centre the stick, and release the dead-man button");
            }
            let snapshot = device.snapshot()?;
            self.pad.resynchronise(snapshot);
        }
        Ok(())
    }

    fn unplug(&mut self, reason: &io::Error, now: Duration) {
        let name = self.device.take().map_or(String::new(), |device| device.name());
        self.pad.lose();
        self.pad.take_commands();
        self.connection += 1;
        self.look_at = now + LOOK_EVERY;
        self.panel.say(format!("{name} is unplugged ({reason}): motion stops. Plug it in again"));
    }

    fn look(&mut self, now: Duration) {
        self.look_at = now + LOOK_EVERY;
        if let Ok(device) = self.devices.find() {
            self.panel
                .say(format!("{} is back: centre the stick, and release the dead-man button", device.name()));
            self.connection += 1;
            self.device = Some(device);
        }
    }

    fn reading(&mut self) -> Reading {
        let wheel = self.pad.wheel();
        let status = format!("handwheel {:?} {}", wheel.axis(), wheel.step().text());
        Reading {
            connection: self.connection,
            known: self.device.is_some() && self.pad.in_step(),
            axes: self.pad.axes(),
            dead_man: self.pad.dead_man(),
            up: self.pad.up(),
            armed: self.pad.armed(),
            commands: self.pad.take_commands(),
            turned_mm: Mm3::ZERO,
            status,
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::cell::RefCell;
    use std::collections::{BTreeSet, VecDeque};
    use std::rc::Rc;

    use super::super::pad::AxisRange;
    use super::*;

    /// A simulated device: its next events and its state.
    #[derive(Debug, Default)]
    pub struct Played {
        pub plugged: bool,
        pub events: VecDeque<RawEvent>,
        pub state: Snapshot,
        /// Number of searches for the device.
        pub looked: usize,
    }

    #[derive(Clone, Debug, Default)]
    pub struct Fake(pub Rc<RefCell<Played>>);

    impl Devices for Fake {
        type Device = Self;

        fn find(&mut self) -> Result<Self, DeviceError> {
            self.0.borrow_mut().looked += 1;
            if self.0.borrow().plugged {
                Ok(self.clone())
            } else {
                Err(DeviceError::None { what: "stick", seen: 0, example: "" })
            }
        }
    }

    impl Device for Fake {
        fn name(&self) -> String {
            "a fake".into()
        }

        fn snapshot(&mut self) -> io::Result<Snapshot> {
            let played = self.0.borrow();
            if played.plugged { Ok(played.state.clone()) } else { Err(io::ErrorKind::NotFound.into()) }
        }

        fn read(&mut self, events: &mut Vec<RawEvent>) -> io::Result<()> {
            let mut played = self.0.borrow_mut();
            if !played.plugged {
                return Err(io::ErrorKind::NotFound.into());
            }
            events.extend(played.events.drain(..));
            Ok(())
        }
    }

    /// A stick at `x` of ±100, with or without the left shoulder button held.
    pub fn standing(x: i32, dead_man: bool) -> Snapshot {
        let range = AxisRange { low: -100, high: 100 };
        let buttons = if dead_man { BTreeSet::from([0x136]) } else { BTreeSet::new() };
        Snapshot { axes: Some([(range, x), (range, 0)]), buttons }
    }

    fn ms(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    fn plugged(state: Snapshot) -> (Fake, Reader<Fake>, Panel) {
        let fake = Fake::default();
        *fake.0.borrow_mut() = Played { plugged: true, state, ..Played::default() };
        let panel = Panel::default();
        let reader = Reader::open(fake.clone(), Mapping::default(), panel.clone()).unwrap();
        (fake, reader, panel)
    }

    #[test]
    fn without_a_device_there_is_no_session() {
        assert!(Reader::open(Fake::default(), Mapping::default(), Panel::default()).is_err());
    }

    #[test]
    fn unplugged_device_gives_no_input_and_is_searched_twice_a_second() {
        let (fake, mut reader, panel) = plugged(standing(50, true));
        let first = reader.round(ms(0));
        assert!(first.known && first.dead_man && first.axes == Mm2::new(0.5, 0.0));
        fake.0.borrow_mut().plugged = false;
        let gone = reader.round(ms(4));
        assert!(!gone.known && !gone.dead_man && gone.axes == Mm2::ZERO);
        assert!(gone.connection > first.connection);
        assert!(panel.notices().last().unwrap().contains("unplugged"));
        let looked = fake.0.borrow().looked;
        (0..500).for_each(|i| drop(reader.round(ms(8 + 4 * i))));
        assert!((3..=4).contains(&(fake.0.borrow().looked - looked)), "in two seconds");
        fake.0.borrow_mut().plugged = true;
        reader.round(ms(3000));
        let back = reader.round(ms(3004));
        assert!(back.known && back.connection > gone.connection);
        assert!(panel.notices().last().unwrap().contains("is back"));
    }

    #[test]
    fn lost_events_start_a_new_connection_and_the_state_is_read_again() {
        let (fake, mut reader, _) = plugged(standing(0, false));
        let first = reader.round(ms(0));
        {
            let mut played = fake.0.borrow_mut();
            played.events.extend([RawEvent::Dropped, RawEvent::Report]);
            played.state = standing(-100, true);
        }
        let after = reader.round(ms(4));
        assert!(after.known && after.axes == Mm2::new(-1.0, 0.0) && after.connection > first.connection);
    }
}
