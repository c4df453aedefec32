//! The contour-error term of a plan's margin.
//!
//! It is the largest contour error of the drives and their controller, over typical parts of a contour and
//! over the errors of the drive model.

use super::Axes;
use super::controllers::kind::Kind;
use super::controllers::selection::Environment;
use super::metrics::Spread;
use super::path::Path;
use super::profile::{DriveProfile, Interpolator};
use super::reference::{Ramp, Reference};
use super::run::{Cutting, Task};
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
    /// RMS and largest contour error with an exact model, µm.
    pub exact: Spread,
    /// RMS and largest contour error over all models within the uncertainty, µm. The two may come from
    /// different models.
    pub worst: Spread,
    /// Signs of the model errors with the largest contour error: gain and time constant of X, then of Y.
    pub signs: [f64; 4],
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
    /// The controller.
    pub kind: Kind,
    /// Feed along the contour, mm/s.
    pub feed_mm_s: f64,
    /// Largest jog speed, mm/s. Without it, the budget covers the finishing feed only.
    pub by_hand_mm_s: Option<f64>,
}

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

/// Computes the budget. `None` if this controller does not exist for these drives, or if it diverges.
///
/// Calls `progress` with the number of finished paths and the number of all paths.
#[must_use]
pub fn budget(
    profile: &DriveProfile,
    question: &BudgetRequest,
    progress: &mut dyn FnMut(usize, usize),
) -> Option<ContourErrorBudget> {
    let mut tasks = match &profile.interpolator {
        Some(interpolator) => interpolated_tasks(profile, interpolator, question),
        None => plain_tasks(profile, question.feed_mm_s),
    };
    for (_, task) in &mut tasks {
        if profile.cutting.bits > 0.0 {
            let angle = profile.cutting.angle_deg.to_radians();
            task.cutting = Some(Cutting { bits: profile.cutting.bits, at_feed: task.feed, angle });
        }
    }
    let count = tasks.len();
    let mut findings = Vec::new();
    for (number, (path, task)) in tasks.into_iter().enumerate() {
        progress(number, count);
        findings.push(finding(profile, question.kind, path, &task)?);
    }
    if findings.iter().any(|finding| !finding.worst.max.is_finite()) {
        return None;
    }
    let worst = findings.iter().map(|finding| finding.worst.max).fold(0.0, f64::max);
    let term_mm = (worst * 10.0).ceil() / 10_000.0;
    Some(ContourErrorBudget { source: source(profile, question), findings, term_mm })
}

/// The description of the term.
fn source(profile: &DriveProfile, question: &BudgetRequest) -> String {
    let by_hand =
        question.by_hand_mm_s.map_or(", no jogging".into(), |speed| format!(", {:.0} by hand", speed * 60.0));
    let how = profile.interpolator.map_or(", at once".into(), |interpolator| {
        format!(", speeding up by {} mm/s²", interpolator.acceleration_mm_s2)
    });
    format!(
        "servo budget: {}, {}, {:.0} mm/min{by_hand}{how}, gain ±{} %, time constant ±{} %",
        profile.name,
        question.kind.names().1,
        question.feed_mm_s * 60.0,
        profile.uncertainty.gain * 100.0,
        profile.uncertainty.time_constant * 100.0
    )
}

fn finding(profile: &DriveProfile, kind: Kind, path: String, task: &Task) -> Option<PathFinding> {
    let environment = Environment::of(task, profile.uncertainty.largest());
    let mut found: Option<PathFinding> = None;
    for signs in sign_patterns() {
        let mut setting = profile.setting(environment);
        setting.belief = setting.belief.off_by(profile.uncertainty, signs);
        let mut controller = kind.built(&setting)?;
        let contour = task.run(controller.as_mut()).figures.contour.times(profile.um());
        let best = found.get_or_insert_with(|| PathFinding {
            path: path.clone(),
            exact: contour,
            worst: contour,
            signs,
        });
        if contour.max > best.worst.max {
            best.signs = signs;
        }
        best.worst = best.worst.worse(contour);
    }
    found
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
        let profile = DriveProfile::load("koren-lo-table-1").unwrap();
        let question = BudgetRequest { kind: Kind::Ccc, feed_mm_s: 15.0, by_hand_mm_s: None };
        let mut total = 0;
        let found = budget(&profile, &question, &mut |_, of| total = of).unwrap();
        assert_eq!((found.findings.len(), total), (4, 4));
        let worst = found.findings.iter().map(|finding| finding.worst.max).fold(0.0, f64::max);
        assert!(found.term_mm * 1000.0 >= worst && found.term_mm * 1000.0 < worst + 0.11);
        assert!(found.findings.iter().all(|finding| finding.worst.max >= finding.exact.max));
    }

    #[test]
    fn diverging_controller_has_no_budget() {
        let mut profile = DriveProfile::load("koren-lo-table-1").unwrap();
        profile.gains.proportional = 1e6;
        let question = BudgetRequest { kind: Kind::P, feed_mm_s: 15.0, by_hand_mm_s: None };
        assert_eq!(budget(&profile, &question, &mut |_, _| {}), None);
    }
}
