//! Degenerate profiles by family: sets of edges that no drawing should contain.

use fastrand::Rng;
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::{Edge, Length, Point, Segment};

use crate::properties::Xy;

/// The kind of degeneracy of a set of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// No degeneracy: edges anywhere in a field.
    Scattered,
    /// Edges that occur twice, some of them reversed.
    Duplicates,
    /// Overlapping segments of one line.
    Overlapping,
    /// A straight run of many collinear edges.
    Collinear,
    /// Edges that end in the middle of others.
    TJunctions,
    /// Many edges that leave a few vertices.
    SharedVertices,
    /// Edges of zero length among others.
    ZeroLength,
    /// Long needles a unit or two wide.
    Needles,
    /// Two parallel walls exactly two thresholds apart.
    Slot,
    /// Coordinates at both extremes of the lattice.
    Extremes,
    /// Vertices on a square grid. Thresholds are exact distances of the grid.
    Grid,
    /// Many edges in a few units.
    Crowded,
    /// A part much smaller than the threshold.
    TinyPart,
    /// Edges with chord-error bounds from zero to more than the threshold.
    ChordErrors,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 14] = [
        Self::Scattered,
        Self::Duplicates,
        Self::Overlapping,
        Self::Collinear,
        Self::TJunctions,
        Self::SharedVertices,
        Self::ZeroLength,
        Self::Needles,
        Self::Slot,
        Self::Extremes,
        Self::Grid,
        Self::Crowded,
        Self::TinyPart,
        Self::ChordErrors,
    ];

    /// Random edges of the family, with the threshold for queries.
    pub fn profile(self, random: &mut Rng) -> ProfileCase {
        let count = random.usize(1..=120);
        let mut profile = ProfileCase { edges: Vec::new(), threshold: random.i64(0..=400) };
        self.fill(&mut profile, count, random);
        if profile.edges.is_empty() {
            profile.push((0, 0), (1, 0));
        }
        profile
    }

    fn fill(self, profile: &mut ProfileCase, count: usize, random: &mut Rng) {
        match self {
            Self::Scattered | Self::Duplicates | Self::ZeroLength | Self::ChordErrors => {
                self.scatter(profile, count, random);
            }
            Self::Overlapping | Self::Collinear => self.line(profile, count, random),
            Self::TJunctions | Self::SharedVertices | Self::Needles => self.join(profile, count, random),
            Self::Slot => {
                let half = profile.threshold;
                for x in (0..=random.i64(0..60)).map(|k| k * 50) {
                    profile.push((x, -half), (x + 50, -half));
                    profile.push((x + 50, half), (x, half));
                }
            }
            Self::Extremes => {
                let limit = i64::from(COORD_MAX);
                profile.threshold = *[0, 1, limit / 3, limit].get(count % 4).unwrap_or(&0);
                profile.crowd(count, || match random.u8(0..4) {
                    0 => -limit,
                    1 => limit,
                    2 => limit - random.i64(0..3),
                    _ => random.i64(-limit..=limit),
                });
            }
            Self::Grid => {
                profile.threshold = 25 * random.i64(0..=8);
                profile.crowd(count, || 25 * random.i64(-8..=8));
            }
            Self::Crowded => profile.crowd(count * 4, || random.i64(-6..=6)),
            Self::TinyPart => {
                profile.threshold = random.i64(100_000..=400_000);
                profile.crowd(count, || random.i64(-40..=40));
            }
        }
    }

    /// Short edges anywhere in the field, with the family's degeneracy.
    fn scatter(self, profile: &mut ProfileCase, count: usize, random: &mut Rng) {
        for k in 0..count {
            let (a, b) = (anywhere(random), anywhere(random));
            let b = (a.0 + b.0 / 20, a.1 + b.1 / 20);
            match self {
                Self::Duplicates => {
                    profile.push(a, b);
                    if k % 2 == 0 { profile.push(b, a) } else { profile.push(a, b) }
                }
                Self::ZeroLength if k % 3 == 0 => profile.push(a, a),
                _ => profile.push(a, b),
            }
        }
        if self == Self::ChordErrors {
            for edge in &mut profile.edges {
                edge.chord_error = length(if random.bool() { 0 } else { random.i64(0..=900) });
            }
        }
    }

    /// Segments of one line: end to end for `Collinear`, otherwise anywhere on the line.
    fn line(self, profile: &mut ProfileCase, count: usize, random: &mut Rng) {
        let (origin, (dx, dy)) = (anywhere(random), (random.i64(-9..=9), random.i64(-9..=9)));
        let along = |k: i64| (origin.0 + dx * k, origin.1 + dy * k);
        let mut k = 0;
        for _ in 0..count {
            let from = if self == Self::Collinear { k } else { random.i64(-200..=200) };
            k = from + random.i64(1..=20);
            profile.push(along(from), along(k));
        }
    }

    /// Edges that share points as the family prescribes.
    fn join(self, profile: &mut ProfileCase, count: usize, random: &mut Rng) {
        let hubs: Vec<Xy> = (0..4).map(|_| anywhere(random)).collect();
        for k in 0..count {
            let (a, b) = (anywhere(random), anywhere(random));
            match self {
                Self::TJunctions => {
                    let (dx, dy) = (b.0 / 75, b.1 / 75);
                    let middle = (a.0 + dx, a.1 + dy);
                    profile.push(a, (a.0 + 4 * dx, a.1 + 4 * dy));
                    profile.push(middle, (middle.0 - 3 * dy, middle.1 + 3 * dx));
                }
                Self::SharedVertices => profile.push(hubs[k % 4], b),
                _ => {
                    profile.push(a, b);
                    profile.push(b, (a.0 + random.i64(-2..=2), a.1 + random.i64(-2..=2)));
                }
            }
        }
    }
}

