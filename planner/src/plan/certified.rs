//! The certificate of a plan, and the certified plan.
//!
//! Implements SR-16, SR-20.

use std::sync::{Arc, OnceLock};

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Length, Levels, Point, ProhibitedRegion, Ring, Segment};
use rayon::prelude::*;

use super::section::{Section, Walls, sections, walls};
use super::{DEPTHS_MAX, FEEDS_MM_MIN, PASSES_MAX, Pass, Plan, PlanError, TOOL_MAX_MM, TOOL_MIN_MM};
use crate::Box2;
use crate::finish::{FinishingPath, centre_distance};
use crate::margin::Budget;
use crate::mesh::Mesh;
use crate::planned::PlannedContour;
use crate::units::{length_up_from_mm, mm, window_mm};

/// Largest distance between the part's chords and those of the mesh for link moves, mm. An arc has far fewer
/// chords in the mesh.
const MESH_TOLERANCE_MM: f64 = 0.02;

/// A plan whose claims all hold, with the part that the check used.
#[derive(Debug)]
pub struct CertifiedPlan {
    /// The plan.
    pub plan: Plan,
    /// The part, as the drawing shows it from above.
    pub part: Arc<ProhibitedRegion>,
    /// What stands above each height of the tool's tip. A plan for two axes has one level: the part.
    pub levels: Arc<Levels>,
    /// The height margin. It is zero on a machine with two axes.
    pub height_margin: Length,
    /// Jogging clearance, R + A + M: jogs and link moves keep it. A counts as at least
    /// [`Budget::stopping`].
    pub roughing: Length,
    /// Finishing clearance, R + M: the finishing toolpath keeps it.
    pub finishing: Length,
    /// Number of certified motions of the finishing passes.
    pub certified_motions: usize,
    /// The walls that the passes finish, depth by depth, downward.
    pub walls: Vec<Walls>,
    mesh: OnceLock<Option<Mesh>>,
    pub(crate) contours: OnceLock<Vec<PlannedContour>>,
}

impl Plan {
    /// Certifies the plan from its own data alone. It builds the part and its levels, then checks the tool, the
    /// margins, the heights, every motion, and the completeness of every pass.
    ///
    /// # Errors
    /// [`PlanError`] for the first claim that fails.
    pub fn certify(self) -> Result<CertifiedPlan, PlanError> {
        let part = Arc::new(self.profile.part(self.side, &self.zones)?);
        if let Some(relief) = &self.relief {
            relief.check(&part, &self.machine)?;
        }
        let (levels, sections) = sections(&self, &part)?;
        Ok(self.check_against(&sections)?.plan(self, part, levels, &sections))
    }

    pub(super) fn check_against(&self, sections: &[Section]) -> Result<Checked, PlanError> {
        let diameter_mm = 2.0 * mm(self.tool_radius.units());
        if !(TOOL_MIN_MM..=TOOL_MAX_MM).contains(&diameter_mm) {
            return Err(PlanError::Tool { diameter_mm });
        }
        self.budget.check(&self.machine, self.provenance.placed.is_some())?;
        let finishing = finishing_clearance(self.tool_radius, &self.budget)?;
        let roughing = jogging_clearance(finishing, self.stock_to_leave, &self.budget)?;
        let depths = self.by_depth(sections)?;
        let motions =
            |(index, (section, passes)): (usize, &(&Section, &[Pass]))| -> Result<usize, PlanError> {
                self.certify_order(passes)?;
                let mut motions = 0;
                for (number, pass) in passes.iter().enumerate() {
                    // Passes with the same path at the same section are certified at the first of them.
                    let before = depths[..index].iter().filter(|(other, _)| std::ptr::eq(*other, *section));
                    let known = before.filter_map(|(_, passes)| passes.get(number));
                    if known.into_iter().any(|known| known.is_like(pass)) {
                        motions += pass.motions();
                        continue;
                    }
                    let threshold = plus(finishing, pass.stock_to_leave)?;
                    let number = index * passes.len() + number + 1;
                    let refused = |refusal| PlanError::Pass { number, refusal };
                    let d = centre_distance(&self.profile, &self.zones, threshold);
                    let Section { outlines, region, .. } = section;
                    motions += pass.path.certify(outlines, region, (threshold, d)).map_err(refused)?;
                }
                Ok(motions)
            };
        // The first refusal counts, whichever was found first.
        let certified: Vec<Result<usize, PlanError>> = depths.par_iter().enumerate().map(motions).collect();
        let motions = certified.into_iter().sum::<Result<usize, PlanError>>()?;
        let height_margin = match &self.relief {
            Some(relief) => {
                relief.budget.total().map_err(|source| PlanError::Length { what: "height margin", source })?
            }
            None => Length::ZERO,
        };
        Ok(Checked { roughing, finishing, height_margin, motions })
    }

