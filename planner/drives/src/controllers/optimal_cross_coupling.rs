//! Optimal cross-coupling (section 6.1; Kulkarni & Srinivasan 1989).
//!
//! The performance index contains the contour error, so the gains of both axes depend on the direction of the
//! path. A table holds gains for a set of directions. It is computed once.

use nalgebra::{Matrix2, SMatrix, SVector};

use super::cross_coupling::ContourError;
use super::optimal::{Index, augmented};
use super::speed::Speed;
use super::{Belief, Controller, optimal};
use crate::Axes;
use crate::path::left_of;
use crate::reference::ReferenceWindow;

type Gain = SMatrix<f64, 2, 6>;

/// Number of directions in half a turn. The index is the same for opposite directions.
const DIRECTIONS: usize = 48;

/// State feedback of both axes, with gains from a table of path directions.
#[derive(Clone, Debug)]
pub struct OptimalCrossCoupling {
    gains: Box<[Gain; DIRECTIONS]>,
    period_s: f64,
    speed: Speed,
    /// Integral of the error. It turns with the path, so its part along the path stays along the path.
    sum: Axes,
    tangent: Option<Axes>,
}

impl OptimalCrossCoupling {
    /// The controller for this index plus `contour` times the squared contour error. `None` if there is no optimum.
    #[must_use]
    pub fn new(belief: &Belief, index: Index, contour: f64) -> Option<Self> {
        let mut gains = Box::new([Gain::zeros(); DIRECTIONS]);
        for (number, gain) in gains.iter_mut().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "a small count")]
            let angle = std::f64::consts::PI * number as f64 / DIRECTIONS as f64;
            *gain = along(belief, index, contour, Axes::new(angle.cos(), angle.sin()))?;
        }
        Some(Self {
            gains,
            period_s: belief.period_s,
            speed: Speed::new(belief.period_s),
            sum: Axes::zeros(),
            tangent: None,
        })
    }

    /// The gain for `tangent`, interpolated between the two nearest directions of the table.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small count"
    )]
    fn gain(&self, tangent: Axes) -> Gain {
        let turn = tangent.y.atan2(tangent.x).rem_euclid(std::f64::consts::PI) / std::f64::consts::PI;
        let place = turn * DIRECTIONS as f64;
        let (first, share) = (place.floor(), place.fract());
        let first = first as usize % DIRECTIONS;
        self.gains[first] * (1.0 - share) + self.gains[(first + 1) % DIRECTIONS] * share
    }
}

/// The gain for a path in the direction `tangent`: positions, speeds, then integrals of both axes.
fn along(belief: &Belief, index: Index, contour: f64, tangent: Axes) -> Option<Gain> {
    let normal = left_of(tangent);
    let weight = Matrix2::identity() + normal * normal.transpose() * contour;
    let mut step = SMatrix::<f64, 6, 6>::zeros();
    let mut input = SMatrix::<f64, 6, 2>::zeros();
    let mut state_cost = SMatrix::<f64, 6, 6>::zeros();
    let mut input_cost = Matrix2::zeros();
    for (axis, drive) in belief.drives.iter().enumerate() {
        let (alone, push) = augmented(&drive.held(belief.period_s), belief.period_s);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            step[(2 * i + axis, 2 * j + axis)] = alone[(i, j)];
        }
        for i in 0..3 {
            input[(2 * i + axis, axis)] = push[i];
        }
        input_cost[(axis, axis)] = index.effort * drive.gain * drive.gain;
    }
    state_cost.fixed_view_mut::<2, 2>(0, 0).copy_from(&weight);
    state_cost.fixed_view_mut::<2, 2>(4, 4).copy_from(&(weight * index.integral));
    Some(optimal::regulator(&step, &input, &state_cost, &input_cost, |m| m.try_inverse())?.gain)
}

/// `vector`, rotated by the rotation from `from` to `to`, which are unit vectors.
fn turned(vector: Axes, from: Axes, to: Axes) -> Axes {
    to * vector.dot(&from) + left_of(to) * vector.dot(&left_of(from))
}

impl Controller for OptimalCrossCoupling {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let foot = &window.ahead(0).foot;
        // The error has the tracking error along the path, and the contour error of eqs. (15) to (17) across
        // it.
        let along = (foot.point - measured).dot(&foot.tangent);
        let across = ContourError::modelled(foot, measured).error;
        let error = foot.tangent * along + left_of(foot.tangent) * across;
        let speed = self.speed.see(measured);
        let before = self.tangent.replace(foot.tangent).unwrap_or(foot.tangent);
        self.sum = turned(self.sum, before, foot.tangent) + error * self.period_s;
        let state = SVector::<f64, 6>::new(-error.x, -error.y, speed.x, speed.y, -self.sum.x, -self.sum.y);
        -(self.gain(foot.tangent) * state)
    }
}
