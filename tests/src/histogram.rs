//! Counts of times.

/// Counts of times, in ns. Each power of two has 16 classes.
#[derive(Clone, Debug)]
pub struct Histogram {
    classes: [u64; 16 * 40],
    count: u64,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { classes: [0; 16 * 40], count: 0, max: 0 }
    }
}

impl Histogram {
    /// Counts a time, ns.
    pub fn add(&mut self, ns: u64) {
        let ns = ns.max(16);
        let log = ns.ilog2();
        let within = (ns >> (log - 4)) & 15;
        let class = usize::try_from(u64::from(log - 4) * 16 + within).unwrap_or(usize::MAX);
        self.classes[class.min(16 * 40 - 1)] += 1;
        self.count += 1;
        self.max = self.max.max(ns);
    }

    /// The upper end of the class that contains the quantile `numerator / denominator`, µs.
    #[must_use]
    pub fn quantile(&self, numerator: u64, denominator: u64) -> f64 {
        let wanted = (self.count * numerator).div_ceil(denominator);
        let mut sum = 0;
        for (class, &count) in (0_u32..).zip(&self.classes) {
            sum += count;
            if sum >= wanted {
                return f64::from(16 + class % 16 + 1) * 2.0_f64.powi(i32::try_from(class / 16).unwrap_or(0))
                    / 1000.0;
            }
        }
        0.0
    }

    /// The heading of a table of rows.
    #[must_use]
    pub fn heading(first: &str) -> String {
        format!(
            "| {first} | count | p50 µs | p99 µs | p99.9 µs | p99.99 µs | max µs |\n|---|---|---|---|---|---|---|"
        )
    }

    /// A row of the table.
    #[must_use]
    pub fn row(&self, name: &str) -> String {
        let us = |numerator, denominator| self.quantile(numerator, denominator);
        format!(
            "| {name} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {}.{} |",
            self.count,
            us(1, 2),
            us(99, 100),
            us(999, 1000),
            us(9999, 10_000),
            self.max / 1000,
            self.max % 1000 / 100
        )
    }
}
