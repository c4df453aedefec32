//! The panel in a real browser: the whole job by touch, and what users of other programs complain about.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod browser;
mod complaints;
mod whole_job;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A running panel.
pub struct PanelProcess {
    process: Child,
    /// Its address, with the token.
    pub url: String,
    /// Its folder of jobs.
    pub folder: PathBuf,
}

impl PanelProcess {
    /// Starts the panel of the demonstration, at a free port.
    pub(crate) fn start(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("panel-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        let mut process = Command::new(env!("CARGO_BIN_EXE_keepout"))
            .args(["panel", "--demo", "--port", "0"])
            .arg(&folder)
            .env("KEEPOUT_CONFIG", folder.join("config"))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let line = lines.next().unwrap().unwrap();
        std::thread::spawn(move || lines.for_each(drop));
        let url = line.split_once("http://").map(|(_, rest)| format!("http://{rest}")).unwrap();
        Self { process, url, folder }
    }
}

impl Drop for PanelProcess {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
