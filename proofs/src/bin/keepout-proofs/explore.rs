//! `explore`: explores the worlds of the guard's invariant.

use std::process::ExitCode;
use std::time::Instant;

use keepout_proofs::invariant::World;
use keepout_proofs::second_controller::SecondController;
use keepout_proofs::worlds;

/// The worlds to explore, and the limit.
#[derive(Debug, clap::Args)]
pub struct Explore {
    /// Explore only worlds whose name contains this text.
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Largest number of states per world.
    #[arg(long, default_value_t = worlds::STATES)]
    states: usize,
    /// Explore with the second model of the controller, which another author wrote from the documentation.
    #[arg(long)]
    second: bool,
}

impl Explore {
    /// Explores the worlds and prints a line for each. The exit code is 0 if every world holds and was
    /// explored completely.
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
            let explored = if self.second {
                world.explore_with::<SecondController>(self.states)
            } else {
                world.explore(self.states)
            };
            let (states, steps, depth) = (explored.states, explored.steps, explored.depth);
            let all = if explored.complete { "all" } else { "not all" };
            let seconds = begin.elapsed().as_secs_f64();
            println!("{}: {states} states ({all}), {steps} steps, depth {depth}, {seconds:.1} s", world.name);
            if let Some(sequence) = &explored.violation {
                println!("{sequence:#?}");
            }
            held &= explored.violation.is_none() && explored.complete;
        }
        super::code(Ok(held))
    }
}
