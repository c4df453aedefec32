//! Whether a line carried no more than its rate lets through.

use keepout_executor::session::LoggedEvent;
use keepout_executor::session::log::Log;

use super::job::Case;

/// Longest greeting of a controller, bytes.
const GREETING: u128 = 100;

/// Whether no more was received at any time than a line of that rate carries since the session began, and what may have waited
/// before it.
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
