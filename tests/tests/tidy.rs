//! The rules of the house that Cargo cannot express.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// The Rust files under a folder of the repository, or the file itself, with their text.
fn sources(place: &str) -> Vec<(String, String)> {
    fn visit(path: &Path, into: &mut Vec<PathBuf>) {
        if path.is_dir() {
            std::fs::read_dir(path).unwrap().for_each(|entry| visit(&entry.unwrap().path(), into));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path.to_path_buf());
        }
    }
    let mut paths = Vec::new();
    visit(&root().join(place), &mut paths);
    paths.sort();
    assert!(!paths.is_empty(), "{place}: no such place");
    let name = |path: &Path| path.strip_prefix(root()).unwrap().display().to_string();
    paths.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

/// A file without its inline tests.
fn product(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let ends =
        lines.windows(2).position(|pair| pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod tests {"));
    lines[..ends.unwrap_or(lines.len())].join("\n")
}

/// Whether the text names the word, not as a part of a longer one.
fn names(text: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(part) && !text[at + word.len()..].starts_with(part))
}

/// What every certified motion rests on. The mesh, the offsets' proposals and the indexes' proposals are not here: they are checked.
const TRUSTED: [&str; 8] = [
    "kernel/src/exact",
    "kernel/src/index/check.rs",
    "kernel/src/index/query.rs",
    "kernel/src/index/cells.rs",
    "kernel/src/clear.rs",
    "kernel/src/simplify.rs",
    "kernel/src/offset/certify.rs",
    "executor/guard/src",
];

#[test]
fn trusted_lines_are_fewer_than_4000() {
    let (mut code, mut all) = (0, 0);
    for (name, text) in TRUSTED.into_iter().flat_map(sources) {
        // No product is built with these.
        if name.ends_with("tests.rs") {
            continue;
        }
        let text = product(&text);
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        code += lines.iter().filter(|line| !line.starts_with("//")).count();
        all += lines.len();
    }
    println!("{code} lines of code, {all} with comments");
    assert!(code < 4000, "{code} trusted lines of code, {all} with comments");
}

#[test]
fn trusted_crates_name_no_float() {
    for place in ["kernel/src/exact", "executor/guard/src"] {
        for (name, text) in sources(place).iter().filter(|(name, _)| !name.ends_with("tests.rs")) {
            for float in ["f32", "f64"] {
                assert!(!names(&product(text), float), "{name} names {float}");
            }
        }
    }
}

#[test]
fn trusted_files_name_no_arc_view() {
    for (name, text) in TRUSTED.into_iter().flat_map(sources) {
        for word in ["ArcView", "arc_view"] {
            assert!(!names(&text, word), "{name} names {word}");
        }
    }
}

/// A room of the executor, and the rooms that it may not name.
const ARROWS: [(&str, &[&str]); 4] = [
    ("executor/src/supervisor", &["dialect", "session", "operator"]),
    ("executor/src/operator", &["dialect", "session"]),
    ("executor/src/dialect", &["session", "operator"]),
    ("kernel/src/exact", &["index", "clear", "clip", "curve", "offset", "simplify"]),
];

#[test]
fn arrows_between_rooms_run_one_way() {
    for (place, forbidden) in ARROWS {
        for (name, text) in sources(place) {
            for room in forbidden {
                assert!(!text.contains(&format!("crate::{room}")), "{name} names {room}");
            }
        }
    }
}

/// Seeds are part of the record: they must give the same numbers in every version.
#[test]
fn seeds_give_the_same_numbers_as_ever() {
    let mut random = fastrand::Rng::with_seed(20_261_125);
    let mut order: Vec<u8> = (0..8).collect();
    let numbers =
        (random.u64(..), random.f64().to_bits(), random.usize(0..1000), random.i64(-5..5), random.bool());
    random.shuffle(&mut order);
    assert_eq!(
        (numbers, order),
        ((3_864_322_368_815_853_088, 4_604_169_150_310_717_304, 451, -2, true), vec![6, 2, 0, 3, 5, 4, 7, 1])
    );
}
