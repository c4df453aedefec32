//! Proves theorems query by query. A step may use only statements that an earlier step proved.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::explore::PredicatePath;
use super::fact::{Fact, Implication, all, any, at_most, equal, less, not};
use super::script::{Arithmetic, script};
use super::solver::{Solver, SolverAnswer};
use super::term::{Term, TermNode, whole};

/// The solvers, and the folder for the questions.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The solver whose answers count.
    pub solver: Solver,
    /// The solver that must not contradict the first.
    pub second: Option<Solver>,
    /// Folder for a copy of every question, for a reader's own solver.
    pub dump: Option<PathBuf>,
}

/// The outcome of a theorem.
#[derive(Clone, Debug, Default)]
pub struct TheoremReport {
    /// Number of paths through the predicates that were run.
    pub paths: usize,
    /// Number of questions: negations to refute, and conditions to meet.
    pub queries: usize,
    /// Number of questions in which the second solver agreed.
    pub agreed: usize,
    /// Number of questions that the second solver left undecided.
    pub undecided: usize,
    /// The failures, in order.
    pub failures: Vec<String>,
    /// Contracts that were proved: theorem and name.
    pub proves: BTreeSet<(&'static str, &'static str)>,
    /// Contracts that were used: theorem and name.
    pub rests_on: BTreeSet<(&'static str, &'static str)>,
    /// Time with the first solver.
    pub time: Duration,
    /// Time with the second solver.
    pub second_time: Duration,
}

/// Stands for all that a theorem proves, in place of the name of a contract.
pub const WHOLE: &str = "all of it";

/// Proves one theorem.
#[derive(Debug)]
pub struct Prover<'a> {
    settings: &'a Settings,
    theorem: &'static str,
    report: TheoremReport,
}

/// A statement that was proved for all values of its `N` numbers.
#[derive(Clone, Copy, Debug)]
pub struct Lemma<const N: usize> {
    statement: fn([Term; N]) -> Implication,
}

/// A theorem's statement about the answer of a predicate: for all values of `N` numbers there are values of
/// `M` more.
#[derive(Clone, Copy, Debug)]
pub struct Contract<const N: usize, const M: usize> {
    /// The theorem that proves it.
    pub theorem: &'static str,
    /// The name of the contract within its theorem.
    pub name: &'static str,
    /// The statement, given the predicate's answer (near, or yes).
    pub statement: fn(Fact, [Term; N], [Term; M]) -> Implication,
}

/// A proved statement for particular numbers. A step may assume nothing else.
#[derive(Clone, Debug)]
pub struct Instance(Fact);

impl<const N: usize> Lemma<N> {
    /// The lemma for these numbers.
    #[must_use]
    pub fn at(&self, numbers: [Term; N]) -> Instance {
        Instance((self.statement)(numbers).fact())
    }
}

impl<'a> Prover<'a> {
    /// A prover of the theorem of this name.
    #[must_use]
    pub fn new(settings: &'a Settings, theorem: &'static str) -> Self {
        Self { settings, theorem, report: TheoremReport::default() }
    }

    /// The outcome.
    #[must_use]
    pub fn report(self) -> TheoremReport {
        self.report
    }

    /// Counts paths that were run outside of [`Prover::on_paths`].
    pub fn ran(&mut self, paths: usize) {
        self.report.paths += paths;
    }

    /// Proves a statement for all values of its numbers.
    pub fn lemma<const N: usize>(&mut self, name: &str, statement: fn([Term; N]) -> Implication) -> Lemma<N> {
        let numbers = std::array::from_fn(|_| Term::fresh("n"));
        self.prove(name, &statement(numbers));
        Lemma { statement }
    }

    /// Proves a claim about particular unknowns.
    pub fn prove(&mut self, name: &str, claim: &Implication) {
        self.can_be_met(name, &claim.given);
        self.refute(name, &claim.given, &claim.then, Arithmetic::Whole);
    }

