//! Processes of the program, which do not outlive who started them.

use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A process; it is killed when dropped.
#[derive(Debug)]
pub struct Process(Child);

impl Process {
    /// Starts the program; what it says is appended to a file.
    ///
    /// # Errors
    /// What the system says.
    pub fn start(program: &Path, arguments: &[&str], says: &Path) -> Result<Self, String> {
        let file = OpenOptions::new().append(true).create(true).open(says);
        let file = file.map_err(|error| format!("{}: {error}", says.display()))?;
        let errors = file.try_clone().map_err(|error| error.to_string())?;
        let child =
            Command::new(program).args(arguments).stdin(Stdio::null()).stdout(file).stderr(errors).spawn();
        child.map(Self).map_err(|error| format!("{}: {error}", program.display()))
    }

    /// Kills it: it gets no chance to do anything.
    ///
    /// # Errors
    /// What the system says.
    pub fn kill(&mut self) -> Result<(), String> {
        self.0.kill().and_then(|()| self.0.wait()).map(|_| ()).map_err(|error| error.to_string())
    }

    /// Sends it a signal, by name.
    ///
    /// # Errors
    /// When it can not be sent.
    pub fn signal(&self, name: &str) -> Result<(), String> {
        let sent = Command::new("kill").args([format!("-{name}"), self.0.id().to_string()]).status();
        match sent {
            Ok(status) if status.success() => Ok(()),
            other => Err(format!("SIG{name} can not be sent: {other:?}")),
        }
    }

    /// Waits for its end; the exit code, none when it was killed.
    ///
    /// # Errors
    /// When it does not end in time.
    pub fn wait(&mut self, within: Duration) -> Result<Option<i32>, String> {
        let begun = Instant::now();
        loop {
            match self.0.try_wait() {
                Ok(Some(status)) => return Ok(status.code()),
                Ok(None) if begun.elapsed() < within => std::thread::sleep(Duration::from_millis(10)),
                Ok(None) => return Err(format!("process {} does not end", self.0.id())),
                Err(error) => return Err(error.to_string()),
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The `keepout` program beside this one, built if it is not up to date.
///
/// # Errors
/// When it can not be built.
pub fn keepout_program() -> Result<PathBuf, String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let folder = own.ancestors().skip(1).find(|folder| !folder.ends_with("deps"));
    let folder = folder.ok_or("this program lies nowhere")?;
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let release = folder.ends_with("release");
    // As a test of the executor needs it, so that nothing is built twice.
    let arguments: &[&str] = if release {
        &["build", "--release", "--bin", "keepout"]
    } else {
        &["test", "--no-run", "--test", "cli"]
    };
    let built = Command::new(cargo)
        .args(arguments)
        .args(["--quiet", "-p", "keepout"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status();
    match built {
        Ok(status) if status.success() => Ok(folder.join("keepout")),
        other => Err(format!("keepout can not be built: {other:?}")),
    }
}
