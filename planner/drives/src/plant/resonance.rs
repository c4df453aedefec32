//! The spring between motor and table.

use super::axis::AxisMotion;

/// One structural resonance: the table hangs on the motor by a spring with a damper (the two-mass model of a feed
/// drive: Altintas, Verl, Brecher, Uriarte & Pritschow 2011, "Machine tool feed drives", CIRP Annals 60(2)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// Angular frequency of the table while the motor is held, rad/s.
    pub angular: f64,
    /// Damping ratio while the motor is held.
    pub damping: f64,
    /// Share of the table in the inertia of the axis, between 0 and 1.
    pub table_share: f64,
}

impl Resonance {
    /// The acceleration of the table by the spring, pulses/s². Within the play of `play` pulses to each side, the
    /// spring does not touch it.
    pub(super) fn pull(&self, motion: &AxisMotion, play: f64) -> f64 {
        let stretch = motion.motor.position - motion.table.position;
        let beyond = stretch - stretch.clamp(-play, play);
        if play > 0.0 && beyond == 0.0 {
            return 0.0;
        }
        let speed = motion.motor.velocity - motion.table.velocity;
        self.angular * (self.angular * beyond + 2.0 * self.damping * speed)
    }
}