fn anywhere(random: &mut Rng) -> Xy {
    (random.i64(-3_000..=3_000), random.i64(-3_000..=3_000))
}

/// Edges, and a threshold in lattice units.
#[derive(Clone, Debug)]
pub struct ProfileCase {
    /// The edges.
    pub edges: Vec<Edge>,
    /// The threshold.
    pub threshold: i64,
}

impl ProfileCase {
    fn push(&mut self, a: Xy, b: Xy) {
        self.edges.push(Edge { chord: Segment { from: at(a), to: at(b) }, chord_error: Length::ZERO });
    }

    /// Edges with coordinates drawn one by one.
    fn crowd(&mut self, count: usize, mut coordinate: impl FnMut() -> i64) {
        for _ in 0..count {
            let (a, b) = ((coordinate(), coordinate()), (coordinate(), coordinate()));
            self.push(a, b);
        }
    }

    /// A query point: near the end of an edge, at the threshold from the edge, or anywhere around it.
    pub fn query(&self, random: &mut Rng) -> Xy {
        let edge = &self.edges[random.usize(..self.edges.len())];
        let end = if random.bool() { edge.chord.from } else { edge.chord.to };
        let (x, y) = (i64::from(end.x.units()), i64::from(end.y.units()));
        let r = self.threshold + i64::from(edge.chord_error.units());
        let shift = match random.u8(0..8) {
            0 => (r, 0),
            1 => (0, -r),
            2 => (-r - 1, random.i64(-1..=1)),
            3 => (r * 3 / 5, r * 4 / 5),
            4 => (random.i64(-3..=3), random.i64(-3..=3)),
            5 => {
                let way = edge.chord.to.minus(edge.chord.from);
                (i64::from(way.dx) / 2 - i64::from(way.dy).signum() * r, i64::from(way.dy) / 2)
            }
            _ => (random.i64(-2 * r - 50..=2 * r + 50), random.i64(-2 * r - 50..=2 * r + 50)),
        };
        let limit = i64::from(COORD_MAX);
        ((x + shift.0).clamp(-limit, limit), (y + shift.1).clamp(-limit, limit))
    }
}

/// The lattice point of plain coordinates, clamped to the lattice.
#[must_use]
pub fn at((x, y): Xy) -> Point {
    let limit = i64::from(COORD_MAX);
    Point::from_units(x.clamp(-limit, limit), y.clamp(-limit, limit)).unwrap_or(Point::ORIGIN)
}

/// The length, clamped to the lattice.
#[must_use]
pub fn length(units: i64) -> Length {
    Length::from_units(units.clamp(0, i64::from(COORD_MAX))).unwrap_or(Length::ZERO)
}
