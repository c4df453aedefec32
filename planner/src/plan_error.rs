//! Why planning fails, or why a plan is refused.

use keepout_kernel::LatticeError;
use thiserror::Error;

use crate::depth::DepthError;
use crate::finish::{FinishError, PathRefusal};
use crate::margin::MarginError;
use crate::plan::{DEPTHS_MAX, FEEDS_MM_MIN, PASSES_MAX, TOOL_MAX_MM, TOOL_MIN_MM};
use crate::profile::ProfileError;

/// Reason why planning fails, or why a plan is refused.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The loops bound no part.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// The margin is refused.
    #[error(transparent)]
    Margin(#[from] MarginError),
    /// The planner finds no finishing toolpath.
    #[error(transparent)]
    Finish(#[from] FinishError),
    /// A length is off the lattice.
    #[error("{what}: {source}")]
    Length {
        /// Name of the length.
        what: &'static str,
        /// The reason.
        source: LatticeError,
    },
    /// The tool's diameter is out of range.
    #[error(
        "a tool diameter of {diameter_mm} mm is out of range. \
         Give one between {TOOL_MIN_MM} and {TOOL_MAX_MM} mm."
    )]
    Tool {
        /// The given diameter, mm.
        diameter_mm: f64,
    },
    /// A finishing pass does not hold its claims.
    #[error("finishing pass {number}: {refusal}")]
    Pass {
        /// The pass, from 1.
        number: usize,
        /// The reason.
        refusal: PathRefusal,
    },
    /// A pass removes no stock: it leaves as much as the pass before it, or more.
    #[error(
        "a finishing pass leaves {stock_to_leave_mm:.4} mm. Each pass must leave less than the one before, \
         and the first at most the stock to leave (--stock-to-leave-mm)."
    )]
    PassOrder {
        /// Stock that the pass leaves, mm.
        stock_to_leave_mm: f64,
    },
    /// The feed of a finishing pass is out of range.
    #[error(
        "a finishing pass has a feed of {mm_min} mm/min, it must be between {} and {}. \
         Make the plan again from the drawing.",
        FEEDS_MM_MIN.start(), FEEDS_MM_MIN.end()
    )]
    Feed {
        /// The feed.
        mm_min: u32,
    },
    /// The heights of the job fail.
    #[error(transparent)]
    Depth(#[from] DepthError),
    /// The depths of the passes are not those that the part needs.
    #[error("the plan does not cut every wall over its whole height. Make the plan again from the drawing.")]
    Depths,
    /// The plan has too many depths.
    #[error("{count} depth passes: a plan has at most {DEPTHS_MAX}. Raise --step-down-mm.")]
    DepthCount {
        /// Number of depths.
        count: usize,
    },
    /// The number of finishing passes is out of range.
    #[error("{count} finishing passes: a plan has at least one and at most {PASSES_MAX}")]
    PassCount {
        /// Number of passes.
        count: usize,
    },
}
