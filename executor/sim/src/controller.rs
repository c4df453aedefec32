//! The interface between a simulated controller and its serial line.

use keepout_executor::session::Sample;
use keepout_guard::Time;

/// A disturbance of a controller from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// A person presses reset.
    Reset,
    /// The power fails and returns. This differs from a reset where the firmware keeps state across a reset.
    BrownOut,
    /// A limit switch trips, or a drive fails: an alarm, an immediate stop, a lost position.
    Alarm,
}

/// A simulated controller. It keeps its own time, which only goes forward.
pub trait SimulatedController: Send + std::fmt::Debug {
    /// Takes a byte from the line, at the controller's present time.
    fn receive(&mut self, byte: u8);

    /// Whether the controller acts on this byte at once. It buffers other bytes.
    fn is_realtime(&self, byte: u8) -> bool;

    /// Runs until `now`.
    fn advance(&mut self, now: Time);

    /// The time of its next action that a host can notice, or a later time.
    fn next_event(&self) -> Time;

    /// Moves the bytes sent since the last call into `into`, in order.
    fn transmit(&mut self, into: &mut Vec<u8>);

    /// Moves the commanded positions since the last call into `into`: the corners of the path, and the
    /// present position, each with its time.
    fn take_samples(&mut self, into: &mut Vec<Sample>);

    /// Whether its commanded position changes.
    fn is_moving(&self) -> bool;

    /// Applies a disturbance.
    fn disturb(&mut self, disturbance: Disturbance);
}
