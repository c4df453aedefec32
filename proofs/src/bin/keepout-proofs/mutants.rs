//! `mutants`: keeps the outcomes of cargo-mutants, and writes their page.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use keepout_planner::file::write_whole;
use keepout_proofs::faults;
use keepout_proofs::mutants::{self, ListedMutant, MutantTable};

/// The outcomes to keep.
#[derive(Debug, clap::Args)]
pub struct KeepMutants {
    /// Files `outcomes.json` that cargo-mutants wrote for the code as it is now.
    outcomes: Vec<PathBuf>,
}

impl KeepMutants {
    /// The exit code is 0 if every mutant was tried and none was missed.
    pub fn run(&self) -> ExitCode {
        super::code(self.try_run())
    }

    fn try_run(&self) -> io::Result<bool> {
        let root = faults::workspace();
        let mut new = BTreeMap::new();
        for file in &self.outcomes {
            let named = |error: io::Error| io::Error::other(format!("{}: {error}", file.display()));
            let text = std::fs::read_to_string(file).map_err(named)?;
            new.extend(mutants::of_outcomes(&text).map_err(named)?);
        }
        let (mut listed, mut all, mut left_out) = (Vec::new(), 0, Vec::new());
        for part in mutants::PARTS {
            let file = root.join(format!("proofs/mutants/{part}.toml"));
            listed.extend(list(&root, &file)?);
            let settings = std::fs::read_to_string(&file)?;
            let whole = list(&root, &Whole::of(&settings)?.0)?;
            for exclusion in mutants::exclusions(&settings) {
                let mutants = exclusion.matches(&whole).map_err(|why| {
                    io::Error::other(format!("{}: the pattern {}: {why}", file.display(), exclusion.pattern))
                })?;
                left_out.push((exclusion, mutants));
            }
            all += whole.len();
        }
        let table = MutantTable::new(&root, listed, &new)?;
        write_whole(&root.join("proofs/results/mutants.tsv"), table.text().as_bytes())?;
        write_whole(&root.join("docs/safety/mutants.md"), table.page(&left_out, all).as_bytes())?;
        table.missed().for_each(|name| println!("missed: {name}"));
        println!("{} missed, {} not tried", table.missed().count(), table.untried());
        Ok(table.untried() == 0 && table.missed().next().is_none())
    }
}

/// A temporary file with the settings of a part, without their exclusions.
struct Whole(PathBuf);

impl Whole {
    fn of(settings: &str) -> io::Result<Self> {
        let file = std::env::temp_dir().join(format!("keepout-mutants-{}.toml", std::process::id()));
        let whole = settings.split_once("exclude_re").map_or(settings, |(before, _)| before);
        write_whole(&file, whole.as_bytes())?;
        Ok(Self(file))
    }
}

impl Drop for Whole {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The mutants that cargo-mutants makes with these settings.
fn list(root: &Path, settings: &Path) -> io::Result<Vec<ListedMutant>> {
    let mut command = Command::new("cargo");
    command.current_dir(root).args(["mutants", "--list", "--json", "--workspace", "--config"]).arg(settings);
    let listed = command.output()?;
    if !listed.status.success() {
        let said = String::from_utf8_lossy(&listed.stderr);
        return Err(io::Error::other(format!("`cargo install cargo-mutants`, and try again: {said}")));
    }
    mutants::of_list(&String::from_utf8_lossy(&listed.stdout))
}
