//! Compares `docs/research/koren-lo.md` and its pictures with the output of
//! `cargo run --release -p keepout-studies -- koren-lo`.
//!
//! Numbers may differ by a tenth. The last digit of a sine depends on the system, and friction and whole
//! numbers amplify the difference.

use std::path::Path;

use keepout_studies::koren_lo::page::page;

/// Allowed relative difference of two numbers.
const SHARE: f64 = 0.1;
/// Allowed absolute difference of two numbers.
const LEAST: f64 = 0.002;

/// Splits `text` into numbers and the text between them.
fn pieces(text: &str) -> Vec<&str> {
    let is_figure = |c: char| c.is_ascii_digit() || c == '.';
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let end = rest.find(|c| is_figure(c) != is_figure(first)).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// The first line that differs in its words, or in its numbers by more than the allowed difference.
fn differing<'a>(kept: &'a str, made: &'a str) -> Option<(&'a str, &'a str)> {
    let near = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= LEAST + SHARE * a.abs().max(b.abs()),
        _ => a == b,
    };
    let same = |a: &str, b: &str| {
        let (a, b) = (pieces(a), pieces(b));
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| near(a, b))
    };
    let longer = kept.lines().count().max(made.lines().count());
    let lines = kept.lines().chain(std::iter::repeat("")).zip(made.lines().chain(std::iter::repeat("")));
    lines.take(longer).find(|(kept, made)| !same(kept, made))
}

#[test]
#[ignore = "it runs every figure: a minute, in `.ci/weekly studies`"]
fn page_agrees_with_its_generator() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/research");
    let page = page(&mut |_, _| {}).unwrap();
    let stale =
        "is out of date. Run `cargo run --release -p keepout-studies -- koren-lo`, and check the differences";
    let kept = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
    let text = kept(&docs.join("koren-lo.md"));
    assert_eq!(differing(&text, &page.text), None, "docs/research/koren-lo.md {stale}");
    assert_eq!(page.pictures.len(), 12);
    for (name, svg) in &page.pictures {
        // Compare the texts and the number of curves.
        let words = |svg: &str| {
            let texts: Vec<_> = svg.lines().filter(|line| line.contains("<text")).collect();
            format!("{}\n{} curves", texts.join("\n"), svg.matches("<polyline").count())
        };
        let (kept, made) = (words(&kept(&docs.join("koren-lo").join(name))), words(svg));
        assert_eq!(differing(&kept, &made), None, "docs/research/koren-lo/{name} {stale}");
    }
}

#[test]
fn differing_numbers_and_words_are_detected() {
    assert_eq!(differing("| P | 2.82 / 11.9 |", "| P | 2.83 / 11.8 |"), None);
    assert!(differing("| P | 2.82 / 11.9 |", "| P | 2.82 / 14.9 |").is_some());
    assert!(differing("| P | Good |", "| P | Fair |").is_some());
    assert!(differing("one\n", "one\ntwo\n").is_some());
}
