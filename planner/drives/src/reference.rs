//! The reference of a controller: the path, sampled at the feed.

use serde::{Deserialize, Serialize};

use super::Axes;
use super::path::{Foot, Path, PathPiece};

/// The transition to the feed at the start of the path, and from the feed at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Ramp {
    /// A step, as in the paper.
    #[default]
    None,
    /// Half a period of a cosine, with its duration in s.
    RaisedCosine(f64),
    /// A speed profile with bounded acceleration and jerk.
    LimitedJerk {
        /// Largest acceleration, pulses/s².
        acceleration: f64,
        /// Largest jerk, pulses/s³.
        jerk: f64,
    },
}

impl Ramp {
    /// Time to reach `feed`, s.
    #[must_use]
    pub fn lasts(&self, feed: f64) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::RaisedCosine(seconds) => seconds,
            Self::LimitedJerk { acceleration, jerk } => {
                let build_up = acceleration / jerk;
                if feed >= acceleration * build_up {
                    feed / acceleration + build_up
                } else {
                    2.0 * (feed / jerk).sqrt()
                }
            }
        }
    }

    /// Distance covered in the first `t` seconds, pulses. The whole ramp covers half the distance of the full
    /// feed.
    fn distance(&self, feed: f64, t: f64) -> f64 {
        let lasts = self.lasts(feed);
        if t >= lasts {
            return feed * (t - lasts / 2.0);
        }
        match *self {
            Self::None => feed * t,
            Self::RaisedCosine(seconds) => {
                let turn = std::f64::consts::PI / seconds;
                feed / 2.0 * (t - (turn * t).sin() / turn)
            }
            Self::LimitedJerk { acceleration, jerk } => {
                let build_up = (acceleration / jerk).min(lasts / 2.0);
                let top = jerk * build_up;
                if t <= build_up {
                    jerk * t * t * t / 6.0
                } else if t <= lasts - build_up {
                    let since = t - build_up;
                    jerk * build_up.powi(3) / 6.0 + top * build_up / 2.0 * since + top * since * since / 2.0
                } else {
                    // The speed profile is point-symmetric about its middle.
                    let left = lasts - t;
                    feed * (t - lasts / 2.0) + jerk * left * left * left / 6.0
                }
            }
        }
    }
}

/// One sample of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSample {
    /// The point on the path.
    pub foot: Foot,
    /// The piece of the path with this point.
    pub piece: PathPiece,
    /// Number of that piece along the path.
    pub number: usize,
    /// Start of that piece along the path, pulses.
    pub begins: f64,
    /// Distance of the sample from the start of the path, pulses.
    pub along: f64,
    /// Speed along the path until the next sample, pulses/s.
    pub speed: f64,
}

impl ReferenceSample {
    /// The position, pulses.
    #[must_use]
    pub fn position(&self) -> Axes {
        self.foot.point
    }

    /// The velocity along the tangent, pulses/s.
    #[must_use]
    pub fn velocity(&self) -> Axes {
        self.foot.tangent * self.speed
    }
}

/// The part of the reference that a controller may use: the samples around the current one.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceWindow<'a> {
    samples: &'a [ReferenceSample],
    now: usize,
}

impl<'a> ReferenceWindow<'a> {
    /// A window on `samples`, with number `now` as the current one. Beyond their two ends the reference stands
    /// still. `now` may lie after their end.
    ///
    /// # Panics
    /// If `samples` is empty.
    #[must_use]
    pub fn new(samples: &'a [ReferenceSample], now: usize) -> Self {
        assert!(!samples.is_empty(), "a window needs a sample");
        Self { samples, now }
    }

    /// The sample `ahead` samples after the current one. Negative values are in the past.
    #[must_use]
    pub fn ahead(&self, ahead: isize) -> &'a ReferenceSample {
        let index = self.now.saturating_add_signed(ahead).min(self.samples.len() - 1);
        &self.samples[index]
    }

    /// Position of the reference `ahead` samples after the current one, pulses.
    #[must_use]
    pub fn position(&self, ahead: isize) -> Axes {
        self.ahead(ahead).position()
    }
}

/// The samples of a complete path.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The samples. The first [`AT_REST`] stand still at the start.
    pub samples: Vec<ReferenceSample>,
}

/// Number of samples at rest before the motion begins. Zero-phase filters look this far ahead.
pub const AT_REST: usize = 2;

