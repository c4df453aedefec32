//! Arcs as chords.
//!
//! Source: `doc/markdown/settings.md`, `$12`: the largest distance of a chord from the arc.

use std::f64::consts::TAU;

use super::axes::Triple;
use super::words::LineErrorCode;

/// An arc in a plane, with a straight motion of the axis across the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArcMotion {
    pub from: Triple,
    pub to: Triple,
    /// The axes of the plane, and the axis across it.
    pub plane: [usize; 3],
    pub clockwise: bool,
}

/// Least sweep, rad. A smaller one is a full turn.
const LEAST_SWEEP: f64 = 5e-7;
/// Most chords of an arc.
const CHORDS_MAX: f64 = 100_000.0;

impl ArcMotion {
    fn ends(&self) -> [[f64; 2]; 2] {
        let [first, second, _] = self.plane;
        [self.from, self.to].map(|place| [place[first], place[second]])
    }

    /// The centre of the arc with this radius. A negative radius asks for the longer arc.
    pub fn centre_of_radius(&self, radius: f64) -> Result<[f64; 2], LineErrorCode> {
        let [[ax, ay], [bx, by]] = self.ends();
        let (dx, dy) = (bx - ax, by - ay);
        let apart = dx.hypot(dy);
        if apart == 0.0 {
            return Err(LineErrorCode::TARGET);
        }
        let height_2 = radius * radius - apart * apart / 4.0;
        if height_2 < 0.0 {
            return Err(LineErrorCode::RADIUS);
        }
        // The centre lies left of the chord for a short counter-clockwise arc.
        let left = self.clockwise == (radius < 0.0);
        let height = if left { height_2.sqrt() } else { -height_2.sqrt() };
        Ok([(ax + bx) / 2.0 - dy / apart * height, (ay + by) / 2.0 + dx / apart * height])
    }

    /// Checks that both ends have the same distance from the centre.
    pub fn check_centre(&self, [cx, cy]: [f64; 2]) -> Result<(), LineErrorCode> {
        let [from, to] = self.ends().map(|[x, y]| (x - cx).hypot(y - cy));
        let error = (to - from).abs();
        if error > 0.5 || error > 0.005 && error > 0.001 * from {
            return Err(LineErrorCode::TARGET);
        }
        Ok(())
    }

    /// The ends of the chords, in order. None leaves the arc by more than the tolerance.
    pub fn chords(&self, [cx, cy]: [f64; 2], tolerance_mm: f64) -> Vec<Triple> {
        let [[ax, ay], [bx, by]] = self.ends();
        let (ux, uy, vx, vy) = (ax - cx, ay - cy, bx - cx, by - cy);
        let mut sweep = (ux * vy - uy * vx).atan2(ux * vx + uy * vy);
        if self.clockwise && sweep >= -LEAST_SWEEP {
            sweep -= TAU;
        } else if !self.clockwise && sweep <= LEAST_SWEEP {
            sweep += TAU;
        }
        let radius = ux.hypot(uy);
        let half = (1.0 - (tolerance_mm / radius.max(tolerance_mm)).min(1.0)).acos();
        let count = (sweep.abs() / (2.0 * half.max(1e-6))).ceil().clamp(1.0, CHORDS_MAX);
        let [first, second, across] = self.plane;
        let mut chords = Vec::new();
        let mut index = 1.0;
        while index < count {
            let share = index / count;
            let (sin, cos) = (sweep * share).sin_cos();
            let mut place = self.from;
            place[first] = cx + ux * cos - uy * sin;
            place[second] = cy + ux * sin + uy * cos;
            place[across] = self.from[across] + (self.to[across] - self.from[across]) * share;
            chords.push(place);
            index += 1.0;
        }
        chords.push(self.to);
        chords
    }
}
