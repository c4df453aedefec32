//! The profile: closed loops of lines and arcs on the lattice, and the part they bound.

use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::exact::region::RegionError;
use keepout_kernel::exact::ring::{Piece, RingError};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::Outline;
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How far a curve may leave its chords: 0.1 µm.
pub const CHORD_SLACK: Length = Length::small(10);

/// What arcs leave their checked chords by at most: the sagitta asked for, and what rounding adds.
pub const ARC_CHORD_SLACK: Length = Length::small(20);
/// Most that edges may leave the curves they stand for by: 1 mm.
const SLACK_MAX: Length = Length::whole_mm(1);
/// Chords of one contour's arcs that are held.
const CHORDS_MAX: usize = 16_000_000;

/// An edge of the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfileEdge {
    /// The curve.
    #[serde(with = "crate::stored")]
    pub curve: Curve,
    /// How far the drawing's curve leaves a line that stands for it; zero for true lines and arcs.
    #[serde(with = "crate::stored")]
    pub chord_error: Length,
}

impl ProfileEdge {
    fn is_exact(&self) -> bool {
        self.chord_error == Length::ZERO
    }
}

/// A curve of the drawing that edges stand for, within their chord_error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceCurve {
    /// The curve, in the direction of the loop.
    #[serde(with = "crate::stored")]
    pub curve: Bezier,
    /// The first of the edges.
    pub first: usize,
    /// One past the last.
    pub end: usize,
}

/// A closed loop of edges, each beginning where the one before ends.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfileLoop {
    /// The edges in order.
    pub edges: Vec<ProfileEdge>,
    /// The splines and ellipses that some of them stand for.
    pub sources: Vec<SourceCurve>,
}

/// Closed loops taken from the drawing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Profile {
    /// The loops.
    pub loops: Vec<ProfileLoop>,
}

/// Which side of the profile is machined, as the user says it.
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

/// Why loops make no part.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum ProfileError {
    /// A contour crosses or touches itself.
    #[error("a contour crosses or touches itself at {at}. Trim the curves there in the CAD system.")]
    SelfContact {
        /// Where.
        at: Point,
    },
    /// Two contours cross or touch.
    #[error(
        "two contours cross or touch at {at}. Separate or join them in the CAD system, or choose layers with --layer."
    )]
    ContoursTouch {
        /// Where.
        at: Point,
    },
    /// Lines and arcs do not follow the spline or ellipse that they stand for.
    #[error(
        "near {at} the contour's lines and arcs leave the spline or ellipse they stand for by more than is stated"
    )]
    Curve {
        /// Where.
        at: Point,
    },
    /// A loop is no contour: too few edges, or collapsed.
    #[error("a contour near {at} is no closed shape: {reason}. Remove it in the CAD system.")]
    Degenerate {
        /// A point of it.
        at: Point,
        /// What is wrong.
        reason: String,
    },
    /// More edges than can be indexed.
    #[error("the drawing is too large: {reason}. Leave out layers with --layer.")]
    TooLarge {
        /// What is too large.
        reason: String,
    },
    /// There is no loop.
    #[error(
        "the drawing has no closed contour. Draw one, choose other layers with --layer, or lower --join-mm when it is that small."
    )]
    Empty,
}

impl ProfileError {
    /// Where, when it is anywhere.
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
    /// The part that the profile bounds, from chords checked against every arc, and arcs and lines checked against every
    /// spline and ellipse that they stand for. What the loops of `zones` enclose is prohibited besides.
    ///
    /// # Errors
    /// [`ProfileError`] with the place of the first fault.
    pub fn part(&self, side: MachinedSide, zones: &Self) -> Result<ProhibitedRegion, ProfileError> {
        let zones = zones.loops.iter().map(ProfileLoop::ring).collect::<Result<Vec<_>, _>>()?;
        let rings = self.loops.iter().map(ProfileLoop::ring).collect::<Result<Vec<_>, _>>()?;
        let region = Region::new(rings).map_err(|error| match error {
            RegionError::Empty => ProfileError::Empty,
            RegionError::RingsTouch { at, .. } => ProfileError::ContoursTouch { at },
        })?;
        ProhibitedRegion::with_zones(region, side.into(), zones)
            .map_err(|error| ProfileError::TooLarge { reason: error.to_string() })
    }

    /// The largest chord_error of an edge.
    #[must_use]
    pub fn chord_error(&self) -> Length {
        let edges = self.loops.iter().flat_map(|each| &each.edges);
        edges.map(|edge| edge.chord_error).max().unwrap_or(Length::ZERO)
    }

    /// The number of pieces of splines and ellipses that edges stand for.
    #[must_use]
    pub fn source_count(&self) -> usize {
        self.loops.iter().map(|each| each.sources.len()).sum()
    }

    /// The loops as outlines for offsetting, told on which side of each the tool is.
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

/// The outlines that bound free space, as [`keepout_kernel::offset::certify_complete`] wants them: the profile's, and the
/// zones' from outside.
#[must_use]
pub fn free_outlines(profile: &Profile, zones: &Profile, part: &ProhibitedRegion) -> Vec<Outline> {
    let mut outlines = profile.outlines(part);
    outlines.extend(zones.loops.iter().zip(part.zones()).map(|(each, ring)| Outline {
        curves: each.edges.iter().map(|edge| edge.curve).collect(),
        free_on_left: ring.double_area() < 0,
    }));
    outlines
}

/// The corners of closed curves' chords within `chord_error` of them, each once; only the ends of a curve that has no such chords.
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

    /// The box that the loop is, when it is a rectangle along the axes.
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

    /// Whether it is a line drawn to and fro, which bounds nothing.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        matches!(
            self.edges[..],
            [ProfileEdge { curve: Curve::Line(_), .. }, ProfileEdge { curve: Curve::Line(_), .. }]
        )
    }

    /// Checks that edges stand for curves, each edge with a chord_error for exactly one, and follow them within it: the source follows
    /// the chain of its edges within their least chord_error ([`Bezier::follows`]).
    fn check_sources(&self) -> Result<(), ProfileError> {
        let mut checked = 0;
        for source in &self.sources {
            let at = source.curve.control().first().copied().unwrap_or(Point::ORIGIN);
            // In order and apart, so that the work is bounded by the number of edges; none between them has a chord_error.
            let before = self.edges.get(checked..source.first).ok_or(ProfileError::Curve { at })?;
            let edges = self.edges.get(source.first..source.end).ok_or(ProfileError::Curve { at })?;
            let chord_error = edges
                .iter()
                .map(|edge| edge.chord_error)
                .min()
                .filter(|chord_error| *chord_error <= SLACK_MAX);
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
                .piece(CHORD_SLACK, edge.chord_error)
                .map_err(|error| degenerate(error.to_string()))?;
            if let Piece::Arc { chords: arc, .. } = &piece {
                if arc.chord_error() > ARC_CHORD_SLACK {
                    return Err(degenerate("an arc is not followed closely by its chords".into()));
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
