//! The paths of the tool, which give the query points for every index.

use keepout_kernel::index::CheckedIndex;
use keepout_kernel::{Length, Point};

use crate::profiles::{MM, at, mm};

/// The tool's radius and the margin, mm.
pub const RADIUS_MM: f64 = 3.05;
/// The distance between queries of a coherent path, mm.
pub const STEP_MM: f64 = 0.05;

/// The threshold of all queries.
pub fn threshold() -> Length {
    Length::from_units((RADIUS_MM * MM).round() as i64).expect("3.05 mm is a length")
}

/// Kind of path of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathKind {
    /// Along the wall, between the threshold and 4 mm more.
    Approach,
    /// In sliding contact, within 20 µm of the threshold.
    Contact,
    /// Random points in the field.
    Random,
}

impl PathKind {
    pub const ALL: [Self; 3] = [Self::Approach, Self::Contact, Self::Random];

    pub fn name(self) -> &'static str {
        match self {
            Self::Approach => "approach",
            Self::Contact => "contact",
            Self::Random => "random",
        }
    }

    /// `count` query points.
    pub fn points(self, index: &CheckedIndex, field: (f64, f64), count: usize) -> Vec<Point> {
        let mut random = fastrand::Rng::with_seed(7);
        if self == Self::Random {
            let mut anywhere = || at((random.f64() - 0.5) * field.0, (random.f64() - 0.5) * field.1);
            return (0..count).map(|_| anywhere()).collect();
        }
        let mut points = Vec::new();
        let mut here = (field.0 / 2.0 + 10.0, 1.0);
        let mut phase: f64 = 0.0;
        while points.len() < count {
            phase += 0.004;
            let distance = match self {
                Self::Approach => RADIUS_MM + 2.0 * (1.0 - phase.cos()),
                _ => RADIUS_MM + (random.f64() - 0.5) * 0.04,
            };
            here = follow(index, here, distance);
            points.push(at(here.0, here.1));
        }
        points
    }
}

/// One step along the curve at `distance` from the profile. The profile is on the left.
fn follow(index: &CheckedIndex, (x, y): (f64, f64), distance: f64) -> (f64, f64) {
    let away = |p: (f64, f64)| {
        let nearest = index.nearest(at(p.0, p.1), None).expect("there are edges");
        let chord = index.edges()[nearest.edge].chord;
        let (a, b) = (mm(chord.from), mm(chord.to));
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let t = (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        let foot = (a.0 + dx * t, a.1 + dy * t);
        let (nx, ny) = (p.0 - foot.0, p.1 - foot.1);
        let length = nx.hypot(ny).max(1e-9);
        (foot, (nx / length, ny / length))
    };
    let (_, normal) = away((x, y));
    let mut p = (x - normal.1 * STEP_MM, y + normal.0 * STEP_MM);
    for _ in 0..3 {
        let (foot, normal) = away(p);
        p = (foot.0 + normal.0 * distance, foot.1 + normal.1 * distance);
    }
    p
}
