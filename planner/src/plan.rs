//! The plan: everything the executor needs, and the certificate that it is believed on.

use keepout_kernel::offset::{Gouge, certify_path};
use keepout_kernel::{LatticeError, Length, Point, ProhibitedRegion};
use thiserror::Error;

use crate::drawing::Chained;
use crate::finish::{FinishError, FinishingPath, propose};
use crate::machine::MachineProfile;
use crate::margin::{Budget, MarginError};
use crate::profile::{MachinedSide, Profile, ProfileError};
use crate::units::{length_up_from_mm, mm};

/// What the user decides about a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Diameter of the tool, mm.
    pub tool_diameter_mm: f64,
    /// Stock that roughing leaves for finishing, mm.
    pub allowance_mm: f64,
    /// Which side is machined.
    pub side: MachinedSide,
    /// The whole margin, mm, in place of the machine profile's errors.
    pub margin_mm: Option<f64>,
}

/// A plan. Believe it after [`Plan::certify`].
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Name of the drawing.
    pub drawing: String,
    /// SHA-256 of the drawing's bytes.
    pub drawing_hash: [u8; 32],
    /// The unit the drawing was read in.
    pub unit: String,
    /// What was repaired in the drawing, and what was left out, in words.
    pub remarks: Vec<String>,
    /// The machine the margin was made for.
    pub machine: MachineProfile,
    /// Which side is machined.
    pub side: MachinedSide,
    /// Radius R of the tool.
    pub tool_radius: Length,
    /// Allowance A.
    pub allowance: Length,
    /// The margin M.
    pub budget: Budget,
    /// The profile.
    pub profile: Profile,
    /// The finishing path.
    pub finish: FinishingPath,
}

