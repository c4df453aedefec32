//! How well a path was followed.

use super::Axes;
use super::path::Path;
use super::reference::Sample;

/// One sample of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds since the motion began.
    pub at_s: f64,
    /// Where the reference was, pulses.
    pub reference: Axes,
    /// Where the table was, pulses.
    pub position: Axes,
    /// The exact distance to the path, pulses; positive to the left of its direction.
    pub contour_error: f64,
    /// How far the table lay beyond the end of a piece at a corner, pulses.
    pub overshoot: f64,
}

impl Moment {
    /// What is to be known of a sample.
    #[must_use]
    pub fn seen(at_s: f64, path: &Path, reference: &Sample, position: Axes) -> Self {
        let foot = path.nearest(position, reference.number);
        Self {
            at_s,
            reference: reference.position(),
            position,
            contour_error: foot.distance(position),
            overshoot: path.overshoot(position, &foot, reference.number),
        }
    }
}

/// Root mean square and largest magnitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub max: f64,
}

impl Spread {
    /// Of these figures; zero for none.
    #[must_use]
    pub fn of(figures: impl Iterator<Item = f64>) -> Self {
        let (mut sum, mut count, mut max) = (0.0, 0.0, 0.0_f64);
        for figure in figures {
            sum += figure * figure;
            count += 1.0;
            max = larger(max, figure.abs());
        }
        Self { rms: if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }, max }
    }

    /// The larger figure of each kind.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        Self { rms: larger(self.rms, other.rms), max: larger(self.max, other.max) }
    }

    /// In another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { rms: self.rms * factor, max: self.max * factor }
    }
}

/// The larger of two; what is no number is larger than any.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// What a run comes to. Lengths in pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Contour error, from the first sample on.
    pub contour: Spread,
    /// Contour error without the first [`TRANSIENT_S`].
    pub settled: Spread,
    /// Largest error of an axis.
    pub axial: f64,
    /// The farthest beyond a corner.
    pub overshoot: f64,
    /// The share of commands that were cut off.
    pub saturation_share: f64,
}

/// How long the start transient is taken to last, s: ten times the paper's time constants, about.
pub const TRANSIENT_S: f64 = 0.5;

impl Figures {
    /// Of a whole run.
    #[must_use]
    pub fn of(moments: &[Moment], saturation_share: f64) -> Self {
        let errors = |from_s: f64| {
            moments.iter().filter(move |moment| moment.at_s >= from_s).map(|moment| moment.contour_error)
        };
        Self {
            contour: Spread::of(errors(0.0)),
            settled: Spread::of(errors(TRANSIENT_S)),
            axial: moments.iter().map(|moment| (moment.reference - moment.position).amax()).fold(0.0, larger),
            overshoot: moments.iter().map(|moment| moment.overshoot).fold(0.0, larger),
            saturation_share,
        }
    }
}

/// A figure with about three digits.
#[must_use]
pub fn figure(value: f64) -> String {
    match value.abs() {
        size if size.is_nan() || size >= 1e7 => "diverges".into(),
        size if size >= 99.5 => format!("{value:.0}"),
        size if size >= 9.95 => format!("{value:.1}"),
        size if size >= 0.995 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_not_forgotten() {
        let spread = Spread::of([1.0, f64::NAN, 2.0].into_iter());
        assert!(spread.max.is_nan() && spread.rms.is_nan());
        assert_eq!(Spread::of([3.0, -4.0].into_iter()), Spread { rms: 12.5_f64.sqrt(), max: 4.0 });
        assert_eq!(Spread::of(std::iter::empty()), Spread::default());
    }
}
