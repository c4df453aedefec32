//! The page `docs/safety/mutants.md`.

use std::fmt::Write as _;

use regex::Regex;

use super::{ListedMutant, MutantFate, MutantTable};

/// A pattern of `exclude_re` in the settings of a part: the mutants that it matches are not tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exclusion {
    /// The pattern, as it is matched with the name of a mutant.
    pub pattern: String,
    /// The kind and the reason, from the comment above it.
    pub reason: String,
}

impl Exclusion {
    /// The number of mutants whose name the pattern matches.
    ///
    /// # Errors
    /// When it is no regular expression, or when it matches none, so that its reason is about nothing.
    pub fn matches(&self, mutants: &[ListedMutant]) -> Result<usize, String> {
        let pattern = Regex::new(&self.pattern).map_err(|error| error.to_string())?;
        match mutants.iter().filter(|mutant| pattern.is_match(&mutant.name)).count() {
            0 => Err("it matches no mutant: remove it".into()),
            count => Ok(count),
        }
    }
}

impl MutantTable {
    /// The page. `exclusions` are the patterns that leave out some of `all` mutants, each with their number.
    #[must_use]
    pub fn page(&self, exclusions: &[(Exclusion, usize)], all: usize) -> String {
        let mut page = String::from(
            "# Mutation of the trusted code\n\n`.ci/weekly` lets cargo-mutants change the trusted code of kernel, \
             guard and dialects, one place at a time: other\noperators, other results of functions, arms of \
             matches that are missing. The unit tests and the properties must notice\neach change. \
             `keepout-proofs mutants` writes this page from the outcomes, `proofs/results/mutants.tsv`. A row of \
             a\nfile that changed since does not count: such mutants are *not tried*. *Timed out* means that the \
             tests do not end with\nthe change, and do without it: they notice it.\n\n\
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
        let _ = writeln!(
            page,
            "\n## Left out, with the reason\n\n{} of {all} changes are not tried, because no test has to notice \
             them. The pattern is matched with the name\nof the mutant, and two patterns can match the same one.\n\n\
             - *Same answers*: the change gives the answers of the code, for the stated reason.\n\
             - *Refuses more*: the change admits nothing that the code refuses. The tool may have to go another way.\n\
             - *Out of reach*: a test would need more memory than a CI machine has.\n\n\
             | pattern | mutants | kind | reason |\n|---|---|---|---|",
            all - totals[0]
        );
        for (Exclusion { pattern, reason }, mutants) in exclusions {
            let pattern = pattern.replace('|', "\\|");
            let (kind, reason) = reason.split_once(": ").unwrap_or(("**no kind**", reason));
            let _ = writeln!(page, "| `{pattern}` | {mutants} | {kind} | {reason} |");
        }
        page
    }
}

fn table_line(name: &str, cells: [usize; 6]) -> String {
    let cells = cells.map(|cell| cell.to_string());
    format!("| {name} | {} |\n", cells.join(" | "))
}

/// The exclusions of settings.
#[must_use]
pub fn exclusions(settings: &str) -> Vec<Exclusion> {
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
            found
                .push(Exclusion { pattern: string_of(line.trim_end_matches(',')), reason: reason.join(" ") });
            after_pattern = true;
        }
    }
    found
}

/// The string that a TOML literal stands for: escapes in it are not part of the pattern. Text that is no string stays
/// as it is.
fn string_of(literal: &str) -> String {
    let parsed = literal.parse::<toml::Value>();
    parsed.ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_else(|| literal.into())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::PARTS;
    use super::*;
    use crate::faults::workspace;

    #[test]
    fn every_exclusion_says_its_kind() {
        for part in PARTS {
            let file = workspace().join(format!("proofs/mutants/{part}.toml"));
            for Exclusion { pattern, reason } in
                exclusions(&fs::read_to_string(file).expect("the settings are here"))
            {
                let kind = reason.split(": ").next().unwrap_or_default();
                assert!(
                    ["Same answers", "Refuses more", "Out of reach"].contains(&kind),
                    "{pattern}: {reason}"
                );
            }
        }
    }
}
