//! The plan: everything the executor needs, and the certificate that it is believed on.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::Outline;
use keepout_kernel::{LatticeError, Length, Point, ProhibitedRegion, Ring, Segment};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::finish::{FinishError, FinishingPath, PathRefusal, centre_distance, propose};
use crate::machine::MachineProfile;
use crate::margin::{Budget, MarginError};
use crate::merge::merged;
use crate::profile::{MachinedSide, Profile, ProfileError, free_outlines};
use crate::request::Stage;
use crate::units::{length_up_from_mm, mm};

/// What the user decides about a job.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanParameters {
    /// Diameter of the tool, mm.
    pub tool_diameter_mm: f64,
    /// Stock that roughing leaves for finishing, mm.
    pub stock_to_leave_mm: f64,
    /// Which side is machined.
    pub side: MachinedSide,
    /// The whole margin, mm, in place of the machine profile's errors.
    pub margin_mm: Option<f64>,
    /// Finishing passes, first to last; none means one along the profile itself.
    pub passes: Vec<PassParameters>,
    /// Which way round the tool cuts.
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

/// The smallest and the largest tool's diameter, mm.
const TOOL_MIN_MM: f64 = 0.001;
const TOOL_MAX_MM: f64 = 500.0;
/// Feeds of contours, mm/min.
pub const FEEDS_MM_MIN: std::ops::RangeInclusive<u32> = 1..=600_000;
/// Most finishing passes of a plan.
pub const PASSES_MAX: usize = 16;

/// A finishing pass, as it is ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassParameters {
    /// Stock that the pass leaves, mm.
    pub stock_to_leave_mm: f64,
    /// Its feed, mm/min; the run's own when none is given.
    pub feed_mm_min: Option<u32>,
}

/// Which way round a clockwise cutter goes about the part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cut {
    /// Against the feed, the part on the left: the cutter does not pull itself in where a drive has play.
    #[default]
    Conventional,
    /// With the feed, the part on the right: a better surface on drives without play.
    Climb,
}

/// Something to know about a drawing, and where.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// The place, when it has one.
    #[serde(with = "crate::stored::maybe")]
    pub at: Option<Point>,
    /// What.
    pub text: String,
}

impl From<String> for Remark {
    fn from(text: String) -> Self {
        Self { at: None, text }
    }
}

/// Where a plan comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the drawing.
    pub name: String,
    /// SHA-256 of the drawing's bytes.
    pub hash: [u8; 32],
    /// The unit the drawing was read in.
    pub unit: String,
    /// What was repaired in the drawing, and what was left out.
    pub remarks: Vec<Remark>,
    /// How the drawing was turned, degrees, and then moved, mm.
    pub placed: Option<(f64, (f64, f64))>,
}

/// What a drawing says of a job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanGeometry {
    /// The part's contours.
    pub profile: Profile,
    /// What the tool keeps out of besides.
    pub zones: Profile,
    /// Where the tool's centre may go, when the drawing says so.
    pub travel: Option<Window>,
}

/// A finishing pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Stock that it leaves.
    #[serde(with = "crate::stored")]
    pub stock_to_leave: Length,
    /// Its feed, mm/min; the run's own when none is given.
    pub feed_mm_min: Option<u32>,
    /// Its path.
    pub path: FinishingPath,
}

/// A plan. Believe it after [`Plan::certify`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Where it comes from.
    pub provenance: Provenance,
    /// The machine the margin was made for.
    pub machine: MachineProfile,
    /// Which side is machined.
    pub side: MachinedSide,
    /// Radius R of the tool.
    #[serde(with = "crate::stored")]
    pub tool_radius: Length,
    /// Allowance A.
    #[serde(with = "crate::stored")]
    pub stock_to_leave: Length,
    /// The margin M.
    pub budget: Budget,
    /// The profile.
    pub profile: Profile,
    /// Closed loops that the tool keeps out of besides: clamps, a vice.
    pub zones: Profile,
    /// Where the tool's centre may go, when the drawing says so.
    #[serde(with = "crate::stored::maybe")]
    pub travel: Option<Window>,
    /// Which way round the tool cuts.
    pub cut: Cut,
    /// The finishing passes, first to last; there is at least one.
    pub passes: Vec<Pass>,
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
    #[error(
        "a tool diameter of {diameter_mm} mm is no tool. Give one between {TOOL_MIN_MM} and {TOOL_MAX_MM} mm."
    )]
    Tool {
        /// What was given.
        diameter_mm: f64,
    },
    /// A finishing pass does not hold what it claims.
    #[error("finishing pass {number}, {refusal}")]
    Pass {
        /// The pass, from 1.
        number: usize,
        /// Why.
        refusal: PathRefusal,
    },
    /// Passes do not take off something each.
    #[error(
        "a finishing pass leaves {stock_to_leave_mm:.4} mm: each pass must leave less than the one before, and the first no more than roughing leaves (--stock-to-leave-mm)"
    )]
    PassOrder {
        /// What the pass leaves, mm.
        stock_to_leave_mm: f64,
    },
    /// A finishing pass has a feed that is none.
    #[error(
        "a finishing pass has a feed of {mm_min} mm/min, it must be between {} and {}: make the plan again from the drawing",
        FEEDS_MM_MIN.start(), FEEDS_MM_MIN.end()
    )]
    Feed {
        /// The feed.
        mm_min: u32,
    },
    /// There is no finishing pass, or there are too many.
    #[error("{count} finishing passes: a plan has at least one and at most {PASSES_MAX}")]
    PassCount {
        /// How many there are.
        count: usize,
    },
}

