//! The scenarios of the study as data: profiles, rows of the paper's tables, and the delay model.

use std::fmt::Write as _;

use keepout_drives::controllers::kind::Kind;
use keepout_drives::profile::DriveProfile;
use keepout_planner::machine::{MachineError, MachineProfile};
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::{PlanRequest, PlanRequestError};
use keepout_planner::{Box2, Mm2};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::delays::Delays;

/// All settings of the study.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenarios {
    /// Diameter of the tool, mm.
    pub tool_diameter_mm: f64,
    /// Speeds of the rows of Keepout, mm/s.
    pub ours_mm_s: Vec<f64>,
    /// Delays of the line in the rows of Keepout, ms each way.
    pub latencies_ms: Vec<u64>,
    /// Delay model of the paper's system.
    pub delays: Delays,
    /// The profiles.
    pub profile: Vec<MachinedProfile>,
    /// The rows of Tables 2 and 3, in the paper's order.
    pub row: Vec<Reported>,
}

/// A profile, and the side on which it is machined.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachinedProfile {
    /// Short name.
    pub name: String,
    /// Description.
    pub title: String,
    /// Side of the tool.
    pub(super) side: ShapeSide,
    /// Corners of the closed profile, drawing coordinates, mm.
    pub corners: Vec<Mm2>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShapeSide {
    Outside,
    Inside,
}

/// A row of the paper's tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reported {
    /// The table: "2 (a)".
    pub table: String,
    /// Name of the profile.
    pub profile: String,
    /// Feed V, mm/s.
    pub feed_mm_s: f64,
    /// Tolerance T, mm.
    pub tolerance_mm: f64,
    /// Number of attempts.
    pub attempts: u32,
    /// Number of attempts without an invasion.
    pub successes: u32,
    /// Mean under-cutting of the successes, mm.
    pub under_cutting_mm: Option<f64>,
    /// Whether the delay model was fitted to this row.
    #[serde(default)]
    pub calibrates: bool,
}

impl Reported {
    /// Share of attempts without an invasion.
    #[must_use]
    pub fn success(&self) -> f64 {
        f64::from(self.successes) / f64::from(self.attempts)
    }

    /// The true shares of successes that agree with the row, at 95 %: the interval of Wilson (1927).
    #[must_use]
    pub fn interval(&self) -> [f64; 2] {
        const DEVIATIONS_2: f64 = 1.96 * 1.96;
        let (share, attempts) = (self.success(), f64::from(self.attempts));
        let centre = share + DEVIATIONS_2 / (2.0 * attempts);
        let spread = share * (1.0 - share) / attempts + DEVIATIONS_2 / (4.0 * attempts * attempts);
        let half = DEVIATIONS_2.sqrt() * spread.sqrt();
        [centre - half, centre + half].map(|end| end / (1.0 + DEVIATIONS_2 / attempts))
    }

    /// Whether the number of successes agrees with a true share.
    ///
    /// It agrees if both this number or fewer, and this number or more, have a probability of at least 2.5 %.
    #[must_use]
    pub fn is_within_chance(&self, share: f64) -> bool {
        // With a share of 0 or 1, only the same share agrees. The terms below would be NaN.
        if share <= 0.0 || share >= 1.0 {
            return (self.success() - share).abs() < 1e-9;
        }
        let mut term = (1.0 - share).powf(f64::from(self.attempts));
        let (mut fewer, mut more) = (0.0, 0.0);
        for count in 0..=self.attempts {
            fewer += if count <= self.successes { term } else { 0.0 };
            more += if count >= self.successes { term } else { 0.0 };
            term *= f64::from(self.attempts - count) / f64::from(count + 1) * share / (1.0 - share);
        }
        fewer >= 0.025 && more >= 0.025
    }
}

