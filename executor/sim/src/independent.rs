//! Non-interpolated axes, each from rest to a target, or from a speed to rest.

use keepout_drives::interpolator::Drives;
use keepout_planner::Mm3;

/// The motion of one axis over time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    from: f64,
    /// Direction, 1 or −1.
    sign: f64,
    length: f64,
    acceleration: f64,
    /// Speed at the beginning, and top speed.
    entry: f64,
    top: f64,
}

impl Axis {
    /// From rest to rest.
    fn go(from: f64, to: f64, speed: f64, acceleration: f64) -> Self {
        let length = (to - from).abs();
        let top = speed.min((acceleration * length).sqrt());
        Self { from, sign: (to - from).signum(), length, acceleration, entry: 0.0, top }
    }

    /// To rest in the shortest distance.
    fn brake(from: f64, velocity: f64, acceleration: f64) -> Self {
        let speed = velocity.abs();
        let length = speed * speed / (2.0 * acceleration);
        Self { from, sign: velocity.signum(), length, acceleration, entry: speed, top: speed }
    }

    /// Durations of acceleration, cruise and deceleration, s.
    fn times(&self) -> (f64, f64, f64) {
        if self.top <= 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let up = (self.top - self.entry) / self.acceleration;
        let down = self.top / self.acceleration;
        let ways = f64::midpoint(self.entry, self.top) * up + self.top / 2.0 * down;
        (up, ((self.length - ways) / self.top).max(0.0), down)
    }

    fn lasts(&self) -> f64 {
        let (up, cruise, down) = self.times();
        up + cruise + down
    }

    fn speed(&self, t: f64) -> f64 {
        let left = (self.lasts() - t).max(0.0);
        (self.entry + self.acceleration * t).min(self.top).min(self.acceleration * left)
    }

    fn at(&self, t: f64) -> f64 {
        let (up, cruise, _) = self.times();
        let left = self.lasts() - t;
        let way = if left <= 0.0 {
            self.length
        } else if t < up {
            (self.entry + self.acceleration * t / 2.0) * t
        } else if t < up + cruise {
            f64::midpoint(self.entry, self.top) * up + self.top * (t - up)
        } else {
            self.length - self.acceleration * left * left / 2.0
        };
        self.from + self.sign * way
    }
}

/// All axes in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Apart {
    axes: [Axis; 3],
    elapsed: f64,
}

/// Largest sampling step of the path, mm and s.
const STEP_MM: f64 = 0.05;
const STEP_S: f64 = 0.005;

impl Apart {
    /// Moves each axis from rest to its target, mm and mm/s.
    pub(super) fn go(from: Mm3, to: Mm3, feed: f64, drives: &Drives) -> Self {
        let [up_rate, up_acceleration] = drives.up;
        let plane = |from, to| Axis::go(from, to, feed.min(drives.max_rate), drives.acceleration);
        let up = Axis::go(from.z, to.z, feed.min(up_rate), up_acceleration);
        Self { axes: [plane(from.x, to.x), plane(from.y, to.y), up], elapsed: 0.0 }
    }

    /// Brakes each axis to rest.
    pub(super) fn brake(from: Mm3, velocity: Mm3, drives: &Drives) -> Self {
        let plane = |from, velocity| Axis::brake(from, velocity, drives.acceleration);
        let up = Axis::brake(from.z, velocity.z, drives.up[1]);
        Self { axes: [plane(from.x, velocity.x), plane(from.y, velocity.y), up], elapsed: 0.0 }
    }

    pub(super) fn position(&self) -> Mm3 {
        let [x, y, z] = self.axes.map(|axis| axis.at(self.elapsed));
        Mm3::new(x, y, z)
    }

    pub(super) fn velocity(&self) -> Mm3 {
        let [x, y, z] = self.axes.map(|axis| axis.sign * axis.speed(self.elapsed));
        Mm3::new(x, y, z)
    }

    /// Time until all axes rest, s.
    pub(super) fn left(&self) -> f64 {
        self.axes.iter().map(Axis::lasts).fold(0.0, f64::max) - self.elapsed
    }

    /// Time to the next sample, s. Straight segments between the samples trace the path.
    pub(super) fn look(&self) -> f64 {
        // The result is at most STEP_S / 5, so this bounds the speed gained until the next sample.
        let [x, y, z] = self.axes;
        let up = if z.length > 0.0 { z.acceleration } else { 0.0 };
        let acceleration = x.acceleration.hypot(y.acceleration).hypot(up);
        let fastest = self.velocity().length() + acceleration * STEP_S / 5.0;
        (STEP_MM / fastest).clamp(1e-5, STEP_S / 5.0)
    }

    pub(super) fn advance(&mut self, dt: f64) {
        self.elapsed += dt;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVES: Drives =
        Drives { max_rate: 30.0, acceleration: 500.0, up: [10.0, 200.0], junction_deviation: 0.01 };

    #[test]
    fn independent_axes_stay_in_the_box_and_arrive() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..500 {
            let mut coordinate = || random.f64() * 20.0 - 10.0;
            let mut point = || Mm3::new(coordinate(), coordinate(), coordinate());
            let (from, to) = (point(), point());
            let mut apart = Apart::go(from, to, 30.0, &DRIVES);
            let (mut last, mut farthest) = (from, 0.0_f64);
            while apart.left() > 0.0 {
                apart.advance(apart.look());
                let at = apart.position();
                let inside = |v: f64, a: f64, b: f64| v >= a.min(b) - 1e-9 && v <= a.max(b) + 1e-9;
                assert!(inside(at.x, from.x, to.x) && inside(at.y, from.y, to.y), "within the box");
                assert!(inside(at.z, from.z, to.z), "between the heights");
                farthest = farthest.max(at.distance(last));
                last = at;
            }
            assert!(last.distance(to) < 1e-9);
            assert!(farthest <= STEP_MM * 1.01, "{farthest}");
        }
    }

    #[test]
    fn braking_ends_within_the_braking_distance() {
        let mut apart = Apart::brake(Mm3::new(1.0, 1.0, 2.0), Mm3::new(30.0, -10.0, 0.0), &DRIVES);
        assert!((apart.velocity().x - 30.0).abs() < 1e-9 && (apart.left() - 0.06).abs() < 1e-9);
        apart.advance(1.0);
        assert!(apart.position().distance(Mm3::new(1.9, 0.9, 2.0)) < 1e-9);
    }
}
