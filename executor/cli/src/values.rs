//! Values of arguments that have a form of their own.

use keepout_planner::Mm2;
use keepout_planner::plan::{FEEDS_MM_MIN, PassParameters};

/// Parses `X,Y` as two finite numbers.
pub(crate) fn pair(text: &str) -> Result<Mm2, String> {
    let wrong = || format!("\"{text}\" is not two numbers with a comma between them, such as -200,-175");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let number =
        |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
    Ok(Mm2::new(number(x)?, number(y)?))
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
    let stock_to_leave_mm = stock_to_leave
        .parse::<f64>()
        .ok()
        .filter(|value| (0.0..=1000.0).contains(value))
        .ok_or_else(wrong)?;
    let feed = feed.map(|feed| feed.parse::<u32>().ok().filter(|feed| FEEDS_MM_MIN.contains(feed)));
    match feed {
        Some(None) => Err(wrong()),
        feed => Ok(PassParameters { stock_to_leave_mm, feed_mm_min: feed.flatten() }),
    }
}
