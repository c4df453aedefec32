//! The contour-error term of a plan's margin.
//!
//! It bounds the contour error of the drives and the controller that they run: over typical parts of a contour, over
//! the errors of the drive model, over delays that the controller does not know, between the samples, and until the
//! tool rests.

use super::Axes;
use super::controllers::kind::Kind;
use thiserror::Error;

use super::controllers::selection::Environment;
use super::metrics::Spread;
use super::path::Path;
use super::profile::{DriveProfile, Interpolator};
use super::reference::{Ramp, Reference};
use super::run::{Cutting, RunOutcome, Task};
use crate::interpolated::interpolated;
use keepout_planner::Mm2;

/// Signs of the model errors: gain and time constant of X, then of Y. First the exact model, then all sixteen
/// corners.
#[must_use]
pub fn sign_patterns() -> [[f64; 4]; 17] {
    std::array::from_fn(|number| {
        if number == 0 {
            return [0.0; 4];
        }
        std::array::from_fn(|bit| if (number - 1) >> bit & 1 == 1 { 1.0 } else { -1.0 })
    })
}

/// The contour error on one path of the budget, µm.
#[derive(Clone, Debug, PartialEq)]
pub struct PathFinding {
    /// Description of the path.
    pub path: String,
    /// RMS contour error at the samples and bound on the largest one at any time, µm, with an exact model.
    pub exact: Spread,
    /// The same over all models within the uncertainty and all delays. The two may come from different models.
    pub worst: Spread,
    /// Signs of the model errors with the largest contour error: gain and time constant of X, then of Y.
    pub signs: [f64; 4],
    /// Delay with the largest contour error that the controller does not know, samples.
    pub delay: f64,
}

/// Reason why there is no budget.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BudgetError {
    /// The profile names no controller.
    #[error(
        "{0} names no controller, so nobody knows what its drives do. State the one that they really run, \
         with its gains: controller = \"pid\", say"
    )]
    NoController(String),
    /// The controller does not exist for these drives.
    #[error("{profile} cannot run {controller}: its gains have no solution. Correct the profile.")]
    NotBuilt {
        /// The profile.
        profile: String,
        /// Its controller.
        controller: &'static str,
    },
    /// The error grows without bound.
    #[error(
        "{profile} with {controller} diverges on \"{path}\", with the errors of the model and the delays that were \
         stated. Correct the gains or the uncertainty."
    )]
    Diverges {
        /// The profile.
        profile: String,
        /// Its controller.
        controller: &'static str,
        /// The path.
        path: String,
    },
}

/// The contour-error term and its derivation.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourErrorBudget {
    /// The contour error on every path.
    pub findings: Vec<PathFinding>,
    /// The term, mm: the largest contour error of all paths, rounded up to 0.1 µm.
    pub term_mm: f64,
    /// Description of the term for a plan.
    pub source: String,
}

/// The request for a budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BudgetRequest {
    /// Feed along the contour, mm/s.
    pub feed_mm_s: f64,
    /// Largest jog speed, mm/s. Without it, the budget covers the finishing feed only.
    pub by_hand_mm_s: Option<f64>,
}

/// Shares of the largest delay that the controller does not know.
const DELAY_SHARES: [f64; 3] = [0.0, 0.5, 1.0];
/// Looks at the position between two samples.
const LOOKS: u32 = 8;
/// Radii of the bends that represent all bends of a path, mm: sharp fillets to wide arcs.
const RADII_MM: [f64; 5] = [0.1, 0.5, 2.0, 5.0, 20.0];
/// Sagitta of a chord, mm.
const SAGITTA_MM: f64 = 0.000_5;

impl BudgetRequest {
    /// Approximate number of samples of the longest path.
    #[must_use]
    pub fn samples(&self, profile: &DriveProfile) -> f64 {
        let Some(interpolator) = &profile.interpolator else {
            return std::f64::consts::TAU * 20.0 / self.feed_mm_s / profile.period_s;
        };
        let seconds = |speed: f64| {
            2.0 * leg_mm(speed, interpolator) / speed + 2.0 * speed / interpolator.acceleration_mm_s2
        };
        let longest = self.by_hand_mm_s.map_or(0.0, seconds).max(seconds(self.feed_mm_s));
        longest / profile.period_s
    }
}

/// Length of a straight leg, mm: the distance to reach the speed and stop again, and 5 mm more.
fn leg_mm(speed_mm_s: f64, interpolator: &Interpolator) -> f64 {
    5.0 + speed_mm_s * speed_mm_s / interpolator.acceleration_mm_s2
}