    /// As [`Prover::prove`], from proved instances. The solver sees sums only, and each product as an
    /// unknown number.
    pub fn glue(&mut self, name: &str, using: &[Instance], claim: &Implication) {
        self.can_be_met(name, &claim.given);
        self.chain(name, using, claim);
    }

    /// Proves a claim about particular unknowns, and returns it as an instance.
    pub fn fact(&mut self, name: &str, claim: &Implication) -> Instance {
        self.prove(name, claim);
        Instance(claim.fact())
    }

    /// As [`Prover::fact`], from proved instances, with the full arithmetic of products.
    pub fn follows(&mut self, name: &str, using: &[Instance], claim: &Implication) -> Instance {
        self.can_be_met(name, &claim.given);
        self.join(name, using, claim);
        Instance(claim.fact())
    }

    /// As [`Prover::fact`], from proved instances, with sums only as in [`Prover::glue`].
    pub fn glued(&mut self, name: &str, using: &[Instance], claim: &Implication) -> Instance {
        self.glue(name, using, claim);
        Instance(claim.fact())
    }

    /// As [`Prover::glue`], without the check that the claim's premises can be met: for one of several
    /// cases.
    pub fn chain(&mut self, name: &str, using: &[Instance], claim: &Implication) {
        let mut facts: Vec<Fact> = using.iter().map(|instance| instance.0.clone()).collect();
        facts.extend(claim.given.iter().cloned());
        self.refute(name, &facts, &claim.then, Arithmetic::Sums);
    }

    /// As [`Prover::chain`], with the full arithmetic of products.
    pub fn join(&mut self, name: &str, using: &[Instance], claim: &Implication) {
        let mut facts: Vec<Fact> = using.iter().map(|instance| instance.0.clone()).collect();
        facts.extend(claim.given.iter().cloned());
        self.refute(name, &facts, &claim.then, Arithmetic::Whole);
    }

    /// Proves on every path the claim that `says` makes of the path's outcome.
    pub fn on_paths<T>(&mut self, name: &str, paths: &[PredicatePath<T>], says: impl Fn(&T) -> Implication) {
        self.report.paths += paths.len();
        let mut possible = Vec::new();
        for (number, path) in paths.iter().enumerate() {
            let Implication { mut given, then } = says(&path.outcome);
            if then == Fact::True || given.contains(&Fact::False) {
                continue;
            }
            given.extend(path.conditions.iter().cloned());
            possible.push(all(given.clone()));
            self.refute(&format!("{name}, path {}", number + 1), &given, &then, Arithmetic::Whole);
        }
        self.can_be_met(name, &[any(possible)]);
    }

    /// As [`Prover::on_paths`], and also from proved instances.
    pub fn on_paths_by<T>(
        &mut self,
        name: &str,
        paths: &[PredicatePath<T>],
        using: &[Instance],
        says: impl Fn(&T) -> Implication,
    ) {
        self.on_paths(name, paths, |outcome| {
            let mut claim = says(outcome);
            claim.given.extend(using.iter().map(|instance| instance.0.clone()));
            claim
        });
    }

    /// As [`Prover::contract`] for a predicate with closed parts: from the contracts of the parts, as
    /// [`Prover::glue`] does.
    pub fn by_parts<const N: usize, const M: usize>(
        &mut self,
        contract: &Contract<N, M>,
        paths: &[PredicatePath<bool>],
        numbers: [Term; N],
        (values, using): ([Term; M], &[Instance]),
    ) {
        self.proves(contract, &numbers);
        self.report.paths += paths.len();
        let answers: BTreeSet<bool> = paths.iter().map(|path| path.outcome).collect();
        for answer in answers {
            let claim = (contract.statement)(answer.into(), numbers, values);
            if claim.then == Fact::True || claim.given.contains(&Fact::False) {
                continue;
            }
            let paths = paths.iter().filter(|path| path.outcome == answer);
            let some = any(paths.map(|path| all(path.conditions.clone())));
            let given = claim.given.into_iter().chain([some]).collect();
            self.glue(contract.name, using, &Implication { given, then: claim.then });
        }
    }

