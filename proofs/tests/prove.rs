//! Tests of the prover: it does not prove false claims, and a solver without an answer proves nothing.

use std::time::Duration;

use keepout_kernel::exact::predicate::{Proximity, Site};
use keepout_kernel::exact::width::Lattice;
use keepout_proofs::smt::explore::explore;
use keepout_proofs::smt::fact::{Fact, at_most, claim, equal, less, not};
use keepout_proofs::smt::prover::{Contract, Prover, Settings, TheoremReport, at_least_zero};
use keepout_proofs::smt::run::{Theorem, run};
use keepout_proofs::smt::solver::{Solver, SolverKind};
use keepout_proofs::smt::symbolic::{Scalar, Symbolic, SymbolicPoint};
use keepout_proofs::smt::term::{Term, square, whole};
use keepout_proofs::theorems::{THEOREMS, no_overflow_up_to};

fn settings() -> Option<Settings> {
    match Solver::find(SolverKind::Z3, Duration::from_secs(60)) {
        Ok(solver) => Some(Settings { solver, second: None, dump: None }),
        Err(_) => {
            assert!(std::env::var_os("CI").is_none(), "CI skips nothing: install z3");
            println!("skipped: no z3");
            None
        }
    }
}

fn report(settings: &Settings, proof: impl Fn(&mut Prover<'_>)) -> TheoremReport {
    let mut prover = Prover::new(settings, "test");
    proof(&mut prover);
    prover.report()
}

/// `point_point` with a fault: a threshold that is met counts as clear, or a square has a wrong factor.
fn wrong_point_point<L: Lattice>(p: Site<L>, q: Site<L>, r: L::Linear, strict: bool) -> Proximity {
    let (dx, dy) = (L::difference(p.x, q.x), L::difference(p.y, q.y));
    let y_2 = if strict { L::product(dy, dy) } else { L::product(dy, dx) };
    let distance_2 = L::sum(L::product(dx, dx), y_2);
    let order = L::compare(distance_2, L::product(r, r));
    if order.is_lt() || !strict && order.is_eq() { Proximity::Near } else { Proximity::Clear }
}

#[test]
fn wrong_predicates_are_not_proved() {
    let Some(settings) = settings() else { return };
    for strict in [true, false] {
        let report = report(&settings, |prover| {
            let [px, py, qx, qy, r] = ["px", "py", "qx", "qy", "r"].map(Term::fresh);
            let place = |x, y| -> SymbolicPoint { Site { x: Scalar(x), y: Scalar(y) } };
            let paths = explore(&[], &[], || {
                wrong_point_point::<Symbolic>(place(px, py), place(qx, qy), Scalar(r), strict).is_clear()
            });
            let distance_2 = square(px - qx) + square(py - qy);
            prover.on_paths("distance", &paths, |&clear| {
                let then = if clear { less(square(r), distance_2) } else { at_most(distance_2, square(r)) };
                claim([at_least_zero(r)], then)
            });
        });
        assert!(!report.failures.is_empty(), "strict: {strict}");
        assert!(report.failures.iter().all(|failure| failure.contains("expected unsat, sat")), "{report:?}");
    }
}

#[test]
fn false_and_empty_claims_are_not_proved() {
    let Some(settings) = settings() else { return };
    let of = |proof: fn(&mut Prover<'_>)| report(&settings, proof).failures.len();
    let [true_claim, strict, empty]: [fn(&mut Prover<'_>); 3] = [
        |prover| {
            prover.lemma("true", |[x]| claim([], at_most(whole(0), square(x))));
        },
        |prover| {
            prover.lemma("strict", |[x]| claim([], less(whole(0), square(x))));
        },
        |prover| {
            prover.lemma("empty", |[x]| claim([less(x, x)], equal(x, whole(7))));
        },
    ];
    assert_eq!([of(true_claim), of(strict), of(empty)], [0, 1, 1]);
    let example: fn(&mut Prover<'_>) =
        |prover| prover.is_false("by example", &claim([], less(whole(0), square(Term::fresh("x")))));
    assert_eq!(of(example), 0);
}

#[test]
fn overflow_begins_one_bit_beyond() {
    let Some(settings) = settings() else { return };
    let failures = |limit: i128| report(&settings, |prover| no_overflow_up_to(prover, limit)).failures.len();
    assert_eq!(failures(1 << 29), 0);
    assert!(failures(1 << 30) > 0);
}

const UNPROVED: Contract<1, 0> =
    Contract { theorem: "first", name: "never proved", statement: |_, [x], []| claim([], less(x, x)) };

const CIRCULAR: Contract<1, 0> =
    Contract { theorem: "circular", name: "itself", statement: |_, [x], []| claim([], less(whole(0), x)) };

#[test]
fn theorem_on_an_unproved_contract_fails() {
    let Some(settings) = settings() else { return };
    let theorem = |name, proof| Theorem { name, source: "", claim: "", proof };
    let theorems = [
        theorem("first", |prover| {
            prover.lemma("true", |[x]| claim([], equal(x, x)));
        }),
        theorem("second", |prover| {
            let x = Term::fresh("x");
            let (instance, []) = prover.by(&UNPROVED, Fact::True, [x]);
            prover.glue("from nothing", &[instance], &claim([], Fact::False));
        }),
        theorem("third", |_| {}),
        theorem("circular", |prover| {
            let x = Term::fresh("x");
            let (instance, []) = prover.by(&CIRCULAR, Fact::True, [x]);
            prover.establish(&CIRCULAR, Fact::True, [x], ([], &[instance]));
        }),
        theorem("in words", |prover| {
            prover.needs("second");
            prover.lemma("true", |[x]| claim([], equal(x, x)));
        }),
    ];
    let outcomes = run(&theorems, &settings, |_| {});
    let failed = outcomes.iter().map(|outcome| !outcome.report.failures.is_empty());
    assert_eq!(failed.collect::<Vec<_>>(), [false, true, true, true, true]);
}

#[test]
fn solver_without_an_answer_proves_nothing() {
    for says in [
        "cat > /dev/null; echo unknown",
        "cat > /dev/null; echo sat",
        "exit 3",
        "echo unsat; echo '(error)'",
        "sleep 5",
    ] {
        let solver = Solver::of_command(SolverKind::Z3, &["sh", "-c", says], Duration::from_millis(300));
        let settings = Settings { solver, second: None, dump: None };
        let failures = report(&settings, |prover| {
            prover.lemma("true", |[x]| claim([], not(less(x, x))));
        });
        assert_eq!(failures.failures.len(), 1, "{says}: {failures:?}");
    }
}

#[test]
fn quick_theorems_hold() {
    let Some(settings) = settings() else { return };
    let quick = ["orientation", "point_point", "rounding", "triangle_inequality"];
    let theorems: Vec<Theorem> = THEOREMS.iter().filter(|each| quick.contains(&each.name)).copied().collect();
    for outcome in run(&theorems, &settings, |_| {}) {
        assert_eq!(outcome.report.failures, Vec::<String>::new(), "{}", outcome.theorem.name);
    }
}

#[test]
fn theorem_names_are_unique() {
    let mut names: Vec<&str> = THEOREMS.iter().map(|theorem| theorem.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), THEOREMS.len());
}
