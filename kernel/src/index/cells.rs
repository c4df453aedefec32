//! TRUSTED: squares of the plane with a known answer for one threshold. Implements SR-03.
//!
//! **Theorem.** In a checked [`Cells`] each closed square, clipped at the limits of the lattice, is one of
//! four kinds. *Free*: no edge is within the threshold of any point of the square. *Blocked*: one edge is
//! within the threshold of every point of the square. *Near*: a list holds every edge that comes within the
//! threshold of the square. *Open*: the cells claim nothing. So the answer for a point is the answer of its
//! square.
//!
//! The closed squares of [`Cells::walk`] cover a motion. If no square among them is open, the motion is clear
//! exactly when each is free, or is near with every listed edge clear of the motion.
//!
//! The checker tests the claims against the [`CheckedIndex`]. Their proposer ([`super::subdivide`]) is
//! untrusted.

#![deny(clippy::arithmetic_side_effects, clippy::as_conversions, clippy::float_arithmetic)]

use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;

use super::Edge;
use super::check::CheckedIndex;
use crate::exact::lattice::{Length, Point};
use crate::exact::predicate::Proximity;
use crate::exact::segment::{Segment, Window};

/// A square is divided into 2^DIVIDE × 2^DIVIDE parts.
pub const DIVIDE: u32 = 2;
/// Squares in a group: the parts of one divided square, row by row.
pub const GROUP: usize = 1 << (2 * DIVIDE);
const LAST: i32 = (1 << DIVIDE) - 1;

/// A claim about a square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Claim {
    /// No edge is near.
    Free,
    /// The whole square is within the threshold of the edge with this number.
    Blocked(u32),
    /// Only the edges of one list can be near. The list begins at this entry: its length, then the edge
    /// numbers in ascending order.
    Near(u32),
    /// The square is divided; the group of its parts has this number.
    Divided(u32),
    /// No claim: use the index.
    Open,
}

/// A claim in 32 bits: two for the kind, thirty for the number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packed(u32);

const NUMBER: u32 = u32::MAX >> 2;

impl Packed {
    /// Packs a claim. A number that does not fit makes the square open.
    #[must_use]
    pub const fn of(claim: Claim) -> Self {
        match claim {
            Claim::Free => Self(0),
            Claim::Blocked(number) if number < NUMBER => Self((number << 2) | 1),
            Claim::Near(number) if number < NUMBER => Self((number << 2) | 2),
            Claim::Divided(number) if number < NUMBER => Self((number << 2) | 3),
            _ => Self((NUMBER << 2) | 2),
        }
    }

    /// The claim.
    #[must_use]
    #[inline(always)]
    pub const fn claim(self) -> Claim {
        let number = self.0 >> 2;
        match self.0 & 3 {
            0 => Claim::Free,
            1 => Claim::Blocked(number),
            2 if number == NUMBER => Claim::Open,
            2 => Claim::Near(number),
            _ => Claim::Divided(number),
        }
    }
}

/// A proposed division of the plane.
#[derive(Clone, Debug)]
pub struct CellProposal {
    /// The threshold of the claims.
    pub threshold: Length,
    /// Lowest corner of the whole, in lattice units.
    pub origin: (i32, i32),
    /// The whole is a square of side 2^log_2.
    pub log_2: u32,
    /// The groups, [`GROUP`] claims each, in the order of a depth-first walk. The first group divides the
    /// whole.
    pub claims: Vec<Packed>,
    /// The lists, in the order of the walk.
    pub lists: Vec<u32>,
}

/// Why proposed cells are rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellFault {
    /// The whole is too small to be divided, too large for 32-bit coordinates, or does not hold everything
    /// near an edge.
    Whole,
    /// A group or list is out of the order of the walk, missing, or left over.
    PlanRequest {
        /// The first faulty group or list entry.
        at: usize,
    },
    /// The claim of a square does not hold.
    Claim {
        /// The square.
        square: Window,
        /// The claim.
        claim: Claim,
    },
}

impl fmt::Display for CellFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => write!(f, "the cells do not cover everything near the part"),
            Self::PlanRequest { at } => write!(f, "the cells' groups or lists are out of order at {at}"),
            Self::Claim { square, claim } => {
                write!(f, "the claim {claim:?} does not hold for the cell {square:?}")
            }
        }
    }
}

