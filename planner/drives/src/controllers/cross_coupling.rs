//! Variable-gain cross-coupling, CCC (section 5, eqs. (15) to (17)), alone or with drive feedforward (Fig.
//! 23).

use super::drive_feedforward::DriveInverse;
use super::law::{Law, PidGains};
use super::{Belief, Controller};
use crate::Axes;
use crate::path::{Foot, PathPiece};
use crate::reference::{ReferenceSample, ReferenceWindow};

/// A PID law on the contour error, added to a P controller for each axis.
#[derive(Clone, Debug)]
pub struct CrossCoupling {
    gain: f64,
    law: Law,
    feedforward: Option<DriveInverse>,
    /// The piece before the current one.
    before: Option<PathPiece>,
    /// The piece that the reference is on, with its number.
    on: Option<(usize, PathPiece)>,
}

/// The contour error, and the gains that distribute its correction to the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourError {
    /// Contour error, pulses. Positive if the path lies to the left of the tool.
    pub error: f64,
    /// The gains Cx and Cy.
    pub gains: Axes,
}

impl ContourError {
    /// The paper's model, eqs. (15) to (17): `Cx = sin(theta) − Ex·kappa/2`, `Cy = cos(theta) + Ey·kappa/2`,
    /// with the signed curvature kappa.
    #[must_use]
    pub fn modelled(reference: &Foot, measured: Axes) -> Self {
        let axial = reference.point - measured;
        let bend = reference.curvature / 2.0;
        let gains = Axes::new(reference.tangent.y - axial.x * bend, reference.tangent.x + axial.y * bend);
        Self { error: -axial.x * gains.x + axial.y * gains.y, gains }
    }

    /// The exact distance to a point of the path.
    #[must_use]
    pub fn exact(foot: &Foot, measured: Axes) -> Self {
        Self { error: -foot.distance(measured), gains: Axes::new(foot.tangent.y, foot.tangent.x) }
    }
}

impl CrossCoupling {
    /// Cross-coupling with a P controller of `gain`, bits/pulse, and the law W(z).
    #[must_use]
    pub fn new(belief: &Belief, gain: f64, law: PidGains) -> Self {
        Self { gain, law: Law::new(law, belief.period_s), feedforward: None, before: None, on: None }
    }

    /// The same controller with feedforward of the drive's inverse.
    #[must_use]
    pub fn with_feedforward(self, belief: &Belief) -> Self {
        Self { feedforward: Some(DriveInverse::new(belief)), ..self }
    }

    /// The contour error at the tool. If the previous piece is nearer, as after a corner, the exact distance
    /// to it counts.
    fn contour_error(&mut self, reference: &ReferenceSample, measured: Axes) -> ContourError {
        if let Some((number, piece)) = self.on.filter(|(number, _)| *number != reference.number) {
            self.before = (number + 1 == reference.number).then_some(piece);
        }
        self.on = Some((reference.number, reference.piece));
        let distance = |foot: &Foot| (foot.point - measured).norm();
        let here = reference.piece.nearest(measured);
        match self.before.map(|piece| piece.nearest(measured)).filter(|foot| distance(foot) < distance(&here))
        {
            Some(foot) => ContourError::exact(&foot, measured),
            None => ContourError::modelled(&reference.foot, measured),
        }
    }

    /// The command without feedforward.
    pub(super) fn feedback(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let reference = window.ahead(0);
        let ContourError { error, gains } = self.contour_error(reference, measured);
        let correction = self.law.step(error);
        let axial = reference.position() - measured;
        axial * self.gain + Axes::new(-gains.x, gains.y) * correction
    }
}

impl Controller for CrossCoupling {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let ahead = self.feedforward.map_or(Axes::zeros(), |inverse| inverse.command(window));
        ahead + self.feedback(window, measured)
    }
}
