//! Reproductions of two papers, and comparisons with Keepout.
//!
//! The papers are Koren & Lo 1992 on feed drives, and Franco & Horikawa 2007 on machining with a joystick.
//!
//! `cargo run --release -p keepout-studies -- --help` lists the commands.

pub mod command;
pub mod franco_horikawa;
pub mod koren_lo;
