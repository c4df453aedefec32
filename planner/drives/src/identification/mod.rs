//! Identification of a drive from a record of its motion.
//!
//! The model is the product's own: `tau·v' + v = K·(u − friction)`, with Coulomb friction and a delay of the command.
//! Its parameters are those whose simulation is nearest to the recorded positions: Levenberg-Marquardt steps from the
//! best of a grid of time constants and delays (Erkorkmaz & Altintas 2001 fit the same model by least squares). The
//! confidence intervals count that errors of quantisation depend on each other (Newey & West 1987).

mod fit;
pub mod record;
#[cfg(test)]
mod tests;

use fit::{HeldRecord, Parameters, cost, estimates, fit, residuals};
use record::MotionRecord;
use thiserror::Error;

/// A value with the half width of its 95 % confidence interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The most likely value.
    pub value: f64,
    /// Half the width of the interval.
    pub half_width: f64,
}

impl Estimate {
    /// Whether the interval contains `value`.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.value - value).abs() <= self.half_width
    }

    /// The half width as a share of the value.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.half_width / self.value.abs()
    }
}

/// The drive that a record shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentifiedDrive {
    /// K, the steady speed per bit, mm/(s·bit). Its inverse is the viscous friction, bits/(mm/s).
    pub gain: Estimate,
    /// tau, s.
    pub time_constant_s: Estimate,
    /// Coulomb friction, bits.
    pub coulomb_bits: Estimate,
    /// Delay of the command, s.
    pub delay_s: Estimate,
    /// The largest command that left the axis at rest, and the smallest that moved it from rest, bits. The static
    /// friction lies between them. `None` if the axis never rests.
    pub stiction_bits: Option<[f64; 2]>,
    /// RMS distance of the simulation from the record, mm.
    pub residual_mm: f64,
    /// Smallest step of the recorded positions, mm.
    pub resolution_mm: f64,
}

/// Reasons for which a record tells no drive. Each names what to record instead.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum IdentificationError {
    /// The axis hardly moves.
    #[error(
        "the axis moves {travel_mm:.3} mm, and its positions have steps of {resolution_mm:.4} mm. Record a motion of \
         at least {LEAST_STEPS} steps."
    )]
    Still {
        /// Distance between the extreme positions, mm.
        travel_mm: f64,
        /// Smallest step of the positions, mm.
        resolution_mm: f64,
    },
    /// The command never changes.
    #[error(
        "the command is {0} bits all the time. Record a motion with steps of the command, in both directions."
    )]
    Constant(f64),
    /// The axis does not begin at rest.
    #[error("the axis moves already at the beginning. Begin the record while it rests, with a command of 0.")]
    Moving,
    /// The rows are too far apart.
    #[error(
        "the rows are {period_s:.4} s apart, and the time constant is about {time_constant_s:.4} s. Record at least \
         five rows in a time constant."
    )]
    Coarse {
        /// Time between two rows, s.
        period_s: f64,
        /// The time constant, s.
        time_constant_s: f64,
    },
    /// The record does not determine a parameter.
    #[error(
        "the record does not determine the {0} within 20 %. Record steps of two sizes in both directions, each until \
         the speed is steady."
    )]
    Undetermined(&'static str),
    /// The motion is not that of a drive.
    #[error(
        "the motion is not that of a drive with this command: the best model is {residual_mm:.3} mm away (RMS) on a \
         way of {travel_mm:.3} mm. Check that the columns belong to one axis, and that no limit clipped the command."
    )]
    NotADrive {
        /// RMS distance, mm.
        residual_mm: f64,
        /// Distance between the extreme positions, mm.
        travel_mm: f64,
    },
}

/// Least travel, in steps of the positions.
const LEAST_STEPS: u32 = 200;
/// Largest half width of the gain and the time constant, as a share.
const MOST_SHARE: f64 = 0.2;
/// Largest residual, as a share of the travel.
const MOST_RESIDUAL: f64 = 0.01;
/// Least number of rows in a time constant.
const LEAST_ROWS_IN_TAU: f64 = 5.0;

/// Finds the drive of a record.
///
/// # Errors
/// [`IdentificationError`] if the record does not determine the drive.
pub fn identify(record: &MotionRecord) -> Result<IdentifiedDrive, IdentificationError> {
    let shape = Shape::of(record)?;
    let stiction_bits = breakaway(record, &shape);
    let held_bits = stiction_bits.map_or(0.0, |[held, _]| held);
    let record = &HeldRecord { record, held_bits };
    let (start, _) = shape.grid().into_iter().fold((None, f64::INFINITY), |best, start| {
        let cost = cost(&residuals(record, &start));
        if cost < best.1 { (Some(start), cost) } else { best }
    });
    let not_a_drive =
        |residual_mm| IdentificationError::NotADrive { residual_mm, travel_mm: shape.travel_mm };
    let found = fit(record, start.ok_or(not_a_drive(f64::INFINITY))?);
    let residuals = residuals(record, &found);
    let residual_mm = (cost(&residuals) / count(residuals.len())).sqrt();
    let most_mm = (MOST_RESIDUAL * shape.travel_mm).max(shape.resolution_mm);
    if !(0.0..=most_mm).contains(&residual_mm) {
        return Err(not_a_drive(residual_mm));
    }
    let [gain, time_constant_s, coulomb_bits, delay_s, _] = estimates(record, &found, &residuals);
    if shape.period_s * LEAST_ROWS_IN_TAU > time_constant_s.value {
        return Err(IdentificationError::Coarse {
            period_s: shape.period_s,
            time_constant_s: time_constant_s.value,
        });
    }
    let needed = [("gain", gain.share()), ("time constant", time_constant_s.share())];
    // Friction shifts the command. What is small beside the largest command need not be known exactly.
    let friction = coulomb_bits.half_width / coulomb_bits.value.max(0.1 * shape.most_bits);
    for (parameter, share) in needed.into_iter().chain([("friction", friction)]) {
        if !(0.0..=MOST_SHARE).contains(&share) {
            return Err(IdentificationError::Undetermined(parameter));
        }
    }
    Ok(IdentifiedDrive {
        gain,
        time_constant_s,
        coulomb_bits,
        delay_s,
        stiction_bits,
        residual_mm,
        resolution_mm: shape.resolution_mm,
    })
}

