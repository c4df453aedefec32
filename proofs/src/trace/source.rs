//! Comments that tie code to requirements.
//!
//! - `// Implements SR-07.` ties the item below it; in a comment at the head of a file (`//!`), the whole file.
//! - `// Evidence for SR-07, SR-08.` ties all properties, harnesses, worlds, theorems or fuzz targets below it, up to
//!   the next such comment. It ties the one test below it; at the head of a file, all tests of the file.

use std::path::{Path, PathBuf};
use std::{fs, io};

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

/// The names of a file's tests with a comment of their own, or of all when the file's head has one. A test that is
/// ignored shows nothing.
pub fn tests(file: &SourceFile) -> Vec<(String, Vec<String>)> {
    let lines: Vec<&str> = file.text.lines().collect();
    let mut found = Vec::new();
    for (n, _) in lines.iter().enumerate().filter(|(_, line)| line.trim() == "#[test]") {
        let Some(at) = (n..lines.len()).find(|at| lines[*at].contains("fn ")) else { continue };
        if lines[n..at].iter().any(|line| line.trim().starts_with("#[ignore")) {
            continue;
        }
        let above = lines[..n].iter().rev().take_while(|line| line.trim_start().starts_with("//"));
        let own = above.clone().find_map(|line| tied(line, EVIDENCE));
        let requirements = own.unwrap_or_else(|| of_file(&file.text, EVIDENCE));
        if let (Some(name), false) = (name(lines[at]), requirements.is_empty()) {
            found.push((name, requirements));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_tests_are_no_evidence() {
        let text = "// Evidence for SR-01.\n#[test]\nfn runs() {}\n\n// Evidence for SR-02.\n#[test]\n\
                    #[ignore = \"slow\"]\nfn rests() {}\n";
        let file = SourceFile { path: "a.rs".into(), text: text.into() };
        assert_eq!(tests(&file), [("runs".to_string(), vec!["SR-01".to_string()])]);
    }
}