    /// Proves a contract on every path of its predicate. The predicate was run on the first of the `numbers`.
    pub fn contract<const N: usize, const M: usize>(
        &mut self,
        contract: &Contract<N, M>,
        paths: &[PredicatePath<bool>],
        numbers: [Term; N],
        (values, using): ([Term; M], &[Instance]),
    ) {
        self.proves(contract, &numbers);
        for answer in [false, true] {
            let outcome = |path: &&PredicatePath<bool>| path.outcome == answer;
            let paths: Vec<PredicatePath<bool>> = paths.iter().filter(outcome).cloned().collect();
            let Implication { mut given, then } = (contract.statement)(answer.into(), numbers, values);
            if then == Fact::True || given.contains(&Fact::False) {
                self.report.paths += paths.len();
                continue;
            }
            given.extend(using.iter().map(|instance| instance.0.clone()));
            self.on_paths(contract.name, &paths, |_| Implication {
                given: given.clone(),
                then: then.clone(),
            });
        }
    }

    /// Proves a contract from proved instances, as [`Prover::glue`] does.
    pub fn establish<const N: usize, const M: usize>(
        &mut self,
        contract: &Contract<N, M>,
        answer: Fact,
        numbers: [Term; N],
        (values, using): ([Term; M], &[Instance]),
    ) {
        self.proves(contract, &numbers);
        self.glue(contract.name, using, &(contract.statement)(answer, numbers, values));
    }

    fn proves<const N: usize, const M: usize>(&mut self, contract: &Contract<N, M>, numbers: &[Term; N]) {
        assert_eq!(contract.theorem, self.theorem, "a contract is proved by its theorem");
        assert!(are_free(numbers), "a contract is proved for all values of its numbers");
        self.report.proves.insert((contract.theorem, contract.name));
    }

    /// The contract's statement for these numbers, and the numbers whose existence it states.
    pub fn by<const N: usize, const M: usize>(
        &mut self,
        contract: &Contract<N, M>,
        answer: Fact,
        numbers: [Term; N],
    ) -> (Instance, [Term; M]) {
        let own = (contract.theorem, contract.name);
        if contract.theorem == self.theorem && !self.report.proves.contains(&own) {
            self.report
                .failures
                .push(format!("rests on its own \"{}\" before that is proved", contract.name));
        }
        self.report.rests_on.insert(own);
        let values = std::array::from_fn(|_| Term::fresh("w"));
        (Instance((contract.statement)(answer, numbers, values).fact()), values)
    }

    /// Records that the written part of this proof rests on the lemmas of `theorem`.
    pub fn needs(&mut self, theorem: &'static str) {
        self.report.rests_on.insert((theorem, WHOLE));
    }

    /// Defines a new number: `dividend / divisor` in the case whose guard holds. It first proves that no
    /// two guards hold together, and that no divisor is zero. So such a number exists for all values of the
    /// other numbers.
    pub fn define(&mut self, name: &str, cases: &[(Fact, Term, Term)]) -> (Term, Vec<Instance>) {
        let number = Term::fresh(name);
        let mut definition = Vec::new();
        for (i, (guard, dividend, divisor)) in cases.iter().enumerate() {
            let title = format!("{name} is defined, case {}", i + 1);
            if *divisor != whole(1) {
                self.refute(
                    &title,
                    std::slice::from_ref(guard),
                    &not(equal(*divisor, whole(0))),
                    Arithmetic::Whole,
                );
            }
            for (other, ..) in &cases[..i] {
                self.refute(&title, &[guard.clone(), other.clone()], &Fact::False, Arithmetic::Whole);
            }
            let body = if *divisor == whole(1) { number } else { number * *divisor };
            definition.push(Instance(any([not(guard.clone()), equal(body, *dividend)])));
        }
        (number, definition)
    }

