//! Tests of the Franco & Horikawa study: its required results, and the agreement of
//! `docs/research/franco-horikawa.md` with its generator.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};

use keepout_drives::budget::{BudgetRequest, budget};
use keepout_drives::controllers::kind::Kind;
use keepout_drives::profile::{DriveProfile, Uncertainty};
use keepout_drives::tuning::{MOST_PEAK, peak};
use keepout_studies::franco_horikawa::attempt::{Tally, operator_of, seed_of};
use keepout_studies::franco_horikawa::calibration::misfit;
use keepout_studies::franco_horikawa::check_picture;
use keepout_studies::franco_horikawa::page::{FOLDER, page};
use keepout_studies::franco_horikawa::picture::chart;
use keepout_studies::franco_horikawa::results::{PaperRow, Results, our_rows, paper_attempts, paper_rows};
use keepout_studies::franco_horikawa::roughing::RoughingPass;
use keepout_studies::franco_horikawa::scenario::{Scenarios, machine};
use keepout_studies::franco_horikawa::tables::{ours_table, paper_table};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/research")
}

fn kept(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn kept_results() -> Results {
    serde_json::from_str(&kept(&docs().join(FOLDER).join("results.json"))).unwrap()
}

#[test]
fn page_agrees_with_its_results_and_generator() {
    let (scenarios, results) = (Scenarios::built_in().unwrap(), kept_results());
    assert_eq!(
        results.delays, scenarios.delays,
        "the delay model changed. \
         Run `cargo run --release -p keepout-studies -- franco-horikawa -o docs/research`."
    );
    // The words of page and chart change without the experiment: KEEPOUT_WRITE_PAGE=1 writes them from the results.
    if std::env::var_os("KEEPOUT_WRITE_PAGE").is_some() {
        std::fs::write(docs().join("franco-horikawa.md"), page(&scenarios, &results)).unwrap();
        std::fs::write(docs().join(FOLDER).join("success.svg"), chart(&results)).unwrap();
        std::fs::write(docs().join(FOLDER).join("checks.svg"), check_picture::svg()).unwrap();
    }
    assert_eq!(kept(&docs().join("franco-horikawa.md")), page(&scenarios, &results));
    assert_eq!(kept(&docs().join(FOLDER).join("success.svg")), chart(&results));
    assert_eq!(kept(&docs().join(FOLDER).join("checks.svg")), check_picture::svg());
}

/// Checks the required results of the study, and the required number of attempts.
#[test]
fn results_meet_the_requirements() {
    let results = kept_results();
    let ours = results.ours_together();
    assert!(ours.attempts >= 100_000 && ours.successes == ours.attempts, "{ours:?}");
    assert!(ours.mean_mm.unwrap() <= 0.05, "{ours:?}");
    assert!(results.ours.iter().any(|row| row.latency_ms >= 2000));
    assert!(results.ours.iter().all(|row| row.found.attempts >= 1000));
    assert!(results.paper.iter().all(|row| row.found.attempts >= 1000));
    for row in results.paper.iter().filter(|row| row.reported.table == "2 (a)") {
        let (tolerance, success) = (row.reported.tolerance_mm, row.found.success());
        assert!(tolerance > 2.0 || success < 0.25, "{row:?}");
        assert!(tolerance < 5.0 || success > 0.9, "{row:?}");
    }
    assert!(results.clearing.iter().all(|row| row.system == "paper" || row.found.deepest_mm == 0.0));
    for row in &results.roughing {
        let alike = |other: &&RoughingPass| other.system != row.system && other.profile == row.profile;
        let other = results.roughing.iter().find(alike).unwrap();
        assert_eq!(row.approaches, other.approaches, "{row:?}");
        assert!(row.system == "paper" || (row.invasions, row.deepest_mm) == (0, 0.0), "{row:?}");
        assert!(row.system == "paper" || row.left_mm < 0.1 * other.left_mm, "{row:?} {other:?}");
    }
    // A fast computer stops the table before the desired position, at every speed of the hand.
    for row in results.brake.iter().filter(|row| row.round_s < 0.02) {
        assert_eq!((row.found.successes, row.released), (row.found.attempts, row.found.attempts), "{row:?}");
    }
    for row in &results.handwheel {
        assert_eq!(row.released, row.found.attempts, "{row:?}");
        assert!(row.system == "paper" || row.found.successes == row.found.attempts, "{row:?}");
    }
    // With x intervals alone, internal machining fails more often, as the page states.
    let success = |rows: &[PaperRow]| {
        let internal = rows.iter().filter(|row| row.reported.table == "2 (b)");
        internal.map(|row| row.found.success()).sum::<f64>()
    };
    assert!(success(&results.by_x) < success(&results.paper) - 0.1);
    // Both feeds have a similar success, and the under-cutting grows with T.
    let triangle: Vec<_> = results.paper.iter().filter(|row| row.reported.table == "2 (a)").collect();
    let (slow, quick) = triangle.split_at(triangle.len() / 2);
    for (slow, quick) in slow.iter().zip(quick) {
        assert!((slow.found.success() - quick.found.success()).abs() < 0.12, "{slow:?} {quick:?}");
    }
    for rows in [slow, quick] {
        assert!(rows.windows(2).all(|pair| pair[0].found.success() < pair[1].found.success()));
        assert!(rows[2..].windows(2).all(|pair| pair[0].found.mean_mm < pair[1].found.mean_mm));
    }
}

/// Repeats the attempts of some rows, and compares them with the stored results. The last digit of a sine
/// depends on the system, so a few attempts may differ.
#[test]
fn stored_results_of_paper_rows_are_reproducible() {
    let (scenarios, results) = (Scenarios::built_in().unwrap(), kept_results());
    for number in [1, 2, 9] {
        let tried = paper_attempts(&scenarios, number, (results.attempts, results.seed)).unwrap();
        let (found, kept) = (Tally::of(&tried), results.paper[number].found);
        assert_eq!(found.attempts, kept.attempts);
        assert!(found.successes.abs_diff(kept.successes) <= 5, "{found:?} {kept:?}");
        assert!((found.mean_mm.unwrap() - kept.mean_mm.unwrap()).abs() < 0.02, "{found:?} {kept:?}");
    }
}

#[test]
fn tables_depend_only_on_the_seed() {
    let scenarios = Scenarios::built_in().unwrap();
    let made = |seed| {
        let paper = paper_rows(&scenarios, (4, seed), &|_, _| {}).unwrap();
        let ours = our_rows(&scenarios, (2, seed), &|_, _| {}).unwrap();
        [paper_table(&paper), ours_table(&ours)]
    };
    let first = made(5);
    assert_eq!(first, made(5));
    assert_ne!(first, made(6));
}

/// Checks every profile, speed and delay with other seeds than the page: the tool never enters the part, and
/// stops close to it.
#[test]
fn keepout_never_enters_the_part_and_stops_close_to_it() {
    let scenarios = Scenarios::built_in().unwrap();
    let rows = our_rows(&scenarios, (6, 77), &|_, _| {}).unwrap();
    assert_eq!(
        rows.len(),
        scenarios.profile.len() * scenarios.ours_mm_s.len() * scenarios.latencies_ms.len()
    );
    for row in &rows {
        assert_eq!(row.found.successes, row.found.attempts, "{row:?}");
        assert!(row.found.mean_mm.unwrap() < 0.05, "{row:?}");
    }
}

/// The delays cause the invasions of the paper's system. Almost without delays, a small T is sufficient.
#[test]
fn delays_cause_the_invasions() {
    let mut scenarios = Scenarios::built_in().unwrap();
    scenarios.delays.compute_s = 0.0;
    scenarios.delays.inertia_s = 0.0;
    scenarios.delays.unit_mm = 0.1;
    scenarios.delays.baud = 1e6;
    // T = 2 mm, at 12 mm/s.
    let quick = Tally::of(paper_attempts(&scenarios, 1, (200, 3)).unwrap());
    assert!(quick.success() > 0.99 && quick.mean_mm.unwrap() > 1.5, "{quick:?}");
}

#[test]
fn misfit_is_smallest_at_the_reported_values() {
    let scenarios = Scenarios::built_in().unwrap();
    let row = &scenarios.row[2];
    let with = |successes: u64, mean_mm: f64| {
        let found = Tally { attempts: 170, successes, mean_mm: Some(mean_mm), ..Tally::default() };
        misfit(row, &found)
    };
    let reported = row.under_cutting_mm.unwrap();
    let exact = with(110, reported);
    for (successes, mean_mm) in [(60, reported), (160, reported), (110, reported + 0.5), (0, 0.0), (170, 9.0)]
    {
        assert!(with(successes, mean_mm) > exact + 1.0, "{successes} {mean_mm}");
        assert!(with(successes, mean_mm).is_finite());
    }
}

/// The margin of the study's machine contains this budget.
#[test]
#[ignore = "it takes a minute: `.ci/weekly studies`"]
fn contour_error_of_the_modules_agrees_with_their_drives() {
    let machine = machine(1200.0).unwrap();
    let profile = DriveProfile::load("nsk-modules").unwrap();
    let interpolator = profile.interpolator.unwrap();
    assert!(machine.acceleration_mm_s2 <= interpolator.acceleration_mm_s2);
    assert!(machine.max_rate_mm_s <= interpolator.max_rate_mm_s);
    // The study's modules have no delay that their controller does not know.
    let uncertainty = Uncertainty { delay_samples: 0.0, ..profile.uncertainty };
    let profile = DriveProfile { controller: Some(Kind::Contouring), uncertainty, ..profile };
    let question = BudgetRequest { feed_mm_s: 60.0, by_hand_mm_s: Some(1200.0) };
    let found = budget(&profile, &question, &mut |_, _| {}).unwrap();
    // The last digit of a sine depends on the system, and friction amplifies the difference.
    assert!(found.term_mm <= machine.contour_error_mm + 0.000_3, "{}", found.term_mm);
    assert!(found.term_mm >= machine.contour_error_mm * 0.95, "{}", found.term_mm);
    assert_eq!(machine.contour_error_source.details(), found.source);
}

/// The page says so.
#[test]
fn controllers_of_the_finishing_pass_do_not_keep_their_margins() {
    let modules = DriveProfile::load("nsk-modules").unwrap();
    for kind in [Kind::Contouring, Kind::Gpc] {
        let found = peak(&modules, kind, modules.gains);
        assert!(found.is_none_or(|found| found > MOST_PEAK), "{kind:?} {found:?}");
    }
}

#[test]
fn invalid_scenarios_are_rejected() {
    let text = include_str!("../src/franco_horikawa/scenarios.toml");
    let unknown = text.replace("profile = \"triangle\"", "profile = \"square\"");
    assert!(Scenarios::parse(&unknown).unwrap_err().to_string().contains("\"square\""));
    let misspelt = text.replace("unit_mm", "unit_cm");
    assert!(Scenarios::parse(&misspelt).unwrap_err().to_string().contains("unit_cm"));
}

#[test]
fn attempts_have_different_seeds_and_operators() {
    let mut seeds: Vec<u64> = (0..20).flat_map(|row| (0..50).map(move |n| seed_of(1, row, n))).collect();
    seeds.sort_unstable();
    seeds.dedup();
    assert_eq!(seeds.len(), 1000);
    let all = keepout_studies::franco_horikawa::attempt::ALL;
    let mut found: Vec<_> = (0..6).map(|attempt| format!("{:?}", operator_of(&all, attempt))).collect();
    found.sort();
    found.dedup();
    assert_eq!(found.len(), 6);
}
