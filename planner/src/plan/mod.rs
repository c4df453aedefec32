//! The plan: all data that the executor needs, and the certificate of these data.

mod certified;
mod section;

use std::sync::Arc;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Length, Point};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::certified::CertifiedPlan;
use self::certified::finishing_clearance;
pub use self::section::Walls;
use self::section::{Section, sections};
use crate::Mm2;
use crate::depth::{DepthParameters, Relief};
use crate::finish::{FinishingPath, centre_distance, propose};
use crate::machine::MachineProfile;
use crate::margin::Budget;
use crate::merge::merged;
pub use crate::plan_error::PlanError;
use crate::profile::{MachinedSide, Profile};
use crate::request::Stage;
use crate::units::length_up_from_mm;

/// Parameters of a job, as the user chooses them.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanParameters {
    /// Diameter of the tool, mm.
    pub tool_diameter_mm: f64,
    /// Stock to leave, mm: jogging leaves it for finishing.
    pub stock_to_leave_mm: f64,
    /// Machined side of the profile.
    pub side: MachinedSide,
    /// Total margin, mm, in place of the machine profile's errors.
    pub margin_mm: Option<f64>,
    /// Finishing passes, first to last. An empty list means one pass along the profile itself.
    pub passes: Vec<PassParameters>,
    /// Direction of the cut.
    pub cut: Cut,
    /// The third axis. `None` for a machine with two axes.
    pub depth: Option<DepthParameters>,
}

impl Default for PlanParameters {
    fn default() -> Self {
        Self {
            tool_diameter_mm: 6.0,
            stock_to_leave_mm: 0.2,
            side: MachinedSide::Outside,
            margin_mm: None,
            passes: Vec::new(),
            cut: Cut::default(),
            depth: None,
        }
    }
}

/// Smallest and largest diameter of a tool, mm.
pub(crate) const TOOL_MIN_MM: f64 = 0.001;
pub(crate) const TOOL_MAX_MM: f64 = 500.0;
/// Accepted feeds of contours, mm/min.
pub const FEEDS_MM_MIN: std::ops::RangeInclusive<u32> = 1..=600_000;
/// Largest number of finishing passes of a plan.
pub const PASSES_MAX: usize = 16;
/// Largest number of depths of a plan, each with its finishing passes.
pub const DEPTHS_MAX: usize = 1000;

/// Parameters of a finishing pass, as the user chooses them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassParameters {
    /// Stock that the pass leaves, mm.
    pub stock_to_leave_mm: f64,
    /// Its feed, mm/min. `None` means the feed of the run.
    pub feed_mm_min: Option<u32>,
}

/// Direction of the cut around the part, for a cutter that turns clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cut {
    /// The teeth move against the feed, with the part on the left. The cutter does not pull itself in
    /// where a drive has play.
    #[default]
    Conventional,
    /// The teeth move with the feed, with the part on the right. The surface is better on drives without
    /// play.
    Climb,
}

/// Remark about a drawing, and its place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// The place, if the remark has one.
    #[serde(with = "crate::stored::maybe")]
    pub at: Option<Point>,
    /// The text.
    pub text: String,
}

impl From<String> for Remark {
    fn from(text: String) -> Self {
        Self { at: None, text }
    }
}

/// Origin of a plan: the drawing and its treatment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the drawing.
    pub name: String,
    /// SHA-256 of the drawing's bytes.
    pub hash: [u8; 32],
    /// Unit in which the drawing was read.
    pub unit: String,
    /// Repairs of the drawing, and entities that were left out.
    pub remarks: Vec<Remark>,
    /// Placement of the drawing: rotation, degrees, then offset, mm.
    pub placed: Option<(f64, Mm2)>,
    /// The number of each contour in the drawing, from 1. Empty for contours in their own order.
    pub numbers: Vec<usize>,
    /// Curves of the drawing that were left out, as points, mm. Pictures show them.
    pub left_out: Vec<Vec<Mm2>>,
}

/// Geometry that a drawing gives for a job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanGeometry {
    /// The part's contours.
    pub profile: Profile,
    /// Keep-out zones besides the part.
    pub zones: Profile,
    /// Window in which the tool's centre must stay, if the drawing has one.
    pub travel: Option<Window>,
    /// The layer on which each contour of the part begins. Empty when the layers are not known.
    pub layers: Vec<Arc<str>>,
}

/// A finishing pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Stock that it leaves.
    #[serde(with = "crate::stored")]
    pub stock_to_leave: Length,
    /// Its feed, mm/min. `None` means the feed of the run.
    pub feed_mm_min: Option<u32>,
    /// Height of the tool's tip. It is zero on a machine with two axes.
    #[serde(with = "crate::stored")]
    pub height: Height,
    /// Its path. Passes at other depths share it where the part is the same.
    pub path: Arc<FinishingPath>,
}

/// A plan. Use it only after [`Plan::certify`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Drawing from which it was made.
    pub provenance: Provenance,
    /// Machine of the margin.
    pub machine: MachineProfile,
    /// Machined side of the profile.
    pub side: MachinedSide,
    /// Radius R of the tool.
    #[serde(with = "crate::stored")]
    pub tool_radius: Length,
    /// Stock to leave A.
    #[serde(with = "crate::stored")]
    pub stock_to_leave: Length,
    /// The margin M.
    pub budget: Budget,
    /// The profile.
    pub profile: Profile,
    /// Keep-out zones besides the part, as closed loops: clamps, a vice.
    pub zones: Profile,
    /// Window in which the tool's centre must stay, if the drawing has one.
    #[serde(with = "crate::stored::maybe")]
    pub travel: Option<Window>,
    /// Direction of the cut.
    pub cut: Cut,
    /// The heights of the part. `None` for a machine with two axes.
    pub relief: Option<Relief>,
    /// The finishing passes, first to last; there is at least one. They go from depth to depth, downward, and at
    /// each depth from the most stock to leave to the least.
    pub passes: Vec<Pass>,
}

