//! The search for a smaller session that still fails.

use std::time::Duration;

use keepout_sim::Quirks;

use super::operator::Style;
use super::play::play;
use super::spec::Spec;
use super::world::HostileWorld;

/// The smallest failing session that the search finds: fewer faults, a shorter time, a plain line, a plain
/// operator.
#[must_use]
pub fn shrink(world: &HostileWorld, spec: &Spec) -> Spec {
    let fails = |candidate: &Spec| play(world, candidate).verdict.is_some();
    let mut best = spec.clone();
    let mut smaller = true;
    while smaller {
        smaller = false;
        for candidate in candidates(&best) {
            if candidate != best && fails(&candidate) {
                best = candidate;
                smaller = true;
                break;
            }
        }
    }
    best
}

fn candidates(spec: &Spec) -> Vec<Spec> {
    let mut list = Vec::new();
    for index in 0..spec.faults.len() {
        let mut without = spec.clone();
        without.faults.remove(index);
        list.push(without);
    }
    list.push(Spec { limit: spec.limit / 2, ..spec.clone() });
    list.push(Spec { limit: spec.limit.mul_f64(0.9), ..spec.clone() });
    list.push(Spec { automatic: false, ..spec.clone() });
    list.push(Spec { begins_inside: false, ..spec.clone() });
    list.push(Spec { driven: false, ..spec.clone() });
    list.push(Spec { at_panel: false, ..spec.clone() });
    list.push(Spec { quirks: Quirks::default(), ..spec.clone() });
    list.push(Spec { power_fails: false, ..spec.clone() });
    list.push(Spec { latency: Duration::from_millis(1), ..spec.clone() });
    list.push(Spec { baud: 115_200, ..spec.clone() });
    if let Style::Model(_) = spec.style {
        return list;
    }
    list.extend(Style::ALL.iter().take(4).map(|&style| Spec { style, ..spec.clone() }));
    list
}
