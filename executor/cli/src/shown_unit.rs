//! The unit in which the operator sees lengths.

use clap::ValueEnum;
use keepout_planner::Mm2;
use serde::Deserialize;

/// Millimetres of an inch.
const INCH_MM: f64 = 25.4;

/// Unit of the lengths on the screen. Files, names of contours and the report are in millimetres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShownUnit {
    /// Millimetres.
    #[default]
    Mm,
    /// Inches.
    Inch,
}

impl ShownUnit {
    /// The unit's symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Inch => "in",
        }
    }

    /// A coordinate or distance with a fixed number of decimals, without the symbol.
    pub fn figure(self, mm: f64) -> String {
        // Adding zero turns -0 into 0.
        let rounded = |value: f64, share: f64| (value * share).round() / share + 0.0;
        match self {
            Self::Mm => format!("{:.3}", rounded(mm, 1e3)),
            Self::Inch => format!("{:.4}", rounded(mm / INCH_MM, 1e4)),
        }
    }

    /// A place, such as `(13.500, 0.000) mm`.
    pub fn place(self, Mm2 { x, y }: Mm2) -> String {
        format!("({}, {}) {}", self.figure(x), self.figure(y), self.symbol())
    }

    /// A length without trailing zeros, and the symbol.
    pub fn length(self, mm: f64) -> String {
        format!("{} {}", self.short_figure(mm), self.symbol())
    }

    /// Width and height, and the symbol.
    pub fn size(self, Mm2 { x, y }: Mm2) -> String {
        format!("{} × {}", self.short_figure(x), self.length(y))
    }

    fn short_figure(self, mm: f64) -> String {
        self.figure(mm).trim_end_matches('0').trim_end_matches('.').to_string()
    }

    /// A jog speed.
    pub fn speed(self, mm_s: f64) -> String {
        match self {
            Self::Mm => format!("{mm_s:.1} mm/s"),
            Self::Inch => format!("{:.1} in/min", mm_s * 60.0 / INCH_MM),
        }
    }

    /// A feed.
    pub fn feed(self, mm_min: u32) -> String {
        match self {
            Self::Mm => format!("{mm_min} mm/min"),
            Self::Inch => format!("{:.1} in/min", f64::from(mm_min) / INCH_MM),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_shown_in_both_units() {
        for (unit, figure, length, size, speed, feed) in [
            (ShownUnit::Mm, "-6.350", "6.35 mm", "90 × 70 mm", "10.0 mm/s", "900 mm/min"),
            (ShownUnit::Inch, "-0.2500", "0.25 in", "3.5433 × 2.7559 in", "23.6 in/min", "35.4 in/min"),
        ] {
            assert_eq!(unit.figure(-6.35), figure);
            assert_eq!(unit.length(6.35), length);
            assert_eq!(unit.size(Mm2::new(90.0, 70.0)), size);
            assert_eq!((unit.speed(10.0), unit.feed(900)), (speed.into(), feed.into()));
            assert!(!unit.figure(-0.0).starts_with('-') && !unit.figure(-1e-5).starts_with('-'));
        }
    }
}
