//! The one place that draws: SVG pictures and charts, HTML pages, tables.

pub mod chart;
pub mod element;
pub mod html;
mod inspection;
mod part;
mod plan;
mod section;
pub mod table;
pub mod view;

pub use inspection::inspection_svg;
pub use part::rest_beside;
pub use plan::{RunDrawing, Spot, SpotKind, Trace, TraceKind, svg};
pub use section::section_svg;
