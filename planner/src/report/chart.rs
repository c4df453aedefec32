//! Charts: the document, and round steps of a scale.

use super::element::{Lines, document};

/// SVG of a chart of a size in pixels.
#[must_use]
pub fn sheet(size: (f64, f64), font_size: u32, lines: &Lines) -> String {
    let sheet = document(size).set("font-family", "sans-serif").set("font-size", font_size);
    format!("{}\n", sheet.lines(lines))
}

/// The lengths 1, 2, 5 and 10 times the power of ten that is not above a length.
#[must_use]
pub fn round_steps(length: f64) -> [f64; 4] {
    [1.0, 2.0, 5.0, 10.0].map(|step| step * 10_f64.powf(length.log10().floor()))
}
