//! The assurance table: it runs the engines, and lists proofs, tests and gaps.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use keepout_planner::file::write_whole;

use crate::carried::{self, Carrier};
use crate::faults::results::FaultFate;
use crate::faults::{self, FaultEngine, SeededFault};
use crate::property::{Property, PropertyOutcome, Ran};
use crate::smt::results::{self, TheoremRow};
use crate::{model_check, properties, worlds};

/// Checks without drawn inputs: the check, the code, and where the check is.
const BESIDE: [(&str, &str, &str); 8] = [
    (
        "predicates at product width on every small case, against the definitions",
        "exact/predicate.rs",
        "tests/exhaustive.rs",
    ),
    (
        "predicates, rings and sides, with thresholds at and near the exact distance; the crate `robust` \
         agrees",
        "exact/",
        "tests/random.rs",
    ),
    (
        "degenerate families of edges: index, cells, clearance against all edges",
        "index/",
        "tests/soak.rs, `keepout-proofs soak`",
    ),
    ("a million edges in a millimetre", "index/", "tests/soak.rs"),
    (
        "curves of degree 1 to 6 against chains of lines and arcs, both ways, at 400 points",
        "exact/bezier.rs",
        "tests/bezier.rs",
    ),
    (
        "modified cells are refused or harmless; every walk over a small field ends with the right answer",
        "index/cells.rs",
        "tests/checkers.rs",
    ),
    (
        "admitted lines keep away from the part in every order of execution",
        "guard/",
        "executor/guard/src/tests.rs",
    ),
    (
        "months of simulated hostile operation; the run detects seeded faults of the guard",
        "executor/",
        "tests/src/bin/hostile/",
    ),
];

/// Runs all engines except the solvers, and writes the page. `theorems` is the file that `prove --results`
/// wrote. Returns whether everything holds.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write(page: &Path, theorems: &Path) -> io::Result<bool> {
    let solved_by = results::read(theorems).map_err(|error| {
        io::Error::other(format!("{}: {error}. Make it with `prove --results {0}`.", theorems.display()))
    })?;
    let mut text = include_str!("page.md").to_string();
    let mut failed = Vec::new();
    let mut fill = |text: &mut String| -> Result<(), std::fmt::Error> {
        properties_of(text, &mut failed)?;
        solved(text, &solved_by, &mut failed)?;
        model_checked(text)?;
        explored(text, &mut failed)?;
        seeded(text)?;
        writeln!(text, "\n## Other checks\n\n| check | code | where |\n|---|---|---|")?;
        BESIDE.iter().try_for_each(|(check, code, place)| writeln!(text, "| {check} | {code} | {place} |"))
    };
    fill(&mut text).map_err(io::Error::other)?;
    write_whole(page, text.as_bytes())?;
    for name in &failed {
        println!("does not hold: {name}");
    }
    Ok(failed.is_empty())
}

fn outcome_cell(outcome: Option<&PropertyOutcome>, of: impl Fn(i64) -> String) -> String {
    match outcome {
        None => "–".into(),
        Some(PropertyOutcome { ran: None, .. }) => "**fails**".into(),
        Some(PropertyOutcome { ran: Some(Ran { cases, asked, reach }), time }) => {
            let asked =
                if asked < cases { format!(", premise met in {}", grouped(*asked)) } else { String::new() };
            format!("{}: {}{asked}, {:.1} s", of(*reach), grouped(*cases), time.as_secs_f64())
        }
    }
}

/// A magnitude, as a power of two when it is large.
fn magnitude(reach: i64) -> String {
    let bits = i64::BITS - (reach - 1).leading_zeros();
    if reach < 1 << 12 { format!("±{reach}") } else { format!("±2^{bits}") }
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
    writeln!(
        text,
        "## Properties\n\n{} properties.\n\n\
         - *Every*: every case whose points lie on a lattice of n × n points. Predicates run at narrow width.\n\
         - *Random*: cases from a fixed seed, at the width that ships. ± is the largest magnitude drawn; 2^29 is the \
         whole lattice.\n\
         - *Premise met in*: the cases that meet the property's premise. The other cases prove nothing.\n\
         - *Carried by*: the engine that answers the same question for the most inputs, and why that one. The \
         solver answers for all numbers, the model checker for every input within its bounds, and exploration for \
         every order of messages within its bounds. Where theorems run none of the code, or a small part, they \
         prove the reason, and random cases carry the property. `src/carried.rs` has the list.\n\n\
         All properties hold on the machine that wrote this page, in the stated time.",
        all.len()
    )?;
    let mut group = "";
    for property in all {
        if property.group != group {
            group = property.group;
            writeln!(
                text,
                "\n### {group}: `{}`\n\n| property | claim | every | random | carried by |\n|---|---|---|---|---|",
                property.source
            )?;
        }
        let every = property.observed(Property::run_every);
        let random = property.observed(Property::run_random);
        if [&every, &random].into_iter().flatten().any(|outcome| outcome.ran.is_none()) {
            failed.push(property.name.into());
        }
        let every = outcome_cell(every.as_ref(), |side| format!("{0} × {0}", side + 1));
        let random = outcome_cell(random.as_ref(), magnitude);
        let carrier = carried::by(property.name).map_or_else(String::new, Carrier::text);
        writeln!(text, "| `{}` | {} | {every} | {random} | {carrier} |", property.name, property.claim)?;
    }
    Ok(())
}

