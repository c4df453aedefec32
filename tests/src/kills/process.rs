//! Processes of the program. They end with the test that started them.

use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A process. The drop kills it.
#[derive(Debug)]
pub struct Process(Child);

impl Process {
    /// Starts the program. Its output goes to the end of the file `output`.
    ///
    /// # Errors
    /// The system's error.
    pub fn start(program: &Path, arguments: &[&str], output: &Path) -> Result<Self, String> {
        let file = OpenOptions::new().append(true).create(true).open(output);
        let file = file.map_err(|error| format!("{}: {error}", output.display()))?;
        let errors = file.try_clone().map_err(|error| error.to_string())?;
        let child =
            Command::new(program).args(arguments).stdin(Stdio::null()).stdout(file).stderr(errors).spawn();
        child.map(Self).map_err(|error| format!("{}: {error}", program.display()))
    }

    /// Kills the process at once, and waits for its end.
    ///
    /// # Errors
    /// The system's error.
    pub fn kill(&mut self) -> Result<(), String> {
        self.0.kill().and_then(|()| self.0.wait()).map(|_| ()).map_err(|error| error.to_string())
    }

    /// Sends a signal, such as `TERM`, to the process.
    ///
    /// # Errors
    /// The reason why the signal was not sent.
    pub fn signal(&self, name: &str) -> Result<(), String> {
        let sent = Command::new("kill").args([format!("-{name}"), self.0.id().to_string()]).status();
        match sent {
            Ok(status) if status.success() => Ok(()),
            other => Err(format!("SIG{name} can not be sent: {other:?}")),
        }
    }

    /// Waits for the end of the process, and returns the exit code. A killed process has no exit code.
    ///
    /// # Errors
    /// The process number if the process does not end within `within`, or the system's error.
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

/// The `keepout` program in the folder of this program. Cargo builds it if it is not up to date.
///
/// # Errors
/// The reason why the build failed.
pub fn keepout_program() -> Result<PathBuf, String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let folder = own.ancestors().skip(1).find(|folder| !folder.ends_with("deps"));
    let folder = folder.ok_or("this program lies in no build folder")?;
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let release = folder.ends_with("release");
    // With the features that the tests of the whole workspace give it. So Cargo does not build it twice.
    let arguments: &[&str] = if release {
        &["build", "--release", "-p", "keepout", "--bin", "keepout"]
    } else {
        &["test", "--workspace", "--no-run", "--test", "cli"]
    };
    let built =
        Command::new(cargo).args(arguments).arg("--quiet").current_dir(env!("CARGO_MANIFEST_DIR")).status();
    match built {
        Ok(status) if status.success() => Ok(folder.join("keepout")),
        other => Err(format!("keepout can not be built: {other:?}")),
    }
}
