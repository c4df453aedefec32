//! `explore`: the worlds of the guard's invariant.

use std::process::ExitCode;
use std::time::Instant;

use keepout_proofs::invariant::World;
use keepout_proofs::worlds;

/// Which worlds to explore, and how far.
#[derive(Debug, clap::Args)]
pub struct Explore {
    /// Only worlds with this in their name.
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// The most states of one world.
    #[arg(long, default_value_t = worlds::STATES)]
    states: usize,
}

impl Explore {
    /// Explores, prints a line for each world, and says by the exit code whether all hold and were seen to the last state.
    pub fn run(&self) -> ExitCode {
        let chosen: Vec<World> =
            worlds::all().into_iter().filter(|world| world.name.contains(&self.only)).collect();
        if chosen.is_empty() {
            eprintln!(
                "No world has \"{}\" in its name. Run `explore` without --only to see them all.",
                self.only
            );
            return ExitCode::from(2);
        }
        let mut held = true;
        for world in chosen {
            let begin = Instant::now();
            let explored = world.explore(self.states);
            let (states, steps, depth) = (explored.states, explored.steps, explored.depth);
            let all = if explored.complete { "all" } else { "not all" };
            let seconds = begin.elapsed().as_secs_f64();
            println!("{}: {states} states ({all}), {steps} steps, depth {depth}, {seconds:.1} s", world.name);
            if let Some(story) = &explored.violation {
                println!("{story:#?}");
            }
            held &= explored.violation.is_none() && explored.complete;
        }
        super::code(Ok(held))
    }
}
