//! Runs of a controller and a plant along a path.

use serde::{Deserialize, Serialize};

use super::Axes;
use super::controllers::Controller;
use super::metrics::{Figures, Moment};
use super::path::{Foot, Path};
use super::plant::{Load, Plant, PlantModel};
use super::reference::{AT_REST, ReferenceSample, ReferenceWindow};

/// The cutting force (eqs. (2) to (4)).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cutting {
    /// Force at the feed `at_feed`, bits.
    pub bits: f64,
    /// Feed at which the force is `bits`, pulses/s.
    pub at_feed: f64,
    /// phi, the angle between force and tangent, rad.
    pub angle: f64,
}

/// Exponent of the feed in eq. (2).
const FEED_EXPONENT: f64 = 0.73;

impl Cutting {
    /// Dx and Dy at a point of the reference, bits.
    #[must_use]
    pub fn at(&self, foot: &Foot, speed: f64) -> Axes {
        let size = self.bits * (speed / self.at_feed).powf(FEED_EXPONENT);
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
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// Every sample from the first motion on.
    pub moments: Vec<Moment>,
    /// Summary of the samples.
    pub figures: Figures,
}

impl Task {
    /// The load at a sample.
    #[must_use]
    pub fn load(&self, sample: &ReferenceSample) -> Load {
        let cutting = self.cutting.map_or(Axes::zeros(), |cutting| cutting.at(&sample.foot, sample.speed));
        Load { cutting, reference_velocity: sample.velocity() }
    }

    /// Runs the task with `controller`, from rest at the start of the path to the end of the reference.
    #[must_use]
    pub fn run(&self, controller: &mut dyn Controller) -> RunOutcome {
        let samples = &self.reference;
        let start = samples.first().map_or(Axes::zeros(), ReferenceSample::position);
        let mut plant = Plant::at_rest(self.plant, start);
        let mut moments = Vec::with_capacity(samples.len());
        let mut at_s = 0.0;
        for (now, sample) in samples.iter().enumerate() {
            if now >= AT_REST {
                moments.push(Moment::seen(at_s, &self.path, sample, plant.position()));
                at_s += self.plant.period_s;
            }
            let command = controller.step(&ReferenceWindow::new(samples, now), plant.measured());
            plant.step(command, &self.load(sample));
        }
        let figures = Figures::of(&moments, plant.saturation_share());
        RunOutcome { moments, figures }
    }
}
