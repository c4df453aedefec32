//! Values of arguments that have a form of their own.

use std::time::Duration;

use keepout_planner::Mm2;
use keepout_planner::plan::{FEEDS_MM_MIN, PassParameters};

use crate::CliError;

/// The units that a length may have, and their millimetres.
const UNITS_MM: [(&str, f64); 7] =
    [("mm", 1.0), ("cm", 10.0), ("inches", 25.4), ("inch", 25.4), ("in", 25.4), ("\"", 25.4), ("µm", 0.001)];

/// Parses a length: `6`, `6mm`, `0.25in`, `1/4in`, `-6`. Without a unit it is in millimetres.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let wrong = || {
        let comma = if text.contains(',') { " A decimal has a point, not a comma." } else { "" };
        format!("\"{text}\" is not a length, such as 6, 6mm, 0.25in or 1/4in.{comma}")
    };
    let trimmed = text.trim();
    let with_unit = UNITS_MM.iter().find_map(|(unit, mm)| Some((trimmed.strip_suffix(unit)?, *mm)));
    let (value, mm) = with_unit.unwrap_or((trimmed, 1.0));
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let value = match value.split_once('/') {
        Some((over, under)) => {
            number(under).filter(|under| *under != 0.0).and_then(|under| Some(number(over)? / under))
        }
        None => number(value),
    };
    value.map(|value| value * mm).ok_or_else(wrong)
}

/// Parses `X,Y` as two lengths.
pub(crate) fn pair(text: &str) -> Result<Mm2, String> {
    let wrong = || format!("\"{text}\" is not two lengths with a comma between them, such as -200,-175");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let of = |text: &str| length(text).map_err(|_| wrong());
    Ok(Mm2::new(of(x)?, of(y)?))
}

/// Parses a time limit, s.
pub(crate) fn time(text: &str) -> Result<f64, String> {
    let wrong = || format!("\"{text}\" is not a time between 0.001 and 10⁷ s");
    text.parse().ok().filter(|time| (0.001..=1e7).contains(time)).ok_or_else(wrong)
}

/// Parses `STOCK` or `STOCK:FEED`: the stock to leave in mm, and the feed in mm/min.
pub(crate) fn pass(text: &str) -> Result<PassParameters, String> {
    let wrong = || {
        format!(
            "\"{text}\" is not a pass: give the stock to leave in mm and the feed in mm/min, such as 0.1:900"
        )
    };
    let (stock_to_leave, feed) =
        text.split_once(':').map_or((text, None), |(stock_to_leave, feed)| (stock_to_leave, Some(feed)));
    let stock_to_leave_mm =
        length(stock_to_leave).ok().filter(|value| (0.0..=1000.0).contains(value)).ok_or_else(wrong)?;
    let feed = feed.map(|feed| feed.parse::<u32>().ok().filter(|feed| FEEDS_MM_MIN.contains(feed)));
    match feed {
        Some(None) => Err(wrong()),
        feed => Ok(PassParameters { stock_to_leave_mm, feed_mm_min: feed.flatten() }),
    }
}

/// The dialect, with the full path if it is a file: a machine is used from any folder.
pub(crate) fn full_path(dialect: &str) -> String {
    std::fs::canonicalize(dialect).map_or_else(|_| dialect.into(), |path| path.display().to_string())
}

/// Checks a time in seconds.
pub fn seconds(name: &str, value: f64) -> Result<Duration, CliError> {
    let known = (0.0..=1e7).contains(&value);
    if known {
        Ok(Duration::from_secs_f64(value))
    } else {
        Err(CliError::Argument(format!("{name} {value} is not between 0 and 10⁷ s")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_the_usual_forms() {
        for (text, mm) in [
            ("6", 6.0),
            ("6mm", 6.0),
            ("6 mm", 6.0),
            ("1/4in", 6.35),
            ("0.25 in", 6.35),
            ("-6", -6.0),
            ("3/8\"", 9.525),
        ] {
            assert!((length(text).unwrap() - mm).abs() < 1e-12, "{text}");
        }
        for wrong in ["", "mm", "6,0", "1/0in", "six", "nan", "6px", "1/2/3"] {
            assert!(length(wrong).is_err(), "{wrong}");
        }
        assert!(length("6,0").unwrap_err().contains("a point, not a comma"));
    }
}
