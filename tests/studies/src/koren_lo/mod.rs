//! Reproduction of Koren & Lo, "Advanced controllers for feed drives" (CIRP 1992), and a comparison with our
//! controllers.

pub mod command;
pub mod comparison;
pub mod equations;
mod figures;
pub mod finishing;
pub mod grades;
pub mod page;
pub mod picture;
pub mod scenario;