#[expect(clippy::cast_precision_loss, reason = "at most the rows of a record")]
fn count(number: usize) -> f64 {
    number as f64
}

/// What a record shows before any fit.
#[derive(Clone, Copy, Debug)]
struct Shape {
    travel_mm: f64,
    resolution_mm: f64,
    period_s: f64,
    lasts_s: f64,
    most_bits: f64,
    begins_mm: f64,
    /// Largest speed over a twentieth of the record, mm/s.
    fastest: f64,
}

impl Shape {
    fn of(record: &MotionRecord) -> Result<Self, IdentificationError> {
        let MotionRecord { times_s, commands, positions_mm } = record;
        let span = |values: &[f64]| {
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
                (low.min(value), high.max(value))
            })
        };
        let (low, high) = span(positions_mm);
        let steps = positions_mm.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
        let resolution_mm = steps.fold(f64::INFINITY, f64::min).min((high - low).max(f64::MIN_POSITIVE));
        let travel_mm = high - low;
        if travel_mm < f64::from(LEAST_STEPS) * resolution_mm {
            return Err(IdentificationError::Still { travel_mm, resolution_mm });
        }
        let (least, most) = span(commands);
        if least >= most {
            return Err(IdentificationError::Constant(least));
        }
        let lasts_s = times_s[times_s.len() - 1] - times_s[0];
        let first = commands.iter().position(|command| *command != commands[0]).unwrap_or(0).max(2);
        let (begin_low, begin_high) = span(&positions_mm[..first]);
        if begin_high - begin_low > 0.01 * travel_mm {
            return Err(IdentificationError::Moving);
        }
        let far = (times_s.len() / 20).max(1);
        let speeds = (far..times_s.len())
            .map(|i| ((positions_mm[i] - positions_mm[i - far]) / (times_s[i] - times_s[i - far])).abs());
        Ok(Self {
            travel_mm,
            resolution_mm,
            period_s: lasts_s / count(times_s.len() - 1),
            lasts_s,
            most_bits: least.abs().max(most.abs()),
            begins_mm: f64::midpoint(begin_low, begin_high),
            fastest: speeds.fold(0.0, f64::max),
        })
    }

    /// Starts of the fit: time constants, frictions and delays.
    fn grid(&self) -> Vec<Parameters> {
        let mut starts = Vec::new();
        let mut time_constant = (3.0 * self.period_s).max(self.lasts_s / 2000.0);
        while time_constant < self.lasts_s {
            for share in [0.0, 0.1, 0.3] {
                for delay in [0.0, 2.0, 5.0] {
                    let friction = share * self.most_bits;
                    let gain = self.fastest / (self.most_bits - friction);
                    let delay = delay * self.period_s;
                    starts.push(Parameters::new(gain, time_constant, friction, delay, self.begins_mm));
                }
            }
            time_constant *= 1.6;
        }
        starts
    }
}

/// The largest command that left the axis at rest, and the smallest that moved it.
fn breakaway(record: &MotionRecord, shape: &Shape) -> Option<[f64; 2]> {
    let MotionRecord { commands, positions_mm, .. } = record;
    let mean = |positions: &[f64]| positions.iter().sum::<f64>() / count(positions.len());
    let (mut held, mut moved) = (None::<f64>, None::<f64>);
    let (mut begin, mut rested) = (0, true);
    while begin < commands.len() {
        let end = (begin..commands.len()).find(|&i| commands[i] != commands[begin]).unwrap_or(commands.len());
        let (stretch, size) = (&positions_mm[begin..end], commands[begin].abs());
        let quarter = stretch.len() / 4;
        let goes = |from: &[f64], to: &[f64]| (mean(to) - mean(from)).abs() > shape.resolution_mm;
        if quarter == 0 {
            rested = false;
        } else {
            if rested && goes(&stretch[..quarter], &stretch[stretch.len() - quarter..]) {
                moved = Some(moved.unwrap_or(f64::INFINITY).min(size));
            } else if rested {
                held = Some(held.unwrap_or(0.0).max(size));
            }
            // Whether it rests at the end.
            let half = stretch.len() / 2;
            rested = !goes(&stretch[half..half + quarter], &stretch[stretch.len() - quarter..]);
        }
        begin = end;
    }
    Some([held?, moved?])
}
