//! Runs of a controller and a plant along a path.

use serde::{Deserialize, Serialize};

use super::Axes;
use super::controllers::Controller;
use super::metrics::{Figures, Moment, larger};
use super::path::{Foot, Path};
use super::plant::{Load, MOST_DELAY, Plant, PlantModel};
use super::reference::{AT_REST, ReferenceSample, ReferenceWindow};

/// The cutting force (eqs. (2) to (4)).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cutting {
    /// Force at the feed `at_feed`, bits.
    pub bits: f64,
    /// Feed at which the force is `bits`, pulses/s.
    pub at_feed: f64,
    /// Feed above which the force grows no more, pulses/s: the tool then crosses air.
    pub up_to_feed: f64,
    /// phi, the angle between force and tangent, rad.
    pub angle: f64,
}

/// Exponent of the feed in eq. (2).
const FEED_EXPONENT: f64 = 0.73;

impl Cutting {
    /// Dx and Dy at a point of the reference, bits: eqs. (2) to (4).
    #[must_use]
    pub fn at(&self, foot: &Foot, speed: f64) -> Axes {
        let size = self.bits * (speed.min(self.up_to_feed) / self.at_feed).powf(FEED_EXPONENT);
        let theta = foot.tangent.y.atan2(foot.tangent.x);
        let turned = self.angle - theta;
        Axes::new(turned.cos(), -turned.sin()) * size
    }
}

/// A plant, a path and a load to run a controller with.
#[derive(Clone, Debug)]
pub struct Task {
    /// The true plant.
    pub plant: PlantModel,
    /// The path to follow.
    pub path: Path,
    /// Feed along the path, pulses/s.
    pub feed: f64,
    /// Samples of the path at the feed. Empty for a path without length.
    pub reference: Vec<ReferenceSample>,
    /// The cutting force, if the tool cuts.
    pub cutting: Option<Cutting>,
}

/// The result of a run.
#[derive(Clone, Debug, Default)]
pub struct RunOutcome {
    /// Every sample from the first motion on.
    pub moments: Vec<Moment>,
    /// Number of samples until the reference came to the end of the path.
    pub moving: usize,
    /// Summary of the samples.
    pub figures: Figures,
}

impl RunOutcome {
    /// The samples until the reference came to the end of the path.
    #[must_use]
    pub fn in_motion(&self) -> &[Moment] {
        &self.moments[..self.moving]
    }
}

impl Task {
    /// The same task with commands that act later by `samples`, at most [`MOST_DELAY`] in all.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few samples")]
    pub fn later(&self, samples: f64) -> Self {
        let mut later = self.clone();
        let share = later.plant.delay_share + samples;
        later.plant.delay_samples = (later.plant.delay_samples + share.floor() as usize).min(MOST_DELAY);
        later.plant.delay_share = share.fract();
        later
    }

    /// The load at a sample.
    #[must_use]
    pub fn load(&self, sample: &ReferenceSample) -> Load {
        let cutting = self.cutting.map_or(Axes::zeros(), |cutting| cutting.at(&sample.foot, sample.speed));
        Load { cutting, reference_velocity: sample.velocity() }
    }

    /// Runs the task with `controller`, from rest at the start of the path to the end of the reference, and then as
    /// long as the drives need to come to rest there.
    #[must_use]
    pub fn run(&self, controller: &mut dyn Controller) -> RunOutcome {
        self.run_in_parts(controller, 1)
    }

    /// [`Task::run`], which looks at the position `parts` times in each sampling period for
    /// [`Figures::largest`].
    #[must_use]
    pub fn run_in_parts(&self, controller: &mut dyn Controller, parts: u32) -> RunOutcome {
        let samples = &self.reference;
        let Some(last) = samples.last() else { return RunOutcome::default() };
        let standing = ReferenceSample { speed: 0.0, ..*last };
        let mut plant = Plant::at_rest(self.plant, samples[0].position());
        let mut moments = Vec::with_capacity(samples.len());
        let (mut at_s, mut largest) = (0.0, 0.0_f64);
        let part_s = self.plant.period_s / f64::from(parts);
        for now in 0..samples.len() + self.run_out_samples() {
            let sample = samples.get(now).unwrap_or(&standing);
            if now >= AT_REST {
                let moment = Moment::seen(at_s, &self.path, sample, plant.position());
                largest = larger(largest, moment.contour_error.abs());
                moments.push(moment);
                at_s += self.plant.period_s;
            }
            let command = controller.step(&ReferenceWindow::new(samples, now), plant.measured());
            plant.step_in_parts(command, &self.load(sample), parts, |plant, acceleration| {
                if parts == 1 {
                    return;
                }
                let foot = self.path.nearest(plant.position(), sample.number);
                // Between two looks the tool leaves its chord, and the path leaves its own, by no more than this.
                let bend = foot.curvature.abs() * plant.velocity().norm_squared();
                let between = (acceleration + bend) * part_s * part_s / 8.0;
                largest = larger(largest, foot.distance(plant.position()).abs() + between);
            });
        }
        // The last sample is at the end of the path.
        let (moving, after) = moments.split_at(moments.len().min(samples.len().saturating_sub(AT_REST + 1)));
        let figures = Figures::of(moving, after, largest, plant.saturation_share());
        let moving = moving.len();
        RunOutcome { moments, moving, figures }
    }

    /// Number of samples after the end of the reference: ten time constants of the slower drive.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of samples")]
    fn run_out_samples(&self) -> usize {
        let slower = self.plant.drives().iter().map(|drive| drive.time_constant_s).fold(0.0, f64::max);
        (10.0 * slower / self.plant.period_s).ceil() as usize
    }
}
