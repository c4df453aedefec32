//! The fit of a drive's simulation to a record.

use nalgebra::{SMatrix, SVector};

use super::record::MotionRecord;
use super::{Estimate, count};
use crate::drive::{Drive, DriveMotion};
use crate::plant::{Axis, Friction};

/// Quantile of the normal distribution for 95 %.
const QUANTILE: f64 = 1.96;
/// Number of parameters: gain, time constant, friction, delay, and the position at rest.
pub(super) const COUNT: usize = 5;
/// Least eigenvalue of the normal matrix, with a diagonal of 1.
const LEAST_EIGENVALUE: f64 = 1e-9;
/// Least number of lags that the intervals count.
const LEAST_LAGS: usize = 8;
/// Largest number of steps of the fit.
const MOST_FITS: u32 = 60;

pub(super) type Parameters = SVector<f64, COUNT>;

/// A record with the largest command that left its axis at rest, bits.
pub(super) struct HeldRecord<'a> {
    pub(super) record: &'a MotionRecord,
    pub(super) held_bits: f64,
}

/// Recorded less simulated positions, mm.
pub(super) fn residuals(record: &HeldRecord, parameters: &Parameters) -> Vec<f64> {
    let [gain, time_constant_s, coulomb, delay_s, begins_mm]: [f64; COUNT] = (*parameters).into();
    let stiction = coulomb.max(record.held_bits);
    let friction = if stiction > 0.0 { Friction::Stick { coulomb, stiction } } else { Friction::None };
    let axis = Axis { friction, ..Axis::ideal(Drive { gain, time_constant_s }) };
    let MotionRecord { times_s, commands, positions_mm } = record.record;
    let mut motion = DriveMotion { position: begins_mm, velocity: 0.0 };
    // The row whose command acts.
    let mut acting = 0;
    let mut now_s = times_s[0];
    let mut residuals = Vec::with_capacity(times_s.len());
    for (&at_s, &position) in times_s.iter().zip(positions_mm) {
        while now_s < at_s {
            let next = times_s.get(acting + 1).map_or(f64::INFINITY, |next| next + delay_s);
            if next <= now_s {
                acting += 1;
                continue;
            }
            let until = next.min(at_s);
            motion = axis.moved(motion, commands[acting], 0.0, until - now_s);
            now_s = until;
        }
        residuals.push(position - motion.position);
    }
    residuals
}

/// Sum of the squares.
pub(super) fn cost(residuals: &[f64]) -> f64 {
    residuals.iter().map(|residual| residual * residual).sum()
}

/// Step of a derivative, for each parameter.
fn nudges(parameters: &Parameters) -> Parameters {
    let [gain, tau, coulomb] = [parameters[0], parameters[1], parameters[2]];
    Parameters::new(gain * 1e-4, tau * 1e-4, (coulomb * 1e-3).max(1e-6 / gain), tau * 1e-3, 1e-4)
}

/// Derivatives of the residuals, by central differences; a negative friction or delay is none.
fn derivatives(record: &HeldRecord, parameters: &Parameters) -> Vec<Parameters> {
    let nudges = nudges(parameters);
    let mut rows = vec![Parameters::zeros(); record.record.times_s.len()];
    for index in 0..COUNT {
        let moved = |by: f64| {
            let mut moved = *parameters;
            moved[index] += by * nudges[index];
            residuals(record, &moved)
        };
        let (less, more) = (moved(-1.0), moved(1.0));
        for ((row, less), more) in rows.iter_mut().zip(less).zip(more) {
            row[index] = (more - less) / (2.0 * nudges[index]);
        }
    }
    rows
}

/// Levenberg-Marquardt steps to the least cost.
pub(super) fn fit(record: &HeldRecord, start: Parameters) -> Parameters {
    let (mut best, mut damping) = (start, 1e-3);
    let mut least = cost(&residuals(record, &best));
    for _ in 0..MOST_FITS {
        let rows = derivatives(record, &best);
        let mut normal = SMatrix::<f64, COUNT, COUNT>::zeros();
        let mut slope = Parameters::zeros();
        for (row, residual) in rows.iter().zip(residuals(record, &best)) {
            normal += row * row.transpose();
            slope += row * residual;
        }
        let before = least;
        while damping < 1e9 {
            let mut damped = normal;
            for index in 0..COUNT {
                damped[(index, index)] += damping * normal[(index, index)].max(f64::MIN_POSITIVE);
            }
            let step = damped.lu().solve(&-slope).unwrap_or_default();
            let mut next = best + step;
            for index in 0..2 {
                next[index] = next[index].max(best[index] * 0.2);
            }
            (next[2], next[3]) = (next[2].max(0.0), next[3].max(0.0));
            let cost = cost(&residuals(record, &next));
            if cost < least {
                (best, least) = (next, cost);
                damping = (damping * 0.2).max(1e-12);
                break;
            }
            damping *= 5.0;
        }
        if damping >= 1e9 || before - least <= 1e-10 * before {
            break;
        }
    }
    best
}

/// Number of rows over which a residual depends on an earlier one.
fn correlated(residuals: &[f64]) -> usize {
    let whole = cost(residuals);
    let at = |lag: usize| residuals[lag..].iter().zip(residuals).map(|(a, b)| a * b).sum::<f64>();
    (1..residuals.len() / 4).find(|&lag| at(lag) <= 0.2 * whole).unwrap_or(residuals.len() / 4)
}

/// The parameters with their 95 % intervals.
pub(super) fn estimates(record: &HeldRecord, found: &Parameters, residuals: &[f64]) -> [Estimate; COUNT] {
    let rows = derivatives(record, found);
    let mut normal = SMatrix::<f64, COUNT, COUNT>::zeros();
    for row in &rows {
        normal += row * row.transpose();
    }
    let scores: Vec<Parameters> = rows.iter().zip(residuals).map(|(row, residual)| row * *residual).collect();
    let mut spread = SMatrix::<f64, COUNT, COUNT>::zeros();
    let lags = (LEAST_LAGS + 2 * correlated(residuals)).min(rows.len() - 1);
    for lag in 0..=lags {
        let weight = 1.0 - count(lag) / count(lags + 1);
        let mut at = SMatrix::<f64, COUNT, COUNT>::zeros();
        for (later, earlier) in scores[lag..].iter().zip(&scores) {
            at += later * earlier.transpose();
        }
        spread += if lag == 0 { at } else { (at + at.transpose()) * weight };
    }
    // With columns of one length, the least eigenvalue tells whether the parameters can be told from each other.
    let length = Parameters::from_fn(|index, _| normal[(index, index)].sqrt());
    let alike = SMatrix::<f64, COUNT, COUNT>::from_fn(|i, j| normal[(i, j)] / (length[i] * length[j]));
    let distinct = alike.symmetric_eigenvalues().min() > LEAST_EIGENVALUE;
    let inverse = normal.try_inverse().filter(|_| distinct);
    let Some(inverse) = inverse else {
        return std::array::from_fn(|index| Estimate { value: found[index], half_width: f64::INFINITY });
    };
    let covariance = inverse * spread * inverse;
    std::array::from_fn(|index| Estimate {
        value: found[index],
        half_width: QUANTILE * covariance[(index, index)].max(0.0).sqrt(),
    })
}
