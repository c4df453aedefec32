//! What every simulated controller is to the line it hangs on.

use keepout_executor::session::Sample;
use keepout_guard::Time;

/// Something that happens to a controller from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// Somebody presses reset.
    Reset,
    /// The power fails and returns. What the controller does then differs from a reset where its firmware keeps something across one.
    BrownOut,
    /// A limit switch is touched, or a drive gives up: an alarm, dead stop, place lost.
    Alarm,
}

/// A simulated controller. It lives in its own time, which only goes forward.
pub trait Controller: Send + std::fmt::Debug {
    /// Takes a byte from the line at its present time.
    fn receive(&mut self, byte: u8);

    /// Whether it acts on this byte; others are kept for later.
    fn is_realtime(&self, byte: u8) -> bool;

    /// Goes on until `now`.
    fn advance(&mut self, now: Time);

    /// When it does something by itself that a host can notice, or later.
    fn next_event(&self) -> Time;

    /// Bytes to send since the last call, in order.
    fn transmit(&mut self, into: &mut Vec<u8>);

    /// The commanded positions since the last call: corners of the way, and where it is now.
    fn take_samples(&mut self, into: &mut Vec<Sample>);

    /// Something happens to it.
    fn disturb(&mut self, disturbance: Disturbance);
}
