//! Mutation of the trusted code with cargo-mutants. A test must notice every change that it makes.
//!
//! `.ci/weekly` runs it, part by part, with the settings of `proofs/mutants`. `keepout-proofs mutants` keeps
//! the outcomes in `proofs/results/mutants.tsv`, and writes the page `docs/safety/mutants.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

use keepout_planner::sha256::{hash, hex};
use serde::Deserialize;

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
    /// A digest of the file as it was.
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
    Ok(hex(&hash(&fs::read(root.join(file))?)[..8]))
}

/// The file with the rows, under the root of the workspace.
fn table(root: &Path) -> PathBuf {
    root.join("proofs/results/mutants.tsv")
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
        let kept = kept.lines().filter_map(MutantRow::of_line).map(|row| (row.name.clone(), row));
        let kept: BTreeMap<String, MutantRow> = kept.collect();
        let mut files: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for mutant in listed {
            files.entry(mutant.file).or_default().push(mutant.name);
        }
        let mut rows = Vec::new();
        for (file, names) in &files {
            let digest = digest(root, file)?;
            for name in names {
                let kept = kept.get(name).filter(|row| row.digest == digest).map(|row| row.fate);
                rows.extend(new.get(name).copied().or(kept).map(|fate| MutantRow {
                    name: name.clone(),
                    file: file.clone(),
                    fate,
                    digest: digest.clone(),
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

    /// The page. `settings` are the texts of `proofs/mutants`, whose exclusions it lists with their reasons.
    #[must_use]
    pub fn page(&self, settings: &[String]) -> String {
        let mut page = String::from(
            "# Mutation of the trusted code\n\n`.ci/weekly` lets cargo-mutants change the trusted code of kernel, \
             guard and dialects, one place at a time: other\noperators, other results of functions, arms of \
             matches that are missing. The unit tests and the properties must notice\neach change. \
             `keepout-proofs mutants` writes this page from the outcomes, `proofs/results/mutants.tsv`. A row of \
             a\nfile that changed since does not count: such mutants are *not tried*.\n\n\
             | file | mutants | noticed | timed out | does not compile | missed | not tried |\n\
             |---|---|---|---|---|---|---|\n",
        );
        let mut totals = [0; 6];
        for (file, names) in &self.listed {
            let of_file: Vec<_> = self.rows.iter().filter(|row| row.file == *file).collect();
            let count = |fate| of_file.iter().filter(|row| row.fate == fate).count();
            let [noticed, late, unbuilt, missed] = MutantFate::ALL.map(count);
            let cells = [names.len(), noticed, late, unbuilt, missed, names.len() - of_file.len()];
            page.push_str(&table_line(&format!("`{file}`"), cells));
            totals.iter_mut().zip(cells).for_each(|(total, cell)| *total += cell);
        }
        page.push_str(&table_line("all", totals));
        page.push_str("\n## Missed\n\n");
        let missed: Vec<&str> = self.missed().collect();
        if missed.is_empty() {
            page.push_str("None.\n");
        }
        missed.iter().for_each(|name| page.push_str(&format!("- `{name}`\n")));
        page.push_str(
            "\n## Left out, with the reason\n\nThese changes are not tried, because no test can notice them: they \
             change no answer that anything relies on. The\npattern is matched with the name of the mutant.\n\n\
             | pattern | reason |\n|---|---|\n",
        );
        for (pattern, reason) in settings.iter().flat_map(|text| exclusions(text)) {
            let pattern = pattern.replace('|', "\\|");
            let _ = writeln!(page, "| `{pattern}` | {reason} |");
        }
        page
    }
}

fn table_line(name: &str, cells: [usize; 6]) -> String {
    let cells = cells.map(|cell| cell.to_string());
    format!("| {name} | {} |\n", cells.join(" | "))
}

/// The patterns of `exclude_re` in settings, each with the comment above it.
fn exclusions(settings: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut reason: Vec<&str> = Vec::new();
    let mut after_pattern = false;
    let begin = |line: &&str| !line.starts_with("exclude_re");
    let inside = settings.lines().skip_while(begin).skip(1).map(str::trim).take_while(|line| *line != "]");
    for line in inside {
        if let Some(comment) = line.strip_prefix("# ") {
            if std::mem::take(&mut after_pattern) {
                reason.clear();
            }
            reason.push(comment);
        } else {
            let pattern = line.trim_end_matches(',').trim_matches(['"', '\'']);
            found.push((pattern.into(), reason.join(" ")));
            after_pattern = true;
        }
    }
    found
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
        let settings =
            ["exclude_re = [\n    # It is\n    # the same.\n    \"a|b\",\n    'c',\n]\n".to_string()];
        let page = made.page(&settings);
        for line in [
            "| `kernel/src/lib.rs` | 3 | 1 | 0 | 0 | 1 | 1 |",
            "- `kernel/src/lib.rs:3:1: c`",
            "| `a\\|b` | It is the same. |",
            "| `c` | It is the same. |",
        ] {
            assert!(page.contains(line), "{line} is missing in\n{page}");
        }
        fs::remove_dir_all(root).expect("the folder is removed");
    }

    #[test]
    fn rows_are_kept_until_their_file_changes() {
        let root = root("kept");
        fs::write(table(&root), table_of(&root, OUTCOMES).text()).expect("the table is written");
        assert_eq!(table_of(&root, r#"{"outcomes": []}"#).untried(), 1);
        fs::write(root.join("kernel/src/lib.rs"), "1\n2\n3\n4\n").expect("the file is written");
        assert_eq!(table_of(&root, r#"{"outcomes": []}"#).untried(), 3);
        fs::remove_dir_all(root).expect("the folder is removed");
    }
}
