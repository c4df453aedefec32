//! One roughing pass all round the part, as in Fig. 8: the same operator, with the paper's controller and with Keepout,
//! on the same simulated modules.
//!
//! The operator approaches the part at one place after the other, pushes until the tool stops, draws back, and goes to
//! the next place.

use std::time::Duration;

use keepout_planner::Mm2;
use keepout_sim::operator::Rounds;
use serde::{Deserialize, Serialize};

use super::attempt::Attempt;
use super::invasion::prohibited;
use super::ours::Ours;
use super::paper::{Ground, Paper};
use super::parallel::{ProgressCallback, parallel};
use super::scenario::{MachinedProfile, Scenarios, StudyError, driven_modules, machine};

/// T of the paper's controller, mm: that of Fig. 8 and Table 3.
pub const TOLERANCE_MM: f64 = 4.5;
/// Feeds of the paper's controller, mm/s.
const PAPER_MM_S: [f64; 2] = [12.0, 18.0];
/// Speeds of Keepout, mm/s.
const OURS_MM_S: [f64; 3] = [12.0, 18.0, 100.0];
/// Largest distance of two approaches along the profile, mm. It is less than the diameter of the tool.
const APART_MM: f64 = 3.0;
/// Distance to which the operator draws the tool back, mm.
const BACK_MM: f64 = 8.0;
/// Depth behind the wall of the place that the operator pushes at, mm.
const BEHIND_MM: f64 = 3.0;
/// Distance at which a place counts as reached, mm.
const REACH_MM: f64 = 1.5;
/// Time without progress after which the operator draws back.
const PATIENCE: Duration = Duration::from_secs(3);
/// Speed at which the stick of the paper's system is always fully tilted, mm/s. It gives a direction and no speed.
pub(super) const DIRECTION_MM_S: f64 = 1.0;
/// Distance of the places at which the remaining stock is measured, mm.
const MEASURED_MM: f64 = 1.0;

/// A roughing pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoughingPass {
    /// Name of the profile.
    pub profile: String,
    /// The system: "paper" or "ours".
    pub system: String,
    /// Top speed, mm/s.
    pub speed_mm_s: f64,
    /// Tolerance T, mm.
    pub tolerance_mm: f64,
    /// Number of places that the operator approached.
    pub approaches: u64,
    /// Number of times that the tool entered the part.
    pub invasions: u64,
    /// Largest depth of the tool in the part, mm.
    pub deepest_mm: f64,
    /// Mean thickness of the remaining stock along the profile, mm.
    pub left_mm: f64,
    /// Its largest value, mm.
    pub most_left_mm: f64,
    /// Duration, s.
    pub seconds: f64,
}

/// The places of a pass: those that the operator draws the tool back to, those that the operator pushes at, and the
/// corners of the way between.
#[derive(Clone, Debug, PartialEq)]
struct Places {
    all: Vec<Mm2>,
    approaches: u64,
}

impl Places {
    /// # Errors
    /// [`StudyError`] if the enlarged profile can not be constructed.
    fn around(shape: &MachinedProfile, radius_mm: f64) -> Result<Self, StudyError> {
        let ring = |away_mm: f64| {
            prohibited(&shape.corners, radius_mm + away_mm, shape.side())
                .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })
        };
        let (wall, back) = (ring(0.0)?, ring(BACK_MM)?);
        let mut places = Self { all: Vec::new(), approaches: 0 };
        for (number, (&from, &to)) in wall.iter().zip(wall.iter().cycle().skip(1)).enumerate() {
            let way = to - from;
            // The tool is on the left of the enlarged profile.
            let outward = (way / way.length()).left();
            for foot in middles((from, to), APART_MM) {
                let away = foot + outward * BACK_MM;
                places.all.extend([away, foot - outward * BEHIND_MM, away]);
                places.approaches += 1;
            }
            places.all.push(back[(number + 1) % back.len()]);
        }
        Ok(places)
    }
}

/// The middles of equal parts of a line, which are `apart_mm` long at most.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a few thousand")]
fn middles((from, to): (Mm2, Mm2), apart_mm: f64) -> impl Iterator<Item = Mm2> {
    let way = to - from;
    let count = (way.length() / apart_mm).ceil().clamp(1.0, 1e4) as u32;
    (0..count).map(move |part| from + way * ((f64::from(part) + 0.5) / f64::from(count)))
}

/// Runs the pass of the paper's controller.
///
/// # Errors
/// [`StudyError`] if the profile can not be enlarged, or the modules do not exist.
pub fn with_paper(
    scenarios: &Scenarios,
    shape: &MachinedProfile,
    speed_mm_s: f64,
    seed: u64,
) -> Result<(RoughingPass, Attempt), StudyError> {
    let (machine, drives) = (machine(speed_mm_s)?, driven_modules()?);
    let ground = Ground::new(shape, scenarios.tool_diameter_mm, scenarios.delays.classified.into())?;
    let paper = Paper {
        ground: &ground,
        feed_mm_s: speed_mm_s,
        tolerance_mm: TOLERANCE_MM,
        delays: scenarios.delays,
        machine: Some((&machine, &drives)),
    };
    let places = Places::around(shape, ground.radius_mm())?;
    let start = places.all.first().copied().unwrap_or_default();
    let operator = Rounds::new(places.all, DIRECTION_MM_S, REACH_MM, PATIENCE);
    let run = paper.session(start, Box::new(operator), seed);
    let settings = ("paper", speed_mm_s, TOLERANCE_MM, places.approaches);
    let pass = measured(settings, shape, ground.radius_mm(), &run);
    Ok((pass, run))
}

