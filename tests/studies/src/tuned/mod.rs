//! Every controller, tuned alike, on paths for which it was not tuned.

pub mod page;
pub mod variant;
