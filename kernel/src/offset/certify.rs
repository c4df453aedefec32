//! The certificate "no gouge": every motion of a path keeps its distance.

use core::fmt;

use crate::clear::{Blocked, FreePoint, ProhibitedRegion};
use crate::curve::Curve;
use crate::exact::arc::ArcError;
use crate::exact::lattice::{Length, Point};

/// An arc of a path is certified as chords within this distance of it, in lattice units (0.1 µm).
pub const PATH_CHORD_ERROR: i64 = 10;

/// An arc whose ends are this near or nearer is given as a line: controllers that compute in 32-bit floats can take it
/// for a full circle. 10 µm, or 20 ppm of the radius when that is more.
#[must_use]
pub fn shortest_arc(radius: Length) -> Length {
    let units = (i64::from(radius.units()) / 50_000).max(1_000);
    Length::from_units(units).unwrap_or(radius)
}

/// A motion of a path that could not be certified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gouge {
    /// Index of the curve in the path.
    pub index: usize,
    /// Where the refused motion begins.
    pub at: Point,
    /// Why.
    pub cause: GougeCause,
}

/// Why a motion of a path was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GougeCause {
    /// It comes too near the part.
    Blocked(Blocked),
    /// The curve does not begin where the one before it ended.
    Discontinuous,
    /// An arc could not be turned into checked chords.
    Arc(ArcError),
}

impl fmt::Display for Gouge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            GougeCause::Blocked(blocked) => write!(f, "motion {} of the path: {blocked}", self.index),
            GougeCause::Discontinuous => {
                write!(f, "motion {} does not begin where the one before it ends", self.index)
            }
            GougeCause::Arc(error) => write!(f, "motion {}: {error}", self.index),
        }
    }
}

impl core::error::Error for Gouge {}

/// Certifies that the whole path stays farther than `threshold` from the part.
///
/// Arcs are asked whole; one that is not proven clear that way is taken as checked chords, asked with [`PATH_CHORD_ERROR`] more.
/// Returns the free point at the path's end, or `None` for an empty path.
///
/// # Errors
/// [`Gouge`] for the first motion that is refused.
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
        // A line; or an arc that is not proven clear at once, whose chords tell the place.
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