/// The answers of the bounded model checker.
fn model_checked(text: &mut String) -> std::fmt::Result {
    let (versions, rows) = model_check::results::read();
    let harnesses = keepout_harnesses::all();
    writeln!(
        text,
        "\n## Bounded model checking\n\n`keepout-proofs model-check` compiles {} harnesses to WebAssembly, with \
         overflow checks, translates them to C, and gives each to CBMC ({versions}). The answer covers all inputs \
         within the bounds at once. *Unwind* is the number of rounds of each loop; CBMC shows that no loop needs \
         more. Before each run CBMC must refute {} false statements.\n\n\
         | harness | claim | code | bounds | unwind | time |\n|---|---|---|---|---|---|",
        harnesses.len(),
        keepout_harnesses::canaries().len(),
    )?;
    for harness in harnesses {
        let Some(row) = rows.iter().find(|row| row.name == harness.name) else { continue };
        writeln!(
            text,
            "| `{}` | {} | `{}` | {} | {} | {:.1} s |",
            harness.name, harness.claim, harness.file, harness.bounds, harness.unwind, row.seconds,
        )?;
    }
    Ok(())
}

/// The solvers' results.
fn solved(text: &mut String, rows: &[TheoremRow], failed: &mut Vec<String>) -> std::fmt::Result {
    let (solver, second) = rows.first().map_or(("no solver", ""), |row| (&row.solver, &row.second));
    let (run, plane): (Vec<&TheoremRow>, Vec<&TheoremRow>) = rows.iter().partition(|row| row.paths > 0);
    writeln!(
        text,
        "\n## Theorems over all numbers\n\n{} theorems. {solver} gave the expected answer to every question: \
         it refuted the negation, or it showed that a condition is possible. The second solver is {second}. \
         It may leave a question undecided, and it contradicted no answer.\n\n\
         Every variable is any real number, and the points of the lattice are among them. Only \
         `no_overflow` is about whole numbers within bounds: coordinates up to ±2^29 and lengths up to \
         2^29, the width that ships.",
        rows.len(),
    )?;
    writeln!(
        text,
        "\n### Theorems about the code\n\n{} theorems run the function that ships on symbolic numbers, path \
         by path. They hold for every path of the function.\n\n\
         | theorem | claim | code | rests on | paths | questions, time | second: agreed, undecided | result |\n\
         |---|---|---|---|---|---|---|---|",
        run.len(),
    )?;
    let mut line = |text: &mut String, row: &TheoremRow, place: &str, more: &str| {
        let proved = row.result == "proved";
        if !proved {
            failed.push(row.theorem.clone());
        }
        let result = if proved { "proved" } else { "**does not hold**" };
        writeln!(
            text,
            "| `{}` | {} | {place} | {}{more} | {}, {:.1} s | {}, {} | {result} |",
            row.theorem,
            row.claim.replace('|', "\\|"),
            row.rests_on,
            row.queries,
            row.seconds,
            row.agreed,
            row.undecided,
        )
    };
    for row in run {
        line(text, row, &format!("`{}`", row.source), &format!(" | {}", row.paths))?;
    }
    writeln!(
        text,
        "\n### Theorems about the plane\n\n{} theorems are geometry. They give the reasons for the code, and \
         do not run it. The column *used by* names the theorems that rest on them, or the properties that \
         they carry.\n\n\
         | theorem | claim | used by | rests on | questions, time | second: agreed, undecided | result |\n\
         |---|---|---|---|---|---|---|",
        plane.len(),
    )?;
    for row in plane {
        line(text, row, &used_by(&row.theorem, rows).join(", "), "")?;
    }
    Ok(())
}

/// The theorems that rest on this one, and the properties that it carries.
#[must_use]
pub fn used_by(theorem: &str, rows: &[TheoremRow]) -> Vec<String> {
    let rests = |row: &&TheoremRow| row.rests_on.split(", ").any(|other| other == theorem);
    let carried = carried::CARRIED.iter().filter(|(_, carrier)| carrier.has_theorem(theorem));
    let above = rows.iter().filter(rests).map(|row| format!("`{}`", row.theorem));
    above.chain(carried.map(|(property, _)| format!("property `{property}`"))).collect()
}

