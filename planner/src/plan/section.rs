//! Sections of a plan: heights with the same prohibited region.

use std::sync::Arc;

use keepout_kernel::offset::Outline;
use keepout_kernel::{Height, Length, Levels, ProhibitedRegion};

use super::{Plan, PlanError};
use crate::depth::chosen;
use crate::profile::{Profile, free_outlines};

/// Heights of the tool's tip with the same prohibited region.
pub(super) struct Section {
    /// Heights of the depth passes, downward.
    pub heights: Vec<Height>,
    /// What stands above them, less the height margin.
    pub region: Arc<ProhibitedRegion>,
    /// The outlines that bound free space there: first those of the contours, then those of the zones.
    pub outlines: Vec<Outline>,
    /// The contours that bound free space there, by index in the profile.
    pub contours: Vec<usize>,
}

/// The walls that a pass finishes at its depth. A plan for two axes has one such group.
#[derive(Clone, Debug)]
pub struct Walls {
    /// Index of the pass: the last one at its depth.
    pub pass: usize,
    /// The contours of the walls, by index in the profile.
    pub contours: Vec<usize>,
    /// Their outlines. Each states the side on which the tool is.
    pub outlines: Vec<Outline>,
}

/// The walls of each depth, downward.
pub(super) fn walls(plan: &Plan, sections: &[Section]) -> Vec<Walls> {
    let depths = sections.iter().flat_map(|section| section.heights.iter().map(move |_| section));
    let at = |(depth, section): (usize, &Section)| Walls {
        pass: (depth + 1) * plan.passes_at_a_depth() - 1,
        contours: section.contours.clone(),
        outlines: section.outlines[..section.contours.len()].to_vec(),
    };
    depths.enumerate().map(at).collect()
}

/// The levels of a plan's part, and its sections downward. A plan for two axes has one of each.
pub(super) fn sections(
    plan: &Plan,
    part: &Arc<ProhibitedRegion>,
) -> Result<(Levels, Vec<Section>), PlanError> {
    let Some(relief) = &plan.relief else {
        let outlines = free_outlines(&plan.profile, &plan.zones, part);
        let contours = (0..plan.profile.loops.len()).collect();
        let section = Section { heights: vec![Height::ZERO], region: Arc::clone(part), outlines, contours };
        return Ok((Levels::flat(Arc::clone(part)), vec![section]));
    };
    let levels = relief.levels(part)?;
    let margin = relief.budget.total().unwrap_or(Length::ZERO);
    let section = |band: crate::depth::HeightBand| {
        let lowest = band.heights.last().copied().unwrap_or(Height::ZERO);
        let region = Arc::clone(levels.at(lowest.lowered(margin)));
        let profile = chosen(&plan.profile, &band.contours);
        let no_zones = Profile::default();
        let zones = if region.zones().is_empty() { &no_zones } else { &plan.zones };
        let outlines = free_outlines(&profile, zones, &region);
        Section { heights: band.heights, region, outlines, contours: band.contours }
    };
    let bands = relief.bands(&levels, part)?;
    let sections = bands.into_iter().map(section).collect();
    Ok((levels, sections))
}
