//! The profile: closed loops of lines and arcs on the lattice, and the part they bound.
//!
//! Implements SR-02, SR-04.

use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::exact::region::RegionError;
use keepout_kernel::exact::ring::{Piece, RingError};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::Outline;
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Chord-error bound of the chords of a curve: 0.1 µm.
pub const CHORD_ERROR: Length = Length::small(10);

/// Chord-error bound of the checked chords of an arc, 0.2 µm: [`CHORD_ERROR`] and rounding.
pub const ARC_CHORD_ERROR: Length = Length::small(20);
/// Largest chord-error bound between a spline or ellipse and its edges: 1 mm.
const CHORD_ERROR_MAX: Length = Length::whole_mm(1);
/// Largest number of chords of the arcs of one contour.
const CHORDS_MAX: usize = 16_000_000;

/// An edge of the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfileEdge {
    /// The curve.
    #[serde(with = "crate::stored")]
    pub curve: Curve,
    /// Chord-error bound: the largest distance between the edge and the spline or ellipse that it replaces.
    /// Zero for lines and arcs of the drawing.
    #[serde(with = "crate::stored")]
    pub chord_error: Length,
}

impl ProfileEdge {
    fn is_exact(&self) -> bool {
        self.chord_error == Length::ZERO
    }
}

/// A spline or ellipse of the drawing that edges replace, within their chord-error bound.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceCurve {
    /// The curve, in the direction of the loop.
    #[serde(with = "crate::stored")]
    pub curve: Bezier,
    /// Index of the first edge.
    pub first: usize,
    /// Index after the last edge.
    pub end: usize,
}

/// A closed loop of edges. Each edge begins where the previous one ends.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfileLoop {
    /// The edges in order.
    pub edges: Vec<ProfileEdge>,
    /// The splines and ellipses that some of the edges replace.
    pub sources: Vec<SourceCurve>,
}

/// The closed loops taken from the drawing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Profile {
    /// The loops.
    pub loops: Vec<ProfileLoop>,
}

/// The side of the profile that is machined, from the user's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MachinedSide {
    /// The tool stays outside: the part is inside the profile.
    Outside,
    /// The tool stays inside: the part is outside the profile.
    Inside,
}

impl From<MachinedSide> for Side {
    fn from(side: MachinedSide) -> Self {
        match side {
            MachinedSide::Outside => Self::Outside,
            MachinedSide::Inside => Self::Inside,
        }
    }
}

/// Reasons why loops bound no part.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum ProfileError {
    /// A contour crosses or touches itself.
    #[error("a contour crosses or touches itself at {at}. Trim the curves there in the CAD system.")]
    SelfContact {
        /// The place.
        at: Point,
    },
    /// Two contours cross or touch.
    #[error(
        "two contours cross or touch at {at}. Separate or join them in the CAD system, or choose layers with \
         --layer."
    )]
    ContoursTouch {
        /// The place.
        at: Point,
    },
    /// Lines and arcs do not follow the spline or ellipse that they replace.
    #[error(
        "near {at} the contour's lines and arcs leave their spline or ellipse by more than the stated chord \
         error. Make the plan again from the drawing."
    )]
    Curve {
        /// The place.
        at: Point,
    },
    /// A loop is not a contour: it has too few edges, or no width.
    #[error("a contour near {at} is no closed shape: {reason}. Remove it in the CAD system.")]
    Degenerate {
        /// A point of the loop.
        at: Point,
        /// The fault.
        reason: String,
    },
    /// The drawing has more edges than the index can hold.
    #[error("the drawing is too large: {reason}. Leave out layers with --layer.")]
    TooLarge {
        /// The limit that the drawing exceeds.
        reason: String,
    },
    /// The profile has no loop.
    #[error(
        "the drawing has no closed contour. Draw one, choose other layers with --layer, or lower --join-mm \
         if the contour is that small."
    )]
    Empty,
}

