//! `prove`: proves the theorems and prints a line for each.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use keepout_proofs::smt::prover::Settings;
use keepout_proofs::smt::results;
use keepout_proofs::smt::run::{Theorem, TheoremOutcome, run};
use keepout_proofs::smt::solver::{MissingSolver, Solver, SolverKind};
use keepout_proofs::theorems::THEOREMS;

/// The theorems and the solvers.
#[derive(Debug, clap::Args)]
pub struct Prove {
    /// The solver whose answers count.
    #[arg(long, value_enum, default_value = "z3")]
    solver: SolverKind,
    /// Ask both solvers; they must not contradict each other. The default if both are installed.
    #[arg(long)]
    cross: bool,
    /// Ask one solver only.
    #[arg(long, conflicts_with = "cross")]
    single: bool,
    /// Prove only theorems whose name begins with this text, and those that they rest on.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Time limit for a question, in seconds.
    #[arg(long, default_value_t = 60, value_name = "SECONDS")]
    limit: u64,
    /// Time limit for a question to the second solver, in seconds.
    #[arg(long, default_value_t = 5, value_name = "SECONDS")]
    second_limit: u64,
    /// Write every question to a file in this folder.
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    /// Write the results to this file.
    #[arg(long, value_name = "FILE")]
    results: Option<PathBuf>,
}

#[derive(Debug, thiserror::Error)]
enum ProveError {
    #[error(transparent)]
    Missing(#[from] MissingSolver),
    #[error("No theorem's name begins with \"{0}\". Run `prove` without --only to see them all.")]
    NoTheorem(String),
    #[error("{}: {source}", .path.display())]
    File { path: PathBuf, source: std::io::Error },
}

impl Prove {
    /// Proves the theorems and prints the results. Exit code: 0 everything was proved, 1 something was not,
    /// 2 the proof could not run.
    pub fn run(&self) -> ExitCode {
        match self.prove() {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::from(1),
            Err(error) => {
                eprintln!("{error}");
                ExitCode::from(2)
            }
        }
    }

    fn prove(&self) -> Result<bool, ProveError> {
        let settings = self.settings()?;
        let begin = Instant::now();
        let mut chosen: Vec<&'static str> = match &self.only {
            Some(name) => {
                THEOREMS.iter().map(|each| each.name).filter(|each| each.starts_with(name)).collect()
            }
            None => THEOREMS.iter().map(|each| each.name).collect(),
        };
        if chosen.is_empty() {
            return Err(ProveError::NoTheorem(self.only.clone().unwrap_or_default()));
        }
        // A theorem's dependencies are known only after it was run.
        let outcomes = loop {
            let theorems: Vec<Theorem> =
                THEOREMS.iter().filter(|each| chosen.contains(&each.name)).copied().collect();
            let outcomes = progress(&theorems, &settings);
            let used = outcomes.iter().flat_map(|outcome| outcome.report.theorems(outcome.theorem.name));
            let more: Vec<_> = used.filter(|name| !chosen.contains(name)).collect();
            if more.is_empty() {
                break outcomes;
            }
            chosen.extend(more);
        };
        print(&outcomes, &settings);
        let failed = outcomes.iter().filter(|outcome| !outcome.report.failures.is_empty()).count();
        let seconds = begin.elapsed().as_secs_f64();
        println!(
            "{} theorems: {} proved, {failed} failed, {seconds:.0} s",
            outcomes.len(),
            outcomes.len() - failed
        );
        if let Some(path) = &self.results {
            let rows: Vec<_> = outcomes.iter().map(|outcome| outcome.row(&settings)).collect();
            results::write(path, &rows).map_err(|source| ProveError::File { path: path.clone(), source })?;
        }
        Ok(failed == 0)
    }

    fn settings(&self) -> Result<Settings, ProveError> {
        let solver = Solver::find(self.solver, Duration::from_secs(self.limit))?;
        let other = if self.solver == SolverKind::Z3 { SolverKind::Cvc5 } else { SolverKind::Z3 };
        let second = match Solver::find(other, Duration::from_secs(self.second_limit)) {
            _ if self.single => None,
            Err(missing) if self.cross => return Err(missing.into()),
            found => found.ok(),
        };
        if let Some(folder) = &self.dump {
            std::fs::create_dir_all(folder)
                .map_err(|source| ProveError::File { path: folder.clone(), source })?;
        }
        Ok(Settings { solver, second, dump: self.dump.clone() })
    }
}

fn progress(theorems: &[Theorem], settings: &Settings) -> Vec<TheoremOutcome> {
    let show = std::io::stderr().is_terminal();
    let count = AtomicUsize::new(0);
    let outcomes = run(theorems, settings, |outcome| {
        let done = count.fetch_add(1, Ordering::Relaxed) + 1;
        if show {
            eprint!("\r\x1b[K{done} of {}: {}", theorems.len(), outcome.theorem.name);
            let _ = std::io::stderr().flush();
        }
    });
    if show {
        eprint!("\r\x1b[K");
    }
    outcomes
}

fn print(outcomes: &[TheoremOutcome], settings: &Settings) {
    let name = |solver: &Solver| format!("{} {}", solver.kind, solver.version);
    let second = settings.second.as_ref().map_or("no second solver".to_owned(), name);
    println!("{}, and {second}", name(&settings.solver));
    println!(
        "{:24} {:>6} {:>8} {:>8} {:>7} {:>8} {:>9}  result",
        "theorem", "paths", "queries", "time", "agreed", "undecided", "time"
    );
    for TheoremOutcome { theorem, report } in outcomes {
        let result = if report.failures.is_empty() { "proved" } else { "FAILED" };
        println!(
            "{:24} {:>6} {:>8} {:>6.2} s {:>7} {:>9} {:>6.2} s  {result}: {} ({})",
            theorem.name,
            report.paths,
            report.queries,
            report.time.as_secs_f64(),
            report.agreed,
            report.undecided,
            report.second_time.as_secs_f64(),
            theorem.claim,
            theorem.source,
        );
        for failure in report.failures.iter().take(8) {
            println!("    {failure}");
        }
    }
}
