//! Folders hold more than one file.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::{Exceptions, Offender, files, judge};

/// Folders with one file.
const WITH_ONE_FILE: &Exceptions = &[
    ("executor/src/dialect/venus", "owed: results of the fault catalogue hold for the path of venus.rs"),
    ("fuzz/seeds", "the seeds of each fuzz target"),
    ("tests/fuzz", "the inputs at which each fuzz target once failed"),
    ("tests/studies/src/bin", "Cargo looks for further programs there"),
];

/// The folders with one entry, and the files with the name of their folder beside its `mod.rs`.
fn offenders(files: &[String]) -> Vec<Offender> {
    let mut folders: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for file in files {
        for (at, _) in file.match_indices('/') {
            let entry = file[at + 1..].split('/').next().unwrap_or_default();
            folders.entry(&file[..at]).or_default().insert(entry);
        }
    }
    let mut offenders = Vec::new();
    for (folder, entries) in folders {
        let mut add = |fault: String| offenders.push(Offender { subject: folder.into(), fault });
        let namesake = format!("{}.rs", folder.rsplit('/').next().unwrap_or(folder));
        if entries.len() == 1 {
            add(format!("{folder}/{} is alone in its folder", entries.iter().copied().collect::<String>()));
        }
        if entries.contains("mod.rs") && entries.contains(namesake.as_str()) {
            add(format!("{folder}/{namesake} has the name of its folder"));
        }
    }
    offenders
}

#[test]
fn folders_hold_more_than_one_file() {
    let rule = "A folder holds more than one file, and beside mod.rs none of its own name";
    judge(rule, &offenders(&files("")), WITH_ONE_FILE);
}

#[test]
fn lonely_files_and_namesakes_are_noticed() {
    let faults = |files: &[&str]| {
        let files: Vec<String> = files.iter().map(ToString::to_string).collect();
        offenders(&files).into_iter().map(|offender| offender.subject).collect::<Vec<_>>()
    };
    assert_eq!(faults(&["a/b/mod.rs", "a/b/c.rs", "a/d.rs"]), [""; 0]);
    assert_eq!(faults(&["a/b/mod.rs", "a/c.rs"]), ["a/b"]);
    assert_eq!(faults(&["a/b/mod.rs", "a/b/b.rs", "a/c.rs"]), ["a/b"]);
}
