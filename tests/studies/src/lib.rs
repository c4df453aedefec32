//! Two papers, reproduced and compared with Keepout: Koren & Lo 1992 on feed drives, Franco & Horikawa 2007 on machining by hand.
//!
//! `cargo run --release -p keepout-studies -- --help` lists the commands.

pub mod command;
pub mod franco_horikawa;
pub mod koren_lo;
