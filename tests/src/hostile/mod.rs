//! Hostile simulation: the whole stack from operator to simulated controller in virtual time, with faults from a menu, on
//! drawings random and real. An exact judge decides whether the tool was in the part. Everything follows from a seed.

mod drawing;
mod operator;
mod play;
mod shrink;
mod spec;
mod world;

pub use drawing::random_drawing;
pub use keepout_sim::monitor::Verdict;
pub use operator::{Hostile, Style};
pub use play::{Outcome, play, play_logged};
pub use shrink::shrink;
pub use spec::{Fault, Spec};
pub use world::{World, Worlds};
