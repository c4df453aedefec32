//! The robustness of a control loop: the peak of its sensitivity.
//!
//! The sensitivity S is the response of the measured position to a disturbance of it. It is found by a pulse, and not
//! from equations, so it holds for every controller, whatever it computes: for a small pulse the loop at rest is
//! linear. `max |S|` is one over the smallest distance of the Nyquist curve from −1 (Åström & Murray, "Feedback
//! Systems", section 9.3), so it bounds both margins. For two axes it is the largest singular value.

use nalgebra::{Complex, Matrix2};

use crate::Axes;
use crate::controllers::Controller;
use crate::path::{Foot, PathPiece};
use crate::plant::{Load, Plant, PlantModel};
use crate::reference::{ReferenceSample, ReferenceWindow};

/// The least gain and phase margin that a peak of the sensitivity leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Factor by which the gain of the loop may grow.
    pub gain: f64,
    /// Phase that the loop may lose, degrees.
    pub phase_deg: f64,
}

impl Margins {
    /// The margins that a peak of `peak` leaves at least: `Ms/(Ms − 1)` and `2·asin(1/(2·Ms))`.
    #[must_use]
    pub fn of(peak: f64) -> Self {
        Self { gain: peak / (peak - 1.0), phase_deg: 2.0 * (0.5 / peak).asin().to_degrees() }
    }
}

/// The disturbance of a measured position, pulses: small beside any change of a controller's structure.
const PULSE: f64 = 1e-3;
/// The direction of the path at rest, degrees. No axis has a part in it that another one lacks.
const DIRECTION_DEG: f64 = 30.0;
/// Share of the pulse to which the response must decay.
const DECAYED: f64 = 0.02;
/// Time for the decay, in samples and in time constants of the slower drive: the longer of the two.
const DECAY_SAMPLES: f64 = 150.0;
const DECAY_TIME_CONSTANTS: f64 = 6.0;
/// Angles per sample at which the peak is sought, from half the sampling frequency down.
const ANGLES: u32 = 60;
/// Ratio of two such angles.
const RATIO: f64 = 1.08;

/// The largest singular value of the sensitivity over all frequencies, for a loop of `plant` and a controller of
/// `built`. `None` if the response does not decay.
///
/// The plant has no friction, backlash, limit or rounding here: they only make the loop slower, and a limit of its own
/// is not a margin.
#[must_use]
pub fn sensitivity_peak(
    plant: &PlantModel,
    built: &mut dyn FnMut() -> Option<Box<dyn Controller>>,
) -> Option<f64> {
    let mut linear = PlantModel::ideal(plant.drives(), plant.period_s);
    (linear.delay_samples, linear.delay_share) = (plant.delay_samples, plant.delay_share);
    let responses = [Axes::new(PULSE, 0.0), Axes::new(0.0, PULSE)]
        .map(|pulse| Some(response(linear, built()?.as_mut(), pulse)).filter(|response| decays(response)));
    let [Some(x), Some(y)] = responses else { return None };
    let mut peak = 0.0_f64;
    let mut angle = std::f64::consts::PI;
    for _ in 0..ANGLES {
        let at = |response: &[Axes], axis: usize| -> Complex<f64> {
            let turn = Complex::from_polar(1.0, -angle);
            let mut phase = Complex::new(1.0, 0.0);
            let mut sum = Complex::new(0.0, 0.0);
            for position in response {
                sum += phase * (position[axis] / PULSE);
                phase *= turn;
            }
            sum
        };
        let matrix = Matrix2::new(at(&x, 0), at(&y, 0), at(&x, 1), at(&y, 1));
        peak = peak.max(matrix.singular_values()[0]);
        angle /= RATIO;
    }
    peak.is_finite().then_some(peak)
}

/// The measured positions of a loop at rest after a pulse on the first of them.
fn response(model: PlantModel, controller: &mut dyn Controller, pulse: Axes) -> Vec<Axes> {
    let (sin, cos) = DIRECTION_DEG.to_radians().sin_cos();
    let along = Axes::new(cos, sin);
    let piece = PathPiece::Line { from: along * -1e6, to: along * 1e6 };
    let foot = Foot { point: Axes::zeros(), tangent: along, curvature: 0.0 };
    let samples = [ReferenceSample { foot, piece, number: 0, begins: 0.0, along: 1e6, speed: 0.0 }];
    let slowest = model.drives().iter().map(|drive| drive.time_constant_s).fold(0.0, f64::max);
    let count = DECAY_SAMPLES.max(DECAY_TIME_CONSTANTS * slowest / model.period_s);
    let mut plant = Plant::at_rest(model, Axes::zeros());
    // Controllers take their first look at rest.
    for _ in 0..3 {
        let command = controller.step(&ReferenceWindow::new(&samples, 0), plant.measured());
        plant.step(command, &Load::default());
    }
    let mut seen = Vec::new();
    let mut number = 0.0;
    while number < count {
        let pulse = if number == 0.0 { pulse } else { Axes::zeros() };
        let measured = plant.measured() + pulse;
        seen.push(measured);
        let command = controller.step(&ReferenceWindow::new(&samples, 0), measured);
        plant.step(command, &Load::default());
        number += 1.0;
    }
    seen
}

/// Whether the last fifth of a response is small.
fn decays(response: &[Axes]) -> bool {
    response[response.len() * 4 / 5..].iter().all(|position| position.amax() <= DECAYED * PULSE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controllers::proportional::Proportional;
    use crate::drive::Drive;

    const DRIVE: Drive = Drive { gain: 10.0, time_constant_s: 0.045 };

    fn found(gain: f64) -> Option<f64> {
        let plant = PlantModel::ideal([DRIVE; 2], 0.004);
        sensitivity_peak(&plant, &mut || Some(Box::new(Proportional { gain })))
    }

    /// The transfer function of a P loop gives the same peak: `S = A/(A + Kp·z⁻¹·B)`.
    #[test]
    fn peak_is_that_of_the_transfer_function() {
        let held = DRIVE.held(0.004);
        for gain in [1.0, 3.0, 6.0] {
            let closed = held.closed(gain);
            let peak = (1..=3000)
                .map(|number| {
                    let angle = std::f64::consts::PI * f64::from(number) / 3000.0;
                    let at = |[a0, a1, a2]: [f64; 3]| {
                        let z = Complex::from_polar(1.0, -angle);
                        (z * z * a2 + z * a1 + a0).norm()
                    };
                    at(held.poles()) / at(closed.poles)
                })
                .fold(0.0, f64::max);
            let found = found(gain).unwrap();
            assert!((found / peak - 1.0).abs() < 0.005, "{gain}: {found} {peak}");
        }
    }

    #[test]
    fn loop_that_does_not_settle_has_no_peak() {
        assert_eq!(found(40.0), None);
    }

    #[test]
    fn peak_of_two_leaves_the_known_margins() {
        let Margins { gain, phase_deg } = Margins::of(2.0);
        assert!((gain - 2.0).abs() < 1e-12 && (phase_deg - 28.955).abs() < 1e-3);
    }
}
