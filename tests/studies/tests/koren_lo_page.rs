//! `docs/research/koren-lo.md` and its pictures are what `cargo run --release -p keepout-studies -- koren-lo` writes, to a tenth: friction and whole numbers make much of the
//! last digit of a sine, and that is the system's.

use std::path::Path;

use keepout_studies::koren_lo::page::page;

/// Figures may differ by this share, or by this much.
const SHARE: f64 = 0.1;
const LEAST: f64 = 0.002;

/// Runs of digits and points, and what stands between them.
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

/// The first line that is not the same but for its figures, and these nearly.
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
fn page_is_the_one_that_is_written() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/research");
    let page = page(&mut |_, _| {}).unwrap();
    let stale = "is not what `cargo run --release -p keepout-studies -- koren-lo` writes: run it, and look at what changed";
    let kept = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
    let text = kept(&docs.join("koren-lo.md"));
    assert_eq!(differing(&text, &page.text), None, "docs/research/koren-lo.md {stale}");
    assert_eq!(page.pictures.len(), 12);
    for (name, svg) in &page.pictures {
        // What is written on it, and how many curves there are.
        let words = |svg: &str| {
            let said: Vec<_> = svg.lines().filter(|line| line.contains("<text")).collect();
            format!("{}\n{} curves", said.join("\n"), svg.matches("<polyline").count())
        };
        let (kept, made) = (words(&kept(&docs.join("koren-lo").join(name))), words(svg));
        assert_eq!(differing(&kept, &made), None, "docs/research/koren-lo/{name} {stale}");
    }
}

#[test]
fn figures_that_differ_are_noticed() {
    assert_eq!(differing("| P | 2.82 / 11.9 |", "| P | 2.83 / 11.8 |"), None);
    assert!(differing("| P | 2.82 / 11.9 |", "| P | 2.82 / 14.9 |").is_some());
    assert!(differing("| P | Good |", "| P | Fair |").is_some());
    assert!(differing("one\n", "one\ntwo\n").is_some());
}
