//! The operator at a gamepad, joystick or handwheel. A thread reads the device, the session loop takes its
//! last reading.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use keepout_executor::operator::{Operator, OperatorView, Panel};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase, Stick};
use keepout_guard::Time;
use keepout_planner::Mm3;

use super::device::{DeviceError, Devices, EnablingInterlock, Mapping, Reader, Reading, Wanted};

/// Time between two reads of the device.
const LOOK: Duration = Duration::from_millis(4);
/// Most commands that are kept until the loop takes them.
const COMMANDS_MAX: usize = 8;

/// Last reading of the thread, and the commands that the loop has not taken.
#[derive(Debug)]
struct Left {
    reading: Reading,
    commands: VecDeque<OperatorCommand>,
    /// Time of the reading.
    at: Instant,
    /// Whether the loop has taken the reading.
    taken: bool,
    /// A contour began: the thread is to disarm the cycle.
    disarm: bool,
}

/// The operator at an input device. Dropping it ends its thread.
pub struct Gamepad {
    interlock: EnablingInterlock,
    /// Last reading that the loop took. It serves while the thread holds the lock.
    last: Reading,
    /// Time of that reading.
    read_at: Instant,
    /// A contour began, and the thread does not know it yet.
    disarm: bool,
    /// A contour runs, and the operator could not stop it: the device is gone or silent.
    holds: bool,
    left: Arc<Mutex<Left>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    panel: Panel,
    wheel: bool,
}

impl Gamepad {
    /// Opens a device of this computer and reads it from now on. Notices go to `panel`.
    ///
    /// # Errors
    /// [`DeviceError`] when the device is missing or may not be read, or when the system is not Linux.
    pub fn open(wanted: Wanted, mapping: Mapping, stick: Stick, panel: Panel) -> Result<Self, DeviceError> {
        #[cfg(target_os = "linux")]
        {
            let wheel = wanted == Wanted::Wheel;
            let devices = super::device::EvdevDevices::new(wanted, mapping.clone());
            let mut opened = Self::of(devices, mapping, stick, panel)?;
            opened.wheel = wheel;
            Ok(opened)
        }
        #[cfg(not(target_os = "linux"))]
        {
            let _ = (wanted, mapping, stick, panel);
            Err(DeviceError::NotLinux)
        }
    }

    /// Opens one of `devices` and reads it from now on.
    ///
    /// # Errors
    /// [`DeviceError`] when the device is missing.
    pub fn of<D: Devices + Send + 'static>(
        devices: D,
        mapping: Mapping,
        stick: Stick,
        panel: Panel,
    ) -> Result<Self, DeviceError>
    where
        D::Device: Send,
    {
        let reader = Reader::open(devices, mapping, panel.clone())?;
        let began = Instant::now();
        let left = Arc::new(Mutex::new(Left {
            reading: Reading::default(),
            commands: VecDeque::new(),
            at: began,
            taken: true,
            disarm: false,
        }));
        let stop = Arc::new(AtomicBool::new(false));
        let shared = (Arc::clone(&left), Arc::clone(&stop));
        let thread = std::thread::Builder::new()
            .name("operator's device".into())
            .spawn(move || serve(reader, began, &shared.0, &shared.1))
            .map_err(DeviceError::Thread)?;
        Ok(Self {
            interlock: EnablingInterlock::new(stick, panel.clone()),
            last: Reading::default(),
            read_at: began,
            disarm: false,
            holds: false,
            left,
            stop,
            thread: Some(thread),
            panel,
            wheel: false,
        })
    }
}

impl Gamepad {
    /// Status line: the dead-man button or the handwheel, and whether the cycle is armed.
    fn status(&self) -> String {
        let device = match (self.wheel, self.last.dead_man) {
            (true, _) => self.last.status.as_str(),
            (false, true) => "dead-man held",
            (false, false) => "dead-man released",
        };
        let armed = if self.last.armed { ", armed" } else { "" };
        format!("{device}{armed}")
    }
}

/// The reading thread: reads the device, and leaves each reading for the loop.
fn serve<D: Devices>(mut reader: Reader<D>, began: Instant, left: &Mutex<Left>, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let at = Instant::now();
        let reading = reader.round(at.duration_since(began));
        leave(&mut reader, reading, at, &mut left.lock().unwrap_or_else(PoisonError::into_inner));
        std::thread::sleep(LOOK);
    }
}

/// Leaves a reading for the loop. The reader keeps further handwheel turns until the loop has taken the last
/// ones.
fn leave<D: Devices>(reader: &mut Reader<D>, mut reading: Reading, at: Instant, left: &mut Left) {
    if std::mem::take(&mut left.disarm) {
        reader.disarm();
        reading.armed = false;
    }
    for command in std::mem::take(&mut reading.commands) {
        if left.commands.len() >= COMMANDS_MAX && command == OperatorCommand::Stop {
            left.commands.pop_back();
        }
        if left.commands.len() < COMMANDS_MAX {
            left.commands.push_back(command);
        }
    }
    if left.taken {
        reading.turned_mm = reader.take_turned_mm();
    } else if left.reading.connection == reading.connection {
        reading.turned_mm = left.reading.turned_mm;
    }
    (left.reading, left.at, left.taken) = (reading, at, false);
}

