//! TRUSTED: the checker of the clearance index, and the descent that skips only checked boxes.
//!
//! Implements SR-03.
//!
//! **Theorem.** A [`CheckedIndex`] holds every edge in exactly one leaf, and each box contains everything
//! below it. So a descent that enters every box that meets a window visits every edge whose own box meets
//! that window.

#![deny(clippy::arithmetic_side_effects, clippy::as_conversions, clippy::float_arithmetic)]

use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;

use super::Edge;
use crate::exact::segment::Window;

/// Boxes in a node.
pub const LANES: usize = 8;
/// Edges in a leaf.
pub const LEAF: usize = 4;
/// Most levels of boxes. 2^30 edges need ten levels, because 4 · 8^10 > 2^30. One level is in reserve.
const LEVELS: usize = 11;

/// The empty box runs from this coordinate to its negative. It lies off the lattice, and its differences to
/// lattice points fit `i32`.
const FAR: i32 = 1 << 30;

/// Eight boxes side by side, so that one query compares them together. An unused lane holds the empty box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(64))]
pub struct Node {
    min_x: [i32; LANES],
    min_y: [i32; LANES],
    max_x: [i32; LANES],
    max_y: [i32; LANES],
}

impl Node {
    /// A node from its boxes. Lanes without a box are empty. Boxes beyond the eighth are ignored.
    pub fn of(boxes: impl Iterator<Item = Window>) -> Self {
        let mut node =
            Self { min_x: [FAR; LANES], min_y: [FAR; LANES], max_x: [-FAR; LANES], max_y: [-FAR; LANES] };
        let lanes = node.min_x.iter_mut().zip(&mut node.min_y).zip(&mut node.max_x).zip(&mut node.max_y);
        for ((((min_x, min_y), max_x), max_y), window) in lanes.zip(boxes) {
            (*min_x, *min_y, *max_x, *max_y) = window.corners();
        }
        node
    }

    /// The boxes, lane by lane.
    pub fn windows(&self) -> impl Iterator<Item = Window> + '_ {
        let lanes = self.min_x.iter().zip(&self.min_y).zip(self.max_x.iter().zip(&self.max_y));
        lanes.map(|((&x0, &y0), (&x1, &y1))| Window::from_corners(x0, y0, x1, y1))
    }

    /// The corners of the boxes, lane by lane: least x, least y, greatest x, greatest y.
    #[must_use]
    #[inline]
    pub fn corners(&self) -> [&[i32; LANES]; 4] {
        [&self.min_x, &self.min_y, &self.max_x, &self.max_y]
    }

    /// The box of one lane.
    #[must_use]
    #[inline]
    pub fn window(&self, lane: u32) -> Option<Window> {
        let lane = usize::try_from(lane).ok()?;
        let of = |values: &[i32; LANES]| values.get(lane).copied();
        Some(Window::from_corners(of(&self.min_x)?, of(&self.min_y)?, of(&self.max_x)?, of(&self.max_y)?))
    }

    /// The lanes with a closed box that shares a point with `window`, as bits.
    #[must_use]
    #[inline]
    pub fn meeting(&self, window: Window) -> u8 {
        let (min_x, min_y, max_x, max_y) = window.corners();
        let mut meets = [false; LANES];
        let lanes = self.min_x.iter().zip(&self.min_y).zip(self.max_x.iter().zip(&self.max_y));
        for (meet, ((&x0, &y0), (&x1, &y1))) in meets.iter_mut().zip(lanes) {
            *meet = (x0 <= max_x) & (y0 <= max_y) & (x1 >= min_x) & (y1 >= min_y);
        }
        meets.into_iter().rev().fold(0, |mask, meet| (mask << 1_u32) | u8::from(meet))
    }
}

/// The proposed boxes: boxes over blocks of four consecutive edges, boxes over eight of those, and so on. The
/// first level is just above the edges. The last level has one node.
#[derive(Clone, Debug, Default)]
pub struct BoxProposal {
    /// The levels, from the edges upward.
    pub levels: Vec<Vec<Node>>,
}

/// Why a proposal is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexFault {
    /// More than 2^30 edges.
    TooManyEdges {
        /// The number of edges.
        count: usize,
    },
    /// The number of levels does not fit the number of edges.
    Levels {
        /// The number of proposed levels.
        count: usize,
    },
    /// A level has the wrong number of nodes, so an item below it is in no box or in two.
    Nodes {
        /// The level, from the edges upward.
        level: usize,
        /// The number of its nodes.
        count: usize,
    },
    /// A box does not contain everything below it.
    Box {
        /// The level, from the edges upward.
        level: usize,
        /// The index of the box in its level.
        index: usize,
    },
}

impl fmt::Display for IndexFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyEdges { count } => write!(f, "{count} edges exceed the index limit of 2^30 edges"),
            Self::Levels { count } => write!(f, "{count} levels of boxes do not fit the number of edges"),
            Self::Nodes { level, count } => write!(f, "level {level} has the wrong number of nodes: {count}"),
            Self::Box { level, index } => {
                write!(f, "box {index} of level {level} does not contain everything below it")
            }
        }
    }
}

impl core::error::Error for IndexFault {}

/// Edges behind checked bounding boxes. Safety queries accept no other index.
#[derive(Clone, Debug)]
pub struct CheckedIndex {
    edges: Vec<Edge>,
    levels: Vec<Vec<Node>>,
}

