//! Which edges a query has to look at.

mod runs;

pub use runs::{Edge, EdgeRuns};

use core::ops::ControlFlow;

use crate::exact::segment::Window;

/// A source of edges near a window: what the clear queries are written over.
///
/// An implementation may hand out more edges than asked for, never fewer: every edge whose own box meets `window`
/// when grown by the edge's slack must be visited.
pub trait EdgeSource {
    /// Visits the edges whose box, grown by their slack, meets `window`, until `visit` breaks.
    fn visit(&self, window: Window, visit: &mut dyn FnMut(&Edge) -> ControlFlow<()>) -> ControlFlow<()>;
}
