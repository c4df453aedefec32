//! One tuner for every controller: the same objective, the same robustness, the same paths.
//!
//! The objective is the geometric mean of the RMS contour errors on three paths, until the drives rest, with friction,
//! cutting force and model errors. The constraint is the peak of the sensitivity ([`margins`]) of every loop whose
//! gains and time constants are wrong by ±20 % and whose commands act up to one sample later than the controller
//! knows. The search is an evolution strategy with one parent and one child (Rechenberg 1973) over the logarithms of
//! the parameters, from several starts: after each round the worse half of them ends (successive halving, Jamieson &
//! Talwalkar 2016). A candidate without the margins is made slower until it has them, because the best gains lie on
//! the edge of the margins.

pub mod margins;
pub mod parameter;

use margins::sensitivity_peak;
use parameter::Parameter;
use thiserror::Error;

use crate::Axes;
use crate::controllers::Controller;
use crate::controllers::kind::{Kind, Setting};
use crate::controllers::selection::Environment;
use crate::gains::Gains;
use crate::metrics::Spread;
use crate::path::Path;
use crate::plant::PlantModel;
use crate::profile::{DriveProfile, Uncertainty};
use crate::reference::{Ramp, Reference};
use crate::run::{Cutting, Task};

/// The largest peak of the sensitivity. It leaves a gain margin of 2 and a phase margin of 29°.
pub const MOST_PEAK: f64 = 2.0;
/// The errors that the loop must bear with that peak.
pub const BORNE: Uncertainty = Uncertainty { gain: 0.2, time_constant: 0.2, delay_samples: 1.0 };
/// Signs of these errors: gain and time constant of X, then of Y. The axes err together and against each other. The
/// first are the hardest: most candidates without the margins end there.
const SIGNS: [[f64; 4]; 7] = [
    [1.0, -1.0, 1.0, -1.0],
    [0.0; 4],
    [1.0, 1.0, 1.0, 1.0],
    [-1.0, -1.0, -1.0, -1.0],
    [-1.0, 1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0, -1.0],
];
/// The error of the model on the paths of the objective.
const ON_PATHS: Uncertainty = Uncertainty { gain: 0.05, time_constant: 0.05, delay_samples: 0.0 };
/// RMS contour error below which a better one does not count, µm.
const LEAST_UM: f64 = 0.01;

/// The tuned gains of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TunedGains {
    /// All gains. Only the parameters of the controller were changed.
    pub gains: Gains,
    /// Geometric mean of the RMS contour errors on the three paths, µm.
    pub rms_um: f64,
    /// The largest peak of the sensitivity.
    pub peak: f64,
    /// Number of candidates.
    pub tried: usize,
}

/// Reason why a controller was not tuned.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TuningError {
    /// The controller has no parameters, or needs what the paths do not have.
    #[error(
        "{0} cannot be tuned: it has no gains of its own, or needs a path that repeats. Choose another controller."
    )]
    NoParameters(&'static str),
    /// No gains keep the margins.
    #[error(
        "no gains of {0} keep the margins with these drives. Shorten the sampling period, or choose another controller."
    )]
    NotRobust(&'static str),
}

