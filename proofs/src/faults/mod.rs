//! The fault catalogue (`faults.toml`): faults that are seeded into a copy of the tree, each of which must be noticed.
//!
//! [`tree`] makes the copies, [`run`] builds and runs them, [`results`] keeps who noticed which fault.

pub mod results;
pub mod run;
pub mod tree;

use std::path::{Path, PathBuf};
use std::{fs, io};

use keepout_planner::sha256::{hash, hex};
use serde::Deserialize;

/// The word in a replacement that reads "it is this fault's turn", see [`SeededFault::is_switched`].
const SEEDED: &str = "seeded";

/// A seeded fault.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeededFault {
    /// What is wrong.
    pub name: String,
    /// The safety requirement that it breaks, such as "SR-07".
    pub requirement: String,
    /// The first edit's file.
    file: PathBuf,
    /// The text that the first edit replaces; it is in the file once.
    find: String,
    /// The text that replaces it.
    with: String,
    /// Further edits.
    #[serde(default)]
    also: Vec<Edit>,
    /// Why nobody can notice it.
    pub equivalent: Option<String>,
    /// The hostile simulation must notice it, in sessions that these arguments choose.
    pub hostile: Option<Vec<String>>,
    /// A fuzz target must notice it.
    pub fuzz: Option<Fuzz>,
    /// The model checker must find it, with this harness.
    pub model: Option<String>,
    /// A solver must refute this theorem, which runs the code.
    pub theorem: Option<String>,
    /// Tests must notice it, instead of properties and worlds: the arguments of `cargo test` that choose them.
    pub tests: Option<Vec<String>>,
}

/// One replacement of text in a file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// The file, from the root of the workspace.
    pub file: PathBuf,
    /// The text that is replaced; it is in the file once.
    pub find: String,
    /// The text that replaces it.
    pub with: String,
}

/// The fuzz target that must notice a fault.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fuzz {
    /// Its name.
    pub target: String,
    /// Texts one of which its failure contains: else it was found for another reason.
    pub expect: Vec<String>,
}

/// Who must notice a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultEngine {
    /// Properties, soaks and worlds: the program `check`.
    Proofs,
    /// The hostile simulation.
    Hostile,
    /// A fuzz target.
    Fuzz,
    /// Ordinary tests.
    Tests,
    /// The bounded model checker.
    Model,
    /// A solver, with a theorem.
    Theorem,
}

impl FaultEngine {
    /// All engines.
    pub const ALL: [Self; 6] =
        [Self::Proofs, Self::Hostile, Self::Fuzz, Self::Tests, Self::Model, Self::Theorem];

    /// Its name in the results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Proofs => "proofs",
            Self::Hostile => "hostile",
            Self::Fuzz => "fuzz",
            Self::Tests => "tests",
            Self::Model => "model",
            Self::Theorem => "theorem",
        }
    }

    /// Whether it runs the copy with all switched faults. The other engines need a copy with one fault.
    #[must_use]
    pub fn runs_switched(self) -> bool {
        matches!(self, Self::Proofs | Self::Hostile)
    }
}

impl SeededFault {
    /// All edits, in order.
    pub fn edits(&self) -> impl Iterator<Item = Edit> + '_ {
        let first = Edit { file: self.file.clone(), find: self.find.clone(), with: self.with.clone() };
        std::iter::once(first).chain(self.also.iter().cloned())
    }

    /// Whether the fault goes into one copy with others, and a number chooses it while the program runs.
    #[must_use]
    pub fn is_switched(&self) -> bool {
        self.edits().any(|edit| edit.with.contains(SEEDED))
    }

    /// Who must notice it.
    #[must_use]
    pub fn engines(&self) -> Vec<FaultEngine> {
        if self.fuzz.is_some() {
            return vec![FaultEngine::Fuzz];
        }
        let first = if self.tests.is_some() { FaultEngine::Tests } else { FaultEngine::Proofs };
        let hostile = self.hostile.as_ref().map(|_| FaultEngine::Hostile);
        let model = self.model.as_ref().map(|_| FaultEngine::Model);
        let theorem = self.theorem.as_ref().map(|_| FaultEngine::Theorem);
        std::iter::once(first).chain(hostile).chain(model).chain(theorem).collect()
    }

    /// Whether all of it lies in the kernel: then the properties of the kernel must notice it.
    #[must_use]
    pub fn is_in_kernel(&self) -> bool {
        self.is_under("kernel")
    }

    /// Whether all of it lies in a folder of the workspace.
    #[must_use]
    pub fn is_under(&self, folder: &str) -> bool {
        self.edits().all(|edit| edit.file.starts_with(folder))
    }

    /// A digest of the edits. A result with another digest belongs to an earlier form of the fault.
    #[must_use]
    pub fn digest(&self) -> String {
        let text = |edit: Edit| [&*edit.file.to_string_lossy(), &*edit.find, &*edit.with].join("\0");
        let bytes = self.edits().map(text).collect::<Vec<_>>().join("\0").into_bytes();
        hex(&hash(&bytes)[..8])
    }
}

/// The workspace that this was built in.
#[must_use]
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The catalogue.
///
/// # Errors
/// When the file cannot be read, or two faults have one name.
pub fn catalogue() -> io::Result<Vec<SeededFault>> {
    #[derive(Deserialize)]
    struct Catalogue {
        fault: Vec<SeededFault>,
    }
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("faults.toml"))?;
    let Catalogue { fault: faults } = toml::from_str(&text).map_err(io::Error::other)?;
    let mut names = std::collections::HashSet::new();
    match faults.iter().find(|fault| !names.insert(fault.name.as_str())) {
        Some(double) => Err(io::Error::other(format!("faults.toml names two faults \"{}\"", double.name))),
        None => Ok(faults),
    }
}
