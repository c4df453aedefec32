//! Builds the boxes of the clearance index. This code is untrusted: [`CheckedIndex::check`] verifies every
//! box.

use alloc::vec;
use alloc::vec::Vec;

use super::Edge;
use super::check::{BoxProposal, CheckedIndex, IndexFault, LANES, LEAF, Node};
use crate::exact::region::Region;
use crate::exact::ring::Ring;
use crate::exact::segment::Window;

/// The edges of a region, ring by ring, with their chord errors.
#[must_use]
pub fn edges_of(region: &Region) -> Vec<Edge> {
    edges_of_rings(region.rings())
}

/// The edges of rings, one ring after the other, with their chord errors.
#[must_use]
pub fn edges_of_rings(rings: &[Ring]) -> Vec<Edge> {
    let count = rings.iter().map(|ring| ring.vertices().len()).sum();
    let mut edges = Vec::with_capacity(count);
    for ring in rings {
        edges.extend(
            ring.segments().zip(ring.chord_errors()).map(|(chord, &chord_error)| Edge { chord, chord_error }),
        );
    }
    edges
}

/// Proposes the boxes over `edges`.
#[must_use]
pub fn propose(edges: &[Edge]) -> BoxProposal {
    let mut levels = Vec::new();
    let mut boxes: Vec<Window> =
        edges.chunks(LEAF).filter_map(|block| block.iter().map(Edge::bounds).reduce(Window::union)).collect();
    while !boxes.is_empty() {
        let nodes: Vec<Node> = boxes.chunks(LANES).map(|run| Node::of(run.iter().copied())).collect();
        let last = nodes.len() == 1;
        boxes = if last {
            vec![]
        } else {
            boxes.chunks(LANES).filter_map(|run| run.iter().copied().reduce(Window::union)).collect()
        };
        levels.push(nodes);
    }
    BoxProposal { levels }
}

/// Proposes the boxes over `edges`, and checks them with [`CheckedIndex::check`].
///
/// # Errors
/// [`IndexFault::TooManyEdges`] above 2^30 edges.
pub fn build(edges: Vec<Edge>) -> Result<CheckedIndex, IndexFault> {
    let proposal = propose(&edges);
    CheckedIndex::check(edges, proposal)
}
