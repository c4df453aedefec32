//! The plan: all data that the executor needs, and the certificate of these data.

use std::sync::OnceLock;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::Outline;
use keepout_kernel::{Length, Point, ProhibitedRegion, Ring, Segment};
use serde::{Deserialize, Serialize};

use crate::finish::{FinishingPath, centre_distance, propose};
use crate::machine::MachineProfile;
use crate::margin::Budget;
use crate::merge::merged;
use crate::mesh::Mesh;
pub use crate::plan_error::PlanError;
use crate::planned::PlannedContour;
use crate::profile::{MachinedSide, Profile, free_outlines};
use crate::request::Stage;
use crate::units::{length_up_from_mm, mm, window_mm};
use crate::{Box2, Mm2};

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

/// Largest distance between the part's chords and those of the mesh for link moves, mm. An arc has far fewer
/// chords in the mesh.
const MESH_TOLERANCE_MM: f64 = 0.02;

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
}

/// A finishing pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Stock that it leaves.
    #[serde(with = "crate::stored")]
    pub stock_to_leave: Length,
    /// Its feed, mm/min. `None` means the feed of the run.
    pub feed_mm_min: Option<u32>,
    /// Its path.
    pub path: FinishingPath,
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
    /// The finishing passes, first to last; there is at least one.
    pub passes: Vec<Pass>,
}

/// A plan whose claims all hold, with the part that the check used.
#[derive(Debug)]
pub struct CertifiedPlan {
    /// The plan.
    pub plan: Plan,
    /// The part.
    pub part: ProhibitedRegion,
    /// Jogging clearance, R + A + M: jogs and link moves keep it. A counts as at least
    /// [`Budget::stopping`].
    pub roughing: Length,
    /// Finishing clearance, R + M: the finishing toolpath keeps it.
    pub finishing: Length,
    /// Number of certified motions of the finishing passes.
    pub certified_motions: usize,
    mesh: OnceLock<Option<Mesh>>,
    pub(crate) contours: OnceLock<Vec<PlannedContour>>,
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
        let length =
            |what, value| length_up_from_mm(value).map_err(|source| PlanError::Length { what, source });
        let tool_radius = length("tool radius", diameter_mm / 2.0)?;
        let stock_to_leave = length("stock to leave", job.stock_to_leave_mm)?;
        let budget = Budget::of(machine, job.margin_mm, provenance.placed.is_some())?;
        let PlanGeometry { profile, zones, travel } = shapes;
        stage(Stage::Checking);
        let part = profile.part(job.side, &zones)?;
        let finishing = finishing_clearance(tool_radius, &budget)?;
        let outlines = free_outlines(&profile, &zones, &part);
        stage(Stage::Offsetting);
        let single = [PassParameters::default()];
        let wanted = if job.passes.is_empty() { &single[..] } else { &job.passes };
        let (mut passes, mut unmerged) = (Vec::new(), Vec::new());
        for each in wanted {
            let left = length("stock that a pass leaves", each.stock_to_leave_mm)?;
            let threshold = plus(finishing, left)?;
            let d = centre_distance(&profile, &zones, threshold);
            let path = propose(&outlines, &part, d, diameter_mm)?;
            let pass = |path| Pass { stock_to_leave: left, feed_mm_min: each.feed_mm_min, path };
            passes.push(pass(merged(&path, &part, threshold)));
            unmerged.push(pass(path));
        }
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
            passes,
        };
        stage(Stage::Certifying);
        match plan.check_against(&part, &outlines) {
            // Merged motions are a proposal. If the certificate refuses them, it checks the original
            // motions.
            Err(_) if plan.passes != unmerged => {
                plan.passes = unmerged;
                plan.certify_against(part, &outlines)
            }
            checked => Ok(checked?.plan(plan, part)),
        }
    }

    /// Toolpath of the last pass, which finishes the part.
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

    /// Certifies the plan from its own data alone. It builds the part, then checks the tool, the margin,
    /// every motion, and the completeness of every pass.
    ///
    /// # Errors
    /// [`PlanError`] for the first claim that fails.
    pub fn certify(self) -> Result<CertifiedPlan, PlanError> {
        let part = self.profile.part(self.side, &self.zones)?;
        let outlines = free_outlines(&self.profile, &self.zones, &part);
        self.certify_against(part, &outlines)
    }

    fn certify_against(
        self,
        part: ProhibitedRegion,
        outlines: &[Outline],
    ) -> Result<CertifiedPlan, PlanError> {
        Ok(self.check_against(&part, outlines)?.plan(self, part))
    }

    fn check_against(&self, part: &ProhibitedRegion, outlines: &[Outline]) -> Result<Checked, PlanError> {
        let diameter_mm = 2.0 * mm(self.tool_radius.units());
        if !(TOOL_MIN_MM..=TOOL_MAX_MM).contains(&diameter_mm) {
            return Err(PlanError::Tool { diameter_mm });
        }
        self.budget.check(&self.machine, self.provenance.placed.is_some())?;
        let finishing = finishing_clearance(self.tool_radius, &self.budget)?;
        let roughing = jogging_clearance(finishing, self.stock_to_leave, &self.budget)?;
        self.certify_order()?;
        let mut motions = 0;
        for (index, pass) in self.passes.iter().enumerate() {
            let threshold = plus(finishing, pass.stock_to_leave)?;
            let refused = |refusal| PlanError::Pass { number: index + 1, refusal };
            let d = centre_distance(&self.profile, &self.zones, threshold);
            motions += pass.path.certify(outlines, part, (threshold, d)).map_err(refused)?;
        }
        Ok(Checked { roughing, finishing, motions })
    }

    /// Checks that each pass leaves less than the one before, that the first leaves at most the stock to
    /// leave, and that the feeds are in range.
    fn certify_order(&self) -> Result<(), PlanError> {
        let count = self.passes.len();
        if !(1..=PASSES_MAX).contains(&count) {
            return Err(PlanError::PassCount { count });
        }
        let mut before = None;
        for pass in &self.passes {
            if let Some(mm_min) = pass.feed_mm_min.filter(|feed| !FEEDS_MM_MIN.contains(feed)) {
                return Err(PlanError::Feed { mm_min });
            }
            if before.is_some_and(|before| pass.stock_to_leave >= before) {
                return Err(PlanError::PassOrder { stock_to_leave_mm: mm(pass.stock_to_leave.units()) });
            }
            before = Some(pass.stock_to_leave);
        }
        match self.passes.first() {
            Some(first) if first.stock_to_leave > self.stock_to_leave => {
                Err(PlanError::PassOrder { stock_to_leave_mm: mm(first.stock_to_leave.units()) })
            }
            _ => Ok(()),
        }
    }
}

