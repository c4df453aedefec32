//! Reproduction of the experiment of Franco & Horikawa 2007, section 6, with their controller and with
//! Keepout.

pub mod attempt;
pub mod brake;
pub mod calibration;
pub mod check_picture;
pub mod clearing;
pub mod command;
pub mod delays;
pub mod finishing;
pub mod handwheel;
pub mod invasion;
pub mod modules;
pub mod ours;
pub mod page;
pub mod paper;
pub mod paper_picture;
pub mod parallel;
pub mod picture;
mod prediction;
pub mod results;
pub mod roughing;
pub mod scenario;
pub mod stopping;
pub mod tables;
