//! Hostile simulation: all layers from operator to simulated controller in virtual time, with injected
//! faults, on random and real drawings. An exact collision monitor decides whether the tool was in the part.
//! A seed determines each session.

mod drawing;
mod operator;
mod play;
mod screens;
mod shrink;
mod spec;
mod world;

pub use drawing::random_drawing;
pub use keepout_sim::monitor::Verdict;
pub use operator::{Hostile, Style};
pub use play::{Outcome, play, play_logged};
pub use shrink::shrink;
pub use spec::{HostileFault, Spec};
pub use world::{HostileWorld, Worlds};
