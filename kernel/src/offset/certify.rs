//! The certificate "no gouge": every motion of a path keeps its distance from the part.
//!
//! Implements SR-02, SR-12.

use core::fmt;

use crate::clear::{Blocked, FreePoint, ProhibitedRegion};
use crate::curve::Curve;
use crate::exact::arc::ArcError;
use crate::exact::lattice::{Length, Point};

/// Distance between an arc of a path and its chords, in lattice units (0.1 µm). [`certify_path`] adds it to
/// the threshold.
pub const PATH_CHORD_ERROR: i64 = 10;

/// The shortest distance between the ends of an arc: 10 µm, or 20 ppm of the radius if that is more. A path
/// uses a line for a shorter arc, because controllers with 32-bit floats can take it for a full circle.
#[must_use]
pub fn shortest_arc(radius: Length) -> Length {
    let units = (i64::from(radius.units()) / 50_000).max(1_000);
    Length::from_units(units).unwrap_or(radius)
}

/// A motion of a path that has no certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gouge {
    /// Index of the curve in the path.
    pub index: usize,
    /// The start of the refused motion, or of the refused chord of an arc. For a gap: the end of the motion
    /// before.
    pub at: Point,
    /// The cause.
    pub cause: GougeCause,
}

/// Why a motion of a path has no certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GougeCause {
    /// The motion comes too near the part.
    Blocked(Blocked),
    /// The curve does not begin at the end of the curve before it.
    Discontinuous,
    /// The arc has no chords that pass their check.
    Arc(ArcError),
}

impl fmt::Display for Gouge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Motions count from 1 in messages, like loops and passes.
        let number = self.index.saturating_add(1);
        match &self.cause {
            GougeCause::Blocked(blocked) => write!(f, "motion {number} of the path: {blocked}"),
            GougeCause::Discontinuous => {
                write!(f, "motion {number} of the path does not begin where the one before it ends")
            }
            GougeCause::Arc(error) => write!(f, "motion {number} of the path: {error}"),
        }
    }
}

impl core::error::Error for Gouge {}

/// Certifies that the whole path stays farther than `threshold` from the part.
///
/// All tests use `threshold` plus [`PATH_CHORD_ERROR`]. An arc is tested whole first. If that does not prove
/// it clear, its checked chords are tested instead. Returns the free point at the end of the path, or `None`
/// for an empty path.
///
/// # Errors
/// [`Gouge`] for the first motion without a certificate.
pub fn certify_path(
    part: &ProhibitedRegion,
    threshold: Length,
    path: &[Curve],
) -> Result<Option<FreePoint>, Gouge> {
    let chord_error = Length::from_units(PATH_CHORD_ERROR).unwrap_or(Length::ZERO);
    let mut end: Option<FreePoint> = None;
    for (index, curve) in path.iter().enumerate() {
        let refuse = |at, cause| Gouge { index, at, cause };
        let mut free = match end {
            Some(free) if free.point() == curve.from() => free,
            Some(free) => return Err(refuse(free.point(), GougeCause::Discontinuous)),
            None => threshold
                .plus(chord_error)
                .map_err(|_| Blocked::StartTooNear(curve.from()))
                .and_then(|start| part.free_point(curve.from(), start))
                .map_err(|blocked| refuse(curve.from(), GougeCause::Blocked(blocked)))?,
        };
        if let Curve::Arc(arc) = curve
            && let Ok(swept) = part.arc(free, arc)
        {
            end = Some(swept);
            continue;
        }
        // A line, or an arc that the first test did not prove clear. Its chords locate the place.
        let points =
            curve.chord_points(chord_error).map_err(|error| refuse(curve.from(), GougeCause::Arc(error)))?;
        for &point in points.iter().skip(1) {
            free = part
                .motion(free, point)
                .map_err(|blocked| refuse(free.point(), GougeCause::Blocked(blocked)))?;
        }
        end = Some(free);
    }
    Ok(end)
}
