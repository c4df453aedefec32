//! `model-check`: gives the harnesses to the bounded model checker.

use std::path::PathBuf;
use std::process::ExitCode;

use keepout_harnesses::{Inputs, ModelHarness};
use keepout_proofs::faults::workspace;
use keepout_proofs::model_check::results;
use keepout_proofs::model_check::run::{Checked, ModelChecker, ModelVerdict};
use keepout_proofs::model_check::tools::Tools;

/// The harnesses to check, and how.
#[derive(Debug, clap::Args)]
pub struct ModelCheck {
    /// Only harnesses whose name or file contains this text.
    #[arg(default_value = "")]
    name: String,
    /// Only harnesses that took at most so many seconds when results/model-check.tsv was written, and new ones.
    #[arg(long, value_name = "SECONDS", conflicts_with = "write")]
    within: Option<f64>,
    /// Seconds for one harness.
    #[arg(long, default_value_t = 300)]
    limit_s: u64,
    /// Harnesses at a time; default: one for each processor.
    #[arg(long)]
    threads: Option<usize>,
    /// A folder for the C that is checked; default: a folder for temporary files.
    #[arg(long)]
    keep: Option<PathBuf>,
    /// Writes the answers into results/model-check.tsv, for the page of proofs.
    #[arg(long)]
    write: bool,
}

impl ModelCheck {
    /// Checks them and prints a line for each. The exit code is 0 if every statement holds.
    pub fn run(&self) -> ExitCode {
        match self.try_run() {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(error) => {
                eprintln!("{error}");
                ExitCode::from(2)
            }
        }
    }

    fn chosen(&self) -> Vec<&'static ModelHarness> {
        let (_, rows) = results::read();
        let named =
            |harness: &ModelHarness| harness.name.contains(&self.name) || harness.file.contains(&self.name);
        let slower = |harness: &ModelHarness, limit: f64| {
            rows.iter().any(|row| row.name == harness.name && row.seconds > limit)
        };
        let quick = |harness: &ModelHarness| self.within.is_none_or(|limit| !slower(harness, limit));
        keepout_harnesses::all().into_iter().filter(|harness| named(harness) && quick(harness)).collect()
    }

    fn try_run(&self) -> Result<bool, String> {
        let chosen = self.chosen();
        if chosen.is_empty() {
            let asked = &self.name;
            let limit = self.within.map_or(String::new(), |limit| format!(" and took at most {limit} s"));
            return Err(format!(
                "No harness has \"{asked}\" in its name or file{limit}. Run `model-check` to see them all."
            ));
        }
        let tools = Tools::find(&workspace())?;
        let versions = tools.versions();
        let folder = self.keep.clone().unwrap_or_else(|| std::env::temp_dir().join("keepout-model-check"));
        let checker = ModelChecker::new(&workspace(), tools, &folder, self.limit_s)?;
        let threads =
            self.threads.or_else(|| std::thread::available_parallelism().ok().map(Into::into)).unwrap_or(1);
        for (canary, checked) in checker.check(&keepout_harnesses::canaries(), threads, |_, _| {})? {
            if !matches!(checked.verdict, ModelVerdict::Fails(_)) {
                let verdict = checked.verdict;
                return Err(format!(
                    "the model checker does not refute the false statement {}: {verdict:?}",
                    canary.name
                ));
            }
        }
        let mut checked = checker.check(&chosen, threads, tell)?;
        checked.sort_by_key(|(harness, _)| chosen.iter().position(|each| each.name == harness.name));
        let held = checked.iter().filter(|(_, checked)| checked.verdict == ModelVerdict::Holds).count();
        let seconds: f64 = checked.iter().map(|(_, checked)| checked.seconds).sum();
        println!("{held} of {} harnesses hold, {seconds:.0} s of all threads ({versions})", chosen.len());
        if self.write {
            let rows: Vec<(&str, Checked)> =
                checked.into_iter().map(|(harness, checked)| (harness.name, checked)).collect();
            results::write(&versions, &rows).map_err(|error| error.to_string())?;
        }
        Ok(held == chosen.len())
    }
}

/// Prints the answer for one harness.
fn tell(harness: &'static ModelHarness, checked: &Checked) {
    let Checked { verdict, seconds, .. } = checked;
    let (name, bounds) = (harness.name, harness.bounds);
    match verdict {
        ModelVerdict::Holds => println!("holds      {seconds:6.1} s  {name} ({bounds})"),
        ModelVerdict::Unwinding => {
            println!("unwinding  {seconds:6.1} s  {name}: a loop runs more than {} times", harness.unwind);
        }
        ModelVerdict::TimedOut => println!("no answer  {seconds:6.1} s  {name} ({bounds})"),
        ModelVerdict::Broken(why) => println!("broken     {seconds:6.1} s  {name}: {why}"),
        ModelVerdict::Fails(inputs) => {
            println!(
                "fails      {seconds:6.1} s  {name}: with the inputs {inputs:?}, {}",
                replayed(harness, inputs)
            );
        }
    }
}

/// What the harness does with the inputs of a counterexample, outside of the model checker.
fn replayed(harness: &'static ModelHarness, inputs: &[i32]) -> String {
    let (run, inputs) = (harness.run, inputs.to_vec());
    std::panic::set_hook(Box::new(|_| {}));
    match std::panic::catch_unwind(move || run(&mut Inputs::given(&inputs))) {
        Ok(()) => "which pass when they run here: the tree was changed, or the model checker errs".into(),
        Err(_) => "which fail when they run here, too".into(),
    }
}
