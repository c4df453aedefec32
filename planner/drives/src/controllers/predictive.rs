//! Generalised predictive control, GPC (section 6.2; Boucher et al. 1990).
//!
//! A CARIMA model of each axis predicts the positions. GPC computes the command increments that bring them to
//! the reference, and applies the first increment.

use nalgebra::{SMatrix, SVector};

use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Held;
use crate::reference::ReferenceWindow;

/// Number of predicted samples.
pub const HORIZON: usize = 15;

/// The model `A(z⁻¹)·Δ·p = B(z⁻¹)·Δu` of one axis, with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    /// −ã1, −ã2, −ã3 of `(1 − z⁻¹)²(1 − e·z⁻¹)`.
    recursion: [f64; 3],
    zeros: [f64; 2],
    /// First row of `(GᵀG + lambda)⁻¹Gᵀ`.
    row: SVector<f64, HORIZON>,
    /// The last three positions, newest first.
    positions: Option<[f64; 3]>,
    /// The last command.
    command: f64,
    /// The increment of the last command.
    increment: f64,
}

impl Axis {
    /// The axis model and its gains. `None` if the normal matrix has no inverse.
    fn new(held: &Held, effort: f64) -> Option<Self> {
        let [_, a1, a2] = held.poles();
        let mut axis = Self {
            recursion: [1.0 - a1, a1 - a2, a2],
            zeros: [held.b0, held.b1],
            row: SVector::zeros(),
            positions: None,
            command: 0.0,
            increment: 0.0,
        };
        // Positions after a unit increment.
        let response = axis.predicted([0.0; 3], [1.0, 0.0]);
        let by_increments =
            SMatrix::<f64, HORIZON, HORIZON>::from_fn(|i, j| if i >= j { response[i - j] } else { 0.0 });
        let mut normal = by_increments.transpose() * by_increments;
        normal += SMatrix::identity() * (effort * held.b0 * held.b0);
        let inverse = normal.try_inverse()?;
        axis.row = (inverse * by_increments.transpose()).row(0).transpose();
        Some(axis)
    }

    /// The next positions after `past`, newest first. The increments are those of now and of one sample ago,
    /// then zero.
    fn predicted(&self, mut past: [f64; 3], [mut now, mut before]: [f64; 2]) -> SVector<f64, HORIZON> {
        SVector::from_fn(|_, _| {
            let old: f64 = self.recursion.iter().zip(past).map(|(c, p)| c * p).sum();
            let next = old + self.zeros[0] * now + self.zeros[1] * before;
            past = [next, past[0], past[1]];
            (now, before) = (0.0, now);
            next
        })
    }

    fn step(&mut self, wanted: impl Fn(isize) -> f64, measured: f64, limit: f64) -> f64 {
        let [first, second, _] = self.positions.unwrap_or([measured; 3]);
        let past = [measured, first, second];
        self.positions = Some(past);
        let free = self.predicted(past, [0.0, self.increment]);
        let off = SVector::<f64, HORIZON>::from_fn(|i, _| wanted(count(i) + 1) - free[i]);
        // The increment counts after the amplifier's limit.
        let command = (self.command + self.row.dot(&off)).clamp(-limit, limit);
        self.increment = command - self.command;
        self.command = command;
        command
    }
}

#[expect(clippy::cast_possible_wrap, reason = "at most the horizon")]
fn count(samples: usize) -> isize {
    samples as isize
}

/// GPC for each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predictive {
    axes: [Axis; 2],
    limit: f64,
}

impl Predictive {
    /// GPC for the drive model `belief`. `effort` is the weight of an increment, in terms of the distance that it
    /// causes in one sample. `None` if the gains can not be computed.
    #[must_use]
    pub fn new(belief: &Belief, effort: f64) -> Option<Self> {
        let [x, y] = belief.drives.map(|drive| Axis::new(&drive.held(belief.period_s), effort));
        Some(Self { axes: [x?, y?], limit: belief.limit.unwrap_or(f64::INFINITY) })
    }
}

impl Controller for Predictive {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let [x, y] = &mut self.axes;
        Axes::new(
            x.step(|ahead| window.position(ahead).x, measured.x, self.limit),
            y.step(|ahead| window.position(ahead).y, measured.y, self.limit),
        )
    }
}