impl ProfileError {
    /// The place of the fault, if it has one.
    #[must_use]
    pub fn at(&self) -> Option<Point> {
        match *self {
            Self::SelfContact { at }
            | Self::ContoursTouch { at }
            | Self::Curve { at }
            | Self::Degenerate { at, .. } => Some(at),
            Self::TooLarge { .. } | Self::Empty => None,
        }
    }
}

impl Profile {
    /// The part that the profile bounds.
    ///
    /// The check compares chords with every arc, and arcs and lines with every spline and ellipse that they
    /// replace. The loops of `zones` enclose keep-out zones, which are prohibited, too.
    ///
    /// # Errors
    /// [`ProfileError`] with the place of the first fault.
    pub fn part(&self, side: MachinedSide, zones: &Self) -> Result<ProhibitedRegion, ProfileError> {
        let region = Region::new(self.rings()?).map_err(|error| match error {
            RegionError::Empty => ProfileError::Empty,
            RegionError::RingsTouch { at, .. } => ProfileError::ContoursTouch { at },
        })?;
        ProhibitedRegion::with_zones(region, side.into(), zones.rings()?)
            .map_err(|error| ProfileError::TooLarge { reason: error.to_string() })
    }

    fn rings(&self) -> Result<Vec<Ring>, ProfileError> {
        let rings: Vec<_> = self.loops.par_iter().map(ProfileLoop::ring).collect();
        // The first loop with a fault is named, whichever was checked first.
        rings.into_iter().collect()
    }

    /// The largest chord-error bound of an edge.
    #[must_use]
    pub fn chord_error(&self) -> Length {
        let edges = self.loops.iter().flat_map(|each| &each.edges);
        edges.map(|edge| edge.chord_error).max().unwrap_or(Length::ZERO)
    }

    /// The number of pieces of splines and ellipses that edges replace.
    #[must_use]
    pub fn source_count(&self) -> usize {
        self.loops.iter().map(|each| each.sources.len()).sum()
    }

    /// The loops as outlines for offsetting. Each states the side on which the tool is.
    #[must_use]
    pub fn outlines(&self, part: &ProhibitedRegion) -> Vec<Outline> {
        let depths = part.region().depths();
        let rings = part.region().rings().iter().zip(depths);
        let outline = |(each, (ring, depth)): (&ProfileLoop, (&Ring, usize))| {
            let counter_clockwise = ring.double_area() > 0;
            let material_inside = (depth % 2 == 0) == (part.side() == Side::Outside);
            Outline {
                curves: each.edges.iter().map(|edge| edge.curve).collect(),
                free_on_left: counter_clockwise != material_inside,
            }
        };
        self.loops.iter().zip(rings).map(outline).collect()
    }
}

/// The outlines that bound free space, for [`keepout_kernel::offset::certify_complete`]: those of the
/// profile, and the outsides of the keep-out zones.
#[must_use]
pub fn free_outlines(profile: &Profile, zones: &Profile, part: &ProhibitedRegion) -> Vec<Outline> {
    let mut outlines = profile.outlines(part);
    outlines.extend(zones.loops.iter().zip(part.zones()).map(|(each, ring)| Outline {
        curves: each.edges.iter().map(|edge| edge.curve).collect(),
        free_on_left: ring.double_area() < 0,
    }));
    outlines
}

/// The corners of the chords of closed curves within `chord_error`, each once. A curve without such chords
/// has only its ends as corners.
pub(crate) fn corners<'a>(curves: impl Iterator<Item = &'a Curve>, chord_error: Length) -> Vec<Point> {
    let mut corners = Vec::new();
    for curve in curves {
        corners.extend(curve.chord_points(chord_error).unwrap_or_else(|_| vec![curve.from(), curve.to()]));
        corners.pop();
    }
    corners
}