/// Computes the budget of the controller that the profile names.
///
/// Calls `progress` with the number of finished paths and the number of all paths.
///
/// # Errors
/// [`BudgetError`] if the profile names no controller, or the controller does not exist for these drives, or diverges.
pub fn budget(
    profile: &DriveProfile,
    question: &BudgetRequest,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<ContourErrorBudget, BudgetError> {
    let kind = profile.controller.ok_or_else(|| BudgetError::NoController(profile.name.clone()))?;
    let mut tasks = match &profile.interpolator {
        Some(interpolator) => interpolated_tasks(profile, interpolator, question),
        None => plain_tasks(profile, question.feed_mm_s),
    };
    for (_, task) in &mut tasks {
        // A jog that is faster than the contour crosses air.
        let up_to_feed = question.feed_mm_s * profile.pulses_per_mm;
        task.cutting = profile.cutting().map(|cutting| Cutting { up_to_feed, ..cutting });
    }
    let count = tasks.len();
    let mut findings = Vec::new();
    for (number, (path, task)) in tasks.into_iter().enumerate() {
        progress(number, count);
        findings.push(finding(profile, kind, path, &task)?);
    }
    let worst = findings.iter().map(|finding| finding.worst.max).fold(0.0, f64::max);
    let term_mm = (worst * 10.0).ceil() / 10_000.0;
    Ok(ContourErrorBudget { source: source(profile, kind, question), findings, term_mm })
}

/// The description of the term.
fn source(profile: &DriveProfile, kind: Kind, question: &BudgetRequest) -> String {
    let by_hand =
        question.by_hand_mm_s.map_or(", no jogging".into(), |speed| format!(", {:.0} by hand", speed * 60.0));
    let how = profile.interpolator.map_or(", at once".into(), |interpolator| {
        format!(", speeding up by {} mm/s²", interpolator.acceleration_mm_s2)
    });
    let late = profile.uncertainty.delay_samples;
    let samples = if late == 1.0 { "sample" } else { "samples" };
    format!(
        "drives budget: {}, {}, {:.0} mm/min{by_hand}{how}, gain ±{} %, time constant ±{} %, up to {late} {samples} \
         late",
        profile.name,
        kind.names().1,
        question.feed_mm_s * 60.0,
        profile.uncertainty.gain * 100.0,
        profile.uncertainty.time_constant * 100.0
    )
}

/// RMS at the samples, and the bound on the largest error at any time, µm.
fn spread(outcome: &RunOutcome, profile: &DriveProfile) -> Spread {
    let figures = &outcome.figures;
    Spread { rms: figures.contour.rms, max: figures.largest }.times(profile.um())
}

fn finding(
    profile: &DriveProfile,
    kind: Kind,
    path: String,
    task: &Task,
) -> Result<PathFinding, BudgetError> {
    let environment = Environment::of(task, profile.uncertainty.largest());
    let mut found =
        PathFinding { path, exact: Spread::default(), worst: Spread::default(), signs: [0.0; 4], delay: 0.0 };
    let mut delays = DELAY_SHARES.map(|share| share * profile.uncertainty.delay_samples).to_vec();
    delays.dedup();
    for delay in delays {
        let late = task.later(delay);
        for signs in sign_patterns() {
            let mut setting = profile.setting(environment);
            setting.belief = setting.belief.off_by(profile.uncertainty, signs);
            let mut controller = kind.built(&setting).ok_or_else(|| BudgetError::NotBuilt {
                profile: profile.name.clone(),
                controller: kind.names().1,
            })?;
            let spread = spread(&late.run_in_parts(controller.as_mut(), LOOKS), profile);
            if !spread.max.is_finite() {
                let (profile, controller) = (profile.name.clone(), kind.names().1);
                return Err(BudgetError::Diverges { profile, controller, path: found.path });
            }
            if signs == [0.0; 4] && delay == 0.0 {
                found.exact = spread;
            }
            if spread.max > found.worst.max {
                (found.signs, found.delay) = (signs, delay);
            }
            found.worst = found.worst.worse(spread);
        }
    }
    Ok(found)
}

/// A line, a circle in both directions and a corner, at constant feed from the first sample on, as in the
/// paper.
fn plain_tasks(profile: &DriveProfile, feed_mm_s: f64) -> Vec<(String, Task)> {
    let scale = profile.pulses_per_mm;
    let feed = feed_mm_s * scale;
    let right = std::f64::consts::FRAC_PI_2;
    let paths = [
        ("line at 26.6°", Path::line(Axes::new(40.0, 20.0) * scale)),
        ("circle of 20 mm, clockwise", Path::circle(20.0 * scale, true, 1)),
        ("circle of 20 mm, counter-clockwise", Path::circle(20.0 * scale, false, 1)),
        ("corner of 90°", Path::corner(20.0 * scale, right)),
    ];
    let task = |(name, path): (&str, Path)| {
        let plant = profile.plant();
        let reference = Reference::along(&path, feed, plant.period_s, Ramp::None).samples;
        (name.to_string(), Task { plant, path, feed, reference, cutting: None })
    };
    paths.into_iter().map(task).collect()
}

/// Lines, corners and bends as the interpolator runs them. Bends consist of chords. Lines and corners also
/// occur in jogging, so they run once more at the jog speed.
fn interpolated_tasks(
    profile: &DriveProfile,
    interpolator: &Interpolator,
    question: &BudgetRequest,
) -> Vec<(String, Task)> {
    let mut tasks = Vec::new();
    let mut add = |name: String, points: &[Mm2], speed: f64| {
        let found = interpolated(points, speed, interpolator, profile);
        let (plant, feed) = (profile.plant(), speed * profile.pulses_per_mm);
        tasks.push((name, Task { plant, path: found.path, feed, reference: found.samples, cutting: None }));
    };
    let by_hand = question.by_hand_mm_s.map(|speed| (speed, " at jog speed"));
    for (speed, how) in [(question.feed_mm_s, "")].into_iter().chain(by_hand) {
        let leg = leg_mm(speed, interpolator);
        add(
            format!("line at 26.6° and back{how}"),
            &[Mm2::ZERO, Mm2::new(0.894 * leg, 0.447 * leg), Mm2::ZERO],
            speed,
        );
        for angle in [45.0_f64, 90.0, 150.0] {
            let (sin, cos) = angle.to_radians().sin_cos();
            add(
                format!("corner of {angle}°{how}"),
                &[Mm2::ZERO, Mm2::new(leg, 0.0), Mm2::new(leg + leg * cos, leg * sin)],
                speed,
            );
        }
    }
    for radius in RADII_MM {
        let leg = leg_mm(question.feed_mm_s, interpolator);
        add(format!("bend of 90°, radius {radius} mm"), &bend(leg, radius), question.feed_mm_s);
    }
    tasks
}

/// A leg along X, a quarter turn to the left as chords, and a leg along Y.
fn bend(leg: f64, radius: f64) -> Vec<Mm2> {
    let half = (1.0 - SAGITTA_MM / radius).acos();
    let chords = (std::f64::consts::FRAC_PI_4 / half).ceil().max(2.0);
    let mut points = vec![Mm2::ZERO];
    let mut number = 0.0;
    while number <= chords {
        let angle = std::f64::consts::FRAC_PI_2 * number / chords;
        points.push(Mm2::new(leg + radius * angle.sin(), radius * (1.0 - angle.cos())));
        number += 1.0;
    }
    points.push(Mm2::new(leg + radius, leg + radius));
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sign_patterns_are_all_different() {
        let patterns = sign_patterns();
        for (i, one) in patterns.iter().enumerate() {
            assert!(patterns[..i].iter().all(|other| other != one));
        }
    }

    /// On the paper's machine, the term is the largest error of all four paths, rounded up.
    #[test]
    fn budget_is_the_worst_of_its_paths() {
        let mut profile = DriveProfile::load("koren-lo-table-1").unwrap();
        profile.controller = Some(Kind::Ccc);
        let mut total = 0;
        let found = budget(&profile, &QUESTION, &mut |_, of| total = of).unwrap();
        assert_eq!((found.findings.len(), total), (4, 4));
        let worst = found.findings.iter().map(|finding| finding.worst.max).fold(0.0, f64::max);
        assert!(found.term_mm * 1000.0 >= worst && found.term_mm * 1000.0 < worst + 0.11);
        assert!(found.findings.iter().all(|finding| finding.worst.max >= finding.exact.max));
    }

    const QUESTION: BudgetRequest = BudgetRequest { feed_mm_s: 15.0, by_hand_mm_s: None };

    #[test]
    fn profile_without_a_controller_has_no_budget() {
        let profile = DriveProfile::load("koren-lo-table-1").unwrap();
        let error = budget(&profile, &QUESTION, &mut |_, _| {}).unwrap_err();
        assert_eq!(error, BudgetError::NoController(profile.name));
    }

    #[test]
    fn diverging_controller_has_no_budget() {
        let mut profile = DriveProfile::load("koren-lo-table-1").unwrap();
        profile.gains.proportional = 1e6;
        profile.controller = Some(Kind::P);
        let error = budget(&profile, &QUESTION, &mut |_, _| {}).unwrap_err();
        assert!(matches!(error, BudgetError::Diverges { .. }), "{error}");
    }

    /// The bound holds at a hundred looks in each sample, and is not much more.
    #[test]
    fn bound_covers_what_happens_between_samples() {
        let profile = DriveProfile::load("simulated").unwrap();
        let interpolator = profile.interpolator.unwrap();
        let request = BudgetRequest { feed_mm_s: 15.0, by_hand_mm_s: None };
        let (_, mut task) = interpolated_tasks(&profile, &interpolator, &request).swap_remove(1);
        task.cutting = profile.cutting();
        let run = |parts| {
            let setting = profile.setting(Environment::of(&task, 0.05));
            let mut controller = Kind::Pid.built(&setting).unwrap();
            task.run_in_parts(controller.as_mut(), parts).figures.largest
        };
        let (samples, few, many) = (run(1), run(LOOKS), run(128));
        assert!(few >= many * 0.999_9 && few <= many * 1.05, "{samples} {few} {many}");
        assert!(many >= samples);
    }
}
