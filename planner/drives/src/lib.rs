//! Feed drives: models, controllers, and the contour error that each controller leaves on a path.
//!
//! The controllers are those of Koren & Lo ("Advanced controllers for feed drives", CIRP 1992) and better
//! ones. Units are the paper's: positions in encoder pulses, commands and loads in bits, times in seconds. A
//! controller is a value with `step(window of the reference, measured position) -> command`. A step allocates
//! no memory.
//!
//! The trusted part of Keepout does not depend on this crate. The crate computes the contour-error term of a
//! plan's margin, moves the simulated machine like a real one, and compares controllers for the engineer.
//!
//! ```
//! use keepout_drives::profile::DriveProfile;
//!
//! let drives = DriveProfile::load("simulated").unwrap();
//! assert!(drives.period_s > 0.0);
//! ```

pub mod ballbar;
pub mod budget;
pub mod controllers;
pub mod drive;
pub mod export;
pub mod gains;
pub mod identification;
pub mod interpolated;
pub mod interpolator;
pub mod metrics;
pub mod number_table;
pub mod path;
pub mod plant;
pub mod profile;
pub mod reference;
pub mod run;
pub mod stream;
pub mod tuning;

/// One value for each axis, X and Y.
pub type Axes = nalgebra::Vector2<f64>;
