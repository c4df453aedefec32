//! The safety trace has no gap, its pages are up to date, and it notices its own seeded defects.
#![cfg(all(feature = "guard", feature = "tools", feature = "solvers"))]

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use keepout_proofs::faults::{tree, workspace};
use keepout_proofs::mutants;
use keepout_proofs::trace::{self, EvidenceKind, SafetyTrace, TraceGap, TracedEvidence, page};

fn read() -> SafetyTrace {
    trace::read(&workspace()).expect("the pages and sources are here")
}

#[test]
fn every_requirement_is_traced_from_its_hazard_to_a_fault() {
    let gaps = read().gaps();
    let list: Vec<String> = gaps.iter().map(ToString::to_string).collect();
    assert!(gaps.is_empty(), "{} gaps:\n{}", gaps.len(), list.join("\n"));
}

/// Text that is not found would change unnoticed.
#[test]
fn all_evidence_has_a_text() {
    let nothing = trace::code_digest("");
    let lost: Vec<_> = read().evidence.into_iter().filter(|each| each.digest == nothing).collect();
    assert!(lost.is_empty(), "{lost:#?}");
}

#[test]
fn pages_are_up_to_date() {
    for (name, text) in page::pages(&read()).expect("they can be written") {
        let kept = fs::read_to_string(workspace().join("docs/safety").join(name)).unwrap_or_default();
        assert!(kept == text, "docs/safety/{name} is old: run `keepout-proofs trace`");
    }
}

/// The page of mutants counts those of a changed file as not tried, once it is written again.
#[test]
fn rows_of_mutants_are_of_the_code_as_it_is() {
    let changed = mutants::changed_files(&workspace()).expect("`keepout-proofs mutants` has written them");
    assert!(
        changed.is_empty(),
        "changed since their mutants were tried: {changed:?}. Run `keepout-proofs mutants`"
    );
}

/// A requirement that nobody tests, a test that cannot fail, evidence for nothing, and wrong numbers.
#[test]
fn seeded_defects_of_the_trace_are_noticed() {
    let sound = read();
    let with = |change: &dyn Fn(&mut SafetyTrace)| {
        let mut changed = sound.clone();
        change(&mut changed);
        changed.gaps()
    };
    let test = |name: &str, requirements: &[&str]| TracedEvidence {
        kind: EvidenceKind::Test,
        name: name.into(),
        file: "kernel/src/lib.rs".into(),
        requirements: requirements.iter().map(ToString::to_string).collect(),
        runs_code: true,
        digest: String::new(),
    };

    let untested = |trace: &mut SafetyTrace| {
        let mut requirement = trace.statements.requirements[0].clone();
        requirement.id = "SR-99".into();
        trace.statements.requirements.push(requirement);
    };
    let gaps = with(&untested);
    assert!(gaps.contains(&TraceGap::NoEvidence("SR-99".into())), "{gaps:?}");
    assert!(gaps.contains(&TraceGap::NoMechanism("SR-99".into())), "{gaps:?}");

    let gaps = with(&|trace| trace.evidence.push(test("it_holds", &["SR-01"])));
    let gap = |gap: &TraceGap| matches!(gap, TraceGap::CannotFail { name, .. } if name == "it_holds");
    assert!(gaps.iter().any(gap), "{gaps:?}");

    let gaps = with(&|trace| trace.evidence.push(test("it_holds", &[])));
    let gap = |gap: &TraceGap| matches!(gap, TraceGap::NoRequirement { name, .. } if name == "it_holds");
    assert!(gaps.iter().any(gap), "{gaps:?}");

    let gaps = with(&|trace| trace.evidence.push(test("it_holds", &["SR-77"])));
    let gap = |gap: &TraceGap| matches!(gap, TraceGap::Unknown { id, .. } if id == "SR-77");
    assert!(gaps.iter().any(gap), "{gaps:?}");

    let gaps = with(&|trace| trace.faults[0].settled = false);
    assert!(gaps.contains(&TraceGap::Unnoticed(sound.faults[0].name.clone())), "{gaps:?}");

    let gaps = with(&|trace| trace.statements.hazards[0].whole = false);
    assert!(gaps.contains(&TraceGap::Incomplete("H-01".into())), "{gaps:?}");

    let gaps = with(&|trace| trace.statements.requirements[0].hazards.clear());
    assert!(gaps.iter().any(|gap| matches!(gap, TraceGap::OneWay { .. })), "{gaps:?}");

    // A mechanism whose file was moved: the faults in the file at its new place break a requirement elsewhere.
    let gaps = with(&|trace| {
        for mechanism in trace.mechanisms.iter_mut().filter(|each| each.file.ends_with("predicate.rs")) {
            mechanism.file = "kernel/src/exact/moved.rs".into();
        }
    });
    assert!(gaps.iter().any(|gap| matches!(gap, TraceGap::Elsewhere { .. })), "{gaps:?}");
}

/// A file of the workspace with a text replaced, which is in it once.
fn changed(file: &str, find: &str, with: &str) -> (PathBuf, String) {
    let text = fs::read_to_string(workspace().join(file)).expect("the file is there");
    assert_eq!(text.matches(find).count(), 1, "{file}: {find}");
    (file.into(), text.replace(find, with))
}

/// A file of the workspace with a test that ends at once.
fn emptied(file: &str, head: &str) -> (PathBuf, String) {
    changed(file, head, &format!("{head} return;"))
}

/// The same defects in a copy of the workspace: they pass the reading of pages and sources.
#[test]
fn defects_of_a_copy_are_noticed() {
    let requirements = "docs/safety/requirements.md";
    let changes = BTreeMap::from([
        // A requirement that nobody tests.
        changed(requirements, "\n### SR-02 ", "\n### SR-99 Something else\n\n### SR-02 "),
        // A property, a harness and a test that were emptied.
        emptied("proofs/src/properties/rings.rs", "fn area_is_the_shoelace(polygon: &[Xy]) {"),
        emptied("proofs/harnesses/src/guard.rs", "fn times_add_up_to_the_last_moment(c: &mut impl Cases) {"),
        emptied("executor/src/supervisor/input/mod.rs", "    fn old_input_does_not_jog() {"),
    ]);
    let folder = std::env::temp_dir().join(format!("keepout-trace-{}", std::process::id()));
    tree::copy_with(&folder, changes).expect("it is copied");
    // A file that has another name than the faults give it.
    let renamed = |name: &str| folder.join("kernel/src/exact").join(name);
    fs::rename(renamed("predicate.rs"), renamed("moved.rs")).expect("it is there");
    let found = trace::read(&folder).expect("the pages and sources are here").gaps();
    fs::remove_dir_all(folder).expect("it is removed");

    assert!(found.contains(&TraceGap::NoEvidence("SR-99".into())), "{found:?}");
    for emptied in ["area_is_the_shoelace", "times_add_up_to_the_last_moment", "old_input_does_not_jog"] {
        let gap = |gap: &TraceGap| matches!(gap, TraceGap::Changed { name, .. } if name == emptied);
        assert!(found.iter().any(gap), "{emptied}: {found:?}");
    }
    assert!(found.iter().any(|gap| matches!(gap, TraceGap::Elsewhere { .. })), "{found:?}");
}
