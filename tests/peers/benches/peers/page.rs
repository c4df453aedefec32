//! The results page `docs/contributor/performance.md` and its pictures.

use std::fmt::Write as _;
use std::path::Path;

use keepout_planner::report::table::markdown;

use crate::builds::Built;
use crate::growth::growth;
use crate::offsets::Offsets;
use crate::paths::PathKind;
use crate::profiles::ProfileFamily;
use crate::queries::{self, QueryKind};
use crate::timing::Timed;

/// All measurements.
pub struct Measured {
    pub queries: Vec<queries::Result>,
    pub builds: Vec<Built>,
    pub memory: Vec<(String, f64)>,
    pub memory_edges: usize,
    pub offsets: Vec<Offsets>,
}

/// Names of the kernel's own entries.
const OURS: [&str; 10] = [
    "cells",
    "index alone",
    "index, hint",
    "mesh",
    "mesh, refined",
    "swept triangle",
    "its motion alone",
    "index, checked",
    "cells, proposed and checked",
    "rings found simple",
];

/// Whether a name is of ours.
pub fn is_ours(name: &str) -> bool {
    OURS.contains(&name) || name.starts_with("keepout")
}

/// Writes the page and its pictures below `docs`.
pub fn write(docs: &Path, measured: &Measured) -> std::io::Result<()> {
    std::fs::create_dir_all(docs.join("performance"))?;
    let mut page = String::from(INTRODUCTION);
    for question in QueryKind::ALL {
        section(&mut page, question, measured);
    }
    mesh_section(&mut page, measured);
    growth_section(&mut page);
    builds_section(&mut page, measured);
    offsets_section(&mut page, measured);
    whole(&docs.join("performance.md"), &page)?;
    for (family, motion) in
        [(ProfileFamily::Studs, PathKind::Contact), (ProfileFamily::Studs, PathKind::Approach)]
    {
        let name = format!("growth-{}.svg", motion.name());
        whole(&docs.join("performance").join(name), &growth(measured, QueryKind::Point, family, motion))?;
    }
    for family in ProfileFamily::ALL {
        let name = format!("nearest-{}.svg", family.name());
        whole(
            &docs.join("performance").join(name),
            &growth(measured, QueryKind::Nearest, family, PathKind::Approach),
        )?;
    }
    Ok(())
}

fn whole(path: &Path, text: &str) -> std::io::Result<()> {
    let part = path.with_extension("part");
    std::fs::write(&part, text)?;
    std::fs::rename(part, path)
}

const INTRODUCTION: &str = "# Performance

Written by `cargo bench -p keepout-peers --bench peers -- --write`. Do not edit it by hand.

The peers take turns in the same process on the same data. A value is the median over the rounds, in ns per
query unless another unit is given. Machines differ and are noisy, so read the ratios. Our answers are exact,
those of the peers are floating point. *wrong* counts answers that differ from the exact one.

| profile | description |
|---|---|
| star | a radial random polygon in 400 × 350 mm; its triangles are needles |
| maze | a band that winds through 400 × 350 mm in rows |
| studs | eight-sided studs of 4 mm at a constant distance; the field grows with their number |

| path | description |
|---|---|
| approach | along the wall, between the threshold and 4 mm more, in steps of 50 µm |
| contact | within 20 µm of the threshold, in steps of 50 µm |
| random | anywhere in the field, motions of any length |

The tool radius is 3 mm and the margin 50 µm.

- *cells* answer from the squares that are certified for the threshold.
- *index alone* is the checked bounding-box index. Safety depends on it, and it answers any threshold.
- *goal* is a ratio: the time of the fastest peer divided by ours.

";

fn goal(question: QueryKind, motion: PathKind, edges: usize) -> Option<f64> {
    match (question, motion) {
        (QueryKind::Point, PathKind::Approach) => Some(5.0),
        (QueryKind::Point, PathKind::Contact) => Some(3.0),
        (QueryKind::Point, PathKind::Random) => Some(1.0),
        (QueryKind::Motion | QueryKind::Clip, _) if edges >= 900 => Some(4.0),
        (QueryKind::Nearest, PathKind::Random) => Some(2.0),
        (QueryKind::Nearest, _) => Some(3.0),
        _ => None,
    }
}

fn fastest(timed: &[Timed], ours: bool) -> Option<&Timed> {
    let chosen = timed.iter().filter(|each| is_ours(each.name) == ours);
    chosen.min_by(|a, b| a.ns.total_cmp(&b.ns))
}

