//! All edges in runs of consecutive ones, behind bounding boxes.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use super::EdgeSource;
use crate::exact::lattice::Length;
use crate::exact::region::Region;
use crate::exact::segment::{Segment, Window};

/// One edge of the profile: a chord and how far the true curve leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The chord.
    pub chord: Segment,
    /// Bound on the distance between the true curve and the chord.
    pub slack: Length,
}

impl Edge {
    /// The box of the chord, grown by the slack.
    #[must_use]
    pub fn bounds(&self) -> Window {
        self.chord.bounds().grown(self.slack)
    }
}

/// Consecutive edges of a profile mostly lie close together: this many share one box, and this many boxes another.
const RUN: usize = 16;

/// The edges of a region in runs of consecutive ones, each behind its bounding box, runs of runs behind theirs, and so
/// on up to one box.
#[derive(Clone, Debug)]
pub struct EdgeRuns {
    edges: Vec<Edge>,
    /// Boxes of runs of 16 edges, of 16 such runs, ...; the last level has one box.
    levels: Vec<Vec<Window>>,
}

impl EdgeRuns {
    /// The edges of `region`, with their slacks.
    #[must_use]
    pub fn of(region: &Region) -> Self {
        let with_slack = |ring: &crate::exact::ring::Ring| -> Vec<Edge> {
            ring.segments().zip(ring.slacks()).map(|(chord, &slack)| Edge { chord, slack }).collect()
        };
        let edges: Vec<Edge> = region.rings().iter().flat_map(with_slack).collect();
        let mut boxes: Vec<Window> = edges.iter().map(Edge::bounds).collect();
        let mut levels = Vec::new();
        while boxes.len() > 1 {
            boxes = boxes.chunks(RUN).filter_map(|run| run.iter().copied().reduce(Window::union)).collect();
            levels.push(boxes.clone());
        }
        Self { edges, levels }
    }

    /// All edges.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Visits what lies below box `index` of the level that has `above` levels of boxes at and below it.
    fn descend(
        &self,
        above: usize,
        index: usize,
        window: Window,
        visit: &mut dyn FnMut(&Edge) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(level) = above.checked_sub(1) else {
            return match self.edges.get(index) {
                Some(edge) if edge.bounds().meets(window) => visit(edge),
                _ => ControlFlow::Continue(()),
            };
        };
        if !self.levels[level].get(index).is_some_and(|bounds| bounds.meets(window)) {
            return ControlFlow::Continue(());
        }
        let below = if level == 0 { self.edges.len() } else { self.levels[level - 1].len() };
        (index * RUN..below.min((index + 1) * RUN))
            .try_for_each(|child| self.descend(level, child, window, visit))
    }
}

impl EdgeSource for EdgeRuns {
    fn visit(&self, window: Window, visit: &mut dyn FnMut(&Edge) -> ControlFlow<()>) -> ControlFlow<()> {
        self.descend(self.levels.len(), 0, window, visit)
    }
}
