//! The programs that model checking needs: `cbmc`, `kissat`, `wasm2c`, and Rust's library for WebAssembly.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the programs are.
#[derive(Clone, Debug)]
pub struct Tools {
    /// The folder that holds them, or `None` where the PATH names them.
    folder: Option<PathBuf>,
}

/// The folder that `proofs/get-model-checker` fills, from the root of the workspace.
const FOLDER: &str = "target/model-checker/bin";

/// What to do without the programs.
pub const REMEDY: &str = "cbmc, kissat and wasm2c are needed: run proofs/get-model-checker, or install them from \
                          Debian 13 or later";

impl Tools {
    /// Finds the programs: on the PATH, or where `proofs/get-model-checker` puts them.
    ///
    /// # Errors
    /// [`REMEDY`] when one of them is in neither place.
    pub fn find(workspace: &Path) -> Result<Self, String> {
        let local = workspace.join(FOLDER);
        let places = [Self { folder: None }, Self { folder: Some(local) }];
        places.into_iter().find(Self::work).ok_or_else(|| REMEDY.to_string())
    }

    fn work(&self) -> bool {
        ["cbmc", "kissat", "wasm2c"].into_iter().all(|name| {
            let ran = self.command(name).arg("--version").output();
            ran.is_ok_and(|ran| ran.status.success())
        })
    }

    /// A command that runs one of them.
    #[must_use]
    pub fn command(&self, name: &str) -> Command {
        Command::new(self.path(name))
    }

    /// The path of one of them.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.as_ref().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
    }

    /// The versions, for the table.
    #[must_use]
    pub fn versions(&self) -> String {
        let version = |name: &str| {
            let ran = self.command(name).arg("--version").output().ok()?;
            let text = String::from_utf8_lossy(&ran.stdout).into_owned();
            Some(format!("{name} {}", text.split_whitespace().next()?))
        };
        ["cbmc", "kissat", "wasm2c"].into_iter().filter_map(version).collect::<Vec<_>>().join(", ")
    }
}
