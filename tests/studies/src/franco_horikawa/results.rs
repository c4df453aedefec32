//! Runs of the complete study, and its results.

use std::time::Duration;

use keepout_drives::profile::DriveProfile;
use serde::{Deserialize, Serialize};

use super::attempt::{ALL, Attempt, PEOPLE, Tally, operator_of, real, seed_of};
use super::brake::{self, BrakeRow};
use super::clearing::{Cleared, with_ours, with_paper};
use super::delays::{Delays, Looked};
use super::finishing::{CONTROLLERS, Finished, finish};
use super::handwheel::{self, WheelRow};
use super::ours::Ours;
use super::paper::{Ground, Paper};
use super::parallel::{ProgressCallback, parallel};
use super::roughing::{self, RoughingPass};
use super::scenario::{Reported, Scenarios, StudyError, driven_modules};

/// Results of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Seed of the study.
    pub seed: u64,
    /// Attempts per row.
    pub attempts: u64,
    /// The delay model.
    pub delays: Delays,
    /// Rows of the paper's tables.
    pub paper: Vec<PaperRow>,
    /// The same rows, with segments selected by x intervals alone.
    pub by_x: Vec<PaperRow>,
    /// Rows of Keepout.
    pub ours: Vec<OurRow>,
    /// Rows of Keepout with simulated feed drives.
    pub driven: Vec<OurRow>,
    /// Time to clear stock.
    pub clearing: Vec<ClearRow>,
    /// Roughing passes all round, on the same modules.
    pub roughing: Vec<RoughingPass>,
    /// Finishing passes.
    pub finishing: Vec<Finished>,
    /// The one-dimensional system.
    pub handwheel: Vec<WheelRow>,
    /// The one-dimensional system with a gradual brake.
    pub brake: Vec<BrakeRow>,
}

/// A row of the paper's tables, with our result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperRow {
    /// The paper's values.
    pub reported: Reported,
    /// Our simulation of the paper's controller.
    pub found: Tally,
}

/// A row of Keepout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OurRow {
    /// Name of the profile.
    pub profile: String,
    /// Top speed, mm/s.
    pub speed_mm_s: f64,
    /// Delay of the line each way, ms.
    pub latency_ms: u64,
    /// Distance that jogging keeps from the part, mm.
    pub tolerance_mm: f64,
    /// Statistics of the attempts.
    pub found: Tally,
}

/// A row of the clearing runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClearRow {
    /// Name of the profile.
    pub profile: String,
    /// The system: "paper" or "ours".
    pub system: String,
    /// Top speed, mm/s.
    pub speed_mm_s: f64,
    /// Tolerance T, mm.
    pub tolerance_mm: f64,
    /// Whether the operator also clears the near stock.
    pub all: bool,
    /// Mean of several runs. The depth is the largest of all runs.
    pub found: Cleared,
}

/// Number of runs of a clearing row.
const CLEARINGS: u64 = 4;
/// T of the paper's system in clearing, mm: the largest of Table 2.
const CLEARING_T_MM: f64 = 5.0;
/// Number of attempts for each attempt with simulated drives.
const DRIVEN_SHARE: u64 = 50;
/// First random stream of the rows of Keepout.
const OURS_FROM: u64 = 1000;
/// First random stream of the rows with simulated drives.
const DRIVEN_FROM: u64 = 2000;
/// First random stream of the clearing rows.
const CLEARING_FROM: u64 = 3000;

impl Results {
    /// Runs the complete study. Calls `progress` with the name of the part, its finished rows and all its
    /// rows.
    ///
    /// # Errors
    /// [`StudyError`] if an attempt can not run.
    pub fn of(
        scenarios: &Scenarios,
        (attempts, seed): (u64, u64),
        progress: &(dyn Fn(&str, u64, u64) + Sync),
    ) -> Result<Self, StudyError> {
        let named = |part: &'static str| move |done: u64, all: u64| progress(part, done, all);
        let paper = paper_rows(scenarios, (attempts, seed), &named("the paper's tables"))?;
        let mut literal = scenarios.clone();
        literal.delays.classified = Looked::ByX;
        let by_x = paper_rows(&literal, (attempts, seed), &named("the paper's tables, x alone"))?;
        let ours = our_rows(scenarios, (attempts, seed), &named("Keepout"))?;
        let driven = attempts.div_ceil(DRIVEN_SHARE);
        let driven = driven_rows(scenarios, (driven, seed), &named("Keepout with drives"))?;
        let clearing = clear_rows(scenarios, seed, &named("clearing stock"))?;
        let roughing = roughing::passes(scenarios, seed, &named("roughing passes"))?;
        let finishing = finish_rows(scenarios, &paper, &ours, &named("finishing passes"))?;
        let wheel = (attempts, seed);
        let handwheel =
            handwheel::rows(scenarios.tool_diameter_mm, scenarios.delays, wheel, &named("handwheel"))?;
        Ok(Self {
            seed,
            attempts,
            delays: scenarios.delays,
            paper,
            by_x,
            ours,
            driven,
            clearing,
            roughing,
            finishing,
            handwheel,
            brake: brake::rows(scenarios.delays, wheel),
        })
    }
}