fn explored(text: &mut String, failed: &mut Vec<String>) -> std::fmt::Result {
    writeln!(
        text,
        "\n## The invariant\n\n*In every reachable state, every point where the tool can be lies in a \
         certified set, whatever is delayed, lost, repeated or cancelled.* The guard is the one that ships. \
         The controller is the model in `src/controller.rs`. The exploration visited every state once, by a \
         shortest sequence of steps. The bounds are the numbers of motions, queries, cancels, and halves of \
         500 ms.\n\n\
         | world | bounds | faults | states | steps | longest | outcome |\n|---|---|---|---|---|---|---|"
    )?;
    for world in worlds::all() {
        let seen = world.explore(worlds::STATES);
        let outcome = match (&seen.violation, seen.complete) {
            (Some(_), _) => "**does not hold**",
            (None, true) => "holds in all states",
            (None, false) => "holds in these states; there are more",
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
            (trouble.holds, "held by somebody"),
            (trouble.jumps, "clock jump"),
        ];
        let faults: Vec<String> = counted
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, fault)| format!("{count} {fault}"))
            .collect();
        let faults =
            if faults.is_empty() { "delays".into() } else { format!("delays, {}", faults.join(", ")) };
        let (states, steps) = (grouped(seen.states as u64), grouped(seen.steps as u64));
        writeln!(
            text,
            "| {} | {motions}, {queries}, {cancels}, {halves} | {faults} | {states} | {steps} | {} | \
             {outcome} |",
            world.name, seen.depth
        )?;
    }
    writeln!(
        text,
        "\nThe worlds named \"pair\" combine each kind of fault with each other kind, except these, \
         which the assumptions A-06 and A-07 exclude: {}. A test shows that these defeat the evidence.",
        worlds::pairs::exclusions()
    )
}

fn seeded(text: &mut String) -> std::fmt::Result {
    let rows = faults::results::read();
    let catalogue = faults::catalogue().unwrap_or_default();
    let fate = |fault: &SeededFault, engine: FaultEngine| {
        faults::results::row(&rows, fault, engine).map_or("not run".into(), |row| row.fate.to_string())
    };
    let of = |wanted: FaultEngine| catalogue.iter().filter(move |fault| fault.engines().contains(&wanted));
    let count = |begin: &str| {
        of(FaultEngine::Proofs).filter(|f| fate(f, FaultEngine::Proofs).starts_with(begin)).count()
    };
    let equivalent = FaultFate::Equivalent.to_string();
    writeln!(
        text,
        "\n## Seeded faults\n\nThe catalogue `faults.toml` has {} faults. Each goes into a copy of the \
         tree, and somebody must notice it. {} are for the properties, soaks and worlds: {} were noticed, {} \
         survived, {} are equivalent, {} were not decided in ten minutes, {} were not run. {} of these must be \
         noticed by the hostile simulation, too. {} are for ordinary tests. {} more are for the fuzz targets (`cargo \
         run -p keepout-fuzz --example seeded`), and are not listed here.\n\n\
         | fault | file | properties, worlds and tests | solver | model checker | hostile simulation |\n\
         |---|---|---|---|---|---|",
        catalogue.len(),
        of(FaultEngine::Proofs).count(),
        count("noticed"),
        count("survived"),
        count(&equivalent),
        count("undecided"),
        count("not run"),
        of(FaultEngine::Hostile).count(),
        of(FaultEngine::Tests).count(),
        of(FaultEngine::Fuzz).count(),
    )?;
    for fault in catalogue.iter().filter(|fault| !fault.engines().contains(&FaultEngine::Fuzz)) {
        let tested = fault.engines().contains(&FaultEngine::Tests);
        let proofs = fate(fault, if tested { FaultEngine::Tests } else { FaultEngine::Proofs });
        let why = fault.equivalent.as_deref().filter(|_| proofs == equivalent);
        let proofs = why.map_or(proofs.clone(), |why| format!("{proofs}: {why}"));
        let asked =
            |engine| if fault.engines().contains(&engine) { fate(fault, engine) } else { "–".into() };
        let [solver, model, hostile] =
            [FaultEngine::Theorem, FaultEngine::Model, FaultEngine::Hostile].map(asked);
        let files: Vec<String> = fault.edits().map(|edit| format!("`{}`", edit.file.display())).collect();
        writeln!(text, "| {} | {} | {proofs} | {solver} | {model} | {hostile} |", fault.name, files[0])?;
    }
    Ok(())
}
