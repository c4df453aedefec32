//! The closed-form equations of the paper.

use keepout_drives::Axes;
use keepout_drives::drive::Drive;

/// Eq. (1): the steady contour error on a line if the open-loop gains differ. The unit is the feed's unit
/// times s.
#[must_use]
pub fn mismatch_error(feed: Axes, gains: Axes) -> f64 {
    feed.x * feed.y / feed.norm() * (gains.y - gains.x) / (gains.x * gains.y)
}

/// Eq. (5) as printed: the steady contour error of matched P loops on a line, pulses.
///
/// It holds for a motor `1/(s + 1/tau)`. `lost` is the speed that the loads take from each axis in a sample, pulses/s.
/// `gain` is the gain of the P controller in that model, 1/s².
#[must_use]
pub fn lost_speed_error(feed: Axes, lost: Axes, gain: f64, period_s: f64, time_constant_s: f64) -> f64 {
    let share = -(-period_s / time_constant_s).exp_m1();
    (feed.y * lost.x - feed.x * lost.y) / (time_constant_s * share * gain * feed.norm())
}

/// Eq. (5) in the units of section 7: the same error under loads in bits, with a `gain` in bits/pulse. Period and time
/// constant cancel.
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
