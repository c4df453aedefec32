//! A path as the simulated interpolator sends it to the drives: slower at corners, from rest to rest.

use keepout_planner::machine::MachineProfile;
use keepout_planner::{Mm2, Mm3};

use crate::Axes;
use crate::interpolator::{Drives, QueuedMotion};
use crate::path::{Path, PathPiece};
use crate::profile::{DriveProfile, Interpolator};
use crate::reference::{AT_REST, ReferenceSample};
use crate::stream::Stream;

/// A path of straight blocks, and its samples.
#[derive(Clone, Debug)]
pub struct Interpolated {
    /// The path, in pulses.
    pub path: Path,
    /// The samples from rest to rest, and [`SETTLES_S`] more.
    pub samples: Vec<ReferenceSample>,
}

/// Time for which the reference stays at the end of the path, s.
pub const SETTLES_S: f64 = 0.5;

/// Interpolates straight blocks through `points_mm` at `feed_mm_s`. The first point is the start.
#[must_use]
pub fn interpolated(
    points_mm: &[Mm2],
    feed_mm_s: f64,
    interpolator: &Interpolator,
    profile: &DriveProfile,
) -> Interpolated {
    let pulses = |at: Mm3| Axes::new(at.x, at.y) * profile.pulses_per_mm;
    let in_space = |point: Mm2| point.at_height(0.0);
    let start = in_space(points_mm.first().copied().unwrap_or_default());
    let machine = MachineProfile {
        max_rate_mm_s: interpolator.max_rate_mm_s,
        acceleration_mm_s2: interpolator.acceleration_mm_s2,
        ..MachineProfile::simulated()
    };
    let mut motion = QueuedMotion::new(Drives::of(&machine, interpolator.junction_deviation_mm), start);
    for &point in points_mm.iter().skip(1) {
        motion.push(in_space(point), feed_mm_s, 1e-9);
    }
    let mut stream = Stream::at_rest(pulses(start), AT_REST).keeping_all();
    while motion.queued() > 0 {
        motion.advance(profile.period_s, |corner, _| stream.pass(pulses(corner)));
        stream.pass(pulses(motion.position()));
        stream.tick(profile.period_s);
    }
    let mut rests = 0.0;
    while rests < SETTLES_S {
        stream.tick(profile.period_s);
        rests += profile.period_s;
    }
    let lines = points_mm
        .windows(2)
        .map(|pair| PathPiece::Line { from: pulses(in_space(pair[0])), to: pulses(in_space(pair[1])) });
    Interpolated { path: Path::of(lines.collect()), samples: stream.samples().to_vec() }
}
