//! The pages `docs/safety/trace.md` and `docs/safety/change-impact.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Result, Write as _};
use std::path::PathBuf;

use super::{EvidenceKind, Mechanism, SafetyTrace, TracedEvidence, TracedFault};

const KINDS: [EvidenceKind; 8] = [
    EvidenceKind::Theorem,
    EvidenceKind::Property,
    EvidenceKind::Soak,
    EvidenceKind::Harness,
    EvidenceKind::World,
    EvidenceKind::Test,
    EvidenceKind::Fuzz,
    EvidenceKind::Hostile,
];

/// The pages: file name and text.
///
/// # Errors
/// When a text cannot be formatted.
pub fn pages(trace: &SafetyTrace) -> std::result::Result<[(&'static str, String); 2], std::fmt::Error> {
    let (mut of_trace, mut of_impact) = (String::new(), String::new());
    write_trace(&mut of_trace, trace)?;
    write_impact(&mut of_impact, trace)?;
    Ok([("trace.md", of_trace), ("change-impact.md", of_impact)])
}

/// Some names, and the number of the others.
fn some<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let shown = names.iter().take(most).copied().collect::<Vec<_>>().join(", ");
    if names.len() > most { format!("{shown} and {} more", names.len() - most) } else { shown }
}

fn write_trace(text: &mut String, trace: &SafetyTrace) -> Result {
    let running = trace.evidence.iter().filter(|each| each.runs_code).count();
    writeln!(
        text,
        "# The trace\n\n`cargo run --release -p keepout-proofs -- trace` writes this page from the comments of \
         the code, from\n[hazards](hazards.md), [requirements](requirements.md) and [assumptions](assumptions.md), \
         and from the results of the\nseeded faults. CI fails when a requirement has no running evidence, when \
         evidence belongs to no requirement, when\nnobody notices a fault, when no fault can \
         make a test fail, or when a test changed since it \
         noticed one\n([the evidence](evidence.md#proofs) says what this rests on).\n\n\
         {} requirements, {} pieces of evidence ({running} of them run code of the product), {} seeded faults. In \
         each\nsection, the table of the evidence names the faults that each piece noticed, in a copy of the \
         code.\n\n\
         | requirement | hazards | code | evidence | seeded faults |\n|---|---|---|---|---|",
        trace.statements.requirements.len(),
        trace.evidence.len(),
        trace.faults.len(),
    )?;
    for requirement in &trace.statements.requirements {
        let files: BTreeSet<&PathBuf> = trace.mechanisms_of(&requirement.id).map(|each| &each.file).collect();
        writeln!(
            text,
            "| [{0}](#{1}) {2} | {3} | {4} {5} | {6} | {7} |",
            requirement.id,
            anchor(&requirement.id, &requirement.title),
            requirement.title,
            requirement.hazards.join(", "),
            files.len(),
            if files.len() == 1 { "file" } else { "files" },
            counted(trace.evidence_for(&requirement.id)),
            trace.faults_of(&requirement.id).count(),
        )?;
    }
    for requirement in &trace.statements.requirements {
        let id = &requirement.id;
        writeln!(
            text,
            "\n## {id} {}\n\nHazards: {}. Assumptions: {}.\n",
            requirement.title,
            requirement.hazards.join(", "),
            requirement.assumptions.join(", ")
        )?;
        write_code(text, trace.mechanisms_of(id))?;
        writeln!(text, "\n| evidence | kind | where | seeded faults that it noticed |\n|---|---|---|---|")?;
        for evidence in trace.evidence_for(id) {
            write_evidence(text, trace, evidence)?;
        }
        writeln!(text, "\n| seeded fault | file | noticed by | within |\n|---|---|---|---|")?;
        for fault in trace.faults_of(id) {
            write_fault(text, fault)?;
        }
    }
    Ok(())
}

/// The anchor of a heading, as GitHub builds it.
fn anchor(id: &str, title: &str) -> String {
    let text = format!("{id} {title}").to_lowercase();
    text.chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

/// How many pieces of each kind there are.
fn counted<'a>(evidence: impl Iterator<Item = &'a TracedEvidence>) -> String {
    let mut counts: BTreeMap<EvidenceKind, usize> = BTreeMap::new();
    evidence.for_each(|each| *counts.entry(each.kind).or_default() += 1);
    let words = counts.iter().map(|(kind, count)| match kind {
        EvidenceKind::Hostile => kind.plural().to_string(),
        _ if *count == 1 => format!("1 {}", kind.name()),
        _ => format!("{count} {}", kind.plural()),
    });
    words.collect::<Vec<_>>().join(", ")
}

