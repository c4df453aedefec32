//! Runs all engines, the quick ones first, up to the first failure. The runner of seeded faults uses it.

use std::sync::mpsc;
use std::time::Duration;

use fastrand::Rng;

use crate::families::Family;
use crate::property::{Property, Ran};
use crate::{properties, soak};

/// Runs the properties of the chosen groups, then the soaks and worlds. Returns the name of the first
/// failure.
///
/// `word` is a comma-separated list of parts of group names. An empty one chooses everything. The soaks
/// belong to `index`, the worlds to `guard`.
#[must_use]
pub fn first_failure(word: &str) -> Option<String> {
    std::panic::set_hook(Box::new(|_| {}));
    let chosen: Vec<&'static Property> = properties::all()
        .into_iter()
        .filter(|property| word.is_empty() || word.split(',').any(|word| property.group.contains(word)))
        .collect();
    let quickly = chosen.iter().find_map(|property| quick(property));
    let engines: [fn(&Property) -> Option<Ran>; 2] = [Property::run_every, Property::run_random];
    let by_property = || {
        engines.into_iter().find_map(|engine| {
            let fails = |property: &&&Property| {
                property.observed(engine).is_some_and(|outcome| outcome.ran.is_none())
            };
            chosen.iter().find(fails).map(|property| property.name.to_string())
        })
    };
    quickly.or_else(by_property).or_else(|| soaked(word)).or_else(|| explored(word))
}

/// Time limit of [`quick`]. A tenth of the random cases takes less. The limit finds faults that make a loop
/// endless.
const PATIENCE: Duration = Duration::from_secs(100);

fn quick(property: &'static Property) -> Option<String> {
    let (done, outcome) = mpsc::channel();
    std::thread::spawn(move || done.send(property.observed(Property::run_quick)));
    match outcome.recv_timeout(PATIENCE) {
        Ok(outcome) => {
            outcome.is_some_and(|outcome| outcome.ran.is_none()).then(|| property.name.to_string())
        }
        Err(_) => Some(format!("{} (it does not end)", property.name)),
    }
}

fn soaked(word: &str) -> Option<String> {
    if !word.is_empty() && !word.contains("index") {
        return None;
    }
    type Run = (&'static str, fn(&mut Rng));
    let runs: [Run; 3] = [
        ("soak: predicates", |random| soak::predicates(random, 200_000)),
        ("soak: arcs", |random| soak::arcs(random, 10_000)),
        ("soak: families", |random| {
            for family in Family::ALL {
                for _ in 0..6 {
                    soak::family_queries(family, random);
                }
            }
        }),
    ];
    let fails = |run: fn(&mut Rng)| std::panic::catch_unwind(|| run(&mut Rng::with_seed(11))).is_err();
    runs.into_iter().find(|&(_, run)| fails(run)).map(|(name, _)| name.to_string())
}

#[cfg(feature = "guard")]
fn explored(word: &str) -> Option<String> {
    /// Largest number of states per world. Faults show early.
    const STATES: usize = 400_000;
    if !word.is_empty() && !word.contains("guard") {
        return None;
    }
    let mut worlds = crate::worlds::all().into_iter();
    worlds
        .find(|world| {
            let explored = std::panic::catch_unwind(|| world.explore(STATES));
            explored.map_or(true, |explored| explored.violation.is_some())
        })
        .map(|world| format!("invariant: {}", world.name))
}

#[cfg(not(feature = "guard"))]
fn explored(_word: &str) -> Option<String> {
    None
}