/// Tunes `kind` for the drives of `profile` and a feed along the contour, mm/s.
///
/// Calls `progress` with the number of candidates tried and the most there may be.
///
/// # Errors
/// [`TuningError`] if no gains keep the margins.
pub fn tune(
    profile: &DriveProfile,
    kind: Kind,
    feed_mm_s: f64,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<TunedGains, TuningError> {
    let title = kind.names().1;
    let parameters = Parameter::of(kind);
    let mut search =
        Search { profile, kind, parameters, tasks: tasks(profile, feed_mm_s), tried: 0, progress };
    if parameters.is_empty() || kind.built(&profile.setting(search.environment())).is_none() {
        return Err(TuningError::NoParameters(title));
    }
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut climbs = Vec::with_capacity(STARTS);
    while climbs.len() < STARTS && search.tried < MOST_STARTS {
        // The first start is the profile's gains.
        let spread = if search.tried == 0 { 0.0 } else { START_SPREAD };
        let start = stepped(&profile.gains, parameters, spread, &mut random);
        climbs.extend(search.candidate(start).map(|best| Climb { best, step: FIRST_STEP }));
    }
    let mut most = FIRST_TRIED;
    while climbs.len() > 1 {
        for climb in &mut climbs {
            search.go_on(climb, most, &mut random);
        }
        climbs.sort_by(|one, other| one.best.rms_um.total_cmp(&other.best.rms_um));
        climbs.truncate(climbs.len().div_ceil(2));
        most *= 2;
    }
    let Some(last) = climbs.first_mut() else { return Err(TuningError::NotRobust(title)) };
    search.go_on(last, MOST_TRIED, &mut random);
    Ok(TunedGains { tried: search.tried, ..last.best })
}

/// Standard deviation of the first steps of the search in the logarithm of a parameter, and of the last.
const FIRST_STEP: f64 = 0.7;
const LAST_STEP: f64 = 0.005;
/// Factor of the step after a success. One success in five keeps the step (Rechenberg 1973).
const GROWTH: f64 = 1.5;
/// Most candidates.
const MOST_TRIED: usize = 400;
/// Number of starts, and the standard deviation of their parameters' logarithms.
const STARTS: usize = 8;
/// Most starts, if some do not keep the margins at any speed.
const MOST_STARTS: usize = 24;
const START_SPREAD: f64 = 1.0;
/// Candidates of each start in the first round. Half of the starts go on to a round of twice as many.
const FIRST_TRIED: usize = 15;
/// The search takes the same steps each time.
const SEED: u64 = 1;
/// The least factor by which a candidate without the margins is made slower, and the number of its squarings.
const SLOWED: f64 = 1.15;
const MOST_SLOWED: u32 = 7;
/// Number of bisections of that factor.
const BISECTIONS: u32 = 3;

/// `gains` with a random step of this standard deviation in the logarithms of the parameters.
fn stepped(gains: &Gains, parameters: &[Parameter], step: f64, random: &mut fastrand::Rng) -> Gains {
    parameters.iter().fold(*gains, |gains, parameter| parameter.times(&gains, (step * normal(random)).exp()))
}

/// A random number of the normal distribution (Box & Muller 1958).
fn normal(random: &mut fastrand::Rng) -> f64 {
    let (radius, turn) = (random.f64().max(f64::MIN_POSITIVE), random.f64());
    (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
}

/// The search from one start.
struct Climb {
    best: TunedGains,
    step: f64,
}

/// The search for gains.
struct Search<'a> {
    profile: &'a DriveProfile,
    kind: Kind,
    parameters: &'static [Parameter],
    tasks: [Task; 3],
    tried: usize,
    progress: &'a mut dyn FnMut(usize, usize),
}

impl Search<'_> {
    fn environment(&self) -> Environment {
        Environment::of(&self.tasks[0], ON_PATHS.largest())
    }

    /// Goes on from one start with at most `most` candidates.
    fn go_on(&mut self, climb: &mut Climb, most: usize, random: &mut fastrand::Rng) {
        let end = MOST_TRIED.min(self.tried + most);
        while climb.step > LAST_STEP && self.tried < end {
            let next = stepped(&climb.best.gains, self.parameters, climb.step, random);
            match self.candidate(next).filter(|next| next.rms_um < climb.best.rms_um) {
                Some(better) => *climb = Climb { best: better, step: climb.step * GROWTH },
                None => climb.step /= GROWTH.powf(0.25),
            }
        }
    }

    /// The candidate, made slower until it keeps the margins.
    fn candidate(&mut self, gains: Gains) -> Option<TunedGains> {
        self.tried += 1;
        (self.progress)(self.tried.min(MOST_TRIED), MOST_TRIED);
        let (gains, peak) = self.robust(gains)?;
        let rms_um = self.mean_rms_um(gains)?;
        Some(TunedGains { gains, rms_um, peak, tried: self.tried })
    }

    /// The least slow gains that keep the margins, with their peak.
    fn robust(&self, gains: Gains) -> Option<(Gains, f64)> {
        let slowed = |factor: f64| {
            let slower =
                self.parameters.iter().fold(gains, |gains, parameter| parameter.slowed(&gains, factor));
            let in_range = slower.figures().iter().all(|each| each.range.contains(&each.value));
            let peak = in_range.then(|| peak_up_to(self.profile, self.kind, slower, MOST_PEAK));
            Some((slower, peak??))
        };
        if let Some(found) = slowed(1.0) {
            return Some(found);
        }
        let (mut low, mut high) = (1.0, SLOWED);
        let mut found = slowed(high);
        for _ in 0..MOST_SLOWED {
            if found.is_some() {
                break;
            }
            (low, high) = (high, high * high);
            found = slowed(high);
        }
        let mut found = found?;
        for _ in 0..BISECTIONS {
            let middle = f64::sqrt(low * high);
            match slowed(middle) {
                Some(better) => (high, found) = (middle, better),
                None => low = middle,
            }
        }
        Some(found)
    }

    /// Geometric mean of the RMS contour errors, µm. `None` for a run that diverges.
    fn mean_rms_um(&self, gains: Gains) -> Option<f64> {
        let mut product = 1.0;
        for task in &self.tasks {
            let mut setting = self.profile.setting(Environment::of(task, ON_PATHS.largest()));
            setting.gains = gains;
            setting.belief = setting.belief.off_by(ON_PATHS, [1.0, -1.0, -1.0, 1.0]);
            let outcome = task.run(self.kind.built(&setting)?.as_mut());
            let errors = outcome.moments.iter().map(|moment| moment.contour_error);
            product *= (Spread::of(errors).rms * self.profile.um()).max(LEAST_UM);
        }
        Some(product.cbrt()).filter(|rms| rms.is_finite())
    }
}

