//! All edges in runs of consecutive ones, each run behind its bounding box.

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

/// Consecutive edges of a profile mostly lie close together: 32 of them share one box.
const RUN: usize = 32;

/// The edges of a region, in runs of consecutive ones with a bounding box each.
///
/// A query costs one box test per run and one per edge of the runs that pass.
#[derive(Clone, Debug)]
pub struct EdgeRuns {
    edges: Vec<Edge>,
    boxes: Vec<Window>,
}

impl EdgeRuns {
    /// The edges of `region`, with their slacks.
    #[must_use]
    pub fn of(region: &Region) -> Self {
        let with_slack = |ring: &crate::exact::ring::Ring| -> Vec<Edge> {
            ring.segments().zip(ring.slacks()).map(|(chord, &slack)| Edge { chord, slack }).collect()
        };
        let edges: Vec<Edge> = region.rings().iter().flat_map(with_slack).collect();
        let union = |run: &[Edge]| run.iter().map(Edge::bounds).reduce(Window::union);
        let boxes = edges.chunks(RUN).filter_map(union).collect();
        Self { edges, boxes }
    }

    /// All edges.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }
}

impl EdgeSource for EdgeRuns {
    fn visit(&self, window: Window, visit: &mut dyn FnMut(&Edge) -> ControlFlow<()>) -> ControlFlow<()> {
        for (run, bounds) in self.edges.chunks(RUN).zip(&self.boxes) {
            if bounds.meets(window) {
                for edge in run.iter().filter(|edge| edge.bounds().meets(window)) {
                    visit(edge)?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}
