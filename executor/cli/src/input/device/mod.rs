//! Input devices: gamepads, joysticks and handwheels. The codes of axes and buttons are those of Linux
//! (evdev).
//!
//! ```text
//! evdev ──> Reader (its thread) ──> Reading (shared) ──> EnablingInterlock ──> OperatorInput
//! ```
//!
//! The [`Reader`] follows the device when it is unplugged and plugged in. Its `Pad` keeps the device's state.
//! The [`EnablingInterlock`] decides which readings may move the tool. Only `linux` uses devices; no module
//! uses clocks.

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

/// The requested device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The first gamepad or joystick with two axes and a dead-man button.
    Stick,
    /// The first device with a dial.
    Wheel,
    /// The device at this path.
    At(PathBuf),
}

/// Why no device is available.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// No device of the requested kind is plugged in.
    #[error(
        "no {what} is plugged in: /dev/input has {seen} other devices. Plug it in, or name it, such as \
         {example}"
    )]
    None {
        /// The requested kind.
        what: &'static str,
        /// Number of devices in `/dev/input`.
        seen: usize,
        /// Option that names a device.
        example: &'static str,
    },
    /// The system has no input devices.
    #[error(
        "this computer shows no input devices ({}): {source}. In a container, share /dev/input with it.",
        path.display()
    )]
    NoInput {
        /// The searched folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The user may not read the device.
    #[error(
        "{} may not be read: join the group \"input\" (sudo usermod -aG input $USER) and log in again",
        path.display()
    )]
    Denied {
        /// The device.
        path: PathBuf,
    },
    /// The device cannot be opened.
    #[error("{} cannot be opened as an input device: {source}", path.display())]
    Open {
        /// The device.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The device has no dead-man button.
    #[error(
        "{} has two axes, but no dead-man button (shoulder button or trigger): a stick needs one. Use \
         another device.",
        path.display()
    )]
    NoDeadMan {
        /// The device.
        path: PathBuf,
    },
    /// The device has no usable stick or wheel.
    #[error(
        "{} has neither two axes with a dead-man button nor a dial or wheel: use another device",
        path.display()
    )]
    NotUsable {
        /// The device.
        path: PathBuf,
    },
    /// The system is not Linux.
    #[error("gamepads, joysticks and handwheels work only on Linux: use --operator keyboard")]
    NotLinux,
    /// The system cannot start the reading thread.
    #[error("the system cannot start a thread to read the device: {0}")]
    Thread(std::io::Error),
}
