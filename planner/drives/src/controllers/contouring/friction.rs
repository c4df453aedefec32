//! The friction that the reference meets.

use super::HORIZON;
use crate::Axes;
use crate::controllers::FrictionBelief;
use crate::plant::MOST_DELAY;
use crate::reference::ReferenceWindow;

/// Distance of the reference in a sample up to which an axis stands, pulses.
const STANDING: f64 = 1e-3;
/// The samples from the one before now to the end of the horizon.
const SAMPLES: usize = HORIZON + MOST_DELAY + 2;

/// The friction against a tool that follows the reference, in the samples around now.
///
/// Without pre-sliding it has the sign of the speed. With pre-sliding it turns over a distance after each reversal, as
/// the bristles of the LuGre model do at a small speed: `F/Fc` moves towards the sign of the speed by
/// `1 − exp(−s/presliding)` over a distance s. This is what compensates the glitch at a quadrant.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrictionAhead {
    friction: [FrictionBelief; 2],
    /// Shares of the Coulomb friction.
    shares: [Axes; SAMPLES],
}

impl FrictionAhead {
    pub(super) fn at_rest(friction: [FrictionBelief; 2]) -> Self {
        Self { friction, shares: [Axes::zeros(); SAMPLES] }
    }

    /// Goes on by a sample.
    pub(super) fn go_on(&mut self, window: &ReferenceWindow, period_s: f64) {
        self.shares[0] = self.shares[1];
        let mut share = self.shares[0];
        for (ahead, next) in (0..).zip(&mut self.shares[1..]) {
            let step = window.ahead(ahead).velocity() * period_s;
            for axis in 0..2 {
                share[axis] = after(share[axis], step[axis], self.friction[axis].presliding);
            }
            *next = share;
        }
    }

    /// The friction `ahead` samples after now, from −1 on, bits.
    pub(super) fn at(&self, ahead: isize) -> Axes {
        let share = self.shares[0_usize.saturating_add_signed(ahead + 1).min(SAMPLES - 1)];
        let [x, y] = self.friction;
        Axes::new(x.coulomb * share.x, y.coulomb * share.y)
    }
}

/// The share of the Coulomb friction after a step.
fn after(share: f64, step: f64, presliding: f64) -> f64 {
    if presliding > 0.0 {
        return step.signum() + (share - step.signum()) * (-step.abs() / presliding).exp();
    }
    if step.abs() > STANDING { step.signum() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controllers::kind::Kind;
    use crate::controllers::selection::Environment;
    use crate::path::Path;
    use crate::profile::DriveProfile;
    use crate::reference::{Ramp, Reference};
    use crate::run::Task;

    /// The largest contour error on a circle of 20 mm with this belief in the friction, µm, without the start and the
    /// end.
    fn glitch(profile: &DriveProfile, friction: [FrictionBelief; 2]) -> f64 {
        let scale = profile.pulses_per_mm;
        let path = Path::circle(20.0 * scale, false, 1);
        let feed = 15.0 * scale;
        let reference = Reference::along(&path, feed, profile.period_s, Ramp::RaisedCosine(0.1)).samples;
        let task = Task { plant: profile.plant(), path, feed, reference, cutting: None };
        let mut setting = profile.setting(Environment::of(&task, 0.0));
        setting.belief.friction = friction;
        let run = task.run(Kind::Contouring.built(&setting).unwrap().as_mut());
        let steady = &run.in_motion()[run.moving / 20..run.moving * 19 / 20];
        steady.iter().map(|moment| moment.contour_error.abs()).fold(0.0, f64::max) * profile.um()
    }

    /// Friction that turns over a distance leaves a glitch at each quadrant. A controller that knows the distance
    /// leaves a smaller one than a controller that expects a jump, or nothing.
    #[test]
    fn glitch_at_a_quadrant_is_compensated() {
        let mut profile = DriveProfile::simulated().unwrap();
        for axis in [&mut profile.x, &mut profile.y] {
            axis.coulomb_bits = 1000.0;
            axis.presliding_mm = Some(0.02);
        }
        let known = profile.belief().friction;
        let jump = known.map(|friction| FrictionBelief { presliding: 0.0, ..friction });
        let [ours, jump, none] =
            [known, jump, [FrictionBelief::default(); 2]].map(|belief| glitch(&profile, belief));
        assert!(ours < 0.8, "{ours} µm");
        assert!(jump > 2.0 * ours && none > 2.0 * ours, "{ours} µm, {jump} µm, {none} µm");
    }

    /// Small steps cover the same curve as one step of their sum, and the curve ends at the Coulomb friction.
    #[test]
    fn friction_turns_over_the_presliding_distance() {
        let turned = (0..10).fold(1.0, |share, _| after(share, -0.5, 5.0));
        assert!((turned - after(1.0, -5.0, 5.0)).abs() < 1e-12);
        assert!((turned - (2.0 * (-1.0_f64).exp() - 1.0)).abs() < 1e-12);
        assert_eq!(after(turned, 0.0, 5.0), turned);
        assert!((after(turned, 100.0, 5.0) - 1.0).abs() < 1e-8);
        assert_eq!([0.4, -0.4, 0.0].map(|step| after(1.0, step, 0.0)), [1.0, -1.0, 0.0]);
    }
}