/// Simulates the rows of the paper's tables.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn paper_rows(
    scenarios: &Scenarios,
    (attempts, seed): (u64, u64),
    progress: &ProgressCallback<'_>,
) -> Result<Vec<PaperRow>, StudyError> {
    parallel(scenarios.row.len(), progress, |number| {
        let reported = scenarios.row[number].clone();
        let ground = ground(scenarios, &reported.profile)?;
        let paper = on(scenarios, &ground, &reported);
        let found = paper.attempts((number as u64, attempts, seed)).collect::<Result<_, _>>()?;
        Ok(PaperRow { reported, found })
    })
}

fn ground<'a>(scenarios: &'a Scenarios, profile: &str) -> Result<Ground<'a>, StudyError> {
    let shape = scenarios.shape(profile)?;
    Ground::new(shape, scenarios.tool_diameter_mm, scenarios.delays.classified.into())
}

/// The paper's controller with the settings of a row.
fn on<'a>(scenarios: &Scenarios, ground: &'a Ground<'a>, row: &Reported) -> Paper<'a> {
    let delays = scenarios.delays;
    Paper { ground, feed_mm_s: row.feed_mm_s, tolerance_mm: row.tolerance_mm, delays, machine: None }
}

/// Simulates the first attempts of a row of the paper's tables.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn paper_attempts(
    scenarios: &Scenarios,
    number: usize,
    (attempts, seed): (u64, u64),
) -> Result<Vec<Attempt>, StudyError> {
    let row = &scenarios.row[number];
    let ground = ground(scenarios, &row.profile)?;
    on(scenarios, &ground, row).attempts((number as u64, attempts, seed)).collect()
}

/// Profile, speed and delay of each row of Keepout.
fn settings(scenarios: &Scenarios) -> Vec<(usize, f64, u64)> {
    let mut settings = Vec::new();
    for profile in 0..scenarios.profile.len() {
        for &speed in &scenarios.ours_mm_s {
            settings.extend(scenarios.latencies_ms.iter().map(|&latency| (profile, speed, latency)));
        }
    }
    settings
}

/// Runs the rows of Keepout.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn our_rows(
    scenarios: &Scenarios,
    (attempts, seed): (u64, u64),
    progress: &ProgressCallback<'_>,
) -> Result<Vec<OurRow>, StudyError> {
    let settings = settings(scenarios);
    parallel(settings.len(), progress, |number| {
        our_row(scenarios, settings[number], (OURS_FROM + number as u64, attempts, seed), None)
    })
}

/// Runs the rows of Keepout with simulated drives, at the shortest delay.
fn driven_rows(
    scenarios: &Scenarios,
    (attempts, seed): (u64, u64),
    progress: &ProgressCallback<'_>,
) -> Result<Vec<OurRow>, StudyError> {
    let first = scenarios.latencies_ms.iter().copied().min().unwrap_or_default();
    let settings: Vec<_> =
        settings(scenarios).into_iter().filter(|(_, _, latency)| *latency == first).collect();
    let servo = driven_modules()?;
    parallel(settings.len(), progress, |number| {
        let stream = (DRIVEN_FROM + number as u64, attempts, seed);
        our_row(scenarios, settings[number], stream, Some(&servo))
    })
}

fn our_row(
    scenarios: &Scenarios,
    (profile, speed_mm_s, latency_ms): (usize, f64, u64),
    (stream, attempts, seed): (u64, u64, u64),
    servo: Option<&DriveProfile>,
) -> Result<OurRow, StudyError> {
    let shape = &scenarios.profile[profile];
    let ours = Ours::new(shape, scenarios.tool_diameter_mm, speed_mm_s)?;
    let latency = Duration::from_millis(latency_ms);
    let tried = (0..attempts).map(|attempt| {
        ours.attempt(operator_of(&ALL, attempt), (seed_of(seed, stream, attempt), latency), servo)
    });
    let found = tried.collect::<Result<_, _>>()?;
    Ok(OurRow {
        profile: shape.name.clone(),
        speed_mm_s,
        latency_ms,
        tolerance_mm: ours.tolerance_mm(),
        found,
    })
}

