//! The simplest model of the paper's system: a stopping distance with a normal distribution, the same for all
//! feeds and profiles. The delay model must predict better than this, or its five values are not needed.

use super::scenario::Reported;

/// A normal distribution of the stopping distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalStop {
    /// Mean, mm.
    pub mean_mm: f64,
    /// Standard deviation, mm.
    pub deviation_mm: f64,
}

impl NormalStop {
    /// The distribution with the greatest likelihood of the reported successes, to 0.01 mm. The under-cutting
    /// has no part in the fit.
    #[must_use]
    pub fn fitted<'a>(rows: impl Iterator<Item = &'a Reported> + Clone) -> Self {
        let hundredths = |from: u32, to: u32| (from..=to).map(|count| f64::from(count) / 100.0);
        let models = hundredths(50, 500)
            .flat_map(|mean_mm| hundredths(10, 300).map(move |deviation_mm| Self { mean_mm, deviation_mm }));
        let rated = models.map(|model| (model, rows.clone().map(|row| model.likelihood(row)).sum::<f64>()));
        let best = rated.max_by(|(_, one), (_, other)| one.total_cmp(other));
        best.map_or(Self { mean_mm: 0.0, deviation_mm: 1.0 }, |(model, _)| model)
    }

    /// Share of attempts that stop within a tolerance, mm.
    #[must_use]
    pub fn success(self, tolerance_mm: f64) -> f64 {
        let deviations = (tolerance_mm - self.mean_mm) / self.deviation_mm;
        0.5 * libm::erfc(-deviations / std::f64::consts::SQRT_2)
    }

    /// Mean of what is left of a tolerance in these attempts, mm: the mean of a truncated normal distribution.
    #[must_use]
    pub fn under_cutting_mm(self, tolerance_mm: f64) -> f64 {
        let deviations = (tolerance_mm - self.mean_mm) / self.deviation_mm;
        let density = (-0.5 * deviations * deviations).exp() / (2.0 * std::f64::consts::PI).sqrt();
        tolerance_mm - self.mean_mm + self.deviation_mm * density / self.success(tolerance_mm)
    }

    /// Logarithm of the probability of a row's successes, but for a constant.
    fn likelihood(self, row: &Reported) -> f64 {
        let share = self.success(row.tolerance_mm).clamp(1e-12, 1.0 - 1e-12);
        let successes = f64::from(row.successes);
        successes * share.ln() + (f64::from(row.attempts) - successes) * (1.0 - share).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drawn distances must have the share, the mean remainder and, fitted, the values of their distribution.
    #[test]
    fn model_agrees_with_drawn_stopping_distances() {
        let model = NormalStop { mean_mm: 2.0, deviation_mm: 0.5 };
        let mut random = fastrand::Rng::with_seed(3);
        // Box and Muller.
        let drawn: Vec<f64> = (0..20_000)
            .map(|_| {
                let (radius, angle) = ((-2.0 * (1.0 - random.f64()).ln()).sqrt(), random.f64());
                model.mean_mm + model.deviation_mm * radius * (2.0 * std::f64::consts::PI * angle).cos()
            })
            .collect();
        let rows: Vec<Reported> = [1.5, 2.0, 2.6]
            .map(|tolerance_mm| {
                let left: Vec<f64> =
                    drawn.iter().map(|stop| tolerance_mm - stop).filter(|&left| left >= 0.0).collect();
                let successes = u32::try_from(left.len()).unwrap();
                let share = f64::from(successes) / 20_000.0;
                let mean = left.iter().sum::<f64>() / f64::from(successes);
                assert!((model.success(tolerance_mm) - share).abs() < 0.01, "{tolerance_mm} {share}");
                assert!((model.under_cutting_mm(tolerance_mm) - mean).abs() < 0.02, "{tolerance_mm} {mean}");
                Reported {
                    table: "2 (a)".into(),
                    profile: "triangle".into(),
                    feed_mm_s: 12.0,
                    tolerance_mm,
                    attempts: 20_000,
                    successes,
                    under_cutting_mm: None,
                    calibrates: true,
                }
            })
            .into();
        let found = NormalStop::fitted(rows.iter());
        assert!((found.mean_mm - 2.0).abs() < 0.02 && (found.deviation_mm - 0.5).abs() < 0.02, "{found:?}");
    }
}
