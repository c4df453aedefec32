//! A byte stream to a controller.

use keepout_guard::Time;
use thiserror::Error;

/// Why a port cannot be opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedPort {
    /// There is no such device.
    Missing,
    /// Another program has it open.
    Busy,
    /// The user may not use it.
    Forbidden,
    /// Another reason.
    Other,
}

impl ClosedPort {
    /// The kind of a system's reason.
    #[must_use]
    pub fn of(reason: &str) -> Self {
        let reason = reason.to_lowercase();
        let says = |words: &[&str]| words.iter().any(|word| reason.contains(word));
        if says(&["busy", "in use", "lock"]) {
            Self::Busy
        } else if says(&["denied", "permission"]) {
            // Windows denies access to a port that another program has open.
            if cfg!(windows) { Self::Busy } else { Self::Forbidden }
        } else if says(&["no such", "not found", "cannot find", "does not exist", "no device"]) {
            Self::Missing
        } else {
            Self::Other
        }
    }

    fn remedy(self) -> &'static str {
        match self {
            Self::Missing => "Check that the device is plugged in, and that its name is right.",
            Self::Busy => "Another program has it open: close your sender, or the other keepout.",
            Self::Forbidden if cfg!(target_os = "linux") => {
                "You may not use it: add yourself to the group dialout (or uucp), and log in again."
            }
            Self::Forbidden => "You may not use it: ask your administrator.",
            Self::Other => "Check the device, its name, and its driver.",
        }
    }
}

/// An error of a port.
#[derive(Debug, Error)]
pub enum PortError {
    /// The port cannot be opened.
    #[error("cannot open port {name}: {reason}. {}", closed.remedy())]
    Open {
        /// The port's name.
        name: String,
        /// The system's reason.
        reason: String,
        /// The kind of the reason.
        closed: ClosedPort,
    },
    /// The port failed while in use.
    #[error("port {name}: {reason}")]
    Lost {
        /// The port's name.
        name: String,
        /// The system's reason.
        reason: String,
    },
}

/// A byte stream to a controller. No call blocks for longer than a few milliseconds.
pub trait Port {
    /// Sends bytes.
    ///
    /// # Errors
    /// [`PortError::Lost`] if the port is gone.
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError>;

    /// Appends the bytes that have arrived.
    ///
    /// # Errors
    /// [`PortError::Lost`] if the port is gone.
    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError>;

    /// The time at which the next bytes may arrive. A port that does not know it returns [`Time::ZERO`].
    fn next_event(&self) -> Time {
        Time::ZERO
    }
}

impl<P: Port> Port for &mut P {
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError> {
        (**self).write(bytes, now)
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        (**self).read(into, now)
    }

    fn next_event(&self) -> Time {
        (**self).next_event()
    }
}
