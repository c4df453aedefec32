//! Whether a line carried no more than its rate lets through.

use keepout_executor::session::log::{Entry, Log};

use super::job::Case;

/// Longest greeting of a controller, bytes.
const GREETING: u128 = 100;

/// Whether no more was received at any time than a line of that rate carries since the session began, and what may have waited
/// before it.
pub fn is_throttled(log: &Log, case: Case) -> Result<(), String> {
    let mut received = 0;
    for (at, entry) in &log.entries {
        received += if let Entry::Received(bytes) = entry { bytes.len() } else { 0 };
        let carried = u128::from(case.baud) * u128::from(at.micros()) / 10_000_000;
        if received as u128 > carried + GREETING {
            return Err(format!("{received} bytes within {:.3} s", at.elapsed().as_secs_f64()));
        }
    }
    Ok(())
}
