//! Links, headings, files and functions that the documents name exist.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// The repository's files with one of these endings, without build results and hidden folders.
fn files(endings: &[&str]) -> Vec<PathBuf> {
    fn visit(folder: &Path, endings: &[&str], into: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if !name.starts_with('.') && !["target", "artifacts", "corpus"].contains(&name.as_str()) {
                    visit(&path, endings, into);
                }
            } else if endings.iter().any(|ending| name.ends_with(ending)) {
                into.push(path);
            }
        }
    }
    let mut paths = Vec::new();
    visit(&root(), endings, &mut paths);
    paths.sort();
    paths
}

/// A document's lines outside code blocks, each with its number.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut in_block = false;
    let mut lines = Vec::new();
    for (number, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            in_block = !in_block;
        } else if !in_block {
            lines.push((number + 1, line));
        }
    }
    lines
}

/// The parts of a line between backticks, and the line without them.
fn code_spans(line: &str) -> (Vec<&str>, String) {
    let parts: Vec<&str> = line.split('`').collect();
    let spans = parts.iter().copied().skip(1).step_by(2).take((parts.len() - 1) / 2).collect();
    let rest: Vec<&str> = parts.iter().copied().step_by(2).collect();
    (spans, rest.join(" "))
}

/// The targets of a line's links and pictures.
fn links(line: &str) -> Vec<&str> {
    let after = line.split("](").skip(1);
    after.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target).collect()
}

/// The anchors of a document's headings, as GitHub builds them.
fn anchors(text: &str) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut anchors = Vec::new();
    for (_, line) in prose(text) {
        let Some(title) = line.strip_prefix('#').map(|rest| rest.trim_start_matches('#').trim()) else {
            continue;
        };
        let kept = title.to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let slug: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let count = seen.entry(slug.clone()).or_default();
        anchors.push(if *count == 0 { slug } else { format!("{slug}-{count}") });
        *count += 1;
    }
    anchors
}

/// The fault of a link in the document at `path`, if it has one.
fn broken_link(path: &Path, text: &str, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let other = path.parent().unwrap().join(file);
    if !file.is_empty() && !other.exists() {
        return Some(format!("{target}: no such file"));
    }
    let linked =
        if file.is_empty() { text.to_string() } else { std::fs::read_to_string(&other).unwrap_or_default() };
    let missing = !anchor.is_empty() && !anchors(&linked).iter().any(|found| found == anchor);
    missing.then(|| format!("{target}: no such heading"))
}

/// The folders whose files documents name.
const FOLDERS: [&str; 10] = [
    "kernel/",
    "planner/",
    "executor/",
    "proofs/",
    "fuzz/",
    "tests/",
    "campaigns/",
    "docs/",
    ".ci/",
    ".cargo/",
];

/// Whether a code span names a missing file or folder. Names count from the root, or from a folder above the
/// document.
fn is_missing(path: &Path, span: &str) -> bool {
    let name = span.split([' ', ',', ':']).next().unwrap_or(span);
    let named = FOLDERS.iter().any(|folder| name.starts_with(folder) && name.len() > folder.len());
    // Upper-case parts, such as `TARGET`, are placeholders.
    let stands_for = name.contains(['*', '{', '<', '…'])
        || name.split('/').any(|part| part == part.to_uppercase() && part.len() > 1);
    let places = path.ancestors().skip(1).take_while(|place| place.starts_with(root()));
    named && !stands_for && !places.map(|place| place.join(name)).any(|place| place.exists())
}

/// Every fault of a document.
fn faults(path: &Path, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    for (number, line) in prose(text) {
        let (spans, rest) = code_spans(line);
        let links = links(&rest).into_iter().filter_map(|target| broken_link(path, text, target));
        let missing = spans.into_iter().filter(|span| is_missing(path, span));
        let missing = missing.map(|span| format!("{span}: no such file"));
        let place = path.strip_prefix(root()).unwrap_or(path).display();
        faults.extend(links.chain(missing).map(|fault| format!("{place}:{number}: {fault}")));
    }
    faults
}