/// The names in the order of their first appearance.
pub fn distinct<'a>(timed: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names = Vec::new();
    timed.for_each(|name| {
        if !names.contains(&name) {
            names.push(name);
        }
    });
    names
}

fn section(page: &mut String, question: QueryKind, measured: &Measured) {
    let _ = writeln!(page, "## {}\n", question.name());
    let asked = measured.queries.iter().filter(|result| result.question == question);
    let names = distinct(asked.flat_map(|result| &result.timed).map(|each| each.name));
    let head = [&["profile", "edges", "path"], &names[..], &["ratio", "goal"]].concat();
    let mut table = vec![head.into_iter().map(String::from).collect()];
    let mut missed = Vec::new();
    for result in measured.queries.iter().filter(|result| result.question == question) {
        let cell = |name: &&str| {
            let found = result.timed.iter().find(|each| each.name == *name);
            found.map_or("–".into(), |each| match each.wrong {
                Some(wrong) if wrong > 0 => format!("{:.0} ({wrong} wrong)", each.ns),
                _ => format!("{:.0}", each.ns),
            })
        };
        let ratio = match (fastest(&result.timed, true), fastest(&result.timed, false)) {
            (Some(ours), Some(peer)) => Some(peer.ns / ours.ns),
            _ => None,
        };
        let goal = goal(question, result.motion, result.edges);
        let met = match (ratio, goal) {
            (Some(ratio), Some(goal)) if ratio >= goal => format!("{goal} met"),
            (Some(ratio), Some(goal)) => {
                let place = format!("{} {} {}", result.family.name(), result.edges, result.motion.name());
                missed.push(format!("{place} ({ratio:.1} of {goal})"));
                format!("{goal} missed")
            }
            _ => "–".into(),
        };
        let ratio = ratio.map_or("–".into(), |ratio| format!("{ratio:.1}"));
        let place = [result.family.name().into(), result.edges.to_string(), result.motion.name().into()];
        table.push(place.into_iter().chain(names.iter().map(cell)).chain([ratio, met]).collect());
    }
    let _ = writeln!(page, "{}", markdown(&table));
    if question == QueryKind::Clip {
        casts(page, measured);
    }
    if !missed.is_empty() {
        let _ = writeln!(page, "Missed: {}.\n\n{}\n", missed.join("; "), why(question));
    }
}

/// Reasons for the missed goals of a query.
fn why(question: QueryKind) -> &'static str {
    match question {
        QueryKind::Point => {
            "Reason: in open space every index answers from its topmost boxes, the fastest in about\n\
             15 ns. A field of 10⁵ studs has more wall than the budget of the squares covers, so the index\n\
             answers for the undecided squares."
        }
        QueryKind::Motion => {
            "Reason: a motion needs four exact point–segment tests and one crossing test for each listed\n\
             edge. `static_aabb2d_index`, with our own floating-point test, stops at its boxes. The peers\n\
             have no such test of their own. Their shape casts are below."
        }
        QueryKind::Clip => {
            "Reason: long random motions walk through many squares one by one. Where squares are undecided,\n\
             they search the index in its own order, not from front to back."
        }
        QueryKind::Nearest => {
            "Reason: both sides use floating point. Our boxes over consecutive edges take a tenth of the\n\
             time to build and a third of the memory, but overlap more than the boxes of bvh, which it\n\
             chooses by surface area."
        }
        QueryKind::SweptTriangle => "",
    }
}

/// Ratios of the f64 cast of parry2d to ours, from 10³ edges up. The goal is 25.
fn casts(page: &mut String, measured: &Measured) {
    let mut ratios = Vec::new();
    for result in &measured.queries {
        let of = |name: &str| result.timed.iter().find(|each| each.name == name).map(|each| each.ns);
        if let (QueryKind::Clip, Some(ours), Some(cast)) =
            (result.question, of("cells"), of("parry2d f64 cast"))
            && result.edges >= 900
        {
            let place = format!("{} {} {}", result.family.name(), result.edges, result.motion.name());
            ratios.push(format!("{place} {:.0}", cast / ours));
        }
    }
    let _ = writeln!(
        page,
        "Ratio of the `f64` shape cast to ours (goal 25 from 10³ edges up): {}.\n",
        ratios.join("; ")
    );
}