/// Runs attempts with Keepout and models of people, at a delay of 1 ms, for a picture.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn our_attempts(
    scenarios: &Scenarios,
    (profile, speed_mm_s): (usize, f64),
    (attempts, seed): (u64, u64),
) -> Result<Vec<Attempt>, StudyError> {
    let ours = Ours::new(&scenarios.profile[profile], scenarios.tool_diameter_mm, speed_mm_s)?;
    let latency = Duration::from_millis(1);
    let tried = (0..attempts).map(|attempt| {
        let seed = seed_of(seed, OURS_FROM, attempt);
        ours.attempt(operator_of(&PEOPLE, attempt), (seed, latency), None)
    });
    tried.collect()
}

/// Runs the clearing rows.
///
/// # Errors
/// [`StudyError`] if a run fails.
pub fn clear_rows(
    scenarios: &Scenarios,
    seed: u64,
    progress: &ProgressCallback<'_>,
) -> Result<Vec<ClearRow>, StudyError> {
    let mut settings = Vec::new();
    for profile in 0..scenarios.profile.len() {
        settings.extend(scenarios.ours_mm_s.iter().take(2).map(|&speed| (profile, "paper", speed, false)));
        for all in [false, true] {
            settings.extend(scenarios.ours_mm_s.iter().map(|&speed| (profile, "ours", speed, all)));
        }
    }
    parallel(settings.len(), progress, |number| {
        let (profile, system, speed_mm_s, all) = settings[number];
        let shape = &scenarios.profile[profile];
        let diameter = scenarios.tool_diameter_mm;
        let seeds = (0..CLEARINGS).map(|run| seed_of(seed, CLEARING_FROM + number as u64, run));
        let delays = scenarios.delays;
        let (tolerance_mm, runs) = if system == "paper" {
            let ground = ground(scenarios, &shape.name)?;
            let paper = Paper {
                ground: &ground,
                feed_mm_s: speed_mm_s,
                tolerance_mm: CLEARING_T_MM,
                delays,
                machine: None,
            };
            let runs = seeds.map(|seed| with_paper(&paper, seed));
            (CLEARING_T_MM, runs.collect::<Result<Vec<_>, _>>()?)
        } else {
            let ours = Ours::new(shape, diameter, speed_mm_s)?;
            let runs = seeds.map(|seed| with_ours(&ours, all, (seed, Duration::from_millis(1))));
            (ours.tolerance_mm(), runs.collect::<Result<Vec<_>, _>>()?)
        };
        let found = Cleared::mean(&runs);
        let (profile, system) = (shape.name.clone(), system.into());
        Ok(ClearRow { profile, system, speed_mm_s, tolerance_mm, all, found })
    })
}

/// Simulates single and double finishing passes over the stock that each system left, with each controller.
///
/// # Errors
/// [`StudyError`] if no plan can be made, or a controller does not exist.
pub fn finish_rows(
    scenarios: &Scenarios,
    paper: &[PaperRow],
    ours: &[OurRow],
    progress: &ProgressCallback<'_>,
) -> Result<Vec<Finished>, StudyError> {
    let mean = |tallies: &mut dyn Iterator<Item = &Tally>| {
        let means: Vec<f64> = tallies.filter_map(|tally| tally.mean_mm).collect();
        means.iter().sum::<f64>() / real(means.len().max(1) as u64)
    };
    let mut settings = Vec::new();
    for (number, shape) in scenarios.profile.iter().enumerate() {
        // Only tolerances of 4 mm and more are usable in practice with the paper's system.
        let theirs =
            paper.iter().filter(|row| row.reported.profile == shape.name && row.reported.tolerance_mm >= 4.0);
        let theirs = mean(&mut theirs.map(|row| &row.found));
        let own = mean(&mut ours.iter().filter(|row| row.profile == shape.name).map(|row| &row.found));
        for kind in CONTROLLERS {
            settings.extend([(number, kind, theirs, 1), (number, kind, theirs, 2), (number, kind, own, 1)]);
        }
    }
    parallel(settings.len(), progress, |number| {
        let (profile, kind, stock_mm, passes) = settings[number];
        finish(&scenarios.profile[profile], scenarios.tool_diameter_mm, (stock_mm, passes), kind)
    })
}
