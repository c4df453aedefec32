//! The paper's closed forms.

use keepout_drives::Axes;
use keepout_drives::drive::Drive;

/// Eq. (1): the steady contour error on a line when open-loop gains differ, in the feed's unit times s.
#[must_use]
pub fn mismatch_error(feed: Axes, gains: Axes) -> f64 {
    feed.x * feed.y / feed.norm() * (gains.y - gains.x) / (gains.x * gains.y)
}

/// What eq. (5) should say (as printed it is dimensionally wrong): the steady contour error of matched P loops on a line under loads,
/// pulses, for any period and time constant. `loads` in bits, `gain` in bits/pulse.
#[must_use]
pub fn load_error(feed: Axes, loads: Axes, gain: f64) -> f64 {
    (feed.y * loads.x - feed.x * loads.y) / (gain * feed.norm())
}

/// Eq. (6): the steady radial error of matched P loops (gain 1) on a circle gone at `turning` rad/s, as a share of its radius.
/// Positive: the tool runs outside.
#[must_use]
pub fn radial_error(drive: Drive, turning: f64) -> f64 {
    let natural_2 = drive.gain / drive.time_constant_s;
    let damping_2 = 1.0 / (4.0 * drive.time_constant_s.powi(2) * natural_2);
    let ratio_2 = turning * turning / natural_2;
    1.0 / (1.0 + 4.0 * damping_2 * ratio_2 - 2.0 * ratio_2 + ratio_2 * ratio_2).sqrt() - 1.0
}

/// Eq. (7): the open-loop gain, 1/s, for a closed loop damped by 0.707.
#[must_use]
pub fn recommended_gain(period_s: f64, time_constant_s: f64) -> f64 {
    1.0 / (period_s + 2.0 * time_constant_s)
}
