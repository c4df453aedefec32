//! Reasons why there is no finishing toolpath, or the certificate refuses one.

use keepout_kernel::Point;
use keepout_kernel::offset::{Gouge, Missing};
use thiserror::Error;

/// Reason why the planner finds no finishing toolpath.
#[derive(Debug, Error, PartialEq)]
pub enum FinishError {
    /// The tool fits nowhere.
    #[error(
        "a tool of {diameter_mm:.3} mm diameter fits nowhere on this side of the profile. \
         Take a smaller tool, or the other --side.{}",
        largest_mm.map_or(String::new(), |mm| format!(" The largest tool that fits has {mm:.2} mm."))
    )]
    ToolFitsNowhere {
        /// The tool's diameter, mm.
        diameter_mm: f64,
        /// Diameter of the largest tool that fits somewhere on this side, mm, if the search finds one.
        largest_mm: Option<f64>,
    },
    /// The search could not close the toolpath.
    #[error(
        "no closed path was found near {at}: {count} loose ends. \
         This is a limit of the path search, not of the drawing. Change the tool diameter by 0.01 mm."
    )]
    LooseEnds {
        /// Place near the first loose end.
        at: Point,
        /// Number of loose ends.
        count: usize,
    },
}

/// Reason why the certificate refuses a finishing toolpath.
#[derive(Debug, Error, PartialEq)]
pub enum PathRefusal {
    /// A motion comes too near the part.
    #[error("loop {number}: {gouge}")]
    Gouge {
        /// The loop, from 1.
        number: usize,
        /// The motion.
        gouge: Gouge,
    },
    /// A loop does not close, or has no motion.
    #[error("loop {number} does not close")]
    OpenLoop {
        /// The loop, from 1.
        number: usize,
    },
    /// A motion of a loop does not run beside the part. It would cut where no contour needs finishing.
    #[error("loop {number}: the motion near {at} is not beside the part")]
    Elsewhere {
        /// The loop, from 1.
        number: usize,
        /// Place on the motion.
        at: Point,
    },
    /// A loop has the part on its right. The tool would cut in the wrong direction.
    #[error("loop {number} goes the wrong way round")]
    WrongWay {
        /// The loop, from 1.
        number: usize,
    },
    /// A loop states a free space in which it does not lie. A job would look for it in the wrong free
    /// space.
    #[error("loop {number} lies in free space {found}, but the plan states {said}")]
    WrongSpace {
        /// The loop, from 1.
        number: usize,
        /// The free space in which it lies, as [`crate::finish::FinishingLoop::component`].
        found: usize,
        /// The free space that the plan states.
        said: usize,
    },
    /// A part of the profile that the tool can touch has no toolpath beside it.
    #[error("{0}")]
    Incomplete(Missing),
    /// The stated rest material or contour length is impossible.
    #[error(
        "the plan file is inconsistent: it states {residual_mm} mm{} of rest material \
         and {said_mm} mm of contour, and the contour is {length_mm:.3} mm long. \
         Make the plan again from the drawing.",
        area_mm2.map_or(String::new(), |area| format!(" ({area} mm²)"))
    )]
    Residual {
        /// Stated rest material, mm of contour.
        residual_mm: f64,
        /// Stated length of the contour, mm.
        said_mm: f64,
        /// Stated area of the rest material, mm².
        area_mm2: Option<f64>,
        /// True length of the contour, mm.
        length_mm: f64,
    },
}
