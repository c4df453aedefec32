//! Variable-gain cross-coupling, CCC (section 5, eqs. (15) to (17)), alone or with drive feedforward (Fig.
//! 23), and with the exact distance to the path in place of these equations.

use super::drive_feedforward::DriveInverse;
use super::law::{Law, PidGains};
use super::passed::PassedPieces;
use super::{Belief, Controller};
use crate::Axes;
use crate::path::{Foot, left_of};
use crate::reference::ReferenceWindow;

/// How the contour error is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorEstimate {
    /// By eqs. (15) to (17): from the circle of curvature at the reference. Between a corner and the tool that has
    /// not reached it, it is the exact distance, because the equations know no corner.
    Modelled,
    /// The exact distance to the path.
    Exact,
}

/// A PID law on the contour error, added to a P controller for each axis.
#[derive(Clone, Debug)]
pub struct CrossCoupling {
    gain: f64,
    law: Law,
    estimate: ErrorEstimate,
    feedforward: Option<DriveInverse>,
    passed: PassedPieces,
}

/// The contour error, and the direction of its correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourError {
    /// Contour error, pulses. Positive if the path lies to the left of the tool.
    pub error: f64,
    /// The direction in which a positive correction moves the tool: (−Cx, Cy) in the paper.
    pub direction: Axes,
}

impl ContourError {
    /// The paper's model, eqs. (15) to (17): `Cx = sin(theta) − Ex·kappa/2`, `Cy = cos(theta) + Ey·kappa/2`,
    /// with the signed curvature kappa.
    #[must_use]
    pub fn modelled(reference: &Foot, measured: Axes) -> Self {
        let axial = reference.point - measured;
        let bend = reference.curvature / 2.0;
        let direction =
            Axes::new(-reference.tangent.y + axial.x * bend, reference.tangent.x + axial.y * bend);
        Self { error: axial.dot(&direction), direction }
    }

    /// The exact distance to a point of the path.
    #[must_use]
    pub fn exact(foot: &Foot, measured: Axes) -> Self {
        let left = left_of(foot.tangent);
        let to_path = foot.point - measured;
        // Beside a corner, the way to the path is not across the tangent.
        let direction = to_path.try_normalize(NEAR).map_or(left, |way| way * way.dot(&left).signum());
        Self { error: to_path.dot(&direction), direction }
    }
}

/// Distance at which a tool counts as on the path, pulses.
const NEAR: f64 = 1e-6;

impl CrossCoupling {
    /// Cross-coupling with a P controller of `gain`, bits/pulse, and the law W(z).
    #[must_use]
    pub fn new(belief: &Belief, gain: f64, law: PidGains, estimate: ErrorEstimate) -> Self {
        let law = Law::new(law, belief.period_s);
        Self { gain, law, estimate, feedforward: None, passed: PassedPieces::default() }
    }

    /// The same controller with feedforward of the drive's inverse.
    #[must_use]
    pub fn with_feedforward(self, belief: &Belief) -> Self {
        Self { feedforward: Some(DriveInverse::new(belief)), ..self }
    }
}

impl Controller for CrossCoupling {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let reference = window.ahead(0);
        let found = self.passed.foot(reference, measured);
        let modelled = self.estimate == ErrorEstimate::Modelled && !found.before_corner;
        let ContourError { error, direction } = if modelled {
            ContourError::modelled(&reference.foot, measured)
        } else {
            ContourError::exact(&found.foot, measured)
        };
        let correction = direction * self.law.step(error);
        let axial = (reference.position() - measured) * self.gain;
        let ahead = self.feedforward.map_or(Axes::zeros(), |inverse| inverse.command(window));
        ahead + axial + correction
    }
}
