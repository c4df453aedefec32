//! Nothing is promised without an engine that runs here, and the page knows of everything.
#![cfg(all(feature = "guard", feature = "tools"))]

use std::collections::HashSet;

use keepout_proofs::{mutants, properties};

#[test]
fn no_property_lacks_an_engine_that_ran() {
    let all = properties::all();
    let names: HashSet<&str> = all.iter().map(|property| property.name).collect();
    assert_eq!(names.len(), all.len(), "names are told apart");
    for property in &all {
        let every = property.every.is_some_and(|(side, _)| side >= 0);
        let random = property.random.is_some_and(|(cases, _)| cases > 0);
        assert!(every || random, "{} has no engine that runs here", property.name);
    }
    let harnesses = all.iter().filter(|property| property.kani.is_some()).count();
    assert!(harnesses >= 40, "{harnesses} Kani harnesses");
}

#[test]
fn the_page_names_every_property_and_every_fault() {
    let page = mutants::workspace().join("proofs/README.md");
    let page = std::fs::read_to_string(page).expect("`table` has written it");
    for property in properties::all() {
        assert!(page.contains(&format!("| `{}` | {} |", property.name, property.claim)), "{}", property.name);
    }
    for mutant in mutants::list().expect("the list is here") {
        assert!(page.contains(&mutant.what), "{}", mutant.what);
    }
    assert!(!page.contains("**fails**") && !page.contains("**does not hold**"));
    assert!(page.contains("**Kani itself was not run here**"));
}

#[test]
fn each_fault_has_its_place_once() {
    for mutant in mutants::list().expect("the list is here") {
        let text =
            std::fs::read_to_string(mutants::workspace().join(&mutant.file)).expect("the file is here");
        assert_eq!(text.matches(&mutant.find).count(), 1, "{}", mutant.what);
    }
}
