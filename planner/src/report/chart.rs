//! Charts: the document, and round steps of a scale.

use super::element::{Lines, document};

/// SVG of a chart of a size in pixels.
#[must_use]
pub fn sheet(size: (f64, f64), font_size: u32, lines: &Lines) -> String {
    let sheet = document(size).set("font-family", "sans-serif").set("font-size", font_size);
    format!("{}\n", sheet.lines(lines))
}

/// The largest round length (1, 2 or 5 times a power of ten) that is not above a length.
#[must_use]
pub fn round_below(length: f64) -> f64 {
    round_steps(length).into_iter().rfind(|&step| step <= length).unwrap_or(length)
}

/// The smallest round length that is not below a length.
#[must_use]
pub fn round_above(length: f64) -> f64 {
    round_steps(length).into_iter().find(|&step| step >= length).unwrap_or(length)
}

/// The lengths 1, 2, 5 and 10 times the power of ten that is not above a length.
fn round_steps(length: f64) -> [f64; 4] {
    [1.0, 2.0, 5.0, 10.0].map(|step| step * 10_f64.powf(length.log10().floor()))
}
