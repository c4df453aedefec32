//! The assurance table: runs the engines, and writes what is proved, what is tested and what is not.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use keepout_planner::plan_file::write_whole;

use crate::property::{Outcome, Property};
use crate::smt::results::{self, Row};
use crate::{mutants, properties, worlds};

/// Checks that are not lists of drawn inputs: what they say, of which code, where they are.
const BESIDE: [(&str, &str, &str); 8] = [
    (
        "predicates at product width on every small case, against the definitions",
        "exact/predicate.rs",
        "tests/exhaustive.rs",
    ),
    (
        "predicates, rings and sides, with thresholds at and beside the exact distance; `robust` agrees",
        "exact/",
        "tests/random.rs",
    ),
    (
        "degenerate families of edges: index, cells, near list, clearance against all edges",
        "index/",
        "tests/soak.rs, `keepout-proofs soak`",
    ),
    ("a million edges in a millimetre", "index/", "tests/soak.rs"),
    (
        "curves of all degrees beside chains of lines and arcs, both ways, at 400 places",
        "exact/bezier.rs",
        "tests/bezier.rs",
    ),
    (
        "disturbed cells are refused or harmless; every walk over a small field ends with the right answer",
        "index/cells.rs",
        "tests/checkers.rs",
    ),
    ("no order of execution of admitted lines comes near the part", "guard/", "executor: guard/tests.rs"),
    (
        "months of hostile operation; each part of the guard taken out is noticed",
        "executor/",
        "tests/: bin hostile",
    ),
];

/// Runs all but the solvers and writes the page; `theorems` is what `prove --results` wrote. Answers whether everything holds.
///
/// # Errors
/// When a file can not be read or written.
pub fn write(page: &Path, theorems: &Path) -> io::Result<bool> {
    let solved_by = results::read(theorems).map_err(|error| {
        io::Error::other(format!("{}: {error}. Make it with `prove --results {0}`.", theorems.display()))
    })?;
    let mut text = include_str!("page.md").to_string();
    let mut failed = Vec::new();
    let mut fill = |text: &mut String| -> Result<(), std::fmt::Error> {
        properties_of(text, &mut failed)?;
        solved(text, &solved_by, &mut failed)?;
        explored(text, &mut failed)?;
        mutated(text)?;
        writeln!(text, "\n## Beside these\n\n| what | of | where |\n|---|---|---|")?;
        BESIDE.iter().try_for_each(|(what, of, place)| writeln!(text, "| {what} | {of} | {place} |"))
    };
    fill(&mut text).map_err(io::Error::other)?;
    write_whole(page, text.as_bytes())?;
    for name in &failed {
        println!("does not hold: {name}");
    }
    Ok(failed.is_empty())
}

fn told(outcome: Option<&Outcome>, of: &str) -> String {
    match outcome {
        None => "–".into(),
        Some(Outcome { failure: Some(_), .. }) => format!("{of}: **fails**"),
        Some(Outcome { cases, time, .. }) => {
            format!("{of}: {} in {:.1} s", grouped(*cases), time.as_secs_f64())
        }
    }
}

/// Digits in threes.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

fn properties_of(text: &mut String, failed: &mut Vec<String>) -> std::fmt::Result {
    let all = properties::all();
    let harnesses = all.iter().filter(|property| property.kani.is_some()).count();
    writeln!(
        text,
        "## Properties\n\n{} properties, {harnesses} of them with a Kani harness (**not run here**). *Every* is every case of a lattice \
         of so many units each way; *random* is over the full range of 2^29 units, from a fixed seed; *Kani* says within how many \
         units of the origin all cases would be looked at, and how far loops are unwound. All hold on the machine on which this was \
         written, in the given time.",
        all.len()
    )?;
    let mut group = "";
    for property in all {
        if property.group != group {
            group = property.group;
            writeln!(
                text,
                "\n### {group}: `{}`\n\n| property | says | every | random | Kani harness |\n|---|---|---|---|---|",
                property.source
            )?;
        }
        let every = property.observed(Property::run_every);
        let random = property.observed(Property::run_random);
        if [&every, &random].into_iter().flatten().any(|outcome| outcome.failure.is_some()) {
            failed.push(property.name.into());
        }
        let side = property.every.map_or(String::new(), |(side, _)| format!("{} × {}", side + 1, side + 1));
        let kani = property
            .kani
            .map_or("–".into(), |kani| format!("±{}, unwind {}, {}", kani.half, kani.unwind, kani.solver));
        let (every, random) = (told(every.as_ref(), &side), told(random.as_ref(), "all of the lattice"));
        writeln!(text, "| `{}` | {} | {every} | {random} | {kani} |", property.name, property.claim)?;
    }
    Ok(())
}

