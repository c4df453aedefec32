//! Measures of contour accuracy.

use super::Axes;
use super::path::Path;
use super::reference::ReferenceSample;

/// One sample of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds since the motion began.
    pub at_s: f64,
    /// Position of the reference, pulses.
    pub reference: Axes,
    /// Position of the table, pulses.
    pub position: Axes,
    /// Exact distance to the path, pulses. Positive to the left of its direction.
    pub contour_error: f64,
    /// Distance of the table past a corner, pulses.
    pub overshoot: f64,
    /// Distance of the table past the end of the path, pulses.
    pub past_end: f64,
}

impl Moment {
    /// The measures for a table at `position` and a reference at `reference`.
    #[must_use]
    pub fn seen(at_s: f64, path: &Path, reference: &ReferenceSample, position: Axes) -> Self {
        let foot = path.nearest(position, reference.number);
        Self {
            at_s,
            reference: reference.position(),
            position,
            contour_error: foot.distance(position),
            overshoot: path.overshoot(position, &foot, reference.number),
            past_end: path.past_end(position, &foot),
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
    /// The spread of `figures`. Zero for an empty sequence.
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

    /// The larger RMS and the larger maximum of two spreads.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        Self { rms: larger(self.rms, other.rms), max: larger(self.max, other.max) }
    }

    /// The spread in another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { rms: self.rms * factor, max: self.max * factor }
    }
}

/// The larger of two values. NaN counts as larger than any number.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// Summary of a run. Lengths in pulses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Contour error, from the first sample on until the reference comes to the end of the path.
    pub contour: Spread,
    /// Contour error without the first [`TRANSIENT_S`] seconds.
    pub settled: Spread,
    /// Largest error of a single axis.
    pub axial: f64,
    /// Largest overshoot past a corner.
    pub overshoot: f64,
    /// Distance from the path after the reference came to its end: from then on until the end of the run.
    pub run_out: Spread,
    /// Largest overshoot past the end of the path, in its direction.
    pub stop_overshoot: f64,
    /// Largest distance from the path at any time, between samples and in the run-out, too: an upper bound. In a run
    /// without looks between the samples, it is the largest at the samples.
    pub largest: f64,
    /// Share of the commands that the amplifier clipped.
    pub saturation_share: f64,
}

/// Assumed duration of the start transient, s: about ten time constants of the paper.
pub const TRANSIENT_S: f64 = 0.5;

impl Figures {
    /// Summarises a run. `moving` are the samples until the reference came to the end of the path, `after` the
    /// samples from then on.
    #[must_use]
    pub fn of(moving: &[Moment], after: &[Moment], largest: f64, saturation_share: f64) -> Self {
        let errors = |from_s: f64| {
            moving.iter().filter(move |moment| moment.at_s >= from_s).map(|moment| moment.contour_error)
        };
        let most =
            |moments: &[Moment], figure: fn(&Moment) -> f64| moments.iter().map(figure).fold(0.0, larger);
        Self {
            contour: Spread::of(errors(0.0)),
            settled: Spread::of(errors(TRANSIENT_S)),
            axial: most(moving, |moment| (moment.reference - moment.position).amax()),
            overshoot: most(moving, |moment| moment.overshoot),
            run_out: Spread::of(after.iter().map(|moment| moment.contour_error)),
            stop_overshoot: most(after, |moment| moment.past_end),
            largest,
            saturation_share,
        }
    }
}

/// `value` as text with about three digits, or "diverges".
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
    fn nan_is_never_hidden() {
        let spread = Spread::of([1.0, f64::NAN, 2.0].into_iter());
        assert!(spread.max.is_nan() && spread.rms.is_nan());
        assert_eq!(Spread::of([3.0, -4.0].into_iter()), Spread { rms: 12.5_f64.sqrt(), max: 4.0 });
        assert_eq!(Spread::of(std::iter::empty()), Spread::default());
    }
}
