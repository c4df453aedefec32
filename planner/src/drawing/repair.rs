//! Repairs of a drawing that make contours of it, and problems that keep contours open.

use keepout_kernel::Point;

use super::Origin;

/// A change in the drawing that helps to make contours of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Repair {
    /// Two ends were moved together.
    GapClosed {
        /// The place, after the repair.
        at: Point,
        /// Distance between the ends before the repair.
        gap_mm: f64,
    },
    /// A piece no longer than the joining tolerance, with a loose end, was left out.
    TinyDropped {
        /// The start of the piece.
        at: Point,
        /// Its length.
        length_mm: f64,
    },
    /// Pieces without length were left out.
    ZeroLength {
        /// The place of the first.
        at: Point,
        /// Number of pieces.
        count: usize,
    },
    /// A curve that repeats another was left out.
    DuplicateDropped {
        /// The start of the curve.
        at: Point,
        /// Its length.
        length_mm: f64,
    },
    /// A crossing within a contour, smaller than the joining tolerance, was removed.
    CrossingRemoved {
        /// The place where the contour crossed itself.
        at: Point,
        /// Length of the curves that were removed.
        length_mm: f64,
    },
    /// A line drawn there and back, which encloses no area, was left out.
    ThereAndBack {
        /// Its start.
        at: Point,
        /// Its length, one way.
        length_mm: f64,
    },
    /// Lines that overlap were merged.
    OverlapMerged {
        /// The start of the merged line.
        at: Point,
        /// Its length.
        length_mm: f64,
        /// Number of lines before the repair.
        count: usize,
    },
}

impl Repair {
    /// The place of the repair.
    #[must_use]
    pub fn at(&self) -> Point {
        match *self {
            Self::GapClosed { at, .. }
            | Self::TinyDropped { at, .. }
            | Self::ZeroLength { at, .. }
            | Self::DuplicateDropped { at, .. }
            | Self::ThereAndBack { at, .. }
            | Self::CrossingRemoved { at, .. }
            | Self::OverlapMerged { at, .. } => at,
        }
    }
}

impl std::fmt::Display for Repair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let at = self.at();
        match self {
            Self::GapClosed { gap_mm, .. } => write!(f, "gap of {gap_mm:.5} mm closed at {at}"),
            Self::TinyDropped { length_mm, .. } => {
                write!(f, "loose piece of {length_mm:.5} mm left out at {at}")
            }
            Self::ZeroLength { count, .. } => {
                write!(f, "{count} pieces without length left out, the first at {at}")
            }
            Self::DuplicateDropped { length_mm, .. } => {
                write!(f, "doubled curve of {length_mm:.3} mm left out at {at}")
            }
            Self::CrossingRemoved { length_mm, .. } => {
                write!(f, "crossing of {length_mm:.5} mm removed at {at}")
            }
            Self::ThereAndBack { length_mm, .. } => {
                write!(f, "line of {length_mm:.3} mm drawn there and back left out at {at}")
            }
            Self::OverlapMerged { length_mm, count, .. } => {
                write!(f, "{count} overlapping lines merged into one of {length_mm:.3} mm at {at}")
            }
        }
    }
}

/// A fault of the drawing that keeps a contour open.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// A chain of curves ends without a curve to join.
    Open {
        /// The curve with the loose end.
        origin: Box<Origin>,
        /// The loose end.
        at: Point,
        /// Distance to the nearest other loose end, if there is one and it was measured.
        gap_mm: Option<f64>,
    },
    /// A chain ends on the middle of another curve.
    Tee {
        /// The curve that ends.
        origin: Box<Origin>,
        /// The curve that it ends on.
        on: Box<Origin>,
        /// The place.
        at: Point,
    },
    /// More than two curves meet.
    Branch {
        /// One of the curves.
        origin: Box<Origin>,
        /// The place where they meet.
        at: Point,
        /// Number of ends that meet.
        count: usize,
    },
}

impl Problem {
    /// The place of the problem.
    #[must_use]
    pub fn at(&self) -> Point {
        match *self {
            Self::Open { at, .. } | Self::Tee { at, .. } | Self::Branch { at, .. } => at,
        }
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let at = self.at();
        match self {
            Self::Open { origin, gap_mm, .. } => {
                let other = match gap_mm {
                    Some(gap) => format!("the nearest other loose end is {gap:.3} mm away"),
                    None => "there is no other loose end".into(),
                };
                write!(
                    f,
                    "open contour: {origin} ends at {at} with nothing to join; {other}. Close it in the CAD \
                     system, or allow the gap with --join-mm."
                )
            }
            Self::Tee { origin, on, .. } => write!(
                f,
                "{origin} ends at {at} on the middle of {on}: the course of the contour is ambiguous there. \
                 Trim or delete one of them in the CAD system, or choose layers with --layer."
            ),
            Self::Branch { origin, count, .. } => write!(
                f,
                "{count} curve ends meet at {at}, one of them {origin}: the course of the contours is \
                 ambiguous there. Remove doubled or construction lines, choose layers with --layer, or lower \
                 --join-mm if the drawing has details that small."
            ),
        }
    }
}