impl ProfileLoop {
    /// Its curves.
    pub(crate) fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.edges.iter().map(|edge| &edge.curve)
    }

    /// The loop as a box, if it is a rectangle along the axes.
    #[must_use]
    pub fn rectangle(&self) -> Option<Window> {
        let corners: Vec<Point> = self.edges.iter().map(|edge| edge.curve.from()).collect();
        let window = corners.iter().map(|&corner| Window::of(corner)).reduce(Window::union)?;
        let along = |edge: &ProfileEdge| match edge.curve {
            Curve::Line(Segment { from, to }) => from.x == to.x || from.y == to.y,
            Curve::Arc(_) => false,
        };
        (corners.len() == 4 && self.edges.iter().all(along)).then_some(window)
    }

    /// Whether the loop is two arcs around one centre: a circle.
    pub(crate) fn is_round(&self) -> bool {
        let [one, other] = &self.edges[..] else { return false };
        let centre =
            |edge: &ProfileEdge| if let Curve::Arc(arc) = &edge.curve { Some(arc.centre()) } else { None };
        centre(one).is_some() && centre(one) == centre(other)
    }

    /// Whether the loop is a line drawn there and back, which encloses no area.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        matches!(
            self.edges[..],
            [ProfileEdge { curve: Curve::Line(_), .. }, ProfileEdge { curve: Curve::Line(_), .. }]
        )
    }

    /// Checks that each edge with a chord-error bound replaces exactly one source curve, and that each source
    /// curve follows the chain of its edges within the least of their bounds ([`Bezier::follows`]).
    fn check_sources(&self) -> Result<(), ProfileError> {
        let mut checked = 0;
        for source in &self.sources {
            let at = source.curve.control().first().copied().unwrap_or(Point::ORIGIN);
            // Sources are in order and do not overlap, so the number of edges bounds the work. Edges between
            // them must be exact.
            let before = self.edges.get(checked..source.first).ok_or(ProfileError::Curve { at })?;
            let edges = self.edges.get(source.first..source.end).ok_or(ProfileError::Curve { at })?;
            let chord_error = edges
                .iter()
                .map(|edge| edge.chord_error)
                .min()
                .filter(|chord_error| *chord_error <= CHORD_ERROR_MAX);
            let chord_error = chord_error.filter(|_| before.iter().all(ProfileEdge::is_exact));
            let chord_error = chord_error.ok_or(ProfileError::Curve { at })?;
            let chain: Vec<Curve> = edges.iter().map(|edge| edge.curve).collect();
            source
                .curve
                .follows(&chain, chord_error)
                .map_err(|stray| ProfileError::Curve { at: stray.at })?;
            checked = source.end;
        }
        match self.edges.iter().skip(checked).find(|edge| !edge.is_exact()) {
            Some(edge) => Err(ProfileError::Curve { at: edge.curve.from() }),
            None => Ok(()),
        }
    }

    /// The loop as a closed simple polygon of checked chords.
    ///
    /// # Errors
    /// [`ProfileError`] with the place of the first fault.
    pub fn ring(&self) -> Result<Ring, ProfileError> {
        self.check_sources()?;
        let at = self.edges.first().map_or(Point::ORIGIN, |edge| edge.curve.from());
        let degenerate = |reason: String| ProfileError::Degenerate { at, reason };
        let mut chords = 0;
        let mut pieces = Vec::with_capacity(self.edges.len());
        for edge in &self.edges {
            let piece = edge
                .curve
                .piece(CHORD_ERROR, edge.chord_error)
                .map_err(|error| degenerate(error.to_string()))?;
            if let Piece::Arc { chords: arc, .. } = &piece {
                if arc.chord_error() > ARC_CHORD_ERROR {
                    return Err(degenerate(
                        "an arc leaves its chords by more than the chord-error bound".into(),
                    ));
                }
                chords += arc.points().len();
            }
            if chords > CHORDS_MAX {
                let reason = format!("a contour has arcs of more than {CHORDS_MAX} chords");
                return Err(ProfileError::TooLarge { reason });
            }
            pieces.push(piece);
        }
        Ring::from_pieces(&pieces).map_err(|error| match error {
            RingError::Contact(contact) => ProfileError::SelfContact { at: contact.at },
            other => degenerate(other.to_string()),
        })
    }
}
