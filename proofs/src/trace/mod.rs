//! The safety trace: hazard, requirement, mechanism, evidence, and the seeded fault that shows that the evidence can
//! fail.
//!
//! The pages of `docs/safety/` state hazards, requirements and assumptions. Comments of the source say which code
//! *implements* a requirement, and which proof or test is *evidence for* one. The fault catalogue names the requirement
//! that each fault breaks. [`SafetyTrace::gaps`] lists what is missing, and [`page`] writes the pages.

mod collect;
mod gap;
pub mod page;
mod seen;
mod source;
mod statements;

use std::collections::BTreeSet;
use std::path::PathBuf;

pub use collect::read;
pub use gap::TraceGap;
pub use seen::{SeenTexts, keep};
pub use source::code_digest;
pub use statements::{Requirement, Statements};

/// The kinds of evidence, in the order of the pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EvidenceKind {
    /// A theorem, by an SMT solver.
    Theorem,
    /// A property, on every small case and at random.
    Property,
    /// A soak.
    Soak,
    /// A harness of the bounded model checker.
    Harness,
    /// A world of the exploration.
    World,
    /// An ordinary test.
    Test,
    /// A fuzz target.
    Fuzz,
    /// The hostile simulation.
    Hostile,
}

impl EvidenceKind {
    /// One piece of it, in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Theorem => "theorem",
            Self::Property => "property",
            Self::Soak => "soak",
            Self::Harness => "harness",
            Self::World => "world",
            Self::Test => "test",
            Self::Fuzz => "fuzz target",
            Self::Hostile => "hostile simulation",
        }
    }

    /// Several pieces of it, in words.
    #[must_use]
    pub fn plural(self) -> &'static str {
        match self {
            Self::Theorem => "theorems",
            Self::Property => "properties",
            Self::Soak => "soaks",
            Self::Harness => "harnesses",
            Self::World => "worlds",
            Self::Test => "tests",
            Self::Fuzz => "fuzz targets",
            Self::Hostile => "hostile simulation",
        }
    }

    /// The command that runs one piece of it.
    #[must_use]
    pub fn command(self) -> &'static str {
        match self {
            Self::Theorem => "keepout-proofs prove --only NAME",
            Self::Property => "cargo test -p keepout-proofs --test properties NAME",
            Self::Soak => "keepout-proofs soak --seed 1",
            Self::Harness => "keepout-proofs model-check NAME",
            Self::World => "keepout-proofs explore --only NAME",
            Self::Test => "cargo test -p CRATE NAME",
            Self::Fuzz => "fuzz/run 1800 NAME",
            Self::Hostile => "hostile --seed 1 --hours 100",
        }
    }
}

/// Something that runs and can fail.
#[derive(Clone, Debug)]
pub struct TracedEvidence {
    /// What it is.
    pub kind: EvidenceKind,
    /// Its name.
    pub name: String,
    /// Where it is, from the root of the workspace.
    pub file: PathBuf,
    /// The requirements that it is evidence for.
    pub requirements: Vec<String>,
    /// Whether it runs code of the product. A theorem about the plane does not, so no fault can make it fail.
    pub runs_code: bool,
    /// A digest of its text.
    pub digest: String,
}

/// Code that implements requirements.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mechanism {
    /// Its file, from the root of the workspace.
    pub file: PathBuf,
    /// The item; `None` when it is all of the file.
    pub item: Option<String>,
    /// The requirements.
    pub requirements: Vec<String>,
}

/// A fault of the catalogue, as the trace sees it.
#[derive(Clone, Debug)]
pub struct TracedFault {
    /// Its name.
    pub name: String,
    /// The requirement that it breaks.
    pub requirement: String,
    /// The files that it changes.
    pub files: Vec<PathBuf>,
    /// Whether every engine that must notice it did so, or nothing can.
    pub settled: bool,
    /// The kinds and names of those that noticed it. Of fuzz targets and the hostile simulation the name is theirs.
    pub noticed: Vec<(EvidenceKind, String)>,
    /// Why nobody can notice it.
    pub equivalent: Option<String>,
    /// Seconds until the first engine noticed it, with the build of the copy.
    pub seconds: Option<u64>,
}

/// Everything that the trace joins.
#[derive(Clone, Debug)]
pub struct SafetyTrace {
    /// Hazards, requirements and assumptions.
    pub statements: Statements,
    /// The code.
    pub mechanisms: Vec<Mechanism>,
    /// The evidence.
    pub evidence: Vec<TracedEvidence>,
    /// The faults.
    pub faults: Vec<TracedFault>,
    /// The evidence as it was when it last noticed a fault.
    pub seen: SeenTexts,
    /// The trusted files and the dialects: those that mutation changes.
    pub trusted: BTreeSet<PathBuf>,
}

impl SafetyTrace {
    /// The faults that this evidence noticed.
    pub fn noticed_by<'a>(&'a self, evidence: &'a TracedEvidence) -> impl Iterator<Item = &'a TracedFault> {
        let is_it = |(kind, name): &(EvidenceKind, String)| *kind == evidence.kind && *name == evidence.name;
        self.faults.iter().filter(move |fault| fault.noticed.iter().any(is_it))
    }

    /// The evidence for a requirement.
    pub fn evidence_for<'a>(&'a self, requirement: &'a str) -> impl Iterator<Item = &'a TracedEvidence> {
        self.evidence.iter().filter(move |each| each.requirements.iter().any(|id| id == requirement))
    }

    /// The code that implements a requirement.
    pub fn mechanisms_of<'a>(&'a self, requirement: &'a str) -> impl Iterator<Item = &'a Mechanism> {
        self.mechanisms.iter().filter(move |each| each.requirements.iter().any(|id| id == requirement))
    }

    /// The faults that break a requirement.
    pub fn faults_of<'a>(&'a self, requirement: &'a str) -> impl Iterator<Item = &'a TracedFault> {
        self.faults.iter().filter(move |fault| fault.requirement == requirement)
    }

    /// What is missing or does not fit.
    #[must_use]
    pub fn gaps(&self) -> Vec<TraceGap> {
        gap::all(self)
    }
}