fn mesh_section(page: &mut String, measured: &Measured) {
    page.push_str("## Nearest by mesh or index\n\nThe curves for the approach path (star, maze, studs):\n\n");
    for family in ProfileFamily::ALL {
        let _ = writeln!(page, "![nearest, {0}](performance/nearest-{0}.svg)\n", family.name());
    }
    let mut wins = std::collections::BTreeMap::<&str, usize>::new();
    for result in measured.queries.iter().filter(|result| result.question == QueryKind::Nearest) {
        if let Some(best) = fastest(&result.timed, true) {
            *wins.entry(best.name).or_default() += 1;
        }
    }
    let wins: Vec<String> = wins.iter().map(|(name, wins)| format!("{name} {wins}")).collect();
    let _ =
        writeln!(page, "Number of rows above in which each of ours is the fastest: {}.\n", wins.join(", "));
}

fn growth_section(page: &mut String) {
    page.push_str(
        "## Growth at fixed local density\n\n\
         clear(point) over the studs. Their field grows with their number:\n\n\
         ![approach](performance/growth-approach.svg)\n\n![contact](performance/growth-contact.svg)\n\n",
    );
}

fn builds_section(page: &mut String, measured: &Measured) {
    page.push_str("## Building, ms\n\n");
    let names = distinct(measured.builds.iter().flat_map(|built| &built.ms).map(|(name, _)| *name));
    let head = [&["profile", "edges"], &names[..]].concat();
    let mut table = vec![head.into_iter().map(String::from).collect()];
    for built in &measured.builds {
        let cell = |name: &&str| {
            let found = built.ms.iter().find(|(other, _)| other == name);
            found.map_or(
                "–".into(),
                |(_, ms)| if *ms < 10.0 { format!("{ms:.3}") } else { format!("{ms:.0}") },
            )
        };
        let place = [built.family.name().into(), built.edges.to_string()];
        table.push(place.into_iter().chain(names.iter().map(cell)).collect());
    }
    let _ = writeln!(page, "{}", markdown(&table));
    for built in &measured.builds {
        let notes: Vec<String> =
            built.notes.iter().map(|(what, value)| format!("{what} {value:.0}")).collect();
        let _ = writeln!(page, "- {} {}: {}", built.family.name(), built.edges, notes.join(", "));
    }
    if !measured.memory.is_empty() {
        let _ = writeln!(
            page,
            "\nResident memory that an index adds to its own process, with the segments, for a maze of\n\
             {} edges, MB: {}.",
            measured.memory_edges,
            measured
                .memory
                .iter()
                .map(|(name, bytes)| format!("{name} {:.1}", bytes / 1e6))
                .collect::<Vec<_>>()
                .join(", ")
        );
    }
    page.push('\n');
}

fn offsets_section(page: &mut String, measured: &Measured) {
    page.push_str(
        "## Offset by 3.05 mm, ms\n\n\
         - *ms* of ours is the time to propose and certify the offset.\n\
         - *certificate* is the time of this certificate, plus the time of the second certificate, which\n  \
         proves that no piece is missing. *ms* does not include the second certificate.\n\
         - Our offset is 0.6 µm larger, as in the planner.\n\
         - The peers have no certificate. Those without arcs may flatten by 1 µm.\n\
         - *least* is the smallest distance found between result and profile, mm.\n\
         - geo-buf, a mitre offsetter, is missing. It can not be linked together with the current geo.\n\n\
         | profile | edges | side | offsetter | ms | certificate | loops | pieces | least | ratio |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for each in &measured.offsets {
        let side = if each.outside { "outside" } else { "inside" };
        let ours = each.runs.first().map_or(f64::NAN, |run| run.ms);
        for (i, run) in each.runs.iter().enumerate() {
            let certificate = if i == 0 {
                format!("{:.3} + {:.3}, {} rejected", each.certificate_ms, each.complete_ms, each.refused)
            } else {
                "–".into()
            };
            let ratio = if i == 0 { "–".into() } else { format!("{:.1}", run.ms / ours) };
            let least = if run.least_mm.is_finite() { format!("{:.4}", run.least_mm) } else { "–".into() };
            let _ = writeln!(
                page,
                "| {} | {} | {side} | {} | {:.3} | {certificate} | {} | {} | {least} | {ratio} |",
                each.family.name(),
                each.edges,
                run.name,
                run.ms,
                run.loops,
                run.pieces
            );
        }
    }
    page.push_str(
        "\nCavalier is faster below about 10³ edges. Ours evaluates sines and arctangents without the\n\
         standard library, and rounds and checks every arc on the lattice. The second certificate searches the\n\
         nearest edge along every offset shape, and takes more time than all other steps.\n",
    );
}
