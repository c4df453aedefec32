//! The closed-form equations of the paper.

use keepout_drives::Axes;
use keepout_drives::drive::Drive;

/// Eq. (1): the steady contour error on a line if the open-loop gains differ. The unit is the feed's unit
/// times s.
#[must_use]
pub fn mismatch_error(feed: Axes, gains: Axes) -> f64 {
    feed.x * feed.y / feed.norm() * (gains.y - gains.x) / (gains.x * gains.y)
}

/// Eq. (5), corrected: the steady contour error of matched P loops on a line under loads, pulses.
///
/// The printed equation is dimensionally wrong. This form holds for any period and time constant. `loads` in
/// bits, `gain` in bits/pulse.
#[must_use]
pub fn load_error(feed: Axes, loads: Axes, gain: f64) -> f64 {
    (feed.y * loads.x - feed.x * loads.y) / (gain * feed.norm())
}

/// Eq. (6): the steady radial error of matched P loops (gain 1) on a circle at `turning` rad/s, as a share of
/// the radius. Positive if the tool runs outside the circle.
#[must_use]
pub fn radial_error(drive: Drive, turning: f64) -> f64 {
    let natural_2 = drive.gain / drive.time_constant_s;
    let damping_2 = 1.0 / (4.0 * drive.time_constant_s.powi(2) * natural_2);
    let ratio_2 = turning * turning / natural_2;
    1.0 / (1.0 + 4.0 * damping_2 * ratio_2 - 2.0 * ratio_2 + ratio_2 * ratio_2).sqrt() - 1.0
}

/// Eq. (7): the open-loop gain, 1/s, for a closed loop with a damping of 0.707.
#[must_use]
pub fn recommended_gain(period_s: f64, time_constant_s: f64) -> f64 {
    1.0 / (period_s + 2.0 * time_constant_s)
}
