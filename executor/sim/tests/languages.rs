//! Whole sessions in virtual time with a controller of each dialect: jogging, then the contour.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::session::{Going, NoEventLog, RunFacts};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::TermKind;
use keepout_planner::plan::{CertifiedPlan, PassParameters};
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;
use keepout_sim::session::{SimRun, run_simulated};

/// The bracket, with one finishing pass that leaves `stock_mm`.
fn plan(stock_mm: f64) -> CertifiedPlan {
    let bytes = include_bytes!("../../cli/drawings/bracket.dxf");
    let mut request = PlanRequest::default();
    if stock_mm > 0.0 {
        request.job.passes = vec![PassParameters { stock_to_leave_mm: stock_mm, feed_mm_min: None }];
    }
    request.plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap()
}

fn run(language: &str, operator: &str, stock_mm: f64, seed: u64) -> RunFacts {
    run_over(115_200, 2, language, operator, stock_mm, seed)
}

fn run_over(
    baud: u32,
    latency_ms: u64,
    language: &str,
    operator: &str,
    stock_mm: f64,
    seed: u64,
) -> RunFacts {
    let run = SimRun {
        dialect: DialectName::named(language).unwrap(),
        feed_mm_min: 3000,
        baud,
        latency: Duration::from_millis(latency_ms),
        seed,
        ..SimRun::default()
    };
    let operator = operator::named(operator, 20.0, seed).unwrap();
    let work = PreparedPlan::new(plan(stock_mm));
    run_simulated(work, &run, operator, Box::new(NoEventLog), &mut |_, _, _| Going::On).unwrap().facts
}

fn whole(language: &str, stock_mm: f64) {
    for (operator, seed) in [("wall", 1), ("random", 2)] {
        let facts = run(language, operator, stock_mm, seed);
        assert_eq!(facts.deepest_mm, Some(0.0), "{language} {operator}: {facts:?}");
        assert!(
            facts.outcome.is_by_operator() && !facts.progress.finished.is_empty(),
            "{language} {operator}: {facts:?}"
        );
        assert!(facts.counts.jogs > 10, "{language} {operator}: {facts:?}");
        let coverage = facts.coverage.unwrap();
        // Stock closes the narrow places, so every controller misses the same points.
        let missed = if stock_mm > 0.0 { missed_by("grbl", operator, stock_mm, seed) } else { 0 };
        assert_eq!(coverage.missed, missed, "{language} {operator}: {coverage:?}");
        assert!(coverage.worst_mm < stock_mm + most_left_mm(stock_mm), "{language} {operator}: {coverage:?}");
    }
}

/// The most that a finishing toolpath may leave, mm: the margin, and the errors of the machine beside the
/// toolpath, by the plan's own terms.
fn most_left_mm(stock_mm: f64) -> f64 {
    let off = [TermKind::ContourError, TermKind::Repeatability, TermKind::StepResolution];
    let terms = plan(stock_mm).plan.budget.terms;
    let twice = terms.iter().filter(|term| off.contains(&term.kind));
    terms.iter().chain(twice).map(|term| term.mm).sum()
}

/// The number of reachable points of the profile that a controller of this dialect leaves uncut.
fn missed_by(language: &str, operator: &str, stock_mm: f64, seed: u64) -> usize {
    let facts = run(language, operator, stock_mm, seed);
    let Some(coverage) = facts.coverage else { panic!("{language} {operator}: no contour, {facts:?}") };
    coverage.missed
}

#[test]
fn zaber() {
    whole("zaber", 0.0);
}

#[test]
fn venus() {
    whole("venus", 0.0);
}

/// A dialect described by a file of this package.
fn described(file: &str) -> String {
    format!("{}/{file}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn nsk_style() {
    whole(&described("../dialects/nsk-style"), 0.05);
}

#[test]
fn tango() {
    whole(&described("../dialects/tango"), 0.05);
}

#[test]
fn ok_style() {
    whole(&described("tests/described/ok-style"), 0.0);
}

#[test]
fn one_answer() {
    whole(&described("tests/described/one-answer"), 0.0);
}

/// A session over a slow line, on which exchanges of several lines take a second or more each.
fn slow_line(language: &str) {
    let facts = run_over(9600, 150, language, "calm", 0.1, 3);
    assert_eq!(facts.deepest_mm, Some(0.0), "{language}: {facts:?}");
    assert!(facts.outcome.is_by_operator() && !facts.progress.finished.is_empty(), "{language}: {facts:?}");
}

#[test]
fn slow_zaber() {
    slow_line("zaber");
}

#[test]
fn slow_venus() {
    slow_line("venus");
}

#[test]
fn slow_nsk_style() {
    slow_line(&described("../dialects/nsk-style"));
}

#[test]
fn slow_tango() {
    slow_line(&described("../dialects/tango"));
}

#[test]
fn independent_axes_need_stock_and_a_notice_states_it() {
    let facts = run(&described("../dialects/nsk-style"), "wall", 0.0, 1);
    assert_eq!((facts.progress.finished.len(), facts.deepest_mm), (0, Some(0.0)), "{facts:?}");
    assert!(facts.notices.iter().any(|notice| notice.contains("leaves at least 0.01 mm")), "{facts:?}");
}
