//! The trusted core stays small enough to be read.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::Path;

/// Lines of code up to the tests: without comments, docs and blank lines.
fn lines_of(path: &Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap();
    let code = text.lines().take_while(|line| *line != "#[cfg(test)]").map(str::trim);
    code.filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// What every motion rests on, and beside it what is believed of splines and ellipses when a plan is loaded.
#[test]
fn lines_of_the_trusted_core_are_at_most_1593() {
    let kernel = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernel/src");
    let all: usize =
        std::fs::read_dir(kernel.join("exact")).unwrap().map(|entry| lines_of(&entry.unwrap().path())).sum();
    let curves = lines_of(&kernel.join("exact/bezier.rs"));
    let exact = all - curves;
    let check = lines_of(&kernel.join("index/check.rs"));
    let queries: usize =
        ["index/query.rs", "index/cells.rs"].iter().map(|file| lines_of(&kernel.join(file))).sum();
    println!("exact {exact} and bezier {curves}, index/check {check}; index/query and index/cells {queries}");
    assert!(curves < 250, "{curves}");
    assert!(exact + check <= 1593, "{exact} + {check}");
    assert!(queries < 500, "{queries}");
}