/// The largest peak of the sensitivity over the errors that the loop must bear. `None` if a loop does not settle.
#[must_use]
pub fn peak(profile: &DriveProfile, kind: Kind, gains: Gains) -> Option<f64> {
    peak_up_to(profile, kind, gains, f64::INFINITY)
}

/// [`peak`], if it is `limit` at most. The first that is greater ends the search.
fn peak_up_to(profile: &DriveProfile, kind: Kind, gains: Gains, limit: f64) -> Option<f64> {
    let mut setting: Setting = profile.setting(Environment::of_hand(profile));
    setting.gains = gains;
    setting.belief.limit = None;
    setting.round = Some(64);
    let mut most = 0.0_f64;
    for delay in [BORNE.delay_samples, 0.0] {
        for signs in SIGNS {
            let wrong = setting.belief.off_by(BORNE, signs);
            let mut plant = PlantModel::ideal(wrong.drives, profile.period_s);
            plant.delay_samples = profile.delay_samples;
            let plant = later(plant, delay);
            let mut built = || -> Option<Box<dyn Controller>> { kind.built(&setting) };
            let found = sensitivity_peak(&plant, &mut built)?;
            most = Some(most.max(found)).filter(|most| *most <= limit)?;
        }
    }
    Some(most)
}

/// `plant` with commands that act later by `samples`.
fn later(plant: PlantModel, samples: f64) -> PlantModel {
    let path = Path::line(Axes::new(1.0, 0.0));
    Task { plant, path, feed: 1.0, reference: Vec::new(), cutting: None }.later(samples).plant
}

/// The paths of the objective: a circle, an ellipse and a corner of 60°, each with the friction and the cutting force
/// of the profile. None of them is a path on which controllers are compared.
#[must_use]
pub fn tasks(profile: &DriveProfile, feed_mm_s: f64) -> [Task; 3] {
    let scale = profile.pulses_per_mm;
    let feed = feed_mm_s * scale;
    let ramp = profile.interpolator.map_or(Ramp::RaisedCosine(START_S), |interpolator| {
        let acceleration = interpolator.acceleration_mm_s2 * scale;
        Ramp::LimitedJerk { acceleration, jerk: acceleration / START_S }
    });
    let plant = profile.plant();
    let cutting = profile.cutting().map(|cutting| Cutting { up_to_feed: feed, ..cutting });
    let paths = [
        Path::circle(7.0 * scale, false, 1),
        Path::ellipse(16.0 * scale, 8.0 * scale),
        Path::corner(12.0 * scale, 60_f64.to_radians()),
    ];
    paths.map(|path| {
        let reference = Reference::along(&path, feed, plant.period_s, ramp).samples;
        Task { plant, path, feed, reference, cutting }
    })
}

/// Time to the feed, s; with an interpolator, time to its acceleration.
const START_S: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    const FEED_MM_S: f64 = 15.0;

    /// The paper's gains do not keep the margins.
    #[test]
    fn tuned_gains_keep_the_margins() {
        let profile = DriveProfile::load("koren-lo-table-1").unwrap();
        for kind in [Kind::Pid, Kind::PidZpetc] {
            let tuned = tune(&profile, kind, FEED_MM_S, &mut |_, _| {}).unwrap();
            let peak = peak(&profile, kind, tuned.gains).unwrap();
            assert!(peak <= MOST_PEAK && (peak - tuned.peak).abs() < 1e-9, "{kind:?}: {peak}");
            let before = super::peak(&profile, kind, profile.gains).unwrap();
            assert!(before > MOST_PEAK, "{kind:?}: the paper's gains have a peak of {before}");
            assert_eq!(tune(&profile, kind, FEED_MM_S, &mut |_, _| {}).unwrap(), tuned, "{kind:?}");
        }
    }

    /// A delay that the controller does not know takes margin away.
    #[test]
    fn unknown_delay_takes_margin_away() {
        let profile = DriveProfile::load("koren-lo-table-1").unwrap();
        let with = peak(&profile, Kind::P, Gains { proportional: 2.0, ..profile.gains }).unwrap();
        let plant = PlantModel::ideal(profile.drives(), profile.period_s);
        let alone = sensitivity_peak(&plant, &mut || {
            Some(Box::new(crate::controllers::proportional::Proportional { gain: 2.0 }))
        });
        assert!(with > alone.unwrap() * 1.05, "{with} {alone:?}");
    }

    #[test]
    fn controllers_without_gains_are_refused() {
        let profile = DriveProfile::load("koren-lo-table-1").unwrap();
        for kind in [Kind::Selection, Kind::Repetitive] {
            let error = tune(&profile, kind, FEED_MM_S, &mut |_, _| {}).unwrap_err();
            assert_eq!(error, TuningError::NoParameters(kind.names().1));
        }
    }
}
