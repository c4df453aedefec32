//! Lines and files have bounds.

use crate::source::{Exceptions, Offender, files, judge, read, sources};

/// Most columns of a line.
const COLUMNS: usize = 120;
/// Most lines of a Rust file.
const LINES: usize = 400;

/// Pages that programs write.
const LONG_LINES: &Exceptions = &[
    ("docs/research/drawings.md", "written by `keepout-tests --bin survey`"),
    ("docs/research/koren-lo.md", "written by `keepout-studies koren-lo`"),
    ("docs/research/tuned-controllers.md", "written by `keepout-studies tuned`"),
    ("docs/contributor/performance.md", "written by `cargo bench --bench peers`"),
    ("proofs/README.md", "written by `keepout-proofs table`"),
];

/// Lines that cannot be broken, or read better in one.
fn may_be_long(name: &str, line: &str) -> bool {
    let line = line.trim_start();
    let starts = |beginnings: &[&str]| beginnings.iter().any(|beginning| line.starts_with(beginning));
    let link = (name.ends_with(".rs") || name.ends_with(".md")) && line.contains("://");
    let row = name.ends_with(".md") && starts(&["|"]) || name.ends_with(".rs") && starts(&["/// |", "//! |"]);
    link || row || name == "proofs/faults.toml" && starts(&["find = ", "with = "])
}

/// The lines of a file that are too long.
fn long_lines(name: &str, text: &str) -> Vec<Offender> {
    let mut in_block = false;
    let mut long = Vec::new();
    for (number, line) in text.lines().enumerate() {
        in_block ^= name.ends_with(".md") && line.trim_start().starts_with("```");
        let columns = line.chars().count();
        if columns > COLUMNS && !in_block && !may_be_long(name, line) {
            long.push(Offender::at(name, number + 1, format_args!("{columns} columns")));
        }
    }
    long
}

#[test]
fn lines_have_at_most_120_columns() {
    let is_text = |name: &String| {
        [".rs", ".md", ".toml", ".sh"].iter().any(|ending| name.ends_with(ending))
            || [".ci/run", "fuzz/run"].contains(&name.as_str())
    };
    let offenders: Vec<_> = files("")
        .iter()
        .filter(|name| is_text(name))
        .flat_map(|name| long_lines(name, &read(name)))
        .collect();
    judge("A line has at most 120 columns", &offenders, LONG_LINES);
}

#[test]
fn long_lines_are_noticed() {
    let count = |name: &str, line: &str| long_lines(name, line).len();
    let (long, link) = ("ä ".repeat(61), format!("see https://example.org/{}", "x".repeat(120)));
    assert_eq!(count("a.rs", &long), 1);
    assert_eq!(count("a.rs", &"ä".repeat(120)), 0);
    assert_eq!((count("a.md", &link), count("a.rs", &link), count("a.toml", &link)), (0, 0, 1));
    let row = format!("| {long} |");
    assert_eq!((count("a.md", &row), count("a.rs", &format!("/// {row}")), count("a.rs", &row)), (0, 0, 1));
    assert_eq!(count("a.md", &format!("```text\n{long}\n```\n{long}")), 1);
    let fault = format!("find = \"{long}\"");
    assert_eq!((count("proofs/faults.toml", &fault), count("deny.toml", &fault)), (0, 1));
}

/// Files that are too long.
const LONG_FILES: &Exceptions = &[
    ("executor/cli/tests/processes.rs", "owed: a module of the tests with a device"),
    ("executor/guard/src/tests.rs", "owed"),
    ("executor/sim/src/grbl/mod.rs", "owed"),
    ("kernel/src/exact/bezier.rs", "owed: results of the fault catalogue hold for this path"),
    ("kernel/src/index/cells.rs", "owed: results of the fault catalogue hold for this path"),
    ("planner/tests/resume.rs", "owed"),
    ("proofs/src/controller.rs", "owed: a module of what goes wrong"),
    ("proofs/src/properties/guard.rs", "owed"),
    ("proofs/src/properties/index.rs", "owed: a module of the cells"),
    ("proofs/src/theorems/convex.rs", "owed: a module of the segment"),
    ("tests/src/hostile/play.rs", "owed"),
];

#[test]
fn rust_files_have_at_most_400_lines() {
    let long = |(name, text): &(String, String)| {
        let lines = text.lines().count();
        (lines > LINES).then(|| Offender::at(name, lines, format_args!("{lines} lines")))
    };
    let offenders: Vec<_> = sources("").iter().filter_map(long).collect();
    judge("A Rust file has at most 400 lines", &offenders, LONG_FILES);
}

/// The lint holds the rule. This holds the lint.
#[test]
fn clippy_holds_functions_under_60_lines() {
    assert!(read("clippy.toml").lines().any(|line| line == "too-many-lines-threshold = 60"));
    assert!(read("Cargo.toml").lines().any(|line| line == "too_many_lines = \"warn\""));
    let crates = files("").into_iter().filter(|name| name.ends_with("/Cargo.toml"));
    let inherits = |name: &String| read(name).contains("[lints]\nworkspace = true\n");
    // One crate borders on the model checker, and cannot forbid unsafe code.
    let own = |name: &String| {
        name == "proofs/harnesses/Cargo.toml" && read(name).contains("\ntoo_many_lines = \"warn\"\n")
    };
    let without: Vec<_> = crates.filter(|name| !inherits(name) && !own(name)).collect();
    assert!(without.is_empty(), "without the lints of the workspace: {without:?}");
    let lint = read(".ci/run").replace(" \\\n       ", "");
    assert!(lint.contains(
        "cargo clippy --workspace --all-targets --features keepout-fuzz/libfuzzer --quiet -- -D warnings"
    ));
    let expects = |(name, text): &(String, String)| {
        let lines = text.lines().enumerate();
        let here =
            lines.filter(|(_, line)| line.trim_start().starts_with("#") && line.contains("too_many_lines"));
        here.map(|(number, _)| Offender::at(name, number + 1, "expects too many lines")).collect::<Vec<_>>()
    };
    let offenders: Vec<_> = sources("").iter().flat_map(expects).collect();
    judge("No function has more than 60 lines", &offenders, &[]);
}
