//! Input devices: gamepads, joysticks and handwheels, as Linux (evdev) numbers their axes and buttons.
//!
//! ```text
//! evdev ──> Reader (its thread) ──> Reading (shared) ──> EnablingInterlock ──> OperatorInput
//! ```
//!
//! The [`Reader`] follows unplugging and plugging in, the `Pad` what the events mean, the
//! [`EnablingInterlock`] decides what of it may move the tool. All but `linux` is free of devices and clocks.

mod enabling;
#[cfg(target_os = "linux")]
mod linux;
mod map;
mod pad;
mod reader;

use std::path::PathBuf;

pub use enabling::EnablingInterlock;
#[cfg(target_os = "linux")]
pub use linux::EvdevDevices;
pub use map::Mapping;
#[cfg(test)]
pub use pad::{AxisRange, RawEvent, Snapshot};
#[cfg(test)]
pub use reader::Device;
pub use reader::{Devices, Reader, Reading};
use thiserror::Error;

/// What kind of device is looked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The first gamepad or joystick: two axes and a button that the mapping calls a dead-man.
    Stick,
    /// The first device with a dial.
    Wheel,
    /// This one.
    At(PathBuf),
}

/// Why there is no device.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// None is plugged in.
    #[error(
        "no {what} is plugged in: none of the {seen} devices in /dev/input is one. Plug it in, or name it: {example}"
    )]
    None {
        /// What was looked for.
        what: &'static str,
        /// How many devices there are.
        seen: usize,
        /// How to name it.
        example: &'static str,
    },
    /// The system has no input devices.
    #[error("this computer shows no input devices ({}): {source}. In a container, share /dev/input with it.", path.display())]
    NoInput {
        /// Where they should be.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The devices may not be read.
    #[error("{} may not be read: join the group \"input\" (sudo usermod -aG input $USER) and log in again", path.display())]
    Denied {
        /// The device.
        path: PathBuf,
    },
    /// The device that was commanded for can not be opened.
    #[error("{} can not be opened as an input device: {source}", path.display())]
    Open {
        /// The device.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It has no dead-man button.
    #[error(
        "{} has two axes, but none of the dead-man buttons (shoulder buttons or trigger): a stick without one does not steer",
        path.display()
    )]
    NoDeadMan {
        /// The device.
        path: PathBuf,
    },
    /// It has nothing to steer with.
    #[error("{} has neither two axes with a dead-man button nor a dial or wheel", path.display())]
    NotUsable {
        /// The device.
        path: PathBuf,
    },
    /// The system is no Linux.
    #[error(
        "joysticks and handwheels are read by Linux's evdev, which this system has not: steer by --operator keyboard"
    )]
    NotLinux,
    /// No thread.
    #[error("the system gives no thread to read the device: {0}")]
    Thread(std::io::Error),
}