/// The choices of a descent at each node and edge.
pub trait Search {
    /// The lanes of `node` to enter, as bits. It may omit a lane only when no edge in its box can matter.
    fn enter(&mut self, node: &Node) -> u8;
    /// Tests edge number `index`.
    fn edge(&mut self, index: usize, edge: &Edge) -> ControlFlow<()>;
}

impl CheckedIndex {
    /// Accepts the proposal after exact checks, in time linear in the number of edges.
    ///
    /// Edge `i` is in lane `i / 4 mod 8` of node `i / 32` of the first level. Box `i` of each level is in
    /// lane `i mod 8` of node `i / 8` of the next level. With the right number of nodes on every level, each
    /// edge is in exactly one leaf, and each box is under exactly one box of the next level.
    ///
    /// # Errors
    /// [`IndexFault`] with the place of the first fault.
    pub fn check(edges: Vec<Edge>, proposal: BoxProposal) -> Result<Self, IndexFault> {
        if edges.len() > 1 << 30_u32 {
            return Err(IndexFault::TooManyEdges { count: edges.len() });
        }
        let levels = proposal.levels;
        let wrong_count = Err(IndexFault::Levels { count: levels.len() });
        let mut below = edges.len().div_ceil(LEAF);
        let mut remaining = levels.iter().enumerate();
        while below > 0 {
            let Some((level, nodes)) = remaining.next() else { return wrong_count };
            if nodes.len() != below.div_ceil(LANES) {
                return Err(IndexFault::Nodes { level, count: nodes.len() });
            }
            below = if nodes.len() == 1 { 0 } else { nodes.len() };
        }
        if remaining.next().is_some() {
            return wrong_count;
        }
        if let Some(first) = levels.first() {
            let blocks = edges.chunks(LEAF).map(|block| block.iter().map(Edge::bounds));
            check_boxes(0, first, blocks)?;
        }
        for (level, (lower, upper)) in levels.iter().zip(levels.iter().skip(1)).enumerate() {
            check_boxes(level.saturating_add(1), upper, lower.iter().map(Node::windows))?;
        }
        Ok(Self { edges, levels })
    }

    /// All edges, in the order of the region's rings.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The levels of boxes, from the edges upward.
    #[must_use]
    pub fn levels(&self) -> &[Vec<Node>] {
        &self.levels
    }

    /// Visits every edge whose box (with its chord error) meets `window`, in ascending order, until `visit`
    /// breaks. It may visit other edges too.
    #[inline]
    pub fn visit(
        &self,
        window: Window,
        visit: impl FnMut(usize, &Edge) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        struct InWindow<F>(Window, F);
        impl<F: FnMut(usize, &Edge) -> ControlFlow<()>> Search for InWindow<F> {
            #[inline(always)]
            fn enter(&mut self, node: &Node) -> u8 {
                node.meeting(self.0)
            }
            #[inline(always)]
            fn edge(&mut self, index: usize, edge: &Edge) -> ControlFlow<()> {
                (self.1)(index, edge)
            }
        }
        self.search(&mut InWindow(window, visit))
    }

    /// Descends into the boxes that `search` enters and passes it the edges of their leaves, in ascending
    /// order.
    #[inline]
    pub fn search(&self, search: &mut impl Search) -> ControlFlow<()> {
        let Some(top) = self.levels.len().checked_sub(1) else { return ControlFlow::Continue(()) };
        let mut path = [(0_usize, 0_u8); LEVELS];
        let mut level = top;
        let mut node = 0;
        loop {
            let mask =
                self.levels.get(level).and_then(|nodes| nodes.get(node)).map_or(0, |n| search.enter(n));
            if let Some(step) = path.get_mut(level) {
                *step = (node, mask);
            }
            // Find the next box to enter: in this node, or in the node above when this one has no more.
            loop {
                let Some((node_here, left)) = path.get_mut(level) else { return ControlFlow::Continue(()) };
                if *left == 0 {
                    if level == top {
                        return ControlFlow::Continue(());
                    }
                    level = level.saturating_add(1);
                    continue;
                }
                let lane = left.trailing_zeros();
                *left &= left.wrapping_sub(1);
                let child = (*node_here << 3_u32) | usize::try_from(lane).unwrap_or(0);
                match level.checked_sub(1) {
                    Some(lower) => {
                        (level, node) = (lower, child);
                        break;
                    }
                    None => self.leaf(child, search)?,
                }
            }
        }
    }

    #[inline(always)]
    fn leaf(&self, block: usize, search: &mut impl Search) -> ControlFlow<()> {
        let first = block << 2_u32;
        let end = first.saturating_add(LEAF).min(self.edges.len());
        for (lane, edge) in self.edges.get(first..end).unwrap_or(&[]).iter().enumerate() {
            search.edge(first | lane, edge)?;
        }
        ControlFlow::Continue(())
    }
}

/// Checks that box `i` of the level contains all of the `i`-th group of boxes below.
fn check_boxes<G: Iterator<Item = Window>>(
    level: usize,
    nodes: &[Node],
    groups: impl Iterator<Item = G>,
) -> Result<(), IndexFault> {
    let boxes = nodes.iter().flat_map(Node::windows);
    for (index, (window, group)) in boxes.zip(groups).enumerate() {
        for below in group {
            if !below.is_empty() && !window.contains(below) {
                return Err(IndexFault::Box { level, index });
            }
        }
    }
    Ok(())
}
