//! Proposes the cells of a threshold: divides squares until they are free, blocked or near to few edges.
//! Untrusted.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use super::cells::{CellFault, CellProposal, Cells, Claim, DIVIDE, GROUP, Packed};
use super::check::CheckedIndex;
use super::nearest::least_distance;
use crate::exact::lattice::{Length, Point};
use crate::exact::segment::Window;

/// A square near to more edges than this is divided.
const FEW: usize = 6;
/// Most edges in a list. A square near to more edges stays open.
const LIST_MAX: usize = 96;
/// Squares of this size are not divided (2^n lattice units, 0.16 mm).
const LEAST: u32 = 14;
/// Squares above this size are divided whenever an edge is near (2^n lattice units, 5.2 mm).
const COARSE: u32 = 19;
/// Default number of groups: a base, and one more per this many edges. It is enough for every measured
/// profile.
const GROUPS: (usize, usize) = (1 << 15, 8);

/// Divides the plane for a threshold into at most `groups` groups of squares and checks the result. A group
/// takes 64 bytes and its lists. The default is enough for parts of the size of a machine. Squares beyond the
/// limit stay open.
///
/// # Errors
/// [`CellFault::Whole`] when [`propose`] returns `None`.
pub fn build(index: &CheckedIndex, threshold: Length, groups: Option<usize>) -> Result<Cells, CellFault> {
    let groups = groups.unwrap_or(GROUPS.0 + index.edges().len() / GROUPS.1);
    let proposal = propose(index, threshold, groups).ok_or(CellFault::Whole)?;
    Cells::check(index, proposal)
}

/// Proposes cells in at most `groups` groups. Returns `None` without edges, or when the box of the edges,
/// grown by the threshold and two units, is wider than 2^30 units.
#[must_use]
pub fn propose(index: &CheckedIndex, threshold: Length, groups: usize) -> Option<CellProposal> {
    let boxes = index.levels().last().and_then(|top| top.first())?.windows();
    let window = boxes.filter(|window| !window.is_empty()).reduce(Window::union)?;
    let beyond = threshold.plus(Length::small(2)).ok()?;
    let (min_x, min_y, max_x, max_y) = window.grown(beyond).corners();
    let span = (i64::from(max_x) - i64::from(min_x)).max(i64::from(max_y) - i64::from(min_y));
    if span > 1 << 30 {
        return None;
    }
    let mut log_2 = 2 * DIVIDE;
    while i64::from(1_u32 << log_2) < span {
        log_2 += 1;
    }
    let spare = (i64::from(1_u32 << log_2) - span) / 2;
    let corner = |c: i32| i32::try_from(i64::from(c) - spare).ok();
    let origin = (corner(min_x)?, corner(min_y)?);
    let mut builder = Builder {
        index,
        groups,
        hint: None,
        proposal: CellProposal { threshold, origin, log_2, claims: Vec::new(), lists: Vec::new() },
        found: Vec::new(),
    };
    builder.divide(origin, log_2);
    Some(builder.proposal)
}

struct Builder<'a> {
    index: &'a CheckedIndex,
    groups: usize,
    hint: Option<usize>,
    proposal: CellProposal,
    found: Vec<u32>,
}

impl Builder<'_> {
    /// Appends the group that divides a square and returns its number.
    fn divide(&mut self, low: (i32, i32), log_2: u32) -> u32 {
        let first = self.proposal.claims.len();
        self.proposal.claims.extend([Packed::of(Claim::Open); GROUP]);
        let part = log_2 - DIVIDE;
        for (lane, (row, column)) in
            (0..1 << DIVIDE).flat_map(|row| (0..1 << DIVIDE).map(move |column| (row, column))).enumerate()
        {
            let corner = (low.0.saturating_add(column << part), low.1.saturating_add(row << part));
            self.proposal.claims[first + lane] = Packed::of(self.claim(corner, part));
        }
        u32::try_from(first / GROUP).unwrap_or(u32::MAX)
    }

    fn claim(&mut self, low: (i32, i32), log_2: u32) -> Claim {
        let side = 1_i32 << log_2;
        let square =
            Window::from_corners(low.0, low.1, low.0.saturating_add(side), low.1.saturating_add(side));
        let reach = f64::from(self.proposal.threshold.units());
        let half = f64::from(side) * core::f64::consts::FRAC_1_SQRT_2 + 2.0;
        let centre =
            Point::from_units(i64::from(low.0) + i64::from(side / 2), i64::from(low.1) + i64::from(side / 2));
        let nearest = centre.ok().and_then(|centre| Some((centre, self.index.nearest(centre, self.hint)?)));
        let may_divide = log_2 > LEAST && self.proposal.claims.len() < self.groups.saturating_mul(GROUP);
        if let Some((centre, nearest)) = nearest {
            self.hint = Some(nearest.edge);
            let away = least_distance(centre, &self.index.edges()[nearest.edge]);
            if away + half <= reach
                && let Ok(edge) = u32::try_from(nearest.edge)
            {
                return Claim::Blocked(edge);
            }
            if may_divide && log_2 > COARSE && away - half <= reach {
                return Claim::Divided(self.divide(low, log_2));
            }
        }
        let complete = self.gather(square);
        if complete && self.found.is_empty() {
            return Claim::Free;
        }
        if may_divide && (!complete || self.found.len() > FEW) {
            return Claim::Divided(self.divide(low, log_2));
        }
        if !complete {
            return Claim::Open;
        }
        let (Ok(first), Ok(count)) =
            (u32::try_from(self.proposal.lists.len()), u32::try_from(self.found.len()))
        else {
            return Claim::Open;
        };
        self.proposal.lists.push(count);
        self.proposal.lists.extend_from_slice(&self.found);
        Claim::Near(first)
    }

    /// Collects the edges near the square. Returns whether they fit a list.
    fn gather(&mut self, square: Window) -> bool {
        let threshold = self.proposal.threshold;
        self.found.clear();
        let complete = self.index.visit(square.grown(threshold), |number, edge| {
            if edge.near_box(square, threshold).is_clear() {
                return ControlFlow::Continue(());
            }
            match u32::try_from(number) {
                Ok(number) if self.found.len() < LIST_MAX => self.found.push(number),
                _ => return ControlFlow::Break(()),
            }
            ControlFlow::Continue(())
        });
        complete.is_continue()
    }
}
