//! A byte stream to a controller.

use keepout_guard::Time;
use thiserror::Error;

/// Why a port can not be used.
#[derive(Debug, Error)]
pub enum PortError {
    /// It can not be opened.
    #[error(
        "can not open port {name}: {reason}. Check that the device is plugged in, that its name is right, and that you may use it (group dialout)."
    )]
    Open {
        /// The port's name.
        name: String,
        /// What the system says.
        reason: String,
    },
    /// It failed while in use.
    #[error("port {name}: {reason}")]
    Lost {
        /// The port's name.
        name: String,
        /// What the system says.
        reason: String,
    },
}

/// A byte stream to a controller. Nothing blocks for longer than a few milliseconds.
pub trait Port {
    /// Sends bytes.
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone.
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError>;

    /// Appends what has arrived.
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone.
    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError>;

    /// When there may be something to read; now and then for ports that can not tell.
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