/// Why there is no plan, or a plan is not believed.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The loops bound no part.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// The margin is refused.
    #[error(transparent)]
    Margin(#[from] MarginError),
    /// There is no finishing path.
    #[error(transparent)]
    Finish(#[from] FinishError),
    /// A length is off the lattice.
    #[error("{what}: {source}")]
    Length {
        /// Which length.
        what: &'static str,
        /// Why.
        source: LatticeError,
    },
    /// The tool has no size.
    #[error("a tool diameter of {diameter_mm} mm is no tool. Give one between 0.001 and 500 mm.")]
    Tool {
        /// What was given.
        diameter_mm: f64,
    },
    /// A motion of the finishing path comes too near the part.
    #[error("finishing loop {number}: {gouge}")]
    Gouge {
        /// The loop, from 1.
        number: usize,
        /// The motion.
        gouge: Gouge,
    },
    /// A loop of the finishing path does not close.
    #[error("finishing loop {number} does not close")]
    OpenLoop {
        /// The loop, from 1.
        number: usize,
    },
}

/// A plan whose every claim was checked, with the part it was checked against.
#[derive(Debug)]
pub struct CertifiedPlan {
    /// The plan.
    pub plan: Plan,
    /// The part.
    pub part: ProhibitedRegion,
    /// Threshold of roughing, R + A + M: what manual motions keep.
    pub roughing: Length,
    /// Threshold of finishing, R + M: what the finishing path keeps.
    pub finishing: Length,
    /// Motions of the finishing path that were certified.
    pub certified_motions: usize,
}

impl Plan {
    /// Plans a job: part, margin, finishing path; and certifies it.
    ///
    /// # Errors
    /// [`PlanError`] with place and remedy.
    pub fn make(
        name: &str,
        drawing_hash: [u8; 32],
        (unit, remarks): (String, Vec<String>),
        chained: Chained,
        job: &Job,
        machine: &MachineProfile,
    ) -> Result<CertifiedPlan, PlanError> {
        let diameter_mm = job.tool_diameter_mm;
        if !(0.001..=500.0).contains(&diameter_mm) {
            return Err(PlanError::Tool { diameter_mm });
        }
        let length =
            |what, value| length_up_from_mm(value).map_err(|source| PlanError::Length { what, source });
        let tool_radius = length("tool radius", diameter_mm / 2.0)?;
        let allowance = length("allowance", job.allowance_mm)?;
        let budget = Budget::of(machine, job.margin_mm)?;
        let part = chained.profile.part(job.side)?;
        let finishing = finishing_threshold(tool_radius, &budget)?;
        let finish = propose(&chained.profile, &part, finishing, diameter_mm)?;
        let plan = Self {
            drawing: name.into(),
            drawing_hash,
            unit,
            remarks,
            machine: machine.clone(),
            side: job.side,
            tool_radius,
            allowance,
            budget,
            profile: chained.profile,
            finish,
        };
        plan.certify_against(part)
    }

    /// Certifies the plan from nothing but its own data: builds the part, and checks every motion of the path.
    ///
    /// # Errors
    /// [`PlanError`] for the first claim that does not hold.
    pub fn certify(self) -> Result<CertifiedPlan, PlanError> {
        let part = self.profile.part(self.side)?;
        self.certify_against(part)
    }

    fn certify_against(self, mut part: ProhibitedRegion) -> Result<CertifiedPlan, PlanError> {
        let finishing = finishing_threshold(self.tool_radius, &self.budget)?;
        let too_long = |source| PlanError::Length { what: "roughing threshold", source };
        let roughing = finishing.plus(self.allowance).map_err(too_long)?;
        // Cells only make answers at the roughing threshold faster; a part too large for them is asked by its index.
        let _ = part.prepare(roughing);
        let mut certified_motions = 0;
        for (index, each) in self.finish.loops.iter().enumerate() {
            let number = index + 1;
            let end = certify_path(&part, finishing, &each.curves)
                .map_err(|gouge| PlanError::Gouge { number, gouge })?;
            if end.map(keepout_kernel::FreePoint::point)
                != each.curves.first().map(keepout_kernel::Curve::from)
            {
                return Err(PlanError::OpenLoop { number });
            }
            certified_motions += each.curves.len();
        }
        Ok(CertifiedPlan { plan: self, part, roughing, finishing, certified_motions })
    }
}

fn finishing_threshold(tool_radius: Length, budget: &Budget) -> Result<Length, PlanError> {
    let margin = budget.total().map_err(|source| PlanError::Length { what: "margin", source })?;
    tool_radius.plus(margin).map_err(|source| PlanError::Length { what: "finishing threshold", source })
}

impl CertifiedPlan {
    /// What was planned or proved, in lines for a person.
    #[must_use]
    pub fn summary(&self) -> String {
        let plan = &self.plan;
        let finish = &plan.finish;
        let side = match plan.side {
            MachinedSide::Outside => "outside (the part is inside the contour)",
            MachinedSide::Inside => "inside (the part is outside the contour)",
        };
        let mut lines = vec![
            format!(
                "drawing      {} ({} contours, unit {})",
                plan.drawing,
                plan.profile.loops.len(),
                plan.unit
            ),
            format!("machined     {side}"),
            format!("tool radius  {:.5} mm", mm(plan.tool_radius.units())),
            format!("allowance    {:.5} mm", mm(plan.allowance.units())),
            format!("margin for   {}", plan.machine.name),
            plan.budget.to_string(),
            format!(
                "roughing     the tool centre stays more than {:.5} mm from the part",
                mm(self.roughing.units())
            ),
            format!(
                "finishing    the tool centre stays more than {:.5} mm from the part",
                mm(self.finishing.units())
            ),
            format!(
                "path         {} loops, {} motions, {:.1} mm, every motion certified",
                finish.loops.len(),
                self.certified_motions,
                finish.length_mm()
            ),
            format!(
                "residual     {:.3} mm of {:.1} mm contour, {:.3} mm² left in corners the tool does not fit",
                finish.residual_length_mm, finish.profile_length_mm, finish.residual_area_mm2
            ),
        ];
        lines.extend(plan.remarks.iter().map(|remark| format!("note         {remark}")));
        lines.join("\n")
    }

    /// The corners `(low, high)` of the box around the part, on the lattice.
    #[must_use]
    pub fn part_box(&self) -> (Point, Point) {
        let (x0, y0, x1, y1) = self.part.region().bounds().corners();
        let at = |x: i32, y: i32| Point::from_units(x.into(), y.into()).unwrap_or(Point::ORIGIN);
        (at(x0, y0), at(x1, y1))
    }
}
