//! A byte stream to a controller.

use keepout_guard::Time;
use thiserror::Error;

/// An error of a port.
#[derive(Debug, Error)]
pub enum PortError {
    /// The port cannot be opened.
    #[error(
        "cannot open port {name}: {reason}. \
         Check that the device is plugged in, that its name is right, and that you may use it (group dialout)."
    )]
    Open {
        /// The port's name.
        name: String,
        /// The system's reason.
        reason: String,
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