impl core::error::Error for CellFault {}

/// Checked cells for one threshold. Use them only with the index that checked them.
#[derive(Clone, Debug)]
pub struct Cells {
    threshold: Length,
    origin: (i32, i32),
    log_2: u32,
    claims: Vec<Packed>,
    lists: Vec<u32>,
}

/// A square on a walk.
#[derive(Clone, Copy, Debug)]
pub struct Square<'a> {
    /// Lowest corner, in lattice units.
    pub low: (i32, i32),
    /// Its side is 2^log_2 lattice units.
    pub log_2: u32,
    /// The checked claim.
    pub known: Known<'a>,
}

/// The answer to "is an edge within the threshold?".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// No edge is near.
    Clear,
    /// The edge with this number is near.
    Near(u32),
    /// The cells do not decide: use the index.
    Unknown,
}

/// The checked claim about an undivided square.
#[derive(Clone, Copy, Debug)]
pub enum Known<'a> {
    /// No edge is near.
    Free,
    /// The whole square is within the threshold of this edge.
    Blocked(u32),
    /// Only these edges can be near.
    Near(&'a [u32]),
    /// No claim.
    Open,
}

impl Cells {
    /// Accepts the proposal after checking every square against the index. The time grows with the number of
    /// squares and of edges near them.
    ///
    /// # Errors
    /// [`CellFault`] with the first fault.
    pub fn check(index: &CheckedIndex, proposal: CellProposal) -> Result<Self, CellFault> {
        let CellProposal { threshold, origin, log_2, claims, lists } = proposal;
        let whole = square(origin, log_2).ok_or(CellFault::Whole)?;
        let near = index.levels().last().and_then(|top| top.first()).map(|top| top.windows());
        let mut boxes = near.into_iter().flatten().filter(|window| !window.is_empty());
        // No edge is near outside the whole: it contains every box grown by the threshold and one spare unit.
        let beyond = threshold.saturating_plus(Length::small(1));
        if log_2 < DIVIDE || beyond == threshold || !boxes.all(|window| whole.contains(window.grown(beyond)))
        {
            return Err(CellFault::Whole);
        }
        let cells = Self { threshold, origin, log_2, claims, lists };
        let mut check = Check { cells: &cells, index, groups: 0, lists: 0 };
        check.group(0, origin, log_2)?;
        let (groups, lists) = (check.groups.saturating_mul(GROUP), check.lists);
        if groups != cells.claims.len() || lists != cells.lists.len() {
            return Err(CellFault::PlanRequest { at: groups.min(lists) });
        }
        Ok(cells)
    }

    /// The threshold of the answers.
    #[must_use]
    pub fn threshold(&self) -> Length {
        self.threshold
    }

