//! What the trace lacks.

use std::path::PathBuf;

use thiserror::Error;

use super::{EvidenceKind, SafetyTrace, TracedFault};

/// A gap of the trace.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TraceGap {
    /// A requirement that no code implements.
    #[error("{0}: no code says `// Implements {0}.`")]
    NoMechanism(String),
    /// A requirement without evidence that runs.
    #[error("{0}: no proof or test says `// Evidence for {0}.`")]
    NoEvidence(String),
    /// A requirement that no seeded fault breaks.
    #[error("{0}: no fault of faults.toml says `requirement = \"{0}\"`")]
    NoFault(String),
    /// Faults break the requirement, and the evidence for it noticed none of them.
    #[error("{0}: its evidence noticed no fault that breaks it")]
    NoFaultNoticed(String),
    /// A requirement without a hazard, or with one that is not listed.
    #[error("{id}: {hazard:?} is no hazard of hazards.md")]
    NoHazard {
        /// The requirement.
        id: String,
        /// The number, empty when it names none.
        hazard: String,
    },
    /// A requirement names a hazard, or a hazard a requirement, and the other one does not name it.
    #[error("{requirement} and {hazard}: one of them names the other, and is not named there")]
    OneWay {
        /// The requirement.
        requirement: String,
        /// The hazard.
        hazard: String,
    },
    /// A number that no page states.
    #[error("{place} names {id}, which no page of docs/safety states")]
    Unknown {
        /// Who names it.
        place: String,
        /// The number.
        id: String,
    },
    /// A statement that two sections of a page make.
    #[error("{0} is stated twice")]
    Twice(String),
    /// A hazard without one of its parts, or an assumption without a check.
    #[error(
        "{0}: a hazard needs cause, harm, who notices, measure and what remains; an assumption needs a check"
    )]
    Incomplete(String),
    /// A requirement or an assumption that nothing refers to.
    #[error("{0}: no hazard or requirement names it")]
    Unused(String),
    /// Evidence without a requirement.
    #[error("{}: {name} is evidence for no requirement: say `// Evidence for SR-nn.` above it", .file.display())]
    NoRequirement {
        /// The evidence.
        name: String,
        /// Its file.
        file: PathBuf,
    },
    /// Evidence that no seeded fault makes fail.
    #[error("{}: no fault of faults.toml makes {name} fail: it may be unable to", .file.display())]
    CannotFail {
        /// The evidence.
        name: String,
        /// Its file.
        file: PathBuf,
    },
    /// Evidence that changed since it noticed a fault: it may be empty now.
    #[error("{}: {name} changed since it noticed a fault. Run `{command}`", .file.display())]
    Changed {
        /// The evidence.
        name: String,
        /// Its file.
        file: PathBuf,
        /// What seeds a fault that it noticed: one of its own requirements, or the one that it noticed soonest.
        command: String,
    },
    /// A fault that nobody noticed.
    #[error("\"{0}\": no engine noticed this fault: run `keepout-proofs faults --left`")]
    Unnoticed(String),
    /// A trusted file or a dialect without a requirement.
    #[error("{}: no comment in it says `Implements SR-nn.`", .0.display())]
    Untied(PathBuf),
    /// A trusted file or a dialect in which nobody noticed a fault.
    #[error("{}: faults.toml has no fault in it that somebody noticed", .0.display())]
    NoFaultIn(PathBuf),
    /// A fault in a file that does not implement the requirement that the fault breaks.
    #[error("\"{name}\" breaks {requirement}, and none of its files says `// Implements {requirement}.`")]
    Elsewhere {
        /// The fault.
        name: String,
        /// The requirement.
        requirement: String,
    },
}

/// Trusted files that only the exploration reads. Nothing of the product depends on them.
const FOR_EXPLORATION: [&str; 1] = ["executor/guard/src/state.rs"];

/// All gaps, in the order of the pages.
pub fn all(trace: &SafetyTrace) -> Vec<TraceGap> {
    let mut gaps = of_statements(trace);
    for requirement in &trace.statements.requirements {
        of_requirement(trace, &requirement.id, &mut gaps);
    }
    for evidence in &trace.evidence {
        let (name, file) = (evidence.name.clone(), evidence.file.clone());
        if evidence.requirements.is_empty() {
            gaps.push(TraceGap::NoRequirement { name, file });
        } else if evidence.runs_code {
            let own = |fault: &TracedFault| evidence.requirements.contains(&fault.requirement);
            match trace.noticed_by(evidence).min_by_key(|fault| (!own(fault), fault.seconds)) {
                None => gaps.push(TraceGap::CannotFail { name, file }),
                Some(_) if trace.seen.has(evidence) => {}
                Some(fault) => {
                    let command = match evidence.kind {
                        EvidenceKind::Fuzz => format!("cargo run -p keepout-fuzz --example seeded {name}"),
                        _ => format!("keepout-proofs faults --named \"{}\"", fault.name),
                    };
                    gaps.push(TraceGap::Changed { name, file, command });
                }
            }
        }
    }
    for fault in &trace.faults {
        if !fault.settled {
            gaps.push(TraceGap::Unnoticed(fault.name.clone()));
        }
        let implements =
            |file: &PathBuf| trace.mechanisms_of(&fault.requirement).any(|mechanism| mechanism.file == *file);
        if !fault.files.iter().any(implements) {
            let (name, requirement) = (fault.name.clone(), fault.requirement.clone());
            gaps.push(TraceGap::Elsewhere { name, requirement });
        }
    }
    for file in trace.trusted.iter().filter(|file| !FOR_EXPLORATION.iter().any(|name| file.ends_with(name))) {
        if !trace.mechanisms.iter().any(|mechanism| mechanism.file == *file) {
            gaps.push(TraceGap::Untied(file.clone()));
        }
        let noticed = |fault: &TracedFault| fault.settled && fault.equivalent.is_none();
        if !trace.faults.iter().any(|fault| fault.files.contains(file) && noticed(fault)) {
            gaps.push(TraceGap::NoFaultIn(file.clone()));
        }
    }
    gaps
}