fn write_code<'a>(text: &mut String, mechanisms: impl Iterator<Item = &'a Mechanism>) -> Result {
    let mut files: BTreeMap<&PathBuf, Vec<&str>> = BTreeMap::new();
    for mechanism in mechanisms {
        files.entry(&mechanism.file).or_default().extend(mechanism.item.as_deref());
    }
    for (file, items) in files {
        let items: Vec<String> = items.iter().map(|item| format!("`{item}`")).collect();
        let items = if items.is_empty() { "the whole file".into() } else { items.join(", ") };
        writeln!(text, "- `{}`: {items}", file.display())?;
    }
    Ok(())
}

fn write_evidence(text: &mut String, trace: &SafetyTrace, evidence: &TracedEvidence) -> Result {
    let noticed = if evidence.runs_code {
        some(trace.noticed_by(evidence).map(|fault| fault.name.as_str()), 2)
    } else {
        "runs no code: the reason for what others test".into()
    };
    writeln!(
        text,
        "| `{}` | {} | `{}` | {} |",
        evidence.name,
        evidence.kind.name(),
        evidence.file.display(),
        noticed.replace('|', "\\|"),
    )
}

fn write_fault(text: &mut String, fault: &TracedFault) -> Result {
    let by = if fault.noticed.is_empty() {
        // A settled fault without a name here was noticed by tests of the code's own files.
        let others = if fault.settled { "unit tests, which carry no requirement" } else { "**nobody**" };
        fault.equivalent.as_ref().map_or(others.into(), |why| format!("nobody can: {why}"))
    } else {
        some(fault.noticed.iter().map(|(_, name)| name.as_str()), 2)
    };
    let seconds = fault.seconds.map_or("–".into(), |seconds| format!("{seconds} s"));
    let file = fault.files.first().cloned().unwrap_or_default();
    writeln!(text, "| {} | `{}` | {by} | {seconds} |", fault.name.replace('|', "\\|"), file.display())
}

/// How many faults a file has, and how many of them each kind of evidence noticed.
fn noticed_in(trace: &SafetyTrace, file: &PathBuf) -> String {
    let faults: Vec<&TracedFault> = trace.faults.iter().filter(|fault| fault.files.contains(file)).collect();
    let by = KINDS.into_iter().filter_map(|kind| {
        let noticed = |fault: &&&TracedFault| fault.noticed.iter().any(|(of, _)| *of == kind);
        let count = faults.iter().filter(noticed).count();
        (count > 0).then(|| format!("{count} by {}", kind.plural()))
    });
    let by: Vec<String> = by.collect();
    if by.is_empty() { faults.len().to_string() } else { format!("{}: {}", faults.len(), by.join(", ")) }
}

fn write_impact(text: &mut String, trace: &SafetyTrace) -> Result {
    writeln!(
        text,
        "# Change impact\n\n`cargo run --release -p keepout-proofs -- trace` writes this page. A row names a file that \
         implements safety\nrequirements. After a change of it, run its evidence again, and read the change against \
         its requirements. The names\nare in [the trace](trace.md). `.ci/run` runs all but the long runs, for every \
         change.\n\n\
         A file that is not in the list names no requirement: `.ci/run` is enough. Every trusted file and every \
         file of the\ndialects that mutation changes is in it, except `executor/guard/src/state.rs`, which only the \
         exploration reads. A\nchange of a tool (the compiler, a solver, CBMC) changes every row. A piece of evidence \
         that changes must notice a\nseeded fault again; CI prints the command. The last column counts no unit \
         tests.\n\n\
         | evidence | command |\n|---|---|"
    )?;
    for kind in KINDS {
        writeln!(text, "| {} | `{}` |", kind.plural(), kind.command())?;
    }
    writeln!(
        text,
        "| seeded faults of a file | `keepout-proofs faults --file FILE` |\n\n\
         | file | requirements | evidence to run again | seeded faults in it |\n|---|---|---|---|"
    )?;
    let mut files: BTreeMap<&PathBuf, BTreeSet<&String>> = BTreeMap::new();
    for mechanism in &trace.mechanisms {
        files.entry(&mechanism.file).or_default().extend(&mechanism.requirements);
    }
    for (file, requirements) in files {
        let touched =
            trace.evidence.iter().filter(|each| requirements.iter().any(|id| each.requirements.contains(id)));
        let faults = noticed_in(trace, file);
        let ids: Vec<&str> = requirements.iter().map(|id| id.as_str()).collect();
        writeln!(text, "| `{}` | {} | {} | {faults} |", file.display(), ids.join(", "), counted(touched))?;
    }
    Ok(())
}
