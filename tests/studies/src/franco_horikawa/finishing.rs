//! The contour error of single and double finishing passes ("double path", section 7), which cut the stock
//! that roughing left.

use keepout_drives::controllers::kind::Kind;
use keepout_drives::controllers::selection::Environment;
use keepout_drives::interpolated::interpolated;
use keepout_drives::metrics::Spread;
use keepout_drives::profile::DriveProfile;
use keepout_drives::run::{Cutting, Task};
use keepout_kernel::Length;
use keepout_planner::Mm2;
use keepout_planner::finish::FinishingPath;
use keepout_planner::plan::{PassParameters, PlanParameters};
use keepout_planner::units::point_mm;
use serde::{Deserialize, Serialize};

use super::scenario::{MachinedProfile, StudyError, machine};

/// Thickness of the cut for the force in the drive profile, mm. The force is proportional to the thickness.
pub const THICKNESS_MM: f64 = 0.5;
/// Stock to leave in the first of two passes, mm.
pub const LEFT_MM: f64 = 0.1;
/// Feed of the finishing pass, mm/s: the slower feed of the paper.
pub const FEED_MM_S: f64 = 12.0;

/// A finishing pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// Name of the profile.
    pub profile: String,
    /// The drive controller.
    pub controller: String,
    /// Stock left by roughing, mm.
    pub stock_mm: f64,
    /// Number of passes.
    pub passes: u32,
    /// Largest contour error of the first of two passes, mm.
    pub first_max_mm: Option<f64>,
    /// RMS contour error of the last pass, mm.
    pub rms_mm: f64,
    /// Largest contour error of the last pass, mm.
    pub max_mm: f64,
}

/// The compared controllers: the best one in the paper of Koren & Lo, and the one that the margin budget
/// assumes.
///
/// PID and cross-coupling are missing. With the gains of Koren & Lo's Table 1, scaled to these slow drives,
/// their errors are millimetres under such a cut.
pub const CONTROLLERS: [Kind; 2] = [Kind::Gpc, Kind::Contouring];

/// Simulates the finishing of a profile with `stock_mm` of stock, in one or two `passes`.
///
/// The second pass cuts the stock to leave of the first pass, plus the contour error of the first pass.
///
/// # Errors
/// [`StudyError`] if no plan can be made, or the controller does not exist for these drives.
pub fn finish(
    shape: &MachinedProfile,
    tool_diameter_mm: f64,
    (stock_mm, passes): (f64, u32),
    kind: Kind,
) -> Result<Finished, StudyError> {
    let pass = |stock_to_leave_mm| PassParameters { stock_to_leave_mm, feed_mm_min: None };
    let requested = if passes == 2 { vec![pass(LEFT_MM), pass(0.0)] } else { vec![pass(0.0)] };
    let job = PlanParameters { tool_diameter_mm, passes: requested, ..PlanParameters::default() };
    let plan = shape.plan(&machine(FEED_MM_S)?, job)?.plan;
    let drives = DriveProfile::load("nsk-modules")?;
    let mut thickness_mm = stock_mm;
    let mut found = Vec::new();
    for pass in &plan.passes {
        let error = off(&pass.path, thickness_mm, kind, &drives)?;
        thickness_mm = LEFT_MM + error.max;
        found.push(error);
    }
    let last = found.last().copied().unwrap_or(Spread { rms: 0.0, max: 0.0 });
    Ok(Finished {
        profile: shape.name.clone(),
        controller: kind.names().1.into(),
        stock_mm,
        passes,
        first_max_mm: found.iter().rev().nth(1).map(|first| first.max),
        rms_mm: last.rms,
        max_mm: last.max,
    })
}

/// Contour error along a pass, mm, without the first half second of each loop.
fn off(
    path: &FinishingPath,
    thickness_mm: f64,
    kind: Kind,
    drives: &DriveProfile,
) -> Result<Spread, StudyError> {
    let mut worst = Spread { rms: 0.0, max: 0.0 };
    for each in &path.loops {
        let corners = each.curves.iter().flat_map(|curve| {
            curve.chord_points(Length::small(50)).unwrap_or_else(|_| vec![curve.from(), curve.to()])
        });
        let mut points: Vec<Mm2> = corners.map(point_mm).collect();
        points.dedup();
        worst = worst.worse(contour_error(&points, thickness_mm, kind, drives)?);
    }
    Ok(worst)
}

fn contour_error(
    points: &[Mm2],
    thickness_mm: f64,
    kind: Kind,
    drives: &DriveProfile,
) -> Result<Spread, StudyError> {
    let lacks =
        |missing: &str| StudyError::Finishing { drives: drives.name.clone(), missing: missing.into() };
    let interpolator = drives.interpolator.as_ref().ok_or_else(|| lacks("interpolator"))?;
    let run = interpolated(points, FEED_MM_S, interpolator, drives);
    let feed = FEED_MM_S * drives.pulses_per_mm;
    let thicker = thickness_mm / THICKNESS_MM;
    let cutting =
        drives.cutting().map(|cutting| Cutting { bits: cutting.bits * thicker, at_feed: feed, ..cutting });
    let task = Task { plant: drives.plant(), path: run.path, feed, reference: run.samples, cutting };
    let environment = Environment::of(&task, drives.uncertainty.largest());
    let controller = kind.built(&drives.setting(environment));
    let mut controller = controller.ok_or_else(|| lacks(kind.names().1))?;
    Ok(task.run(controller.as_mut()).figures.settled.times(drives.um() / 1000.0))
}