fn of_requirement(trace: &SafetyTrace, id: &str, gaps: &mut Vec<TraceGap>) {
    if trace.mechanisms_of(id).next().is_none() {
        gaps.push(TraceGap::NoMechanism(id.into()));
    }
    let mut evidence = trace.evidence_for(id).filter(|each| each.runs_code).peekable();
    if evidence.peek().is_none() {
        gaps.push(TraceGap::NoEvidence(id.into()));
        return;
    }
    if trace.faults_of(id).next().is_none() {
        gaps.push(TraceGap::NoFault(id.into()));
        return;
    }
    let breaks = |(kind, name): &(EvidenceKind, String)| {
        trace.evidence_for(id).any(|each| each.kind == *kind && each.name == *name)
    };
    if !trace.faults_of(id).any(|fault| fault.noticed.iter().any(breaks)) {
        gaps.push(TraceGap::NoFaultNoticed(id.into()));
    }
}

fn of_statements(trace: &SafetyTrace) -> Vec<TraceGap> {
    let statements = &trace.statements;
    let mut gaps = Vec::new();
    let hazards: Vec<&str> = statements.hazards.iter().map(|each| each.id.as_str()).collect();
    let requirements: Vec<&str> = statements.requirements.iter().map(|each| each.id.as_str()).collect();
    let assumptions: Vec<&str> = statements.assumptions.iter().map(|each| each.id.as_str()).collect();
    for ids in [&hazards, &requirements, &assumptions] {
        let twice = ids.iter().enumerate().filter(|(n, id)| ids[..*n].contains(id));
        gaps.extend(twice.map(|(_, id)| TraceGap::Twice((*id).into())));
    }
    for requirement in &statements.requirements {
        let unknown: Vec<String> =
            requirement.hazards.iter().filter(|id| !hazards.contains(&id.as_str())).cloned().collect();
        let none = requirement.hazards.is_empty().then(String::new);
        gaps.extend(
            unknown
                .into_iter()
                .chain(none)
                .map(|hazard| TraceGap::NoHazard { id: requirement.id.clone(), hazard }),
        );
        gaps.extend(unknown_of(&requirement.id, &requirement.assumptions, &[&assumptions]));
    }
    for (requirement, hazard) in statements
        .requirements
        .iter()
        .flat_map(|each| statements.hazards.iter().map(move |hazard| (each, hazard)))
    {
        if requirement.hazards.contains(&hazard.id) != hazard.refers_to.contains(&requirement.id) {
            let (requirement, hazard) = (requirement.id.clone(), hazard.id.clone());
            gaps.push(TraceGap::OneWay { requirement, hazard });
        }
    }
    for stated in statements.hazards.iter().chain(&statements.assumptions) {
        if !stated.whole {
            gaps.push(TraceGap::Incomplete(stated.id.clone()));
        }
        gaps.extend(unknown_of(&stated.id, &stated.refers_to, &[&requirements, &assumptions]));
    }
    let named: Vec<&String> = statements.hazards.iter().flat_map(|each| &each.refers_to).collect();
    let rests: Vec<&String> = statements.requirements.iter().flat_map(|each| &each.assumptions).collect();
    let is_named = |id: &str| named.iter().chain(&rests).any(|other| *other == id);
    gaps.extend(
        requirements
            .iter()
            .chain(&assumptions)
            .filter(|id| !is_named(id))
            .map(|id| TraceGap::Unused((*id).into())),
    );
    for mechanism in &trace.mechanisms {
        gaps.extend(unknown_of(
            &mechanism.file.display().to_string(),
            &mechanism.requirements,
            &[&requirements],
        ));
    }
    for evidence in &trace.evidence {
        gaps.extend(unknown_of(&evidence.name, &evidence.requirements, &[&requirements]));
    }
    gaps
}

fn unknown_of(place: &str, ids: &[String], lists: &[&Vec<&str>]) -> Vec<TraceGap> {
    ids.iter()
        .filter(|id| !lists.iter().any(|list| list.contains(&id.as_str())))
        .map(|id| TraceGap::Unknown { place: place.into(), id: id.clone() })
        .collect()
}