/// Results of a plan's check.
struct Checked {
    roughing: Length,
    finishing: Length,
    motions: usize,
}

impl Checked {
    fn plan(self, plan: Plan, part: ProhibitedRegion) -> CertifiedPlan {
        let Self { roughing, finishing, motions } = self;
        CertifiedPlan {
            plan,
            part,
            roughing,
            finishing,
            certified_motions: motions,
            mesh: OnceLock::new(),
            contours: OnceLock::new(),
        }
    }
}

fn plus(threshold: Length, more: Length) -> Result<Length, PlanError> {
    threshold
        .plus(more)
        .map_err(|source| PlanError::Length { what: "jogging or finishing clearance", source })
}

/// The jogging clearance R + M + A. A counts as at least [`Budget::stopping`], the largest distance of a
/// stopped tool from its assumed place.
fn jogging_clearance(
    finishing: Length,
    stock_to_leave: Length,
    budget: &Budget,
) -> Result<Length, PlanError> {
    let stopping = budget.stopping().map_err(|source| PlanError::Length { what: "margin", source })?;
    plus(finishing, stock_to_leave.max(stopping))
}

fn finishing_clearance(tool_radius: Length, budget: &Budget) -> Result<Length, PlanError> {
    let margin = budget.total().map_err(|source| PlanError::Length { what: "margin", source })?;
    tool_radius.plus(margin).map_err(|source| PlanError::Length { what: "finishing clearance", source })
}

impl CertifiedPlan {
    /// The mesh over the simplified outline of the part and its keep-out zones, for link moves. The first
    /// call builds it. `None` when the part reaches the limit of the lattice.
    #[must_use]
    pub fn mesh(&self) -> Option<&Mesh> {
        let build = || {
            let tolerance = length_up_from_mm(MESH_TOLERANCE_MM).ok();
            let simplified = tolerance.and_then(|tolerance| self.part.simplified(tolerance).ok());
            Mesh::of(simplified.as_ref().unwrap_or(&self.part)).ok()
        };
        self.mesh.get_or_init(build).as_ref()
    }

    /// The box around the part and the zones.
    #[must_use]
    pub fn part_box(&self) -> Box2 {
        let segments = self.part.zones().iter().flat_map(Ring::segments);
        window_mm(segments.map(Segment::bounds).fold(self.part.region().bounds(), Window::union))
    }
}