/// A plan whose every claim was checked, with the part it was checked against.
#[derive(Debug)]
pub struct CertifiedPlan {
    /// The plan.
    pub plan: Plan,
    /// The part.
    pub part: ProhibitedRegion,
    /// Threshold of roughing, R + A + M: what manual motions keep. A counts as no less than [`Budget::stopping`].
    pub roughing: Length,
    /// Threshold of finishing, R + M: what the finishing path keeps.
    pub finishing: Length,
    /// Motions of the finishing passes that were certified.
    pub certified_motions: usize,
}

impl Plan {
    /// Plans a job: part, margin, finishing passes; and certifies it. `stage` is told what is being done.
    ///
    /// # Errors
    /// [`PlanError`] with place and remedy.
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
        let stock_to_leave = length("allowance", job.stock_to_leave_mm)?;
        let budget = Budget::of(machine, job.margin_mm, provenance.placed.is_some())?;
        let PlanGeometry { profile, zones, travel } = shapes;
        stage(Stage::Checking);
        let part = profile.part(job.side, &zones)?;
        let finishing = finishing_threshold(tool_radius, &budget)?;
        let outlines = free_outlines(&profile, &zones, &part);
        stage(Stage::Offsetting);
        let single = [PassParameters::default()];
        let ordered = if job.passes.is_empty() { &single[..] } else { &job.passes };
        let (mut passes, mut unmerged) = (Vec::new(), Vec::new());
        for each in ordered {
            let left = length("allowance of a pass", each.stock_to_leave_mm)?;
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
            // Merged motions are a proposal: where they are refused, the motions as they were found are asked.
            Err(_) if plan.passes != unmerged => {
                plan.passes = unmerged;
                plan.certify_against(part, &outlines)
            }
            checked => Ok(checked?.plan(plan, part)),
        }
    }

    /// The path of the last pass, which finishes the part.
    ///
    /// # Panics
    /// Never for a plan that was made or read: it has a pass.
    #[must_use]
    pub fn finish(&self) -> &FinishingPath {
        &self.passes.last().expect("a plan has a pass").path
    }

    /// The number of loops of all passes.
    #[must_use]
    pub fn loop_count(&self) -> usize {
        self.passes.iter().map(|pass| pass.path.loops.len()).sum()
    }

    /// Certifies the plan from nothing but its own data: builds the part, and checks tool, margin, every motion and the completeness
    /// of every pass.
    ///
    /// # Errors
    /// [`PlanError`] for the first claim that does not hold.
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
        let finishing = finishing_threshold(self.tool_radius, &self.budget)?;
        let roughing = roughing_threshold(finishing, self.stock_to_leave, &self.budget)?;
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

    /// Checks that each pass leaves less than the one before, the first less than roughing does, and feeds are feeds.
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

/// What a plan's certificate says besides that it holds.
struct Checked {
    roughing: Length,
    finishing: Length,
    motions: usize,
}

impl Checked {
    fn plan(self, plan: Plan, part: ProhibitedRegion) -> CertifiedPlan {
        let Self { roughing, finishing, motions } = self;
        CertifiedPlan { plan, part, roughing, finishing, certified_motions: motions }
    }
}

fn plus(threshold: Length, more: Length) -> Result<Length, PlanError> {
    threshold
        .plus(more)
        .map_err(|source| PlanError::Length { what: "roughing or finishing threshold", source })
}

/// R + M + A, where A is no less than how far a tool that was stopped by hand can be from where it is taken to be.
fn roughing_threshold(
    finishing: Length,
    stock_to_leave: Length,
    budget: &Budget,
) -> Result<Length, PlanError> {
    let stopping = budget.stopping().map_err(|source| PlanError::Length { what: "margin", source })?;
    plus(finishing, stock_to_leave.max(stopping))
}

fn finishing_threshold(tool_radius: Length, budget: &Budget) -> Result<Length, PlanError> {
    let margin = budget.total().map_err(|source| PlanError::Length { what: "margin", source })?;
    tool_radius.plus(margin).map_err(|source| PlanError::Length { what: "finishing threshold", source })
}

impl CertifiedPlan {
    /// The corners `(low, high)` of the box around the part and the zones, on the lattice.
    #[must_use]
    pub fn part_box(&self) -> (Point, Point) {
        let segments = self.part.zones().iter().flat_map(Ring::segments);
        let bounds = segments.map(Segment::bounds).fold(self.part.region().bounds(), Window::union);
        let (x0, y0, x1, y1) = bounds.corners();
        let at = |x: i32, y: i32| Point::from_units(x.into(), y.into()).unwrap_or(Point::ORIGIN);
        (at(x0, y0), at(x1, y1))
    }
}