/// What the solvers said.
fn solved(text: &mut String, rows: &[Row], failed: &mut Vec<String>) -> std::fmt::Result {
    let (solver, second) = rows.first().map_or(("no solver", ""), |row| (&row.solver, &row.second));
    writeln!(
        text,
        "\n## Theorems over all numbers\n\n{} theorems about the shipped functions, run on symbolic numbers path by path; every question \
         that this raises was refuted by {solver}. Asked beside it: {second}, which may leave a question undecided, and contradicted \
         nothing. Coordinates are whole numbers up to ±2^29, lengths up to 2^29, unless the theorem says that it needs less: the width \
         that ships.\n\n| theorem | says | of | rests on | paths | questions, time | second: agreed, undecided | result |\n\
         |---|---|---|---|---|---|---|---|",
        rows.len(),
    )?;
    for row in rows {
        let proved = row.result == "proved";
        if !proved {
            failed.push(row.theorem.clone());
        }
        writeln!(
            text,
            "| `{}` | {} | `{}` | {} | {} | {}, {:.1} s | {}, {} | {} |",
            row.theorem,
            row.claim.replace('|', "\\|"),
            row.source,
            row.rests_on,
            row.paths,
            row.queries,
            row.seconds,
            row.agreed,
            row.undecided,
            if proved { "proved" } else { "**does not hold**" },
        )?;
    }
    Ok(())
}

fn explored(text: &mut String, failed: &mut Vec<String>) -> std::fmt::Result {
    writeln!(
        text,
        "\n## The invariant\n\n*In every reachable state, every point where the tool can be lies in a certified set, whatever is delayed, \
         lost, repeated or cancelled.* The guard is the one that ships, the controller is the model in `src/controller.rs`. Every state was \
         looked at once, from the shortest way on; bounds are motions, queries, cancels, and halves of 500 ms.\n\n\
         | world | bounds | faults | states | steps | longest | outcome |\n|---|---|---|---|---|---|---|"
    )?;
    for world in worlds::all() {
        let seen = world.explore(worlds::STATES);
        let outcome = match (&seen.violation, seen.complete) {
            (Some(_), _) => "**does not hold**",
            (None, true) => "holds in all",
            (None, false) => "holds in these; there are more",
        };
        if seen.violation.is_some() {
            failed.push(world.name.into());
        }
        let [motions, queries, cancels, halves] = world.budget;
        let trouble = world.trouble;
        let counted = [
            (trouble.lost, "lost"),
            (trouble.doubled, "doubled"),
            (trouble.swapped, "swapped"),
            (trouble.lies, "old report"),
            (trouble.refused, "refused"),
            (trouble.resets, "reset"),
            (world.holds, "times told to hold or go on"),
            (trouble.resets_held, "reset while held"),
            (trouble.jumps, "clock jump"),
        ];
        let faults: Vec<String> = counted
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        let faults =
            if faults.is_empty() { "delays".into() } else { format!("delays, {}", faults.join(", ")) };
        let (states, steps) = (grouped(seen.states as u64), grouped(seen.steps as u64));
        writeln!(
            text,
            "| {} | {motions}, {queries}, {cancels}, {halves} | {faults} | {states} | {steps} | {} | {outcome} |",
            world.name, seen.depth
        )?;
    }
    Ok(())
}

fn mutated(text: &mut String) -> std::fmt::Result {
    let results = mutants::results();
    let count = |fate: &str| results.iter().filter(|result| result.fate == fate).count();
    let list = mutants::list().unwrap_or_default();
    writeln!(
        text,
        "\n## Faults put in\n\nEach line of `mutants.toml` puts one fault into the trusted core; a property must fail. {} in the list: {} killed, \
         {} survived, {} equivalent, {} not decided in ten minutes, {} not run.\n\n| fault | file | outcome | by |\n|---|---|---|---|",
        list.len(),
        count("killed"),
        count("survived"),
        count("equivalent"),
        count("not decided"),
        list.len()
            - results.iter().filter(|result| list.iter().any(|mutant| mutant.what == result.what)).count(),
    )?;
    for mutant in &list {
        let result = results.iter().find(|result| result.what == mutant.what);
        let (fate, by) = result.map_or(("not run", ""), |result| (&result.fate, &result.by));
        let by = mutant.equivalent.as_deref().filter(|_| fate == "equivalent").unwrap_or(by);
        writeln!(text, "| {} | `{}` | {fate} | {by} |", mutant.what, mutant.file.display())?;
    }
    Ok(())
}
