//! Follows a device through unplugging and plugging in.

use std::io;
use std::time::Duration;

use keepout_executor::operator::Panel;
use keepout_executor::supervisor::OperatorCommand;

use super::DeviceError;
use super::map::Mapping;
use super::pad::{Pad, RawEvent, Snapshot};

/// Devices that may be plugged in.
pub trait Devices {
    /// One of them.
    type Device: Device;

    /// Opens the device that is wanted.
    ///
    /// # Errors
    /// [`DeviceError`] when it is not there.
    fn find(&mut self) -> Result<Self::Device, DeviceError>;
}

/// An open device; nothing here waits.
pub trait Device {
    /// Its name.
    fn name(&self) -> String;

    /// Its whole state.
    ///
    /// # Errors
    /// What the system says, when it is gone.
    fn snapshot(&mut self) -> io::Result<Snapshot>;

    /// Appends the events since the last call; none is no error.
    ///
    /// # Errors
    /// What the system says, when it is gone.
    fn read(&mut self, events: &mut Vec<RawEvent>) -> io::Result<()>;
}

/// What is known of the device at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Counts the times that the device was plugged in or lost its events: what is held across a change of it may not
    /// move the tool.
    pub connection: u64,
    /// Whether the device is there and its state is known.
    pub known: bool,
    /// The stick's raw axes, −1 to 1; up is +y.
    pub axes: (f64, f64),
    /// A dead-man button is held.
    pub dead_man: bool,
    /// Automatic mode is on.
    pub automatic: bool,
    /// What was asked for since the last reading, in order.
    pub asks: Vec<OperatorCommand>,
    /// How far handwheels were turned since it was last taken, mm.
    pub turned_mm: (f64, f64),
    /// The handwheel's axis and step, to be shown.
    pub status: String,
}

/// A device that is gone is looked for this often.
pub const LOOK_EVERY: Duration = Duration::from_millis(500);

/// Reads a device and follows it; time is an argument.
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
    /// A reader of the device that is there now.
    ///
    /// # Errors
    /// [`DeviceError`] when none is there: a session begins with its operator's device plugged in.
    pub fn open(mut devices: D, mapping: Mapping, panel: Panel) -> Result<Self, DeviceError> {
        let device = devices.find()?;
        panel.say(format!("steered by {}", device.name()));
        let device = Some(device);
        let pad = Pad::new(mapping);
        Ok(Self { devices, device, pad, look_at: Duration::ZERO, connection: 1, panel, events: Vec::new() })
    }

    /// How far handwheels were turned since this was last asked, mm; readings leave it out, so that the bound holds for
    /// each input, however many readings there are between two.
    pub fn take_turned_mm(&mut self) -> (f64, f64) {
        self.pad.wheel().take_mm()
    }

    /// Takes what the device says, or looks for it; `now` since any beginning.
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
                self.panel.say("events of the device were lost: centre the stick and let go of the dead-man");
            }
            let snapshot = device.snapshot()?;
            self.pad.resynchronise(snapshot);
        }
        Ok(())
    }

    fn unplug(&mut self, reason: &io::Error, now: Duration) {
        let name = self.device.take().map_or(String::new(), |device| device.name());
        self.pad.lose();
        self.pad.take_asks();
        self.connection += 1;
        self.look_at = now + LOOK_EVERY;
        self.panel.say(format!("{name} is unplugged ({reason}): nothing moves until it is back"));
    }

    fn look(&mut self, now: Duration) {
        self.look_at = now + LOOK_EVERY;
        if let Ok(device) = self.devices.find() {
            self.panel.say(format!("{} is back: centre the stick and let go of the dead-man", device.name()));
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
            automatic: self.pad.automatic(),
            asks: self.pad.take_asks(),
            turned_mm: (0.0, 0.0),
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

    /// A device that a test plays: what it says next, and the state it is in.
    #[derive(Debug, Default)]
    pub struct Played {
        pub plugged: bool,
        pub says: VecDeque<RawEvent>,
        pub state: Snapshot,
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
            events.extend(played.says.drain(..));
            Ok(())
        }
    }

    /// A stick that stands at `x` of ±100, with or without the left shoulder held.
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
    fn an_unplugged_device_says_nothing_and_is_looked_for_twice_a_second() {
        let (fake, mut reader, panel) = plugged(standing(50, true));
        let first = reader.round(ms(0));
        assert!(first.known && first.dead_man && first.axes == (0.5, 0.0));
        fake.0.borrow_mut().plugged = false;
        let gone = reader.round(ms(4));
        assert!(!gone.known && !gone.dead_man && gone.axes == (0.0, 0.0));
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
    fn lost_events_are_a_new_connection_and_the_state_is_read_anew() {
        let (fake, mut reader, _) = plugged(standing(0, false));
        let first = reader.round(ms(0));
        {
            let mut played = fake.0.borrow_mut();
            played.says.extend([RawEvent::Dropped, RawEvent::Report]);
            played.state = standing(-100, true);
        }
        let after = reader.round(ms(4));
        assert!(after.known && after.axes == (-1.0, 0.0) && after.connection > first.connection);
    }
}