    /// The square root of a number, after a proof that the number is not negative.
    pub fn root(&mut self, name: &str, given: &[Fact], of: Term) -> (Term, Vec<Instance>) {
        self.refute(&format!("{name} is defined"), given, &at_most(whole(0), of), Arithmetic::Whole);
        let number = Term::fresh(name);
        let given = all(given.iter().cloned());
        let facts = [at_most(whole(0), number), equal(number * number, of)];
        (number, facts.into_iter().map(|fact| Instance(any([not(given.clone()), fact]))).collect())
    }

    /// Proves that the magnitude of each number is at most `most`.
    pub(super) fn bounded(&mut self, name: &str, given: &[Fact], number: Term, most: i128) {
        let then = all([at_most(whole(-most), number), at_most(number, whole(most))]);
        self.refute(name, given, &then, Arithmetic::Whole);
    }

    /// Expects the solver to refute a false statement by an example. This shows that the solver can tell.
    pub fn is_false(&mut self, name: &str, claim: &Implication) {
        let mut facts = claim.given.clone();
        facts.push(not(claim.then.clone()));
        self.ask(name, &facts, Arithmetic::Whole, &SolverAnswer::Satisfiable);
    }

    fn can_be_met(&mut self, name: &str, facts: &[Fact]) {
        if !facts.is_empty() {
            self.ask(&format!("{name}: can be met"), facts, Arithmetic::Whole, &SolverAnswer::Satisfiable);
        }
    }

    fn refute(&mut self, name: &str, given: &[Fact], then: &Fact, arithmetic: Arithmetic) {
        let mut facts = given.to_vec();
        facts.push(not(then.clone()));
        self.ask(name, &facts, arithmetic, &SolverAnswer::Unsatisfiable);
    }

    fn ask(&mut self, name: &str, facts: &[Fact], arithmetic: Arithmetic, expected: &SolverAnswer) {
        self.report.queries += 1;
        let title = format!("{}: {name}\nexpected: {expected}", self.theorem);
        let text = script(&title, facts, arithmetic);
        if let Some(folder) = &self.settings.dump {
            let file = folder.join(format!("{}-{:03}.smt2", self.theorem, self.report.queries));
            if let Err(error) = std::fs::write(&file, &text) {
                self.report.failures.push(format!("{}: {error}", file.display()));
            }
        }
        let begin = Instant::now();
        let answer = self.settings.solver.ask(&text);
        self.report.time += begin.elapsed();
        if answer != *expected {
            self.report.failures.push(format!("{name}: expected {expected}, {answer}"));
        }
        if let Some(second) = &self.settings.second {
            let begin = Instant::now();
            match second.ask(&text) {
                SolverAnswer::None(_) => self.report.undecided += 1,
                opinion if opinion == *expected => self.report.agreed += 1,
                opinion => {
                    self.report
                        .failures
                        .push(format!("{name}: expected {expected}, {} says {opinion}", second.kind));
                }
            }
            self.report.second_time += begin.elapsed();
        }
    }
}

/// Whether the numbers can take all values together. Each is an unknown of its own, or the sum of another
/// number and such an unknown. (A term is no part of itself, so the others can be chosen first.)
fn are_free(numbers: &[Term]) -> bool {
    let mut unknowns = BTreeSet::new();
    numbers.iter().all(|&number| {
        let unknown = match number.node() {
            TermNode::Sum(a, b) if numbers.contains(&a) => b,
            _ => number,
        };
        matches!(unknown.node(), TermNode::Variable(_)) && unknowns.insert(unknown)
    })
}

/// `0 < a`.
#[must_use]
pub fn positive(a: Term) -> Fact {
    less(whole(0), a)
}

/// `0 ≤ a`.
#[must_use]
pub fn at_least_zero(a: Term) -> Fact {
    at_most(whole(0), a)
}
