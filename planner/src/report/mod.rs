//! SVG pictures of a drawing's contours, of a plan, and of a run.

mod inspection;
mod plan;
mod view;

pub use inspection::inspection_svg;
pub use plan::{Spot, SpotKind, Trace, TraceKind, svg, svg_of_run};
pub use view::escape;
