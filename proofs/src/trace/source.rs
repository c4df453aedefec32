//! Comments that tie code to requirements.
//!
//! - `// Implements SR-07.` ties the item below it; in a comment at the head of a file (`//!`), the whole file.
//! - `// Evidence for SR-07, SR-08.` ties all properties, harnesses, worlds, theorems or fuzz targets below it, up to
//!   the next such comment. It ties the one test below it; at the head of a file, all tests of the file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

use keepout_planner::sha256::{hash, hex};

use super::statements::numbers;

/// Words of a comment that ties code.
pub const IMPLEMENTS: &str = "Implements SR-";
/// Words of a comment that ties evidence.
pub const EVIDENCE: &str = "Evidence for SR-";

/// A file of the workspace.
pub struct SourceFile {
    /// Its path, from the root of the workspace.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

/// All Rust files of the workspace under a folder, in order.
///
/// # Errors
/// When a folder or a file cannot be read.
pub fn files(root: &Path, folder: &str) -> io::Result<Vec<SourceFile>> {
    let mut found = Vec::new();
    let mut open = vec![root.join(folder)];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                if !path.ends_with("target") {
                    open.push(path);
                }
            } else if path.extension().is_some_and(|end| end == "rs") {
                let text = fs::read_to_string(&path)?;
                let path = path.strip_prefix(root).unwrap_or(&path).to_path_buf();
                found.push(SourceFile { path, text });
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// The requirements that a comment names behind these words; `None` when the line is no such comment.
fn tied(line: &str, words: &str) -> Option<Vec<String>> {
    let line = line.trim_start();
    let at = line.find(words).filter(|_| line.starts_with("//"))?;
    let list = line[at..].split_once('.').map_or(&line[at..], |(list, _)| list);
    Some(numbers(list, "SR-"))
}

/// The requirements at the head of a file.
pub fn of_file(text: &str, words: &str) -> Vec<String> {
    text.lines()
        .take_while(|line| line.starts_with("//!") || line.trim().is_empty())
        .filter_map(|line| tied(line, words))
        .flatten()
        .collect()
}

/// The requirements of the item whose name is in this line of a list: those of the last comment above it.
pub fn of_listed(text: &str, line: usize, words: &str) -> Vec<String> {
    let above: Vec<&str> = text.lines().take(line).collect();
    above.iter().rev().find_map(|line| tied(line, words)).unwrap_or_default()
}

/// A digest of a text's code: of its lines without comments, blank lines and indentation.
#[must_use]
pub fn code_digest(text: &str) -> String {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
    hex(&hash(lines.flat_map(|line| [line, "\n"]).collect::<String>().as_bytes())[..8])
}

/// The item that begins in a line, up to the next line that is indented no more and does not close a bracket.
pub fn item_at(text: &str, line: usize) -> String {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let mut lines = text.lines().skip(line);
    let first = lines.next().unwrap_or_default();
    let ends = |line: &&str| {
        let [depth, own] = [line, first].map(indent);
        let closes = line.trim_start().starts_with(['}', ')', ']']);
        !line.trim().is_empty() && (depth < own || depth == own && !closes)
    };
    std::iter::once(first).chain(lines.take_while(|line| !ends(line))).flat_map(|line| [line, "\n"]).collect()
}

/// A text, with all functions and constants of these files that it names, those that they name, and so on. Methods are
/// left out: their names say too little.
pub fn with_helpers(text: String, files: &[&str]) -> String {
    let mut declared: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for file in files {
        for (line, _) in file.lines().enumerate().filter(|(_, line)| !line.starts_with([' ', '/', '#'])) {
            let item = file.lines().nth(line).and_then(free_item);
            item.into_iter().for_each(|name| declared.entry(name).or_default().push(item_at(file, line)));
        }
    }
    let mut whole = text;
    let mut read = 0;
    while read < whole.len() {
        let named: BTreeSet<String> = words(&whole[read..]).map(String::from).collect();
        read = whole.len();
        whole.extend(named.iter().filter_map(|name| declared.remove(name.as_str())).flatten());
    }
    whole
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// The name of the free function or constant that a line declares.
fn free_item(line: &str) -> Option<&str> {
    let mut words = words(line).skip_while(|word| matches!(*word, "pub" | "crate" | "super" | "in"));
    let kind = words.next()?;
    let name = words.next()?;
    match kind {
        "const" if name == "fn" => words.next(),
        "fn" | "const" | "static" => Some(name),
        _ => None,
    }
}

/// The line of an item's name: the first that holds one of the forms.
pub fn line_of(text: &str, forms: &[String]) -> Option<usize> {
    text.lines().position(|line| forms.iter().any(|form| line.contains(form.as_str())))
}

/// The items of a file with a comment of their own: name and requirements.
pub fn tied_items(text: &str, words: &str) -> Vec<(String, Vec<String>)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (n, line) in lines.iter().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//!")) {
        let Some(requirements) = tied(line, words) else { continue };
        let below = lines[n + 1..].iter().take(8);
        if let Some(name) =
            below.filter(|line| !line.trim_start().starts_with("//")).find_map(|line| name(line))
        {
            found.push((name, requirements));
        }
    }
    found
}

/// The name of the item that a line declares.
fn name(line: &str) -> Option<String> {
    let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    words.find(|word| ["fn", "struct", "enum", "const", "trait", "impl", "mod", "type"].contains(word))?;
    words.find(|word| *word != "fn").map(String::from)
}

/// A test that is evidence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EvidentTest {
    /// Its name.
    pub name: String,
    /// The requirements that it is evidence for.
    pub requirements: Vec<String>,
    /// Its text.
    pub text: String,
}

