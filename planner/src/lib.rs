//! Planner: from a drawing to a certified plan.
//!
//! ```text
//! drawing (DXF) ── import ── chain ──> profile ── margin ── offset ──> plan file ──> picture
//! ```
//!
//! No code here is trusted. [`plan::Plan::certify`] checks every motion with the kernel's exact
//! predicates. Every reader of a plan file certifies the plan again.
//!
//! ```
//! use keepout_planner::machine::MachineProfile;
//! use keepout_planner::request::PlanRequest;
//!
//! let drawing = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../executor/cli/drawings/bracket.dxf"));
//! let machine = MachineProfile::simulated();
//! let plan = PlanRequest::default().plan("bracket", drawing, &machine, &mut |_| {}).unwrap();
//! assert!(plan.plan.certify().is_ok());
//! ```

pub mod align;
mod chord;
pub mod contour;
mod contour_error;
pub mod depth;
pub mod drawing;
pub mod file;
pub mod finish;
mod finish_error;
pub mod inspect;
pub mod job;
pub mod left_out;
pub mod machine;
pub mod margin;
pub mod merge;
pub mod mesh;
mod mm2;
mod mm3;
pub mod nesting;
pub mod plan;
mod plan_error;
pub mod plan_file;
pub mod planned;
pub mod profile;
pub mod reach;
pub mod report;
pub mod request;
mod rest;
pub mod ribbon;
pub mod route;
pub mod select;
pub mod sha256;
pub mod size;
pub mod stock;
pub mod stored;
mod summary;
pub mod text_file;
pub mod units;

pub use mm2::{Box2, Mm2};
pub use mm3::Mm3;