/// Runs the pass with Keepout.
///
/// # Errors
/// [`StudyError`] if no plan can be made, or the session fails.
pub fn with_ours(
    scenarios: &Scenarios,
    shape: &MachinedProfile,
    speed_mm_s: f64,
    seed: u64,
) -> Result<(RoughingPass, Attempt), StudyError> {
    let ours = Ours::new(shape, scenarios.tool_diameter_mm, speed_mm_s)?;
    let places = Places::around(shape, ours.radius_mm())?;
    let start = places.all.first().copied().unwrap_or_default();
    let operator = Rounds::new(places.all, speed_mm_s, REACH_MM, PATIENCE);
    let line = (seed, Duration::from_millis(1));
    let run = ours.session(start, Box::new(operator), line, Some(&driven_modules()?))?;
    let settings = ("ours", speed_mm_s, ours.tolerance_mm(), places.approaches);
    let pass = measured(settings, shape, ours.radius_mm(), &run);
    Ok((pass, run))
}

/// Runs all passes.
///
/// # Errors
/// [`StudyError`] if a pass can not run.
pub fn passes(
    scenarios: &Scenarios,
    seed: u64,
    progress: &ProgressCallback<'_>,
) -> Result<Vec<RoughingPass>, StudyError> {
    let mut settings = Vec::new();
    for shape in &scenarios.profile {
        settings.extend(PAPER_MM_S.map(|speed| (shape, true, speed)));
        settings.extend(OURS_MM_S.map(|speed| (shape, false, speed)));
    }
    parallel(settings.len(), progress, |number| {
        let (shape, paper, speed) = settings[number];
        let run = if paper { with_paper } else { with_ours };
        run(scenarios, shape, speed, seed).map(|(pass, _)| pass)
    })
}

/// The figures of a pass: its system, top speed, tolerance and approaches, and what they led to.
fn measured(
    (system, speed_mm_s, tolerance_mm, approaches): (&str, f64, f64, u64),
    shape: &MachinedProfile,
    radius_mm: f64,
    run: &Attempt,
) -> RoughingPass {
    let left = remaining(shape, radius_mm, &run.path);
    let count = u32::try_from(left.len()).unwrap_or(u32::MAX).max(1);
    let inside: Vec<bool> = run.path.iter().map(|&at| shape.clearance(at) < radius_mm).collect();
    let entered = inside.windows(2).filter(|pair| !pair[0] && pair[1]).count();
    RoughingPass {
        profile: shape.name.clone(),
        system: system.into(),
        speed_mm_s,
        tolerance_mm,
        approaches,
        invasions: entered as u64,
        deepest_mm: run.depth_mm,
        left_mm: left.iter().sum::<f64>() / f64::from(count),
        most_left_mm: left.iter().copied().fold(0.0, f64::max),
        seconds: run.seconds,
    }
}

/// Thickness of the stock that the tool left on the profile, mm, at places along it. Places in inside corners that the
/// tool can not reach do not count.
fn remaining(shape: &MachinedProfile, radius_mm: f64, path: &[Mm2]) -> Vec<f64> {
    let mut left = Vec::new();
    for (from, to) in shape.edges() {
        let way = to - from;
        let normal = (way / way.length()).left();
        for at in middles((from, to), MEASURED_MM) {
            let touches = [normal, -normal].map(|normal| shape.clearance(at + normal * radius_mm));
            if touches.iter().any(|&clearance| clearance > radius_mm - 1e-6) {
                let near = path.windows(2).map(|pair| at.distance(at.nearest_on(pair[0], pair[1])));
                left.push((near.fold(f64::INFINITY, f64::min) - radius_mm).max(0.0));
            }
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tool that went round the bar 0.2 mm away from it, except along one side.
    #[test]
    fn stock_remains_where_the_tool_was_not() {
        let bar = MachinedProfile::bar();
        let corners = [(-3.2, -3.2), (43.2, -3.2), (43.2, 63.2), (-3.2, 63.2)].map(Mm2::from);
        let left = remaining(&bar, 3.0, &corners);
        assert_eq!(left.len(), 200);
        let near = left.iter().filter(|&&left| (left - 0.2).abs() < 1e-9).count();
        assert_eq!(near, 140);
        let most = left.iter().copied().fold(0.0, f64::max);
        assert!((20.0..35.0).contains(&most), "{most}");
    }

    /// Each approach leads from the tool's side to a place that the tool must not reach.
    #[test]
    fn places_lie_before_and_behind_the_wall() {
        for shape in [MachinedProfile::bar(), Scenarios::built_in().unwrap().profile[1].clone()] {
            let places = Places::around(&shape, 3.0).unwrap();
            let behind = places.all.iter().filter(|&&at| shape.clearance(at) < 3.0 - 1e-6).count();
            assert_eq!(behind as u64, places.approaches);
            assert!(places.approaches > 40);
        }
    }

    /// One pass of each system round a small bar: Keepout leaves the less stock, and never enters the part.
    #[test]
    fn both_systems_go_round_the_same_bar() {
        let scenarios = Scenarios::built_in().unwrap();
        let corners = [(0.0, 0.0), (24.0, 0.0), (24.0, 16.0), (0.0, 16.0)].map(Mm2::from).to_vec();
        let bar = MachinedProfile { corners, ..MachinedProfile::bar() };
        let (paper, _) = with_paper(&scenarios, &bar, 12.0, 1).unwrap();
        let (ours, _) = with_ours(&scenarios, &bar, 12.0, 1).unwrap();
        assert!(ours.invasions == 0 && ours.deepest_mm == 0.0 && ours.most_left_mm < 0.5, "{ours:?}");
        assert!(paper.left_mm > 0.5 && paper.left_mm > 10.0 * ours.left_mm, "{paper:?}");
        assert_eq!(paper.approaches, ours.approaches);
    }
}