/// Attributes of tests that do not run, or pass when they panic.
const NO_EVIDENCE: [&str; 4] = ["#[ignore", "#[cfg", "#[should_panic", "/*"];

/// A file's tests with a comment of their own, or all when the file's head has one. Tests that are ignored, compiled
/// under a condition or expected to panic are left out.
pub fn tests(file: &SourceFile) -> Vec<EvidentTest> {
    let lines: Vec<&str> = file.text.lines().collect();
    let mut found = Vec::new();
    for (n, _) in lines.iter().enumerate().filter(|(_, line)| line.trim() == "#[test]") {
        let Some(at) = (n..lines.len()).find(|at| lines[*at].contains("fn ")) else { continue };
        let below = lines[n..at].iter().copied();
        let around =
            lines[..n].iter().rev().copied().take_while(|line| line.trim_start().starts_with(['#', '/']));
        if below.chain(around).any(|line| NO_EVIDENCE.iter().any(|word| line.contains(word))) {
            continue;
        }
        let above = lines[..n].iter().rev().take_while(|line| line.trim_start().starts_with("//"));
        let own = above.clone().find_map(|line| tied(line, EVIDENCE));
        let requirements = own.unwrap_or_else(|| of_file(&file.text, EVIDENCE));
        if let (Some(name), false) = (name(lines[at]), requirements.is_empty()) {
            // A unit test's helpers are in its module, beside it. The code under test is not.
            let begin = lines.iter().position(|line| line.trim() == "#[cfg(test)]").unwrap_or(0);
            let text = with_helpers(item_at(&file.text, at), &[&beside(&lines[begin..], lines[at])]);
            found.push(EvidentTest { name, requirements, text });
        }
    }
    found
}

/// The lines, less the indentation of this one: items of a module become free items.
fn beside(lines: &[&str], line: &str) -> String {
    let own = line.len() - line.trim_start().len();
    lines.iter().flat_map(|line| [line.get(own..).unwrap_or(line.trim_start()), "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_end_before_the_next() {
        let text = "list! {\n    one |d| {\n        f(d)\n    }\n        => \"why\";\n    two |d| {\n    }\n}\n\n\
                    fn a() {\n}\n";
        assert_eq!(item_at(text, 1), "    one |d| {\n        f(d)\n    }\n        => \"why\";\n");
        assert_eq!(item_at(text, 5), "    two |d| {\n    }\n");
        assert_eq!(item_at(text, 9), "fn a() {\n}\n");
        assert_eq!(code_digest(" // why\n\n  one\n"), code_digest("one"));
    }

    #[test]
    fn helpers_belong_to_the_text() {
        let text = "fn asks() {\n    helper(1);\n}\n";
        let file = "const LIMIT: u8 = 2;\n\npub(crate) fn helper(n: u8) {\n    assert!(n < LIMIT);\n}\n\n\
                    fn other() {}\n";
        let whole = with_helpers(text.into(), &[file]);
        assert!(whole.contains("assert!(n < LIMIT)") && whole.contains("const LIMIT"), "{whole}");
        assert!(!whole.contains("other"), "{whole}");
        let module = "#[cfg(test)]\nmod tests {\n    // Evidence for SR-01.\n    #[test]\n    fn asks() {\n        \
                      helper();\n    }\n\n    fn helper() {\n        assert!(true);\n    }\n}\n";
        let found = tests(&SourceFile { path: "a.rs".into(), text: module.into() });
        assert!(found[0].text.contains("assert!(true)"), "{found:?}");
    }

    #[test]
    fn ignored_tests_are_no_evidence() {
        let text = "// Evidence for SR-01.\n#[test]\nfn runs() {}\n\n// Evidence for SR-02.\n#[test]\n\
                    #[ignore = \"slow\"]\nfn rests() {}\n";
        let file = SourceFile { path: "a.rs".into(), text: text.into() };
        let found: Vec<_> = tests(&file).into_iter().map(|test| (test.name, test.requirements)).collect();
        assert_eq!(found, [("runs".to_string(), vec!["SR-01".to_string()])]);
    }
}