    /// The memory of the cells, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.claims.as_slice()).saturating_add(size_of_val(self.lists.as_slice()))
    }

    /// Whether an edge is within the threshold of the point.
    #[must_use]
    #[inline]
    pub fn point(&self, index: &CheckedIndex, point: Point) -> Answer {
        match self.square_at(point.x.units(), point.y.units()) {
            None => Answer::Clear,
            Some(square) => self.ask(index, square.known, |edge| edge.near_point(point, self.threshold)),
        }
    }

    /// Whether an edge is within the threshold of the motion.
    #[must_use]
    #[inline]
    pub fn motion(&self, index: &CheckedIndex, motion: Segment) -> Answer {
        let mut answer = Answer::Clear;
        let walked = self.walk(motion, |square| {
            answer = self.ask(index, square.known, |edge| edge.near_motion(motion, self.threshold));
            if answer == Answer::Clear { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        walked.map_or(Answer::Unknown, |_| answer)
    }

    /// The answer of a square for a shape wholly inside the closed square. `ask` decides whether an edge is
    /// near the shape.
    #[inline(always)]
    pub fn ask(&self, index: &CheckedIndex, known: Known<'_>, ask: impl Fn(&Edge) -> Proximity) -> Answer {
        match known {
            Known::Free => Answer::Clear,
            Known::Blocked(number) => Answer::Near(number),
            Known::Open => Answer::Unknown,
            Known::Near(list) => {
                let near = |&number: &u32| {
                    let edge = usize::try_from(number).ok().and_then(|number| index.edges().get(number));
                    edge.is_none_or(|edge| !ask(edge).is_clear())
                };
                list.iter().copied().find(near).map_or(Answer::Clear, Answer::Near)
            }
        }
    }

    /// Visits squares, from start to end, until `visit` breaks. Their closed boxes cover the motion. Returns
    /// `None` when the motion leaves the whole.
    ///
    /// The motion leaves a square through the side that it meets first; cross products of 31-bit numbers
    /// decide which. The walk then keeps the lattice unit `(x, y)` that the motion enters. The closed square
    /// of this unit contains the exit point. Each coordinate of the unit is a monotone function of the share
    /// of the motion: rounded down where it rises, rounded up and reduced by one where it falls. The unit
    /// lies outside the square just left, so the walk ends.
    #[inline]
    pub fn walk<'a>(
        &'a self,
        motion: Segment,
        mut visit: impl FnMut(Square<'a>) -> ControlFlow<()>,
    ) -> Option<ControlFlow<()>> {
        let end = (motion.to.x.units(), motion.to.y.units());
        let from = (motion.from.x.units(), motion.from.y.units());
        let mut at = from;
        loop {
            let square = self.square_at(at.0, at.1)?;
            if visit(square).is_break() {
                return Some(ControlFlow::Break(()));
            }
            let side = 1_i32.wrapping_shl(square.log_2);
            let high = (square.low.0.saturating_add(side), square.low.1.saturating_add(side));
            let within =
                (square.low.0 <= end.0) & (end.0 <= high.0) & (square.low.1 <= end.1) & (end.1 <= high.1);
            if within {
                return Some(ControlFlow::Continue(()));
            }
            at = leave(from, end, square.low, high);
        }
    }

    /// The undivided square that holds the lattice point; `None` outside the whole.
    #[must_use]
    #[inline]
    pub fn square_at(&self, x: i32, y: i32) -> Option<Square<'_>> {
        // Unsigned offsets from the origin. For a point below the origin they wrap to numbers that are too
        // large.
        let across = x.wrapping_sub(self.origin.0).cast_unsigned();
        let up = y.wrapping_sub(self.origin.1).cast_unsigned();
        let mut log_2 = self.log_2;
        if (across | up).checked_shr(log_2)? != 0 {
            return None;
        }
        let mut group = 0_u32;
        loop {
            log_2 = log_2.checked_sub(DIVIDE)?;
            let lane = (((up >> log_2) & LAST_U) << DIVIDE) | ((across >> log_2) & LAST_U);
            let first = usize::try_from(group).ok()?.checked_shl(2 * DIVIDE)?;
            let claim = self
                .claims
                .get(first | usize::try_from(lane).ok()?)
                .map_or(Claim::Open, |packed| packed.claim());
            let known = match claim {
                Claim::Divided(below) => {
                    group = below;
                    continue;
                }
                Claim::Free => Known::Free,
                Claim::Blocked(edge) => Known::Blocked(edge),
                Claim::Near(list) => self.list(list).map_or(Known::Open, Known::Near),
                Claim::Open => Known::Open,
            };
            let keep = u32::MAX.wrapping_shl(log_2);
            let corner = |offset: u32, origin: i32| origin.wrapping_add((offset & keep).cast_signed());
            let low = (corner(across, self.origin.0), corner(up, self.origin.1));
            return Some(Square { low, log_2, known });
        }
    }

    #[inline(always)]
    fn list(&self, first: u32) -> Option<&[u32]> {
        let rest = self.lists.get(usize::try_from(first).ok()?..)?;
        let (&count, rest) = rest.split_first()?;
        rest.get(..usize::try_from(count).ok()?)
    }
}

const LAST_U: u32 = (1 << DIVIDE) - 1;

/// The closed square from `low` of side 2^log_2, or `None` when it exceeds `i32`.
fn square(low: (i32, i32), log_2: u32) -> Option<Window> {
    let side = 1_i32.checked_shl(log_2).filter(|&side| side > 0)?;
    Some(Window::from_corners(low.0, low.1, low.0.checked_add(side)?, low.1.checked_add(side)?))
}

/// The lattice unit that the motion enters when it leaves the closed box from `low` to `high`.
#[inline(always)]
fn leave(from: (i32, i32), end: (i32, i32), low: (i32, i32), high: (i32, i32)) -> (i32, i32) {
    // All differences are below 2^32 in magnitude, differences of the motion at most 2^30. So products fit
    // `i64`.
    let wide = |a: i32, b: i32| i64::from(a).wrapping_sub(i64::from(b));
    let (dx, dy) = (wide(end.0, from.0), wide(end.1, from.1));
    let way_x = if dx > 0 { wide(high.0, from.0) } else { wide(from.0, low.0) };
    let way_y = if dy > 0 { wide(high.1, from.1) } else { wide(from.1, low.1) };
    let (run_x, run_y) = (dx.wrapping_abs(), dy.wrapping_abs());
    let x_first = run_y == 0 || run_x != 0 && way_x.wrapping_mul(run_y) <= way_y.wrapping_mul(run_x);
    let beyond = |d: i64, low: i32, high: i32| if d > 0 { high } else { low.wrapping_sub(1) };
    // way / run is the share of the motion at the exit. The other coordinate of the entered unit is rounded
    // down, or, when it falls, rounded up and reduced by one.
    let other = |origin: i32, d: i64, way: i64, run: i64| {
        let before = i64::from(d < 0);
        let moved = d.wrapping_mul(way).wrapping_sub(before).checked_div_euclid(run).unwrap_or(0);
        i32::try_from(i64::from(origin).wrapping_add(moved)).unwrap_or(i32::MAX)
    };
    if x_first {
        (beyond(dx, low.0, high.0), other(from.1, dy, way_x, run_x))
    } else {
        (other(from.0, dx, way_y, run_y), beyond(dy, low.1, high.1))
    }
}

/// A walk over all squares. It checks their claims, and that it meets every group and list exactly once.
struct Check<'a> {
    cells: &'a Cells,
    index: &'a CheckedIndex,
    groups: usize,
    lists: usize,
}

