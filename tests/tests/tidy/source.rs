//! The files of the repository, and the report on those that break a rule.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Folders that hold build results, or nothing of ours.
const LEFT_OUT: [&str; 3] = ["target", "artifacts", "coverage"];
/// Hidden folders that are part of the repository.
const HIDDEN: [&str; 1] = [".ci"];

/// The names of all files at a place of the repository, from its root; the empty place is the root.
pub fn files(place: &str) -> Vec<String> {
    fn visit(path: &Path, into: &mut Vec<PathBuf>) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !path.is_dir() {
            into.push(path.to_path_buf());
        } else if !LEFT_OUT.contains(&name.as_ref())
            && (!name.starts_with('.') || HIDDEN.contains(&name.as_ref()))
        {
            std::fs::read_dir(path).unwrap().for_each(|entry| visit(&entry.unwrap().path(), into));
        }
    }
    let mut paths = Vec::new();
    visit(&root().join(place), &mut paths);
    let name = |path: &PathBuf| path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
    let mut names: Vec<String> = paths.iter().map(name).collect();
    names.sort();
    assert!(!names.is_empty(), "{place}: no such place");
    names
}

/// The text of a file.
pub fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The Rust files at a place, with their text.
pub fn sources(place: &str) -> Vec<(String, String)> {
    let names = files(place).into_iter().filter(|name| name.ends_with(".rs"));
    names.map(|name| (name.clone(), read(&name))).collect()
}

/// The lines of a Rust file without its inline tests, each with its number.
pub fn product(text: &str) -> Vec<(usize, &str)> {
    let mut lines = Vec::new();
    let mut in_tests = false;
    let mut before = "";
    for (number, line) in text.lines().enumerate() {
        let is_module = line.split_whitespace().any(|word| word == "mod") && line.ends_with('{');
        in_tests |= before == "#[cfg(test)]" && is_module && !line.starts_with(' ');
        if !in_tests {
            lines.push((number + 1, line));
        }
        in_tests &= line != "}";
        before = line;
    }
    lines
}

/// What breaks a rule.
pub struct Offender {
    /// What an exception names: a file, a type, or a function as `file/name`.
    pub subject: String,
    /// Where it is, and what is wrong there.
    pub fault: String,
}

impl Offender {
    /// A fault at a line of a file. Its subject is the file.
    pub fn at(file: &str, line: usize, fault: impl std::fmt::Display) -> Self {
        Self { subject: file.into(), fault: format!("{file}:{line}: {fault}") }
    }
}

/// Files, folders or types that may break a rule, each with a reason. A reason that begins with `owed` is a
/// promise to mend it.
pub type Exceptions = [(&'static str, &'static str)];

/// Fails with a list of all offenders that are no exception, and of all exceptions that nothing needs. A
/// promise that was kept may stay in the list for a while.
pub fn judge(rule: &str, offenders: &[Offender], exceptions: &Exceptions) {
    let excuses = |(place, _): &(&str, &str), offender: &Offender| {
        offender.subject.strip_prefix(place).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    let unexcused = offenders.iter().filter(|&offender| !exceptions.iter().any(|one| excuses(one, offender)));
    let needless = exceptions.iter().filter(|one| !offenders.iter().any(|offender| excuses(one, offender)));
    let (kept, needless): (Vec<_>, Vec<_>) = needless.partition(|(_, reason)| reason.starts_with("owed"));
    kept.iter().for_each(|(place, _)| println!("{rule}: {place} is mended, take it from the list"));
    let mut faults: Vec<String> = unexcused.map(|offender| offender.fault.clone()).collect();
    faults.extend(needless.iter().map(|(place, _)| format!("{place}: an exception that nothing needs")));
    assert!(faults.is_empty(), "{rule}:\n{}", faults.join("\n"));
}

#[test]
fn unexcused_offenders_and_needless_exceptions_are_noticed() {
    let fails = |offenders: &[Offender], exceptions: &Exceptions| {
        std::panic::catch_unwind(|| {
            let offenders: Vec<_> = offenders
                .iter()
                .map(|one| Offender { subject: one.subject.clone(), fault: String::new() })
                .collect();
            judge("a rule", &offenders, exceptions);
        })
        .is_err()
    };
    let offenders = [Offender::at("planner/src/plan.rs", 3, "too long")];
    assert!(fails(&offenders, &[]));
    assert!(fails(&offenders, &[("planner/src/pla", "no whole name")]));
    assert!(fails(&offenders, &[("planner/src", "a folder"), ("kernel", "nothing is wrong there")]));
    assert!(!fails(&offenders, &[("planner/src", "a folder"), ("kernel", "owed")]));
}