/// Reasons for which the study can not run.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The scenarios can not be parsed.
    #[error("scenarios of the study: {reason}")]
    Parse {
        /// The place and the problem.
        reason: String,
    },
    /// A row names an unknown profile.
    #[error("scenarios of the study: a row names the unknown profile \"{name}\". Correct the name.")]
    Profile {
        /// The name.
        name: String,
    },
    /// The machine profile is invalid.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// No plan can be made.
    #[error("profile \"{name}\": {source}")]
    Plan {
        /// The profile.
        name: String,
        /// The reason.
        source: PlanRequestError,
    },
    /// The construction of the paper fails.
    #[error("profile \"{name}\": {source}")]
    Radius {
        /// The profile.
        name: String,
        /// The reason.
        source: super::invasion::RadiusError,
    },
    /// No start for the tool is free.
    #[error("profile \"{name}\": no start for the tool is free")]
    NoStart {
        /// The profile.
        name: String,
    },
    /// The drive profile is invalid.
    #[error(transparent)]
    Drives(#[from] keepout_drives::profile::DriveProfileError),
    /// The profile does not fit into the travel of the machine.
    #[error(transparent)]
    Place(#[from] keepout_executor::session::PlaceError),
    /// A session can not run.
    #[error(transparent)]
    Session(#[from] keepout_sim::session::SimError),
    /// The drive profile has no interpolator, or the controller does not exist for it.
    #[error("{drives}: no {missing} for the finishing pass")]
    Finishing {
        /// The drives.
        drives: String,
        /// The missing item.
        missing: String,
    },
    /// The results can not be written.
    #[error("the study's results: {0}")]
    Results(#[from] serde_json::Error),
    /// A session ended in an unexpected way.
    #[error("{what}: {reason}")]
    Ended {
        /// The attempt.
        what: String,
        /// The end.
        reason: String,
    },
}

impl Scenarios {
    /// The built-in scenarios.
    ///
    /// # Errors
    /// Only if the built-in file is invalid.
    pub fn built_in() -> Result<Self, StudyError> {
        Self::parse(include_str!("scenarios.toml"))
    }

    /// Reads scenarios from a TOML text.
    ///
    /// # Errors
    /// [`StudyError`] with the place of the problem, or the name of an unknown profile.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let scenarios: Self =
            toml::from_str(text).map_err(|error| StudyError::Parse { reason: error.to_string() })?;
        scenarios.row.iter().try_for_each(|row| scenarios.shape(&row.profile).map(|_| ()))?;
        Ok(scenarios)
    }

    /// The profiles of Fig. 8, those of Table 3.
    pub fn of_fig_8(&self) -> impl Iterator<Item = &MachinedProfile> + '_ {
        let in_table_3 = |name: &str| self.row.iter().any(|row| row.table == "3" && row.profile == name);
        self.profile.iter().filter(move |shape| in_table_3(&shape.name))
    }

    /// The profile with the name `name`.
    ///
    /// # Errors
    /// [`StudyError::Profile`] if it does not exist.
    pub fn shape(&self, name: &str) -> Result<&MachinedProfile, StudyError> {
        let found = self.profile.iter().find(|shape| shape.name == name);
        found.ok_or_else(|| StudyError::Profile { name: name.into() })
    }
}

impl MachinedProfile {
    /// A bar of 40 by 60 mm. Its left side is the barrier of the one-dimensional system.
    #[must_use]
    pub fn bar() -> Self {
        let corners = [(0.0, 0.0), (40.0, 0.0), (40.0, 60.0), (0.0, 60.0)].map(Mm2::from).to_vec();
        Self { name: "bar".into(), title: "bar".into(), side: ShapeSide::Outside, corners }
    }

    /// Side of the tool.
    #[must_use]
    pub fn side(&self) -> MachinedSide {
        match self.side {
            ShapeSide::Outside => MachinedSide::Outside,
            ShapeSide::Inside => MachinedSide::Inside,
        }
    }

    /// The edges of the profile.
    pub fn edges(&self) -> impl Iterator<Item = (Mm2, Mm2)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Bounding box of the profile.
    #[must_use]
    pub fn bounds(&self) -> Box2 {
        Box2::around(self.corners.iter().copied()).unwrap_or_default()
    }

    /// The nearest point of the profile, mm.
    #[must_use]
    pub fn nearest(&self, p: Mm2) -> Mm2 {
        let feet = self.edges().map(|(a, b)| p.nearest_on(a, b));
        feet.min_by(|a, b| p.distance(*a).total_cmp(&p.distance(*b))).unwrap_or(p)
    }

    /// Signed distance to the profile, mm. Positive on the side of the tool.
    #[must_use]
    pub fn clearance(&self, p: Mm2) -> f64 {
        let distance = p.distance(self.nearest(p));
        let crossings = self.edges().filter(|(a, b)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        let within = crossings.count() % 2 == 1;
        if within == (self.side == ShapeSide::Inside) { distance } else { -distance }
    }

    /// The profile as a DXF drawing of lines, in mm.
    #[must_use]
    pub fn dxf(&self) -> String {
        let mut text =
            String::from("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
        for (Mm2 { x: x0, y: y0 }, Mm2 { x: x1, y: y1 }) in self.edges() {
            let _ = write!(text, "0\nLINE\n8\n0\n10\n{x0}\n20\n{y0}\n11\n{x1}\n21\n{y1}\n");
        }
        text + "0\nENDSEC\n0\nEOF\n"
    }

    /// Makes a plan from the drawing of the profile.
    ///
    /// # Errors
    /// [`StudyError::Plan`] if no plan can be made.
    pub fn plan(&self, machine: &MachineProfile, job: PlanParameters) -> Result<CertifiedPlan, StudyError> {
        let request =
            PlanRequest { job: PlanParameters { side: self.side(), ..job }, ..PlanRequest::default() };
        let plan = request.plan(&self.name, self.dxf().as_bytes(), machine, &mut |_| {});
        plan.map_err(|source| StudyError::Plan { name: self.name.clone(), source })
    }

    /// A random start of the tool. Its edge is `from_mm` to `to_mm` from the profile.
    ///
    /// # Errors
    /// [`StudyError::NoStart`] if none of the 100 000 tried places is free.
    pub fn start(
        &self,
        radius_mm: f64,
        (from_mm, to_mm): (f64, f64),
        random: &mut fastrand::Rng,
    ) -> Result<Mm2, StudyError> {
        let around = self.bounds().grown(radius_mm + to_mm);
        let size = around.size();
        let place =
            |random: &mut fastrand::Rng| around.low + Mm2::new(size.x * random.f64(), size.y * random.f64());
        let fits = |p: &Mm2| (from_mm..=to_mm).contains(&(self.clearance(*p) - radius_mm));
        let found = (0..TRIES).map(|_| place(random)).find(fits);
        found.ok_or_else(|| StudyError::NoStart { name: self.name.clone() })
    }
}

/// Number of places tried for a start.
const TRIES: u32 = 100_000;

/// The machine of the paper's Table 1, with a top speed of `max_rate_mm_s`.
///
/// # Errors
/// [`StudyError`] if the built-in file or the speed is invalid.
pub fn machine(max_rate_mm_s: f64) -> Result<MachineProfile, StudyError> {
    let text = include_str!("nsk-modules.toml");
    let machine: MachineProfile =
        toml::from_str(text).map_err(|error| StudyError::Parse { reason: error.to_string() })?;
    Ok(MachineProfile { max_rate_mm_s, ..machine }.checked()?)
}

/// The modules of Table 1 as feed drives, with the controller that the margin budget assumes.
///
/// # Errors
/// [`StudyError`] if the built-in profile is invalid.
pub fn driven_modules() -> Result<DriveProfile, StudyError> {
    Ok(DriveProfile { controller: Some(Kind::Contouring), ..DriveProfile::load("nsk-modules")? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clearance_is_positive_on_the_side_of_the_tool() {
        let bar = MachinedProfile::bar();
        let pocket = MachinedProfile { side: ShapeSide::Inside, ..MachinedProfile::bar() };
        for (at, clearance) in
            [((-5.0, 10.0), 5.0), ((3.0, 30.0), -3.0), ((-3.0, -4.0), 5.0), ((20.0, 58.0), -2.0)]
        {
            let at = Mm2::from(at);
            assert!((bar.clearance(at) - clearance).abs() < 1e-12, "{at:?}");
            assert!((pocket.clearance(at) + clearance).abs() < 1e-12, "{at:?}");
        }
    }

    /// Profile, plan and exact part agree on the sides, and starts have the requested distance.
    #[test]
    fn starts_are_free_and_at_the_requested_distance() {
        let scenarios = Scenarios::built_in().unwrap();
        let mut random = fastrand::Rng::with_seed(4);
        for shape in &scenarios.profile {
            let plan = shape.plan(&machine(12.0).unwrap(), PlanParameters::default()).unwrap();
            for _ in 0..50 {
                let start = shape.start(3.0, (8.0, 30.0), &mut random).unwrap();
                assert!((11.0..=33.0).contains(&shape.clearance(start)));
                let point = keepout_planner::units::point_from_mm(start).unwrap();
                assert!(plan.part.free_point(point, plan.roughing).is_ok(), "{} {start:?}", shape.name);
            }
            assert!(matches!(shape.start(3.0, (30.0, 8.0), &mut random), Err(StudyError::NoStart { .. })));
        }
    }
}
