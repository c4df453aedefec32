//! What was changed in a drawing to make contours of it, and what keeps others from being closed.

use keepout_kernel::Point;

use super::Origin;

/// Something that was changed in the drawing to make contours of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Repair {
    /// Two ends were moved together.
    GapClosed {
        /// Where, after the repair.
        at: Point,
        /// How far apart the ends were.
        gap_mm: f64,
    },
    /// A piece no longer than the joining tolerance, with a loose end, was left out.
    TinyDropped {
        /// Where it began.
        at: Point,
        /// Its length.
        length_mm: f64,
    },
    /// Pieces without length were left out.
    ZeroLength {
        /// Where the first was.
        at: Point,
        /// How many there were.
        count: usize,
    },
    /// A curve that repeats another was left out.
    DuplicateDropped {
        /// Where it began.
        at: Point,
        /// Its length.
        length_mm: f64,
    },
    /// Lines that lie partly on each other were made one.
    OverlapMerged {
        /// Where the common line begins.
        at: Point,
        /// Its length.
        length_mm: f64,
        /// How many lines there were.
        count: usize,
    },
}

impl Repair {
    /// Where it was made.
    #[must_use]
    pub fn at(&self) -> Point {
        match *self {
            Self::GapClosed { at, .. }
            | Self::TinyDropped { at, .. }
            | Self::ZeroLength { at, .. }
            | Self::DuplicateDropped { at, .. }
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
            Self::OverlapMerged { length_mm, count, .. } => {
                write!(f, "{count} overlapping lines made one of {length_mm:.3} mm at {at}")
            }
        }
    }
}

/// Something that keeps a contour from being closed.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// A chain of curves ends with nothing to join.
    Open {
        /// The curve with the loose end.
        origin: Box<Origin>,
        /// The loose end.
        at: Point,
        /// Distance to the nearest other loose end, if there is one.
        gap_mm: Option<f64>,
    },
    /// A chain ends on the middle of another curve.
    Tee {
        /// The curve that ends.
        origin: Box<Origin>,
        /// The curve that it ends on.
        on: Box<Origin>,
        /// Where.
        at: Point,
    },
    /// More than two curves meet.
    Branch {
        /// One of the curves.
        origin: Box<Origin>,
        /// Where they meet.
        at: Point,
        /// How many ends meet.
        count: usize,
    },
}

impl Problem {
    /// Where it is.
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
                    "open contour: {origin} ends at {at} with nothing to join; {other}. Close it in the CAD system, allow \
                     the gap with --join-mm, or leave open curves out with --leave-out-open."
                )
            }
            Self::Tee { origin, on, .. } => write!(
                f,
                "{origin} ends at {at} on the middle of {on}: which way the contour goes on is not decided. Trim or \
                 delete one of them in the CAD system, choose layers with --layer, or leave open curves out with \
                 --leave-out-open."
            ),
            Self::Branch { origin, count, .. } => write!(
                f,
                "{count} curve ends meet at {at}, one of them {origin}: which contour goes on where is not decided. \
                 Remove doubled or construction lines, choose layers with --layer, or lower --join-mm when the drawing \
                 has details that small."
            ),
        }
    }
}
