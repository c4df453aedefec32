//! Digests of the texts of the evidence, as it was when it last noticed a seeded fault.
//!
//! A test that was emptied since still stands in the results of the faults. Its text then differs from the digest in
//! `proofs/results/evidence.tsv`, and it must notice a fault again.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{fs, io};

use keepout_planner::file::write_whole;

use super::collect::identified;
use super::{EvidenceKind, TracedEvidence};
use crate::faults::results::{self, FaultFate, FaultRow};
use crate::faults::{self, FaultEngine};

/// Kind, name and digest of the text of each piece of evidence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SeenTexts(BTreeSet<[String; 3]>);

impl SeenTexts {
    /// The file's texts; empty when there is no file.
    #[must_use]
    pub fn read(root: &Path) -> Self {
        let text = fs::read_to_string(file(root)).unwrap_or_default();
        let row = |line: &str| line.split('\t').map(String::from).collect::<Vec<_>>().try_into().ok();
        Self(text.lines().filter_map(row).collect())
    }

    /// Whether the evidence had its present text.
    #[must_use]
    pub fn has(&self, evidence: &TracedEvidence) -> bool {
        self.0.contains(&row(evidence))
    }

    /// Replaces the digests of the evidence of this kind and name by those of its texts.
    fn renew(&mut self, kind: EvidenceKind, name: &str, evidence: &[TracedEvidence]) {
        self.0.retain(|[of, old, _]| of != kind.name() || old != name);
        self.0.extend(evidence.iter().filter(|each| each.kind == kind && each.name == name).map(row));
    }

    /// Drops the digests of evidence that no longer exists.
    fn drop_gone(&mut self, present: &[TracedEvidence]) {
        self.0.retain(|[of, old, _]| present.iter().any(|each| each.kind.name() == of && each.name == *old));
    }

    fn write(&self, root: &Path) -> io::Result<()> {
        let lines: String = self.0.iter().map(|fields| fields.join("\t") + "\n").collect();
        write_whole(&file(root), lines.as_bytes())
    }
}

fn row(evidence: &TracedEvidence) -> [String; 3] {
    [evidence.kind.name().into(), evidence.name.clone(), evidence.digest.clone()]
}

fn file(root: &Path) -> PathBuf {
    root.join("proofs/results/evidence.tsv")
}

/// Keeps who noticed a fault, and the texts of those who did. The evidence is as it was before the fault went into its
/// copy: a text that changed since must notice a fault again.
///
/// # Errors
/// When the catalogue, a source or a table cannot be read or written.
pub fn keep(found: FaultRow, evidence: &[TracedEvidence]) -> io::Result<()> {
    let root = faults::workspace();
    let catalogue = faults::catalogue()?;
    let engine = FaultEngine::ALL.into_iter().find(|engine| engine.name() == found.engine);
    // An older form of the fault is no fault of the catalogue.
    let fault = catalogue.iter().find(|fault| fault.name == found.name && fault.digest() == found.digest);
    if let (FaultFate::Noticed(names), Some(engine), Some(fault)) = (&found.fate, engine, fault) {
        let mut seen = SeenTexts::read(&root);
        for (kind, name) in names.iter().filter_map(|name| identified(engine, name, fault, evidence)) {
            seen.renew(kind, &name, evidence);
        }
        seen.drop_gone(&super::read(&root)?.evidence);
        seen.write(&root)?;
    }
    results::keep(found, &catalogue)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_renewed_and_dropped_with_their_evidence() {
        let of = |name: &str, digest: &str| TracedEvidence {
            kind: EvidenceKind::World,
            name: name.into(),
            file: PathBuf::new(),
            requirements: Vec::new(),
            runs_code: true,
            digest: digest.into(),
        };
        let texts = |all: &[TracedEvidence]| SeenTexts(all.iter().map(row).collect());
        let mut seen = texts(&[of("jogs", "1"), of("contour", "1"), of("removed", "1")]);
        let present = [of("jogs", "2"), of("contour", "2")];
        seen.renew(EvidenceKind::World, "jogs", &present);
        seen.drop_gone(&present);
        assert_eq!(seen, texts(&[of("jogs", "2"), of("contour", "1")]));
        assert!(seen.has(&present[0]) && !seen.has(&present[1]));
    }
}
