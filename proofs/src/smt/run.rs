//! Runs theorems on all cores, and checks what they rest on.

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::prover::{Prover, Settings, TheoremReport, WHOLE};
use super::results::TheoremRow;
use super::term;

/// A theorem: a claim and its proof.
#[derive(Clone, Copy, Debug)]
pub struct Theorem {
    /// Its name.
    pub name: &'static str,
    /// The functions that it is about.
    pub source: &'static str,
    /// The claim.
    pub claim: &'static str,
    /// The proof.
    pub proof: fn(&mut Prover<'_>),
}

/// A theorem and its outcome.
#[derive(Clone, Debug)]
pub struct TheoremOutcome {
    /// The theorem.
    pub theorem: Theorem,
    /// The outcome.
    pub report: TheoremReport,
}

/// Proves the theorems, one on each core at a time. Calls `done` with each outcome when it is ready.
///
/// # Panics
/// When a proof panics.
pub fn run(
    theorems: &[Theorem],
    settings: &Settings,
    done: impl Fn(&TheoremOutcome) + Sync,
) -> Vec<TheoremOutcome> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(&theorem) = theorems.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let outcome = prove(theorem, settings);
                    done(&outcome);
                    outcomes.lock().expect("no thread panics with the lock").push(outcome);
                }
            });
        }
    });
    let mut outcomes = outcomes.into_inner().expect("no thread panics with the lock");
    let place = |name: &str| theorems.iter().position(|theorem| theorem.name == name);
    outcomes.sort_by_key(|outcome| place(outcome.theorem.name));
    check_dependencies(&mut outcomes);
    outcomes
}

fn prove(theorem: Theorem, settings: &Settings) -> TheoremOutcome {
    term::forget();
    let mut prover = Prover::new(settings, theorem.name);
    (theorem.proof)(&mut prover);
    let mut report = prover.report();
    if report.queries == 0 {
        report.failures.push("the proof asked no question".to_owned());
    }
    TheoremOutcome { theorem, report }
}

/// Fails every theorem that rests on a contract which neither the theorem itself nor an earlier one proved.
fn check_dependencies(outcomes: &mut [TheoremOutcome]) {
    let mut proved = BTreeSet::new();
    for outcome in outcomes {
        let report = &mut outcome.report;
        let known =
            |contract: &&(&str, &str)| proved.contains(*contract) || report.proves.contains(*contract);
        if let Some((theorem, name)) = report.rests_on.iter().find(|contract| !known(contract)) {
            report.failures.push(format!("rests on \"{name}\" of {theorem}, which was not proved before"));
        }
        if report.failures.is_empty() {
            proved.extend(report.proves.iter().copied());
            proved.insert((outcome.theorem.name, WHOLE));
        }
    }
}

impl TheoremReport {
    /// The other theorems that this one rests on.
    #[must_use]
    pub fn theorems(&self, own: &str) -> BTreeSet<&'static str> {
        self.rests_on.iter().map(|&(theorem, _)| theorem).filter(|&theorem| theorem != own).collect()
    }
}

impl TheoremOutcome {
    /// The outcome as a line of results.
    #[must_use]
    pub fn row(&self, settings: &Settings) -> TheoremRow {
        let name = |solver: &super::solver::Solver| format!("{} {}", solver.kind, solver.version);
        let report = &self.report;
        TheoremRow {
            theorem: self.theorem.name.to_owned(),
            source: self.theorem.source.to_owned(),
            result: if report.failures.is_empty() { "proved" } else { "failed" }.to_owned(),
            paths: report.paths,
            queries: report.queries,
            solver: name(&settings.solver),
            seconds: report.time.as_secs_f64(),
            second: settings.second.as_ref().map(name).unwrap_or_default(),
            agreed: report.agreed,
            undecided: report.undecided,
            second_seconds: report.second_time.as_secs_f64(),
            rests_on: report.theorems(self.theorem.name).into_iter().collect::<Vec<_>>().join(", "),
            claim: self.theorem.claim.to_owned(),
            detail: report.failures.first().cloned().unwrap_or_default(),
        }
    }
}
