//! A controller, a plant and a path: what comes of it.

use serde::{Deserialize, Serialize};

use super::Axes;
use super::controllers::Controller;
use super::metrics::{Figures, Moment};
use super::path::{Foot, Path};
use super::plant::{Load, Plant, PlantModel};
use super::reference::{AT_REST, Sample, Window};

/// The force of the cut (eqs. (2) to (4)).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cutting {
    /// Its size at `at_feed`, bits.
    pub bits: f64,
    /// The feed at which it has that size, pulses/s.
    pub at_feed: f64,
    /// phi, the angle between force and tangent, rad.
    pub angle: f64,
}

/// The exponent of the feed in eq. (2).
const FEED_EXPONENT: f64 = 0.73;

impl Cutting {
    /// Dx and Dy at a place of the reference, bits.
    #[must_use]
    pub fn at(&self, foot: &Foot, speed: f64) -> Axes {
        let size = self.bits * (speed / self.at_feed).powf(FEED_EXPONENT);
        let theta = foot.tangent.y.atan2(foot.tangent.x);
        let turned = self.angle - theta;
        Axes::new(turned.cos(), -turned.sin()) * size
    }
}

/// What is to be run.
#[derive(Clone, Debug)]
pub struct Task {
    /// The plant as it is.
    pub plant: PlantModel,
    /// What is to be followed.
    pub path: Path,
    /// pulses/s.
    pub feed: f64,
    /// The path at the feed; empty for a path without length.
    pub reference: Vec<Sample>,
    /// The cut.
    pub cutting: Option<Cutting>,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Every sample from the first motion on.
    pub moments: Vec<Moment>,
    /// What they come to.
    pub figures: Figures,
}

impl Task {
    /// The load at a sample.
    #[must_use]
    pub fn load(&self, sample: &Sample) -> Load {
        let cutting = self.cutting.map_or(Axes::zeros(), |cutting| cutting.at(&sample.foot, sample.speed));
        Load { cutting, reference_velocity: sample.velocity() }
    }

    /// Runs it with `controller`, from rest at the beginning of the path until the reference has come to its end.
    #[must_use]
    pub fn run(&self, controller: &mut dyn Controller) -> Outcome {
        let samples = &self.reference;
        let start = samples.first().map_or(Axes::zeros(), Sample::position);
        let mut plant = Plant::at_rest(self.plant, start);
        let mut moments = Vec::with_capacity(samples.len());
        let mut at_s = 0.0;
        for (now, sample) in samples.iter().enumerate() {
            if now >= AT_REST {
                moments.push(Moment::seen(at_s, &self.path, sample, plant.position()));
                at_s += self.plant.period_s;
            }
            let command = controller.step(&Window::new(samples, now), plant.measured());
            plant.step(command, &self.load(sample));
        }
        let figures = Figures::of(&moments, plant.saturation_share());
        Outcome { moments, figures }
    }
}