impl Check<'_> {
    fn group(&mut self, number: u32, low: (i32, i32), log_2: u32) -> Result<(), CellFault> {
        let at = usize::try_from(number).unwrap_or(usize::MAX);
        let out_of_order = CellFault::PlanRequest { at };
        let first = at.saturating_mul(GROUP);
        let claims = self.cells.claims.get(first..first.saturating_add(GROUP)).ok_or(out_of_order)?;
        if at != self.groups {
            return Err(out_of_order);
        }
        self.groups = self.groups.saturating_add(1);
        let part = log_2.checked_sub(DIVIDE).ok_or(CellFault::Whole)?;
        for (lane, packed) in (0_i32..).zip(claims) {
            let step = |steps: i32, from: i32| from.saturating_add(steps.wrapping_shl(part));
            let low = (step(lane & LAST, low.0), step(lane >> DIVIDE, low.1));
            let square = square(low, part).ok_or(CellFault::Whole)?;
            let claim = packed.claim();
            let holds = match claim {
                Claim::Open => true,
                Claim::Free => self.index.near_box(square, self.cells.threshold).is_none(),
                Claim::Blocked(edge) => {
                    let edge = usize::try_from(edge).ok().and_then(|edge| self.index.edges().get(edge));
                    edge.is_some_and(|edge| edge.reaches_all(square, self.cells.threshold))
                }
                Claim::Near(list) => self.lists_all_near(list, square)?,
                Claim::Divided(below) => {
                    self.group(below, low, part)?;
                    true
                }
            };
            if !holds {
                return Err(CellFault::Claim { square, claim });
            }
        }
        Ok(())
    }

    /// Whether the list, in ascending order, holds every edge near the square.
    fn lists_all_near(&mut self, list: u32, square: Window) -> Result<bool, CellFault> {
        let at = usize::try_from(list).unwrap_or(usize::MAX);
        let listed =
            self.cells.list(list).filter(|_| at == self.lists).ok_or(CellFault::PlanRequest { at })?;
        self.lists = self.lists.saturating_add(listed.len()).saturating_add(1);
        let threshold = self.cells.threshold;
        let mut rest = listed.iter().copied();
        let complete = self.index.visit(square.grown(threshold), |number, edge| {
            if edge.near_box(square, threshold).is_clear()
                || rest.any(|next| usize::try_from(next).is_ok_and(|next| next == number))
            {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        });
        let known = listed.iter().all(|&n| usize::try_from(n).is_ok_and(|n| n < self.index.edges().len()));
        Ok(complete.is_continue() && known)
    }
}