impl Operator for Gamepad {
    fn input(&mut self, view: &OperatorView, _: Time) -> OperatorInput {
        self.last.turned_mm = Mm3::ZERO;
        // A contact start disarms the cycle: the next contour needs the button again.
        let started = matches!(view.phase, Phase::Touching | Phase::Contouring);
        self.disarm |= started;
        if let Ok(mut left) = self.left.try_lock() {
            if std::mem::take(&mut self.disarm) {
                left.disarm |= left.reading.armed;
                left.reading.armed = false;
            }
            self.last = left.reading.clone();
            self.read_at = left.at;
            left.reading.turned_mm = Mm3::ZERO;
            left.taken = true;
        }
        self.last.armed &= !started && !self.disarm;
        self.panel.set_status(&self.status());
        let input = self.interlock.input(&self.last, self.read_at.elapsed());
        self.holds = input.is_none() && view.phase == Phase::Contouring;
        input.unwrap_or_default()
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        let given = self.left.try_lock().ok().and_then(|mut left| left.commands.pop_front());
        given.or_else(|| std::mem::take(&mut self.holds).then_some(OperatorCommand::FeedHold))
    }
}

impl Drop for Gamepad {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::io;

    use keepout_executor::supervisor::StickSettings;
    use keepout_planner::Mm2;

    use super::*;
    use crate::input::device::{AxisRange, Device, RawEvent, Snapshot};
    use crate::input::testing::view;

    /// The simulated device, shared by the test and the reader's thread.
    #[derive(Debug, Default)]
    struct Bench {
        plugged: bool,
        asleep: bool,
        events: Vec<RawEvent>,
    }

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Bench>>);

    impl Devices for Shared {
        type Device = Self;

        fn find(&mut self) -> Result<Self, DeviceError> {
            let plugged = self.0.lock().unwrap().plugged;
            plugged.then(|| self.clone()).ok_or(DeviceError::None { what: "stick", seen: 0, example: "" })
        }
    }

    impl Device for Shared {
        fn name(&self) -> String {
            "bench".into()
        }

        fn snapshot(&mut self) -> io::Result<Snapshot> {
            let range = AxisRange { low: -100, high: 100 };
            Ok(Snapshot { axes: Some([(range, 0); 2]), buttons: BTreeSet::new() })
        }

        fn read(&mut self, events: &mut Vec<RawEvent>) -> io::Result<()> {
            if self.0.lock().unwrap().asleep {
                std::thread::sleep(Duration::from_millis(400));
            }
            let mut bench = self.0.lock().unwrap();
            events.append(&mut bench.events);
            if bench.plugged { Ok(()) } else { Err(io::ErrorKind::NotFound.into()) }
        }
    }

    /// Takes an input every 2 ms until one is as wanted. Fails after 5 s.
    fn until(gamepad: &mut Gamepad, wanted: impl Fn(&OperatorInput) -> bool) {
        for _ in 0..2500 {
            if wanted(&gamepad.input(&view(Phase::Manual), Time::ZERO)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        panic!("no such input within 5 s");
    }

    #[test]
    fn contact_start_disarms_the_cycle_until_the_button_is_pressed_again() {
        let bench = Shared::default();
        bench.0.lock().unwrap().plugged = true;
        let stick = Stick::new(StickSettings::default()).unwrap();
        let mut gamepad = Gamepad::of(bench.clone(), Mapping::default(), stick, Panel::default()).unwrap();
        std::thread::sleep(Duration::from_millis(30));
        for _ in 0..2 {
            let press = |down| [RawEvent::Button { code: 0x13b, down }, RawEvent::Report];
            bench.0.lock().unwrap().events.extend([press(true), press(false)].concat());
            until(&mut gamepad, |input| input.armed);
            assert!(gamepad.status().contains("armed"));
            assert!(!gamepad.input(&view(Phase::Touching), Time::ZERO).armed);
            std::thread::sleep(Duration::from_millis(30));
            for _ in 0..20 {
                assert!(!gamepad.input(&view(Phase::Manual), Time::ZERO).armed);
                std::thread::sleep(Duration::from_millis(2));
            }
            assert!(!gamepad.status().contains("armed"));
        }
    }

    #[test]
    fn silent_or_unplugged_device_stops_the_tool_and_a_held_one_does_not() {
        let bench = Shared::default();
        bench.0.lock().unwrap().plugged = true;
        let stick = Stick::new(StickSettings::default()).unwrap();
        let panel = Panel::default();
        let mut gamepad = Gamepad::of(bench.clone(), Mapping::default(), stick, panel.clone()).unwrap();
        let held = |input: &OperatorInput| input.velocity == Mm2::new(1.0, 0.0);
        let still = |input: &OperatorInput| input.velocity == Mm2::ZERO;
        let push = || {
            let all = [
                RawEvent::Axis { code: 0, value: 100 },
                RawEvent::Button { code: 0x136, down: true },
                RawEvent::Report,
            ];
            bench.0.lock().unwrap().events.extend(all);
        };
        std::thread::sleep(Duration::from_millis(30));
        until(&mut gamepad, still);
        push();
        until(&mut gamepad, held);
        bench.0.lock().unwrap().asleep = true;
        until(&mut gamepad, still);
        bench.0.lock().unwrap().asleep = false;
        bench.0.lock().unwrap().plugged = false;
        std::thread::sleep(Duration::from_millis(500));
        until(&mut gamepad, still);
        assert!(panel.notices().iter().any(|notice| notice.contains("unplugged")));
        bench.0.lock().unwrap().plugged = true;
        std::thread::sleep(Duration::from_millis(700));
        until(&mut gamepad, still);
        push();
        until(&mut gamepad, held);
    }
}