impl Reference {
    /// Samples `path` at `feed`, pulses/s, every `period_s`. The first [`AT_REST`] samples stand still at the
    /// start. Empty for a path without length.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "counts of samples"
    )]
    pub fn along(path: &Path, feed: f64, period_s: f64, ramp: Ramp) -> Self {
        let length = path.length();
        // Two ramps cover the distance of one ramp's time at full feed. A short path needs a lower feed.
        let feed = if feed * ramp.lasts(feed) > length { slowed(length, feed, ramp) } else { feed };
        let lasts = length / feed + ramp.lasts(feed);
        let distance = |t: f64| {
            if t < lasts / 2.0 {
                ramp.distance(feed, t.max(0.0))
            } else {
                length - ramp.distance(feed, (lasts - t).max(0.0))
            }
        };
        // The last sample is at the end of the path.
        let count = (lasts / period_s).ceil() as usize + 1;
        let sample = |index: usize| {
            let t = (index as f64 - AT_REST as f64) * period_s;
            let along = distance(t);
            let (number, foot) = path.at(along)?;
            let speed = (distance(t + period_s) - along) / period_s;
            Some(ReferenceSample {
                foot,
                piece: path.pieces()[number],
                number,
                begins: path.begins(number),
                along,
                speed,
            })
        };
        Self { samples: (0..count + AT_REST).map_while(sample).collect() }
    }
}

/// The feed, pulses/s, at which two ramps exactly fit into `length`.
fn slowed(length: f64, feed: f64, ramp: Ramp) -> f64 {
    let (mut low, mut high) = (0.0, feed);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if middle * ramp.lasts(middle) > length { high = middle } else { low = middle }
    }
    high.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_starts_at_rest_and_keeps_its_feed() {
        let reference = Reference::along(&Path::circle(2000.0, true, 1), 1000.0, 0.004, Ramp::None);
        assert_eq!(reference.samples[0].position(), reference.samples[AT_REST].position());
        assert_eq!(reference.samples[0].speed, 0.0);
        let step = reference.samples[AT_REST + 1].position() - reference.samples[AT_REST].position();
        assert!((step.norm() - 4.0).abs() < 1e-5);
    }

    /// With each ramp the reference reaches the end of the path and the full feed, within the bounds of the
    /// ramp.
    #[test]
    fn ramps_keep_their_bounds() {
        let line = Path::line(Axes::new(3000.0, 0.0));
        let ramps = [
            Ramp::RaisedCosine(0.2),
            Ramp::LimitedJerk { acceleration: 20_000.0, jerk: 400_000.0 },
            Ramp::LimitedJerk { acceleration: 1e6, jerk: 400_000.0 },
        ];
        for ramp in ramps {
            let dt = 0.001;
            let reference = Reference::along(&line, 2000.0, dt, ramp);
            let x: Vec<_> = reference.samples.iter().map(|sample| sample.position().x).collect();
            assert!(x.windows(2).all(|pair| pair[1] >= pair[0] - 1e-9));
            assert!((x[x.len() - 1] - 3000.0).abs() < 1.0, "{ramp:?}");
            let speeds: Vec<_> = x.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
            assert!((speeds.iter().copied().fold(0.0, f64::max) - 2000.0).abs() < 1e-6);
            let accelerations: Vec<_> = speeds.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
            let most = accelerations.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            let jerk = accelerations
                .windows(2)
                .fold(0.0, |most: f64, pair| most.max((pair[1] - pair[0]).abs() / dt));
            let bounds = match ramp {
                Ramp::LimitedJerk { acceleration, jerk } => (acceleration.min((2000.0 * jerk).sqrt()), jerk),
                Ramp::RaisedCosine(s) => {
                    let turn = std::f64::consts::PI / s;
                    (1000.0 * turn, 1000.0 * turn * turn)
                }
                Ramp::None => unreachable!(),
            };
            assert!(most <= bounds.0 * 1.001 && most > bounds.0 * 0.9, "{ramp:?}: {most}");
            assert!(jerk <= bounds.1 * 1.01, "{ramp:?}: {jerk}");
        }
    }

    #[test]
    fn short_path_runs_at_a_lower_feed() {
        let line = Path::line(Axes::new(10.0, 0.0));
        let ramp = Ramp::LimitedJerk { acceleration: 2000.0, jerk: 40_000.0 };
        let reference = Reference::along(&line, 2000.0, 0.001, ramp);
        let last = reference.samples.last().unwrap();
        assert!((last.position().x - 10.0).abs() < 0.01);
        assert!(reference.samples.iter().all(|sample| sample.speed < 150.0));
    }
}
