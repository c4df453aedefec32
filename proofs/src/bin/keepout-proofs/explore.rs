//! `explore`: explores the worlds of the guard's invariant.

use std::process::ExitCode;
use std::time::Instant;

use keepout_campaigns::{ItemOutcome, ShardOptions, ShardRecord};
use keepout_proofs::invariant::World;
use keepout_proofs::second_controller::SecondController;
use keepout_proofs::worlds::{self, pairs};

/// The worlds to explore, and the limit.
#[derive(Debug, clap::Args)]
pub struct Explore {
    /// Explore only worlds whose name contains this text.
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Largest number of states per world.
    #[arg(long, default_value_t = worlds::STATES)]
    states: usize,
    /// A world also holds when the limit of states ended its exploration without a violation.
    #[arg(long)]
    partial: bool,
    /// Explore with the second model of the controller, which another author wrote from the documentation.
    #[arg(long)]
    second: bool,
    /// Explore the pairs of faults that exclude, which defeat the evidence, in place of the worlds.
    #[arg(long)]
    excluded: bool,
    #[command(flatten)]
    shard: ShardOptions,
}

impl Explore {
    /// Explores the worlds of the shard and prints a line for each. The exit code is 0 if every world holds and
    /// was explored completely, or in part with `--partial`.
    pub fn run(&self) -> ExitCode {
        let all = if self.excluded { pairs::excluded() } else { worlds::all() };
        let chosen: Vec<World> = all.into_iter().filter(|world| world.name.contains(&self.only)).collect();
        if chosen.is_empty() {
            eprintln!(
                "No world has \"{}\" in its name. Run `explore` without --only to see them all.",
                self.only
            );
            return ExitCode::from(2);
        }
        super::code(self.explore(chosen))
    }

    fn explore(&self, worlds: Vec<World>) -> std::io::Result<bool> {
        let mut record = super::begin(&self.shard, &[])?;
        let (mut pairs, mut complete) = (0, 0);
        for world in self.shard.shard.part(worlds) {
            let all = self.explore_one(&world, &mut record);
            let pair = !self.excluded && pairs::is_pair(&world);
            pairs += usize::from(pair);
            complete += usize::from(pair && all);
        }
        if pairs > 0 {
            println!(
                "pairs of faults: {complete} of {pairs} hold in all states; excluded by A-06 and A-07: {}",
                pairs::exclusions()
            );
        }
        super::finish(record)
    }

    /// Returns whether the world holds in all its states.
    fn explore_one(&self, world: &World, record: &mut ShardRecord) -> bool {
        let begin = Instant::now();
        let explored = if self.second {
            world.explore_with::<SecondController>(self.states)
        } else {
            world.explore(self.states)
        };
        let (states, steps, depth) = (explored.states, explored.steps, explored.depth);
        let part = if explored.complete { "all" } else { "not all" };
        let found = format!("{states} states ({part}), {steps} steps, depth {depth}");
        println!("{}: {found}, {:.1} s", world.name, begin.elapsed().as_secs_f64());
        let all = explored.violation.is_none() && explored.complete;
        let holds = all || (self.partial && explored.violation.is_none());
        let detail = match explored.violation {
            Some(sequence) => {
                println!("{sequence:#?}");
                format!("{found}, violated after: {}", sequence.join(" → "))
            }
            None => found,
        };
        let outcome = if holds { ItemOutcome::Held } else { ItemOutcome::Failed };
        let again = format!(
            "explore{}{}{} --states {} --only '{}'",
            if self.second { " --second" } else { "" },
            if self.excluded { " --excluded" } else { "" },
            if self.partial { " --partial" } else { "" },
            self.states,
            world.name
        );
        record.row(outcome, world.name, &detail, &again);
        record.total("worlds", 1);
        for (name, count) in [("states", states), ("steps", steps)] {
            record.total(name, u64::try_from(count).unwrap_or(u64::MAX));
        }
        all
    }
}
