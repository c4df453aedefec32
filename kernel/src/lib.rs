//! The geometry kernel of Keepout.
//!
//! [`exact`] holds coordinates on an integer lattice of 10 nm and predicates that decide in integers. The
//! trusted queries build on it: [`clear`], `levels`, `simplify`, [`index::check`], [`index::query`],
//! [`index::cells`] and [`offset::certify_path`]. The rest of the crate proposes in `f64`, and the trusted
//! code checks each proposal.
//!
//! ```
//! use keepout_kernel::{Length, Point, ProhibitedRegion, Region, Ring, Side};
//!
//! let corner = |x, y| Point::from_units(x, y).unwrap();
//! let square = Ring::new(vec![corner(0, 0), corner(1000, 0), corner(1000, 1000), corner(0, 1000)]).unwrap();
//! let region = Region::new(vec![square]).unwrap();
//! let prohibited = ProhibitedRegion::new(region, Side::Outside).unwrap();
//! let threshold = Length::from_units(300).unwrap();
//! let start = prohibited.free_point(corner(-400, 500), threshold).unwrap();
//! assert!(prohibited.motion(start, corner(-400, 2000)).is_ok());
//! assert!(prohibited.motion(start, corner(1400, 500)).is_err());
//! ```
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod arc_view;
pub mod clear;
pub mod clip;
pub mod curve;
pub mod exact;
pub mod index;
mod levels;
pub mod offset;
mod simplify;
mod vec2;

pub use arc_view::ArcView;
pub use clear::{Blocked, FreePoint, ProhibitedRegion, Side};
pub use curve::Curve;
pub use exact::arc::{Arc, Turn};
pub use exact::convex::Convex;
pub use exact::lattice::{Coord, Height, LatticeError, Length, Place, Point, UNITS_PER_MM, Vector};
pub use exact::region::Region;
pub use exact::ring::Ring;
pub use exact::segment::{Proximity, Segment, Triangle};
pub use index::{Cells, CheckedIndex, Edge, Nearest};
pub use levels::{HeightField, Levels, LevelsError};
pub use vec2::Vec2;