impl Plan {
    /// Plans a job: part, margin and finishing passes; then certifies the plan. It calls `stage` at the
    /// start of each stage.
    ///
    /// # Errors
    /// [`PlanError`] with the place and a remedy.
    pub fn make(
        provenance: Provenance,
        shapes: PlanGeometry,
        job: &PlanParameters,
        machine: &MachineProfile,
        stage: &mut dyn FnMut(Stage),
    ) -> Result<CertifiedPlan, PlanError> {
        let diameter_mm = job.tool_diameter_mm;
        if !(TOOL_MIN_MM..=TOOL_MAX_MM).contains(&diameter_mm) {
            return Err(PlanError::Tool { diameter_mm });
        }
        let tool_radius = length("tool radius", diameter_mm / 2.0)?;
        let stock_to_leave = length("stock to leave", job.stock_to_leave_mm)?;
        let budget = Budget::of(machine, job.margin_mm, provenance.placed.is_some())?;
        let PlanGeometry { profile, zones, travel, layers } = shapes;
        stage(Stage::Checking);
        let part = Arc::new(profile.part(job.side, &zones)?);
        let relief = job.depth.as_ref().map(|depth| {
            let names = (&provenance.numbers[..], &layers[..]);
            Relief::of(depth, names, &part, machine, tool_radius)
        });
        let mut plan = Self {
            provenance,
            machine: machine.clone(),
            side: job.side,
            tool_radius,
            stock_to_leave,
            budget,
            profile,
            zones,
            travel,
            cut: job.cut,
            relief: relief.transpose()?,
            passes: Vec::new(),
        };
        let (levels, sections) = sections(&plan, &part)?;
        stage(Stage::Offsetting);
        let unmerged = plan.offset(&sections, &job.passes, diameter_mm)?;
        stage(Stage::Certifying);
        match plan.check_against(&sections) {
            // Merged motions are a proposal. If the certificate refuses them, it checks the original
            // motions.
            Err(_) if plan.passes != unmerged => {
                plan.passes = unmerged;
                let checked = plan.check_against(&sections)?;
                Ok(checked.plan(plan, part, levels, &sections))
            }
            checked => Ok(checked?.plan(plan, part, levels, &sections)),
        }
    }

    /// Adds the passes of all depths, with merged motions. Returns them with their original motions.
    fn offset(
        &mut self,
        sections: &[Section],
        wanted: &[PassParameters],
        diameter_mm: f64,
    ) -> Result<Vec<Pass>, PlanError> {
        let single = [PassParameters::default()];
        let wanted = if wanted.is_empty() { &single[..] } else { wanted };
        let finishing = finishing_clearance(self.tool_radius, &self.budget)?;
        let proposed = |section: &Section, each: &PassParameters| {
            let left = length("stock that a pass leaves", each.stock_to_leave_mm)?;
            let threshold = certified::plus(finishing, left)?;
            let d = centre_distance(&self.profile, &self.zones, threshold);
            let path = propose(&section.outlines, &section.region, d, diameter_mm)?;
            let better = Arc::new(merged(&path, &section.region, threshold));
            Ok((left, each.feed_mm_min, better, Arc::new(path)))
        };
        let of_section = |section: &Section| wanted.iter().map(|each| proposed(section, each)).collect();
        let found: Vec<Result<Vec<_>, PlanError>> = sections.par_iter().map(of_section).collect();
        let mut unmerged = Vec::new();
        for (section, found) in sections.iter().zip(found) {
            let found = found?;
            for &height in &section.heights {
                for (stock_to_leave, feed_mm_min, better, path) in &found {
                    let pass = |path: &Arc<FinishingPath>| Pass {
                        stock_to_leave: *stock_to_leave,
                        feed_mm_min: *feed_mm_min,
                        height,
                        path: Arc::clone(path),
                    };
                    self.passes.push(pass(better));
                    unmerged.push(pass(path));
                }
            }
        }
        Ok(unmerged)
    }

    /// Toolpath of the last pass, which finishes the part at its greatest depth.
    ///
    /// # Panics
    /// Never for a plan that [`Plan::make`] or the file reader returned: it has a pass.
    #[must_use]
    pub fn finish(&self) -> &FinishingPath {
        &self.passes.last().expect("a plan has a pass").path
    }

    /// Number of loops of all passes.
    #[must_use]
    pub fn loop_count(&self) -> usize {
        self.passes.iter().map(|pass| pass.path.loops.len()).sum()
    }

    /// Number of finishing passes at each depth.
    #[must_use]
    pub fn passes_at_a_depth(&self) -> usize {
        let first = self.passes.first().map(|pass| pass.height);
        self.passes.iter().take_while(|pass| Some(pass.height) == first).count()
    }

    /// Lets passes with equal paths share one.
    pub(crate) fn share_paths(&mut self) {
        for index in 1..self.passes.len() {
            let (before, rest) = self.passes.split_at_mut(index);
            let path = &mut rest[0].path;
            if let Some(known) = before.iter().rev().take(PASSES_MAX).find(|pass| pass.path == *path) {
                *path = Arc::clone(&known.path);
            }
        }
    }
}

fn length(what: &'static str, value_mm: f64) -> Result<Length, PlanError> {
    length_up_from_mm(value_mm).map_err(|source| PlanError::Length { what, source })
}
