//! Mutation of the trusted code with cargo-mutants. A test must notice every change that it makes.
//!
//! `.ci/weekly` runs it, part by part, with the settings of `proofs/mutants`. `keepout-proofs mutants` keeps
//! the outcomes in `proofs/results/mutants.tsv`, and writes the page `docs/safety/mutants.md`.

mod page;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::{fs, io};

pub use page::{Exclusion, exclusions};
use serde::Deserialize;

use crate::trace::code_digest;

/// The parts of the trusted code. `proofs/mutants/PART.toml` holds the settings of each.
pub const PARTS: [&str; 3] = ["kernel", "guard", "dialects"];

/// What became of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MutantFate {
    /// A test failed.
    Noticed,
    /// The tests did not end in time, and they do without the change.
    TimedOut,
    /// It does not compile.
    Unbuilt,
    /// All tests passed.
    Missed,
}

impl MutantFate {
    const ALL: [Self; 4] = [Self::Noticed, Self::TimedOut, Self::Unbuilt, Self::Missed];

    fn name(self) -> &'static str {
        match self {
            Self::Noticed => "noticed",
            Self::TimedOut => "timed out",
            Self::Unbuilt => "does not compile",
            Self::Missed => "missed",
        }
    }

    /// The fate under the name that cargo-mutants gives it.
    fn of_summary(summary: &str) -> Option<Self> {
        Some(match summary {
            "CaughtMutant" => Self::Noticed,
            "Timeout" => Self::TimedOut,
            "Unviable" => Self::Unbuilt,
            "MissedMutant" => Self::Missed,
            _ => return None,
        })
    }
}

/// A mutant and its fate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MutantRow {
    /// File, line, column and change, as cargo-mutants writes them.
    pub name: String,
    /// The file that was changed.
    pub file: String,
    /// What became of it.
    pub fate: MutantFate,
    /// A digest of the file's code as it was.
    pub digest: String,
}

impl MutantRow {
    fn line(&self) -> String {
        format!("{}\t{}\t{}\t{}\n", self.name, self.file, self.fate.name(), self.digest)
    }

    fn of_line(line: &str) -> Option<Self> {
        let [name, file, fate, digest] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
        let fate = MutantFate::ALL.into_iter().find(|each| each.name() == fate)?;
        Some(Self { name: name.into(), file: file.into(), fate, digest: digest.into() })
    }
}

/// A mutant in the lists and outcomes of cargo-mutants.
#[derive(Clone, Debug, Deserialize)]
pub struct ListedMutant {
    name: String,
    file: String,
}

#[derive(Deserialize)]
struct Outcomes {
    outcomes: Vec<Outcome>,
}

#[derive(Deserialize)]
struct Outcome {
    scenario: Scenario,
    summary: String,
}

#[derive(Deserialize)]
enum Scenario {
    Baseline,
    Mutant(ListedMutant),
}

/// The mutants of `cargo mutants --list --json`.
///
/// # Errors
/// When the text is something else.
pub fn of_list(text: &str) -> io::Result<Vec<ListedMutant>> {
    Ok(serde_json::from_str(text)?)
}

/// The fates of an `outcomes.json` that cargo-mutants wrote, by the names of the mutants.
///
/// # Errors
/// When the text is something else.
pub fn of_outcomes(text: &str) -> io::Result<BTreeMap<String, MutantFate>> {
    let outcomes: Outcomes = serde_json::from_str(text)?;
    let fate = |outcome: Outcome| match outcome.scenario {
        Scenario::Baseline => None,
        Scenario::Mutant(mutant) => Some((mutant.name, MutantFate::of_summary(&outcome.summary)?)),
    };
    Ok(outcomes.outcomes.into_iter().filter_map(fate).collect())
}

fn digest(root: &Path, file: &str) -> io::Result<String> {
    Ok(code_digest(&fs::read_to_string(root.join(file))?))
}

/// The line and column in a mutant's name, and the change.
fn place_and_change(name: &str) -> ((u32, u32), &str) {
    let mut fields = name.splitn(4, ':');
    let mut number = || fields.next().and_then(|field| field.parse().ok()).unwrap_or(0);
    let (_file, line, column) = (number(), number(), number());
    ((line, column), fields.next().unwrap_or_default())
}

