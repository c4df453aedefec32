//! The check that a serial line carried no more bytes than its baud rate allows.

use keepout_executor::session::LoggedEvent;
use keepout_executor::session::log::Log;

use super::job::Case;

/// Longest greeting of a controller, bytes. It may wait on the line before the session begins.
const GREETING: u128 = 100;

/// Checks at each log entry that the session received no more bytes than the baud rate carries since its
/// beginning, plus a greeting.
pub fn is_throttled(log: &Log, case: Case) -> Result<(), String> {
    let mut received = 0;
    for entry in &log.entries {
        let at = entry.at;
        received += if let LoggedEvent::Received(bytes) = &entry.event { bytes.len() } else { 0 };
        let carried = u128::from(case.baud) * u128::from(at.micros()) / 10_000_000;
        if received as u128 > carried + GREETING {
            return Err(format!("{received} bytes within {:.3} s", at.elapsed().as_secs_f64()));
        }
    }
    Ok(())
}
