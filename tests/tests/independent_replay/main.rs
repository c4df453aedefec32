//! The second implementation of the check of logs, `proofs/check_log.py`, gives the verdict of `check_certificates`:
//! on honest logs of all languages, and on mutated ones.
//!
//! For more mutants: `KEEPOUT_MUTANTS=10000 cargo test --release -p keepout-tests --test independent_replay`, as
//! in `.ci/weekly replay`.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod honest;
mod lines;
mod mutants;
mod script;

use std::collections::BTreeMap;

use honest::{HonestSession, sessions};
use keepout_executor::session::log::Log;
use keepout_executor::session::replay::{CertificateCheck, check_certificates, replay};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::plan_file;
use mutants::{Mutant, mutate, mutate_plan};
use script::{CheckScript, ScriptVerdict};

/// Number of mutants, without `KEEPOUT_MUTANTS`.
const MUTANTS: usize = 300;
/// Most lines of a log that is mutated.
const LINES: usize = 900;
/// For this many mutants of a log there is one of its plan. Each needs a process of its own.
const PLAN_EVERY: usize = 100;
/// The most by which the two programs may differ about a distance at an arc, lattice units (0.4 µm). The script's
/// docstring states it.
const BAND: i32 = 40;

/// The verdict of the product: what it counted, or the fault.
fn verdict(log: &[u8], work: &PreparedPlan) -> Result<CertificateCheck, String> {
    let log = Log::parse(log).map_err(|error| error.to_string())?;
    check_certificates(&log, work).map_err(|error| error.to_string())
}

/// The verdict of the product on a log and the bytes of a plan.
fn verdict_on_plan(log: &[u8], plan: &[u8]) -> Result<CertificateCheck, String> {
    let plan = plan_file::decode(plan).map_err(|error| error.to_string())?;
    let plan = plan.certify().map_err(|error| error.to_string())?;
    verdict(log, &PreparedPlan::new(plan))
}

/// Every honest log holds for the product's check of certificates, and holds for the script.
#[test]
fn honest_logs_hold_for_both_programs() {
    let Some(script) = CheckScript::found("honest") else { return };
    let mut counted = CertificateCheck::default();
    let (mut retracts, mut logs) = (0, 0);
    for session in sessions() {
        if session.replays {
            let log = Log::parse(&session.log).unwrap();
            replay(&log, session.work.clone()).unwrap_or_else(|error| panic!("{}: {error}", session.name));
        }
        let checked =
            verdict(&session.log, &session.work).unwrap_or_else(|e| panic!("{}: {e}", session.name));
        let said = &script.verdicts(&session.plan, std::slice::from_ref(&session.log), 0)[0];
        assert!(said.holds, "{}: {}", session.name, said.text);
        let lines = session.log.iter().filter(|&&byte| byte == b'\n').count();
        let certificates = checked.jogs + checked.contours;
        let words = format!("every rule holds: {lines} lines, {certificates} certificates");
        assert!(said.text.contains(&words), "{}: {} instead of {words}", session.name, said.text);
        counted.jogs += checked.jogs;
        counted.contours += checked.contours;
        retracts += u64::from(session.begins_inside && checked.jogs > 0);
        logs += 1;
    }
    println!(
        "{logs} honest logs, {} jogs, {} motions of contours, {retracts} logs with retract moves",
        counted.jogs, counted.contours
    );
    assert!(counted.jogs > 1000 && counted.contours > 300 && retracts > 0);
}

#[test]
fn mutated_logs_get_the_same_verdict() {
    let Some(script) = CheckScript::found("mutants") else { return };
    let count = std::env::var("KEEPOUT_MUTANTS").ok().and_then(|count| count.parse().ok()).unwrap_or(MUTANTS);
    let sessions: Vec<HonestSession> = sessions().iter().map(|session| session.shortened(LINES)).collect();
    let mut random = fastrand::Rng::with_seed(20_261_126);
    let mut tally = Tally::default();
    for (number, session) in sessions.iter().enumerate() {
        let each = count * (number + 1) / sessions.len() - tally.count;
        let mutants: Vec<Mutant> = (0..each).map(|_| mutate(session, &mut random)).collect();
        let logs: Vec<Vec<u8>> = mutants.iter().map(|mutant| mutant.bytes.clone()).collect();
        let said = script.verdicts(&session.plan, &logs, 0);
        for (mutant, said) in mutants.iter().zip(said) {
            let product = verdict(&mutant.bytes, &session.work);
            tally.take(&script, session, mutant, (&product, said));
        }
        for _ in 0..each.div_ceil(PLAN_EVERY) {
            let plan = mutate_plan(&session.plan, &mut random);
            let said = script.verdicts(&plan, std::slice::from_ref(&session.log), 0).remove(0);
            let product = verdict_on_plan(&session.log, &plan);
            assert_eq!(product.is_ok(), said.holds, "mutated plan: {product:?}, {}", said.text);
            *tally.kinds.entry(("plan", product.is_ok())).or_default() += 1;
        }
    }
    tally.print();
    assert!(tally.differences.is_empty(), "{}", tally.differences.join("\n"));
    assert!(tally.at_arcs * 200 <= tally.count, "{} differences at arcs", tally.at_arcs);
    let with = |wanted: bool| -> usize {
        tally.kinds.iter().filter(|((_, holds), _)| *holds == wanted).map(|(_, count)| count).sum()
    };
    assert!(with(true) * 20 > count && with(false) * 4 > count, "the mutants are one-sided");
}

/// The count of the verdicts.
#[derive(Default)]
struct Tally {
    count: usize,
    /// Mutants of each kind, with the common verdict.
    kinds: BTreeMap<(&'static str, bool), usize>,
    /// Mutants on which the programs differ, within [`BAND`] of the limit at an arc.
    at_arcs: usize,
    differences: Vec<String>,
}

impl Tally {
    fn take(
        &mut self,
        script: &CheckScript,
        session: &HonestSession,
        mutant: &Mutant,
        (product, said): (&Result<CertificateCheck, String>, ScriptVerdict),
    ) {
        self.count += 1;
        if product.is_ok() == said.holds {
            *self.kinds.entry((mutant.kind, said.holds)).or_default() += 1;
            return;
        }
        // With a larger clearance at arcs the script must refuse what the product refuses, and the other way round.
        let band = if said.holds { BAND } else { -BAND };
        let again = script.verdicts(&session.plan, std::slice::from_ref(&mutant.bytes), band).remove(0);
        if product.is_ok() == again.holds {
            self.at_arcs += 1;
            println!("at an arc: {}: {}: {product:?}; {}", session.name, mutant.kind, said.text);
            return;
        }
        let kept = script.keep(&session.plan, &mutant.bytes, self.differences.len());
        self.differences.push(format!(
            "{}: {}: the product says {product:?}, the script says {}. See {kept}",
            session.name, mutant.kind, said.text
        ));
    }

    fn print(&self) {
        println!("{} mutants, {} at an arc, {} differ", self.count, self.at_arcs, self.differences.len());
        for ((kind, holds), count) in &self.kinds {
            println!("  {kind:<28} {:<8} {count}", if *holds { "holds" } else { "refused" });
        }
    }
}
