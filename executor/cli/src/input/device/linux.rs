//! Input devices of Linux, through evdev.

use std::fs::OpenOptions;
use std::io::{self, ErrorKind};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use evdev::raw_stream::RawDevice;
use evdev::{AbsoluteAxisCode, EventSummary, InputEvent, KeyCode, RelativeAxisCode, SynchronizationCode};

use super::map::{Action, Mapping};
use super::pad::{AxisRange, RawEvent, Snapshot};
use super::reader::{Device, Devices};
use super::{DeviceError, Wanted};

/// Folder of Linux's input devices.
const INPUT: &str = "/dev/input";
/// Number of events after which one round stops reading. A device that sends without end does not hold up the
/// round.
const EVENTS_MAX: usize = 1024;

/// The input devices of this computer.
#[derive(Clone, Debug)]
pub struct EvdevDevices {
    wanted: Wanted,
    mapping: Mapping,
    folder: PathBuf,
}

impl EvdevDevices {
    /// The devices of the wanted kind, with the mapping of their axes and buttons.
    #[must_use]
    pub fn new(wanted: Wanted, mapping: Mapping) -> Self {
        Self { wanted, mapping, folder: INPUT.into() }
    }

    /// Paths of the event devices, in the order of their numbers.
    fn paths(&self) -> Result<Vec<PathBuf>, DeviceError> {
        let none = |source| DeviceError::NoInput { path: self.folder.clone(), source };
        let number = |path: &Path| {
            path.file_name()?.to_str()?.strip_prefix("event").and_then(|digits| digits.parse::<u32>().ok())
        };
        let mut found: Vec<(u32, PathBuf)> = std::fs::read_dir(&self.folder)
            .map_err(none)?
            .filter_map(|entry| entry.ok().map(|entry| entry.path()))
            .filter_map(|path| Some((number(&path)?, path)))
            .collect();
        found.sort();
        Ok(found.into_iter().map(|(_, path)| path).collect())
    }

    fn first(&self, what: &'static str, example: &'static str) -> Result<EvdevDevice, DeviceError> {
        let paths = self.paths()?;
        let mut denied = None;
        for path in &paths {
            match open(path) {
                Ok(device) if self.fits(&device) => return self.usable(path, device),
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::PermissionDenied => denied = Some(path.clone()),
                Err(_) => {}
            }
        }
        match denied {
            Some(path) => Err(DeviceError::Denied { path }),
            None => Err(DeviceError::None { what, seen: paths.len(), example }),
        }
    }

    fn fits(&self, device: &RawDevice) -> bool {
        if self.wanted == Wanted::Wheel { has_dial(device) } else { self.has_stick(device) }
    }

    fn has_stick(&self, device: &RawDevice) -> bool {
        has_axes(device, &self.mapping) && self.has_dead_man(device)
    }

    fn has_dead_man(&self, device: &RawDevice) -> bool {
        let keys = device.supported_keys();
        keys.is_some_and(|keys| {
            self.mapping.with(Action::DeadMan).any(|code| keys.contains(KeyCode::new(code)))
        })
    }

    /// The device, if its stick or its wheel is usable. A device with axes but no dead-man button serves only
    /// as a wheel.
    fn usable(&self, path: &Path, device: RawDevice) -> Result<EvdevDevice, DeviceError> {
        let has_stick = self.has_stick(&device);
        let turns = device.supported_relative_axes().is_some_and(|axes| {
            self.mapping.wheels.iter().any(|&code| axes.contains(RelativeAxisCode(code)))
        });
        if has_stick || turns {
            let axes = has_stick.then_some(self.mapping.axes);
            Ok(EvdevDevice { device, axes, path: path.into() })
        } else if has_axes(&device, &self.mapping) {
            Err(DeviceError::NoDeadMan { path: path.into() })
        } else {
            Err(DeviceError::NotUsable { path: path.into() })
        }
    }
}

/// Whether the device has a dial, and so is a handwheel. A device with only a wheel may be a mouse, so the
/// user must name it.
fn has_dial(device: &RawDevice) -> bool {
    device.supported_relative_axes().is_some_and(|axes| axes.contains(RelativeAxisCode::REL_DIAL))
}

fn has_axes(device: &RawDevice, mapping: &Mapping) -> bool {
    let codes = [mapping.axes.0, mapping.axes.1];
    let axes = device.supported_absolute_axes();
    axes.is_some_and(|axes| codes.iter().all(|&code| axes.contains(AbsoluteAxisCode(code))))
}

/// Opens a device without blocking reads.
fn open(path: &Path) -> io::Result<RawDevice> {
    let file = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(path)?;
    RawDevice::try_from(file)
}