#[test]
fn links_and_named_files_exist() {
    let documents = files(&[".md"]);
    assert!(documents.len() > 30, "only {} documents were found", documents.len());
    let faults: Vec<_> =
        documents.iter().flat_map(|path| faults(path, &std::fs::read_to_string(path).unwrap())).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn documents_that_code_names_exist() {
    let mut named = 0;
    let mut faults = Vec::new();
    for path in files(&[".rs", ".toml"]) {
        let text = std::fs::read_to_string(&path).unwrap();
        for (at, _) in text.match_indices("docs/") {
            let whole =
                !text[..at].ends_with(|c: char| c.is_alphanumeric() || matches!(c, '/' | '.' | '-' | '_'));
            let end = text[at..].find(|c: char| !(c.is_alphanumeric() || matches!(c, '/' | '.' | '-' | '_')));
            let name = text[at..at + end.unwrap_or(text.len() - at)].trim_end_matches('.');
            if whole && name.ends_with(".md") {
                named += 1;
                if !root().join(name).exists() {
                    faults.push(format!("{}: {name}", path.display()));
                }
            }
        }
    }
    assert!(named >= 10, "only {named} were found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Links from README lead to every page in `docs/`.
#[test]
fn every_page_is_linked() {
    let documents = files(&[".md"]);
    let mut reached = vec![root().join("README.md")];
    let mut next = 0;
    while let Some(path) = reached.get(next).cloned() {
        next += 1;
        let text = std::fs::read_to_string(&path).unwrap();
        for (_, line) in prose(&text) {
            for target in links(line) {
                let file = target.split('#').next().unwrap_or_default();
                let Ok(other) = path.parent().unwrap().join(file).canonicalize() else { continue };
                if file.ends_with(".md") && !reached.contains(&other) {
                    reached.push(other);
                }
            }
        }
    }
    let reached: Vec<_> = reached.iter().map(|path| path.canonicalize().unwrap()).collect();
    let lost: Vec<_> = documents
        .iter()
        .filter(|path| path.starts_with(root().join("docs")))
        .filter(|path| !reached.contains(&path.canonicalize().unwrap()))
        .collect();
    assert!(lost.is_empty(), "no page links to {lost:?}");
}

#[test]
fn broken_links_and_missing_files_are_reported() {
    let path = root().join("docs/safety/README.md");
    let wrong = "# One\n\nSee [a](argument.md), [b](nowhere.md), [c](#two), \
                 [d](argument.md#no-such-heading) and `kernel/src/none.rs`.\n";
    let found = faults(&path, wrong);
    assert_eq!(found.len(), 4, "{found:?}");
    let right = "# One\n\n## What is `this`?\n\nSee [a](#what-is-this), [b](https://example.org/x) and \
                 `kernel/src/lib.rs`, `fuzz/artifacts/TARGET`.\n\n```text\n[c](nowhere.md)\n```\n";
    assert_eq!(faults(&path, right), [""; 0]);
}

/// Whether a source file has the function, as `name` or `Type::name`. A type needs an `impl` in the same file.
fn has_function(source: &str, function: &str) -> bool {
    let parts = function.rsplit_once("::");
    let (kind, name) = parts.map_or((None, function), |(kind, name)| (Some(kind), name));
    let declared = ["(", "<"].iter().any(|next| source.contains(&format!("fn {name}{next}")));
    let is_of = |line: &str, kind: &str| {
        let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        line.trim_start().starts_with("impl") && words.any(|word| word == kind)
    };
    declared && kind.is_none_or(|kind| source.lines().any(|line| is_of(line, kind)))
}

/// Every fault of the tables of walks: a missing file or function, a second row of a function, wrong counts.
fn walk_faults(text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let (mut functions, mut named) = (BTreeSet::new(), BTreeSet::new());
    for (number, line) in prose(text) {
        let counts = format!("Counts: {} functions in {} files.", functions.len(), named.len());
        if line.starts_with("| `") {
            let (spans, _) = code_spans(line);
            let [file, function, ..] = spans[..] else {
                faults.push(format!("{number}: the row names no file and function"));
                continue;
            };
            let source = std::fs::read_to_string(root().join(file)).unwrap_or_default();
            if !has_function(&source, function) {
                faults.push(format!("{number}: {file} has no function {function}"));
            }
            if !functions.insert((file, function)) {
                faults.push(format!("{number}: {function} has two rows"));
            }
            named.insert(file);
        } else if line.starts_with("Counts: ") {
            if !line.starts_with(&counts) {
                faults.push(format!("{number}: the table gives: {counts}"));
            }
            functions.clear();
            named.clear();
        }
    }
    if !functions.is_empty() {
        faults.push("the last table has no counts".into());
    }
    faults
}

#[test]
fn walks_name_functions_that_exist_and_count_them() {
    let text = std::fs::read_to_string(root().join("docs/contributor/walks.md")).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with("Counts: ")).count(), 3);
    let faults = walk_faults(&text);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn wrong_rows_and_counts_of_walks_are_noticed() {
    let row = |file: &str, function: &str| format!("| `{file}` | `{function}` | one form → the other |\n");
    let arc = |function| row("kernel/src/exact/arc.rs", function);
    let two = arc("Arc::new") + &row("kernel/src/curve.rs", "fit_arc");
    assert_eq!(walk_faults(&format!("{two}\nCounts: 2 functions in 2 files. Further words.\n")), [""; 0]);
    let one = "\nCounts: 1 functions in 1 files.\n";
    for wrong in [
        arc("Arc::renew") + one,
        arc("Beam::new") + one,
        row("kernel/src/none.rs", "Arc::new") + one,
        format!("{}{}{one}", arc("Arc::new"), arc("Arc::new")),
        format!("{two}{one}"),
        arc("Arc::new"),
        "| `kernel/src/exact/arc.rs` | | |\n".into(),
    ] {
        assert_eq!(walk_faults(&wrong).len(), 1, "{wrong}");
    }
}
