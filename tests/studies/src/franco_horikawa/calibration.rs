//! Calibration: fits the free values of the delay model to half of the rows of Table 2.

use super::attempt::{Tally, real};
use super::delays::{Delays, Looked};
use super::paper::{Ground, Paper};
use super::parallel::{ProgressCallback, parallel};
use super::scenario::{Reported, Scenarios, StudyError};

/// Uncertainty of a mean under-cutting, mm. Rows with equal settings differ by this much at the two feeds.
const SPREAD_MM: f64 = 0.25;

/// A delay model and its misfit.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayFit {
    /// The model.
    pub delays: Delays,
    /// Sum of the binomial deviance of the successes and the squared errors of the mean under-cutting in
    /// units of 0.25 mm.
    pub misfit: f64,
}

/// The misfit of a row.
#[must_use]
pub fn misfit(row: &Reported, found: &Tally) -> f64 {
    let (attempts, successes) = (f64::from(row.attempts), f64::from(row.successes));
    // Add half an attempt to both counts, so that the share is never exactly 0 or 1.
    let share = (real(found.successes) + 0.5) / (real(found.attempts) + 1.0);
    let term = |count: f64, share: f64| {
        if count > 0.0 { 2.0 * count * (count / attempts / share).ln() } else { 0.0 }
    };
    let deviance = term(successes, share) + term(attempts - successes, 1.0 - share);
    let under_cutting = row.under_cutting_mm.zip(found.mean_mm);
    deviance + under_cutting.map_or(0.0, |(reported, found)| ((reported - found) / SPREAD_MM).powi(2))
}

/// Number of models of the coarse search that the fine search refines.
const REFINED: usize = 4;
/// Factor on the attempts in the fine search.
const REFINED_ATTEMPTS: u64 = 8;
/// Number of models of the fine search in the final rating.
const RATED: usize = 8;
/// Factor on the attempts in the final rating.
const RATED_ATTEMPTS: u64 = 40;

/// Searches the delay model in three steps, and returns the best models first.
///
/// 1. Rate every combination of a coarse grid on the rows marked `calibrates`.
/// 2. Rate a fine grid around the best models.
/// 3. Rate the best of these again, with more attempts and another seed. Otherwise a lucky model could win.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn calibrate(
    scenarios: &Scenarios,
    (attempts, seed): (u64, u64),
    progress: &ProgressCallback<'_>,
) -> Result<Vec<DelayFit>, StudyError> {
    let coarse = rate(scenarios, grid(scenarios.delays), (attempts, seed), progress)?;
    let mut fine: Vec<Delays> = Vec::new();
    for around in coarse.iter().take(REFINED).flat_map(|fit| around(fit.delays)) {
        if !fine.contains(&around) {
            fine.push(around);
        }
    }
    let fine = rate(scenarios, fine, (attempts * REFINED_ATTEMPTS, seed), progress)?;
    let best = fine.iter().take(RATED).map(|fit| fit.delays).collect();
    rate(scenarios, best, (attempts * RATED_ATTEMPTS, seed + 1), progress)
}

/// The fine grid around a model.
fn around(delays: Delays) -> Vec<Delays> {
    let mut near = Vec::new();
    let thousandths = |value: f64| (value.max(0.0) * 1000.0).round() / 1000.0;
    for unit in [-0.1, -0.05, 0.0, 0.05, 0.1] {
        for compute in [0.8, 1.0, 1.2] {
            for inertia in [-0.01, 0.0, 0.01] {
                near.push(Delays {
                    unit_mm: thousandths(delays.unit_mm + unit),
                    compute_s: thousandths(delays.compute_s * compute),
                    inertia_s: thousandths(delays.inertia_s + inertia),
                    ..delays
                });
            }
        }
    }
    near
}

/// Rates models on the rows marked `calibrates`, and returns the best models first.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn rate(
    scenarios: &Scenarios,
    grid: Vec<Delays>,
    (attempts, seed): (u64, u64),
    progress: &ProgressCallback<'_>,
) -> Result<Vec<DelayFit>, StudyError> {
    let rows: Vec<(u64, &Reported)> = (0..).zip(&scenarios.row).filter(|(_, row)| row.calibrates).collect();
    let ground = |looked: Looked| {
        let grounds = rows.iter().map(|(_, row)| {
            Ground::new(scenarios.shape(&row.profile)?, scenarios.tool_diameter_mm, looked.into())
        });
        grounds.collect::<Result<Vec<_>, StudyError>>()
    };
    let grounds = [ground(Looked::ByX)?, ground(Looked::ByXOrY)?];
    let mut fits = parallel(grid.len(), progress, |index| {
        let delays = grid[index];
        let grounds = &grounds[usize::from(delays.classified == Looked::ByXOrY)];
        let misfits = rows.iter().zip(grounds).map(|((number, row), ground)| {
            let paper = Paper {
                ground,
                feed_mm_s: row.feed_mm_s,
                tolerance_mm: row.tolerance_mm,
                delays,
                machine: None,
            };
            let found: Tally = paper.attempts((*number, attempts, seed)).collect::<Result<_, _>>()?;
            Ok(misfit(row, &found))
        });
        let misfit = misfits.sum::<Result<f64, StudyError>>()?;
        Ok(DelayFit { delays, misfit })
    })?;
    fits.sort_by(|a: &DelayFit, b| a.misfit.total_cmp(&b.misfit));
    Ok(fits)
}

/// The coarse grid.
fn grid(fixed: Delays) -> Vec<Delays> {
    let mut grid = Vec::new();
    for classified in [Looked::ByX, Looked::ByXOrY] {
        for ahead in [1, 2] {
            for unit_mm in [1.5, 2.0, 2.25, 2.5, 3.0] {
                for compute_s in [0.02, 0.04, 0.08, 0.15, 0.25, 0.35] {
                    for inertia_s in [0.0, 0.03, 0.06, 0.1] {
                        grid.push(Delays { classified, unit_mm, ahead, compute_s, inertia_s, ..fixed });
                    }
                }
            }
        }
    }
    grid
}
