//! From a drawing to a certified plan.
//!
//! ```text
//! drawing (DXF) ── import ── chain ──> profile ── margin ── offset ──> plan file ──> picture
//! ```
//!
//! Nothing here is trusted: a plan is believed after [`plan::Plan::certify`], which asks the kernel's exact predicates
//! about every motion, and whoever loads a plan file does that again.

pub mod align;
mod chord;
pub mod drawing;
pub mod finish;
pub mod inspect;
pub mod job;
pub mod machine;
pub mod margin;
pub mod merge;
pub mod mesh;
pub mod picture;
pub mod plan;
pub mod plan_file;
pub mod profile;
pub mod request;
pub mod route;
pub mod select;
pub mod stored;
mod summary;
pub mod text_file;
pub mod units;
