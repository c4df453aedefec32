//! Two models of GRBL 1.1 by two authors: the same inputs give the same answers, paths and places, except in the
//! differences that `docs/integrator/second-model.md` lists.

mod conformance;
mod conversation;
mod judge;
mod named;
mod script;

use std::collections::BTreeMap;

use conversation::DirectConversation;
use judge::{PlayedScript, differences};
use keepout_planner::Mm3;
use keepout_planner::machine::MachineProfile;
use keepout_sim::{DocumentedGrbl, GrblSim, SimSettings};
use named::NamedDifference;
use script::{Talk, Vocabulary, script};

/// Random conversations of each vocabulary.
const CONVERSATIONS: u64 = 1000;

fn settings(vocabulary: Vocabulary) -> SimSettings {
    let (machine, z) = if vocabulary == Vocabulary::ThreeAxes {
        (MachineProfile::simulated_three_axes(), -20.0)
    } else {
        (MachineProfile::simulated(), 0.0)
    };
    SimSettings::of(machine, Mm3::new(-200.0, -150.0, z))
}

fn both(script: &[Talk], vocabulary: Vocabulary) -> [PlayedScript; 2] {
    let first = DirectConversation::with(Box::new(GrblSim::new(settings(vocabulary))));
    let second = DirectConversation::with(Box::new(DocumentedGrbl::new(settings(vocabulary))));
    [first, second].map(|talk| PlayedScript::new(talk, script))
}

/// Plays the conversations of a vocabulary, and returns the number of each named difference.
fn compared(vocabulary: Vocabulary) -> BTreeMap<NamedDifference, u64> {
    // After a cancel or a reset in motion the tool rests where each model braked.
    let places = matches!(
        vocabulary,
        Vocabulary::Motions | Vocabulary::Jogs | Vocabulary::HeldMotions | Vocabulary::ThreeAxes
    );
    let mut counts = BTreeMap::new();
    for seed in 0..CONVERSATIONS {
        let steps = script(vocabulary, seed);
        let [first, second] = both(&steps, vocabulary);
        for found in differences(&first, &second, places) {
            let Some(name) = NamedDifference::of(&found, vocabulary) else {
                panic!("{vocabulary:?}, seed {seed}: {found:?}\n{steps:#?}");
            };
            *counts.entry(name).or_default() += 1;
        }
        if vocabulary == Vocabulary::CancelledJogs {
            for played in [&first, &second] {
                assert!(played.keeps_to_jogs(&steps), "seed {seed}: a cancelled jog left its path");
            }
        }
    }
    println!("{vocabulary:?}: {CONVERSATIONS} conversations, {counts:?}");
    counts
}

/// The named differences of a vocabulary, and the largest number of those that depend on times.
fn expect(vocabulary: Vocabulary, names: &[NamedDifference]) {
    let counts = compared(vocabulary);
    for (name, count) in counts {
        assert!(names.contains(&name), "{vocabulary:?}: {name:?} in {count} conversations");
        let by_chance = [NamedDifference::ShortState, NamedDifference::ResetAtTheEnd].contains(&name);
        assert!(
            !by_chance || count <= CONVERSATIONS / 40,
            "{vocabulary:?}: {name:?} in {count} conversations"
        );
    }
}

const ERRORS: [NamedDifference; 3] =
    [NamedDifference::TwoMotionWords, NamedDifference::NegativeFeed, NamedDifference::JogWithoutEquals];

#[test]
fn motions_and_jogs_agree_in_answers_places_and_paths() {
    expect(Vocabulary::Motions, &ERRORS);
    expect(Vocabulary::Jogs, &ERRORS);
    expect(Vocabulary::ThreeAxes, &[]);
}

#[test]
fn cancels_holds_and_resets_agree_in_answers() {
    let by_chance = [NamedDifference::ShortState, NamedDifference::ResetAtTheEnd];
    let names = [&ERRORS[..], &by_chance].concat();
    expect(Vocabulary::CancelledJogs, &names);
    expect(Vocabulary::HeldMotions, &names);
    expect(Vocabulary::Resets, &names);
}

#[test]
fn lines_of_other_hosts_differ_as_named() {
    let more = [
        NamedDifference::ShortState,
        NamedDifference::NotInTheFirstModel,
        NamedDifference::UnusedWords,
        NamedDifference::QueriesInMotion,
        NamedDifference::OtherErrorNumber,
        NamedDifference::JogWhileIdle,
    ];
    expect(Vocabulary::OtherHosts, &[&ERRORS[..], &more].concat());
}
