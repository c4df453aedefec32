//! Feed drives: models, the controllers of Koren & Lo ("Advanced controllers for feed drives", CIRP 1992) and better ones, and
//! how far each leaves the path it should follow.
//!
//! Positions are in pulses of the encoder, commands and loads in bits, times in seconds, as in the paper. A controller is a value
//! with `step(window of the reference, measured position) -> command`; nothing is allocated in a step. The trusted part of Keepout
//! rests on none of this: what comes out of here is the contour-error term of a plan's margin, a simulated machine that
//! moves like a real one, and a comparison for the engineer.

pub mod budget;
pub mod controllers;
pub mod drive;
pub mod interpolated;
pub mod interpolator;
pub mod metrics;
pub mod path;
pub mod plant;
pub mod profile;
pub mod reference;
pub mod run;
pub mod stream;

/// One figure for each axis, X and Y.
pub type Axes = nalgebra::Vector2<f64>;
