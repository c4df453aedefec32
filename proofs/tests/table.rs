//! Every property has an engine that runs here, and the page lists everything.
#![cfg(all(feature = "guard", feature = "tools", feature = "solvers"))]

use std::collections::HashSet;

use keepout_proofs::carried::{self, CARRIED, Carrier};
use keepout_proofs::faults::tree;
use keepout_proofs::smt::results;
use keepout_proofs::theorems::THEOREMS;
use keepout_proofs::{faults, model_check, properties, table, worlds};

#[test]
fn every_property_has_an_engine() {
    let all = properties::all();
    let names: HashSet<&str> = all.iter().map(|property| property.name).collect();
    assert_eq!(names.len(), all.len(), "names are unique");
    for property in &all {
        let every = property.every.is_some_and(|(side, _)| side >= 0);
        let random = property.random.is_some_and(|(cases, _)| cases > 0);
        assert!(every || random, "{} has no engine that runs here", property.name);
    }
}

#[test]
fn each_property_is_carried_once_by_an_engine_that_finished() {
    let (_, answered) = model_check::results::read();
    let harnesses: HashSet<String> = answered.into_iter().map(|row| row.name).collect();
    let worlds: HashSet<&str> = worlds::all().iter().map(|world| world.name).collect();
    let theorems = results::read(&faults::workspace().join("proofs/results/theorems.tsv"))
        .expect("`prove` has written it");
    let runs_code = |name: &&str| theorems.iter().any(|row| row.theorem == *name && row.paths > 0);
    let is_proved = |name: &&str| theorems.iter().any(|row| row.theorem == *name && row.result == "proved");
    for property in properties::all() {
        let rows = CARRIED.iter().filter(|(name, _)| *name == property.name).count();
        assert_eq!(rows, 1, "{} has one row", property.name);
        let known = match carried::by(property.name).expect("it has a row") {
            Carrier::Theorems(names) => names.iter().all(is_proved) && names.iter().any(runs_code),
            Carrier::RandomReasoned(names) => property.random.is_some() && names.iter().all(is_proved),
            Carrier::ModelChecker(names) => names.iter().all(|name| harnesses.contains(*name)),
            Carrier::Exploration(names) => names.iter().all(|name| worlds.contains(name)),
            Carrier::EveryCase => property.every.is_some(),
            Carrier::Random(_) => property.random.is_some(),
        };
        assert!(known, "{}: there is no such theorem, answered harness or world", property.name);
    }
    assert_eq!(CARRIED.len(), properties::all().len(), "a row is of no property");
}

/// A harness without an answer would be a promise.
#[test]
fn every_harness_was_proved() {
    let (_, rows) = model_check::results::read();
    for harness in keepout_harnesses::all() {
        let proved = rows.iter().any(|row| row.name == harness.name);
        assert!(proved, "{}: run `model-check --write`", harness.name);
    }
}

#[test]
fn the_page_names_every_property_and_every_fault() {
    let page = faults::workspace().join("proofs/README.md");
    let page = std::fs::read_to_string(page).expect("`table` has written it");
    for property in properties::all() {
        assert!(page.contains(&format!("| `{}` | {} |", property.name, property.claim)), "{}", property.name);
    }
    for fault in faults::catalogue().expect("the catalogue is here") {
        let listed = !fault.engines().contains(&faults::FaultEngine::Fuzz);
        assert!(!listed || page.contains(&fault.name), "{}", fault.name);
    }
    for theorem in THEOREMS {
        assert!(
            page.contains(&format!("| `{}` | {} |", theorem.name, theorem.claim.replace('|', "\\|"))),
            "{}",
            theorem.name
        );
    }
    for world in worlds::all() {
        assert!(page.contains(&format!("| {} |", world.name)), "{}", world.name);
    }
    assert!(!page.contains("**fails**") && !page.contains("**does not hold**"));
    for harness in keepout_harnesses::all() {
        assert!(page.contains(&format!("| `{}` | {} |", harness.name, harness.claim)), "{}", harness.name);
    }
}

/// Another theorem must rest on each theorem that runs no code, or it must carry a property. Otherwise it proves
/// nothing about the code.
#[test]
fn theorems_that_run_no_code_are_tied_to_it() {
    let rows = results::read(&faults::workspace().join("proofs/results/theorems.tsv"))
        .expect("`prove` has written it");
    let names: Vec<&str> = rows.iter().map(|row| row.theorem.as_str()).collect();
    assert_eq!(names, THEOREMS.iter().map(|theorem| theorem.name).collect::<Vec<_>>());
    for row in rows.iter().filter(|row| row.paths == 0) {
        assert!(!table::used_by(&row.theorem, &rows).is_empty(), "{}", row.theorem);
    }
}

#[test]
fn every_fault_is_noticed() {
    let rows = faults::results::read();
    for fault in faults::catalogue().expect("the catalogue is here") {
        assert!(
            faults::results::is_settled(&rows, &fault),
            "{}: run `faults --left`, or the example `seeded` of fuzzing",
            fault.name
        );
    }
}

/// Each edit finds its place once: alone, and after the other faults that share its copy.
#[test]
fn faults_can_be_seeded() {
    let catalogue = faults::catalogue().expect("the catalogue is here");
    for fault in &catalogue {
        tree::seeded_files(std::slice::from_ref(fault)).expect("it can be seeded alone");
    }
    let switched: Vec<_> = catalogue.into_iter().filter(faults::SeededFault::is_switched).collect();
    assert!(tree::seeded_files(&switched).expect("they can be seeded together").len() > 10);
}