    /// The passes of each depth, with the section of that depth. The depths are exactly those of the sections, so
    /// no wall stays uncut over a stretch of its height.
    fn by_depth<'a>(&'a self, sections: &'a [Section]) -> Result<Vec<(&'a Section, &'a [Pass])>, PlanError> {
        let due =
            sections.iter().flat_map(|section| section.heights.iter().map(move |&height| (section, height)));
        let due: Vec<(&Section, Height)> = due.collect();
        if due.len() > DEPTHS_MAX {
            return Err(PlanError::DepthCount { count: due.len() });
        }
        let mut found: Vec<&[Pass]> = self.passes.chunk_by(|a, b| a.height == b.height).collect();
        if self.passes.is_empty() {
            found.push(&[]);
        }
        let heights = found.iter().map(|passes| passes.first().map(|pass| pass.height));
        if !heights.eq(due.iter().map(|&(_, height)| Some(height))) && !self.passes.is_empty() {
            return Err(PlanError::Depths);
        }
        Ok(due.into_iter().map(|(section, _)| section).zip(found).collect())
    }

    /// Checks that each pass of a depth leaves less than the one before, that the first leaves at most the stock
    /// to leave, and that the feeds are in range.
    fn certify_order(&self, passes: &[Pass]) -> Result<(), PlanError> {
        let count = passes.len();
        if !(1..=PASSES_MAX).contains(&count) {
            return Err(PlanError::PassCount { count });
        }
        let mut before = None;
        for pass in passes {
            if let Some(mm_min) = pass.feed_mm_min.filter(|feed| !FEEDS_MM_MIN.contains(feed)) {
                return Err(PlanError::Feed { mm_min });
            }
            if before.is_some_and(|before| pass.stock_to_leave >= before) {
                return Err(PlanError::PassOrder { stock_to_leave_mm: mm(pass.stock_to_leave.units()) });
            }
            before = Some(pass.stock_to_leave);
        }
        match passes.first() {
            Some(first) if first.stock_to_leave > self.stock_to_leave => {
                Err(PlanError::PassOrder { stock_to_leave_mm: mm(first.stock_to_leave.units()) })
            }
            _ => Ok(()),
        }
    }
}

impl Pass {
    /// Its path, to change it. Other passes keep theirs.
    pub fn path_mut(&mut self) -> &mut FinishingPath {
        Arc::make_mut(&mut self.path)
    }

    /// Number of its motions.
    fn motions(&self) -> usize {
        self.path.loops.iter().map(|each| each.curves.len()).sum()
    }

    /// Whether another pass takes the same path and leaves the same stock.
    fn is_like(&self, other: &Self) -> bool {
        let same = Arc::ptr_eq(&self.path, &other.path) || self.path == other.path;
        same && self.stock_to_leave == other.stock_to_leave
    }
}

/// Results of a plan's check.
pub(super) struct Checked {
    roughing: Length,
    finishing: Length,
    height_margin: Length,
    motions: usize,
}

impl Checked {
    pub(super) fn plan(
        self,
        plan: Plan,
        part: Arc<ProhibitedRegion>,
        levels: Levels,
        sections: &[Section],
    ) -> CertifiedPlan {
        let Self { roughing, finishing, height_margin, motions } = self;
        CertifiedPlan {
            walls: walls(&plan, sections),
            plan,
            part,
            levels: Arc::new(levels),
            height_margin,
            roughing,
            finishing,
            certified_motions: motions,
            mesh: OnceLock::new(),
            contours: OnceLock::new(),
        }
    }
}

pub(super) fn plus(threshold: Length, more: Length) -> Result<Length, PlanError> {
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

pub(super) fn finishing_clearance(tool_radius: Length, budget: &Budget) -> Result<Length, PlanError> {
    let margin = budget.total().map_err(|source| PlanError::Length { what: "margin", source })?;
    tool_radius.plus(margin).map_err(|source| PlanError::Length { what: "finishing clearance", source })
}

impl CertifiedPlan {
    /// The top of what stands at a point, clamps too. `None`: nothing stands there above the table.
    #[must_use]
    pub fn top_at(&self, point: Point) -> Option<Height> {
        let floor = self.plan.relief.as_ref()?.floor;
        let mut tops = self.levels.tops().filter(|&top| top > floor);
        tops.find(|top| self.levels.at(top.lowered(Length::small(1))).holds(point))
    }

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

    /// What stands above a tip that is commanded to this height, less the height margin.
    #[must_use]
    pub fn region(&self, height: Height) -> &Arc<ProhibitedRegion> {
        self.levels.at(height.lowered(self.height_margin))
    }

    /// The box around the part and the zones.
    #[must_use]
    pub fn part_box(&self) -> Box2 {
        let segments = self.part.zones().iter().flat_map(Ring::segments);
        window_mm(segments.map(Segment::bounds).fold(self.part.region().bounds(), Window::union))
    }
}