/// Fates of the mutants of files that are as they were, by file and change. A comment moves the lines of mutants and
/// changes none, so the nth mutant with some change is the one that was the nth. Where their number differs, an
/// exclusion by line no longer fits, and none is kept.
struct KeptFates(BTreeMap<(String, String), VecDeque<MutantFate>>);

impl KeptFates {
    fn of(mut rows: Vec<MutantRow>) -> Self {
        rows.sort_by_key(|row| place_and_change(&row.name).0);
        let mut fates: BTreeMap<_, VecDeque<_>> = BTreeMap::new();
        for row in rows {
            let change = place_and_change(&row.name).1.to_string();
            fates.entry((row.file, change)).or_default().push_back(row.fate);
        }
        Self(fates)
    }

    /// Forgets the fates of a change that the file has more or less often now.
    fn forget_unequal(&mut self, listed: &BTreeMap<String, Vec<String>>) {
        self.0.retain(|(file, change), fates| {
            let now =
                listed.get(file).into_iter().flatten().filter(|name| place_and_change(name).1 == *change);
            now.count() == fates.len()
        });
    }

    /// The fate of the next mutant of the file with this name's change.
    fn next(&mut self, file: &str, name: &str) -> Option<MutantFate> {
        self.0.get_mut(&(file.into(), place_and_change(name).1.into()))?.pop_front()
    }
}

/// The file with the rows, under the root of the workspace.
fn table(root: &Path) -> PathBuf {
    root.join("proofs/results/mutants.tsv")
}

/// The files that have kept rows.
///
/// # Errors
/// When the rows cannot be read.
pub fn files(root: &Path) -> io::Result<BTreeSet<PathBuf>> {
    let rows = fs::read_to_string(table(root))?;
    Ok(rows.lines().filter_map(MutantRow::of_line).map(|row| row.file.into()).collect())
}

/// The files that changed since the kept rows were tried.
///
/// # Errors
/// When the rows or one of their files cannot be read.
pub fn changed_files(root: &Path) -> io::Result<BTreeSet<String>> {
    let rows = fs::read_to_string(table(root))?;
    let mut changed = BTreeSet::new();
    for row in rows.lines().filter_map(MutantRow::of_line) {
        if !changed.contains(&row.file) && digest(root, &row.file)? != row.digest {
            changed.insert(row.file);
        }
    }
    Ok(changed)
}

/// The outcomes for the listed mutants, of the code as it is now.
#[derive(Debug)]
pub struct MutantTable {
    listed: BTreeMap<String, Vec<String>>,
    rows: Vec<MutantRow>,
}

impl MutantTable {
    /// The kept rows, and the new fates of the code as it is now, which replace them. Rows of files that changed
    /// since, and of mutants that are not listed, are left out.
    ///
    /// # Errors
    /// When a listed file cannot be read.
    pub fn new(
        root: &Path,
        listed: Vec<ListedMutant>,
        new: &BTreeMap<String, MutantFate>,
    ) -> io::Result<Self> {
        let kept = fs::read_to_string(table(root)).unwrap_or_default();
        let mut files: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for mutant in listed {
            files.entry(mutant.file).or_default().push(mutant.name);
        }
        let digests: BTreeMap<String, String> =
            files.keys().map(|file| Ok((file.clone(), digest(root, file)?))).collect::<io::Result<_>>()?;
        let is_current = |row: &MutantRow| digests.get(&row.file) == Some(&row.digest);
        let mut kept =
            KeptFates::of(kept.lines().filter_map(MutantRow::of_line).filter(is_current).collect());
        kept.forget_unequal(&files);
        let mut rows = Vec::new();
        for (file, names) in &mut files {
            names.sort_by_key(|name| place_and_change(name).0);
            for name in names {
                let kept = kept.next(file, name);
                rows.extend(new.get(name).copied().or(kept).map(|fate| MutantRow {
                    name: name.clone(),
                    file: file.clone(),
                    fate,
                    digest: digests[file].clone(),
                }));
            }
        }
        Ok(Self { listed: files, rows })
    }

    /// The text of `proofs/results/mutants.tsv`.
    #[must_use]
    pub fn text(&self) -> String {
        self.rows.iter().map(MutantRow::line).collect()
    }

    /// Listed mutants that were not tried since their file changed.
    #[must_use]
    pub fn untried(&self) -> usize {
        self.listed.values().map(Vec::len).sum::<usize>() - self.rows.len()
    }