impl Devices for EvdevDevices {
    type Device = EvdevDevice;

    fn find(&mut self) -> Result<EvdevDevice, DeviceError> {
        match &self.wanted {
            Wanted::Stick => self
                .first("gamepad or joystick with a dead-man button", "--operator gamepad:/dev/input/event5"),
            Wanted::Wheel => self.first("handwheel with a dial", "--operator handwheel:/dev/input/event5"),
            Wanted::At(path) => match open(path) {
                Ok(device) => self.usable(path, device),
                Err(error) if error.kind() == ErrorKind::PermissionDenied => {
                    Err(DeviceError::Denied { path: path.clone() })
                }
                Err(source) => Err(DeviceError::Open { path: path.clone(), source }),
            },
        }
    }
}

/// An open event device.
#[derive(Debug)]
pub struct EvdevDevice {
    device: RawDevice,
    /// Codes of the stick's axes. `None` for a device without a usable stick.
    axes: Option<(u16, u16)>,
    path: PathBuf,
}

impl EvdevDevice {
    fn axes(&self, (x, y): (u16, u16)) -> io::Result<[(AxisRange, i32); 2]> {
        let all = self.device.get_abs_state()?;
        let axis = |code: u16| {
            let info = all.get(usize::from(code)).ok_or(ErrorKind::InvalidData)?;
            Ok::<_, io::Error>((AxisRange { low: info.minimum, high: info.maximum }, info.value))
        };
        Ok([axis(x)?, axis(y)?])
    }
}

impl Device for EvdevDevice {
    fn name(&self) -> String {
        let name = self.device.name().unwrap_or("unnamed device");
        format!("{name} ({})", self.path.display())
    }

    fn snapshot(&mut self) -> io::Result<Snapshot> {
        let axes = self.axes.map(|codes| self.axes(codes)).transpose()?;
        let buttons = self.device.get_key_state()?.iter().map(KeyCode::code).collect();
        Ok(Snapshot { axes, buttons })
    }

    fn read(&mut self, events: &mut Vec<RawEvent>) -> io::Result<()> {
        while events.len() < EVENTS_MAX {
            match self.device.fetch_events() {
                Ok(fetched) => events.extend(fetched.filter_map(decoded)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

fn decoded(event: InputEvent) -> Option<RawEvent> {
    match event.destructure() {
        EventSummary::AbsoluteAxis(_, axis, value) => Some(RawEvent::Axis { code: axis.0, value }),
        // The value 2 is the auto-repeat of a held key.
        EventSummary::Key(_, key, value) => {
            (value != 2).then(|| RawEvent::Button { code: key.code(), down: value != 0 })
        }
        EventSummary::RelativeAxis(_, axis, pulses) => Some(RawEvent::Turned { code: axis.0, pulses }),
        EventSummary::Synchronization(_, SynchronizationCode::SYN_REPORT, _) => Some(RawEvent::Report),
        EventSummary::Synchronization(_, SynchronizationCode::SYN_DROPPED, _) => Some(RawEvent::Dropped),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn devices(folder: &Path, wanted: Wanted) -> EvdevDevices {
        EvdevDevices { folder: folder.into(), ..EvdevDevices::new(wanted, Mapping::default()) }
    }

    #[test]
    fn missing_devices_give_an_error_with_the_remedy() {
        let folder = std::env::temp_dir().join(format!("keepout-input-{}", std::process::id()));
        let missing = devices(&folder, Wanted::Stick).find().unwrap_err();
        assert!(missing.to_string().contains("no input devices"), "{missing}");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("event3"), b"no device").unwrap();
        std::fs::write(folder.join("mouse0"), b"no device").unwrap();
        let none = devices(&folder, Wanted::Wheel).find().unwrap_err();
        assert!(none.to_string().contains("1 other devices"), "{none}");
        let named = devices(&folder, Wanted::At(folder.join("event3"))).find().unwrap_err();
        assert!(matches!(named, DeviceError::Open { .. }), "{named}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn evdev_events_become_raw_events() {
        let raw = |kind, code, value| decoded(InputEvent::new(kind, code, value));
        assert_eq!(raw(0, 0, 0), Some(RawEvent::Report));
        assert_eq!(raw(0, 3, 0), Some(RawEvent::Dropped));
        assert_eq!(raw(3, 1, -5), Some(RawEvent::Axis { code: 1, value: -5 }));
        assert_eq!(raw(1, 0x136, 1), Some(RawEvent::Button { code: 0x136, down: true }));
        assert_eq!(raw(1, 0x136, 2), None);
        assert_eq!(raw(2, 7, -1), Some(RawEvent::Turned { code: 7, pulses: -1 }));
        assert_eq!(raw(4, 4, 1), None);
    }
}
