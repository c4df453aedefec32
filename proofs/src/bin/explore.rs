//! Explores the worlds of the supervisor's invariant: `explore [most states] [part of a name]`. With the feature `mutations`
//! and a third word, each part of the guard is taken out in turn, and the worlds that notice are named.

use keepout_proofs::{invariant::World, worlds};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let most = words.first().and_then(|word| word.parse().ok()).unwrap_or(1_500_000);
    let named = |world: &World| words.get(1).is_none_or(|word| world.name.contains(word.as_str()));
    #[cfg(feature = "mutations")]
    if words.len() > 2 {
        return notice(most, named);
    }
    let mut held = true;
    for world in worlds::all().into_iter().filter(named) {
        let begin = std::time::Instant::now();
        let explored = world.explore(most);
        let (states, steps, depth) = (explored.states, explored.steps, explored.depth);
        let all = if explored.complete { "all" } else { "not all" };
        println!(
            "{}: {states} states ({all}), {steps} steps, depth {depth}, {:.1} s",
            world.name,
            begin.elapsed().as_secs_f64()
        );
        if let Some(story) = explored.violation {
            println!("{story:#?}");
            held = false;
        }
    }
    std::process::exit(i32::from(!held));
}

#[cfg(feature = "mutations")]
fn notice(most: usize, named: impl Fn(&World) -> bool) {
    use keepout_executor::supervisor::guard::Mutation;
    for mutation in Mutation::ALL {
        let mut noticed = Vec::new();
        for world in worlds::all().into_iter().filter(&named) {
            let explored = world.explore_with(most, |guard| guard.mutate(mutation));
            if let Some(story) = explored.violation {
                noticed.push(format!("{} in {} steps", world.name, story.len() - 1));
            }
        }
        println!(
            "{mutation:?}: {}",
            if noticed.is_empty() { "not noticed".into() } else { noticed.join("; ") }
        );
    }
}