    /// The names of the missed mutants.
    pub fn missed(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().filter(|row| row.fate == MutantFate::Missed).map(|row| &*row.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: &str = r#"[{"name": "kernel/src/lib.rs:1:1: a", "file": "kernel/src/lib.rs"},
        {"name": "kernel/src/lib.rs:2:1: b", "file": "kernel/src/lib.rs"},
        {"name": "kernel/src/lib.rs:3:1: c", "file": "kernel/src/lib.rs"}]"#;
    const OUTCOMES: &str = r#"{"outcomes": [
        {"scenario": "Baseline", "summary": "Success"},
        {"scenario": {"Mutant": {"name": "kernel/src/lib.rs:1:1: a", "file": "kernel/src/lib.rs"}},
         "summary": "CaughtMutant"},
        {"scenario": {"Mutant": {"name": "kernel/src/lib.rs:3:1: c", "file": "kernel/src/lib.rs"}},
         "summary": "MissedMutant"}]}"#;

    /// A workspace of one file, in a folder of its own.
    fn root(name: &str) -> PathBuf {
        let root = std::env::temp_dir().join(format!("keepout-mutants-{name}-{}", std::process::id()));
        fs::create_dir_all(root.join("kernel/src")).expect("the folder is made");
        fs::create_dir_all(root.join("proofs/results")).expect("the folder is made");
        fs::write(root.join("kernel/src/lib.rs"), "1\n2\n3\n").expect("the file is written");
        root
    }

    fn table_of(root: &Path, outcomes: &str) -> MutantTable {
        let new = of_outcomes(outcomes).expect("the outcomes are read");
        let listed = of_list(LIST).expect("the list is read");
        MutantTable::new(root, listed, &new).expect("the table is made")
    }

    #[test]
    fn page_counts_every_listed_mutant_and_names_the_missed_one() {
        let root = root("page");
        let made = table_of(&root, OUTCOMES);
        assert_eq!(
            (made.untried(), made.missed().collect::<Vec<_>>()),
            (1, vec!["kernel/src/lib.rs:3:1: c"])
        );
        let settings = r#"exclude_re = [
                # Same answers: it is
                # the same.
                "a|\\*b",
                'rs:[23]',
            ]
        "#;
        let listed = of_list(LIST).expect("the list is read");
        let number = |each: Exclusion| {
            let mutants = each.matches(&listed).expect("it leaves some out");
            (each, mutants)
        };
        let numbered: Vec<_> = exclusions(settings).into_iter().map(number).collect();
        let page = made.page(&numbered, 5);
        for line in [
            "| `kernel/src/lib.rs` | 3 | 1 | 0 | 0 | 1 | 1 |",
            "- `kernel/src/lib.rs:3:1: c`",
            "\n2 of 5 changes are not tried",
            "| `a\\|\\*b` | 1 | Same answers | it is the same. |",
            "| `rs:[23]` | 2 | Same answers | it is the same. |",
        ] {
            assert!(page.contains(line), "{line} is missing in\n{page}");
        }
        fs::remove_dir_all(root).expect("the folder is removed");
    }

    #[test]
    fn exclusion_that_matches_nothing_is_refused() {
        let listed = of_list(LIST).expect("the list is read");
        for (pattern, why) in [("lib.rs:4", "matches no mutant"), ("(", "unclosed group")] {
            let exclusion = Exclusion { pattern: pattern.into(), reason: String::new() };
            assert!(exclusion.matches(&listed).expect_err(pattern).contains(why), "{pattern}");
        }
    }

    #[test]
    fn rows_are_kept_until_their_file_changes() {
        let root = root("kept");
        fs::write(table(&root), table_of(&root, OUTCOMES).text()).expect("the table is written");
        assert_eq!(table_of(&root, r#"{"outcomes": []}"#).untried(), 1);
        let write =
            |text: &str| fs::write(root.join("kernel/src/lib.rs"), text).expect("the file is written");
        write("// A comment.\n\n1\n2\n3\n");
        assert_eq!(table_of(&root, r#"{"outcomes": []}"#).untried(), 1);
        write("1\n2\n3\n4\n");
        assert_eq!(table_of(&root, r#"{"outcomes": []}"#).untried(), 3);
        fs::remove_dir_all(root).expect("the folder is removed");
    }
}
