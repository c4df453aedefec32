//! Runs all engines, the quick ones first, and lists the failures. The runner of seeded faults uses it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::time::Duration;

use fastrand::Rng;
use keepout_harnesses::{Inputs, ModelHarness};

use crate::families::Family;
use crate::property::{Property, Ran};
use crate::{properties, soak};

/// Time limit of one quick run. All of them need far less. The limit finds faults that make a loop endless.
const PATIENCE: Duration = Duration::from_secs(100);
/// Random inputs for a harness.
const INPUTS: u64 = 2_000;
/// Largest number of states per world, while no other failure is known. Faults show early.
#[cfg(feature = "guard")]
const STATES: usize = 400_000;
/// The same, once a failure is known.
#[cfg(feature = "guard")]
const MORE_STATES: usize = 60_000;

/// A run over random cases, so many twentieths of a full one.
pub type SoakRun = fn(&mut Rng, u64);
/// A full run, twentieths.
const FULL: u64 = 20;
/// A quick run, twentieths.
const QUICK: u64 = 1;

/// The soaks: name and run.
pub const SOAKS: [(&str, SoakRun); 3] = [
    // Evidence for SR-01.
    ("soak: predicates", |random, parts| soak::predicates(random, 10_000 * parts)),
    // Evidence for SR-02.
    ("soak: arcs", |random, parts| soak::arcs(random, 500 * parts)),
    // Evidence for SR-03.
    ("soak: families", |random, parts| {
        for family in Family::ALL {
            for _ in 0..parts.div_ceil(3) {
                soak::family_queries(family, random);
            }
        }
    }),
];

/// Runs the properties of the chosen groups, the harnesses on random inputs, the soaks and the worlds. Returns the
/// names of all that fail in a quick run. Only while nothing fails, it runs properties and soaks in full, up to the
/// first failure of a property.
///
/// `word` is a comma-separated list of parts of group names. An empty one chooses everything. The soaks belong to
/// `index`, the worlds to `guard`, the harnesses to every group.
#[must_use]
pub fn failures(word: &str) -> Vec<String> {
    std::panic::set_hook(Box::new(|_| {}));
    let chosen: Vec<&'static Property> = properties::all()
        .into_iter()
        .filter(|property| word.is_empty() || word.split(',').any(|word| property.group.contains(word)))
        .collect();
    let mut failed = Vec::new();
    let properties =
        chosen.iter().map(|&property| quick(property.name.into(), || fails(property, Property::run_quick)));
    let harnesses = keepout_harnesses::all()
        .into_iter()
        .map(|harness| quick(format!("harness: {}", harness.name), || refuted(harness)));
    let soaks = soaks_of(word).iter().map(|&(name, run)| quick(name.into(), move || soak_fails(run, QUICK)));
    for answer in properties.chain(harnesses).chain(soaks) {
        match answer {
            Answer::Holds => {}
            Answer::Fails(name) => failed.push(name),
            // Its thread goes on and takes time from all others.
            Answer::Endless(name) => {
                failed.push(format!("{name} (it does not end)"));
                return failed;
            }
        }
    }
    if failed.is_empty() {
        let engines: [fn(&Property) -> Option<Ran>; 2] = [Property::run_every, Property::run_random];
        let mut runs =
            engines.into_iter().flat_map(|engine| chosen.iter().map(move |property| (property, engine)));
        failed.extend(
            runs.find(|(property, engine)| fails(property, *engine)).map(|(found, _)| found.name.into()),
        );
    }
    if failed.is_empty() {
        let fail = soaks_of(word).iter().filter(|(_, run)| soak_fails(*run, FULL));
        failed.extend(fail.map(|(name, _)| (*name).to_string()));
    }
    explored(word, &mut failed);
    failed
}

/// The answer of a quick run.
enum Answer {
    Holds,
    Fails(String),
    Endless(String),
}

fn quick(name: String, fails: impl FnOnce() -> bool + Send + 'static) -> Answer {
    let (done, outcome) = mpsc::channel();
    std::thread::spawn(move || done.send(fails()));
    match outcome.recv_timeout(PATIENCE) {
        Ok(false) => Answer::Holds,
        Ok(true) => Answer::Fails(name),
        Err(_) => Answer::Endless(name),
    }
}

fn fails(property: &Property, engine: fn(&Property) -> Option<Ran>) -> bool {
    property.observed(engine).is_some_and(|outcome| outcome.ran.is_none())
}

fn refuted(harness: &ModelHarness) -> bool {
    let run = || (0..INPUTS).for_each(|seed| (harness.run)(&mut Inputs::random(seed)));
    catch_unwind(AssertUnwindSafe(run)).is_err()
}

/// The soaks, where the words choose them.
fn soaks_of(word: &str) -> &'static [(&'static str, SoakRun)] {
    if word.is_empty() || word.contains("index") { &SOAKS } else { &[] }
}

fn soak_fails(run: SoakRun, parts: u64) -> bool {
    catch_unwind(|| run(&mut Rng::with_seed(11), parts)).is_err()
}

/// Adds the worlds in which the invariant does not hold.
#[cfg(feature = "guard")]
fn explored(word: &str, failed: &mut Vec<String>) {
    if !word.is_empty() && !word.contains("guard") {
        return;
    }
    for world in crate::worlds::all() {
        let states = if failed.is_empty() { STATES } else { MORE_STATES };
        let explored = catch_unwind(|| world.explore(states));
        if explored.map_or(true, |explored| explored.violation.is_some()) {
            failed.push(format!("invariant: {}", world.name));
        }
    }
}

#[cfg(not(feature = "guard"))]
fn explored(_word: &str, _failed: &mut Vec<String>) {}
