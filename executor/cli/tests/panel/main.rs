//! The panel in a real browser: the whole job by touch, and what users of other programs complain about.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod browser;
// The longest test has the first name, so it starts first.
mod by_touch;
mod complaints;
mod network;
mod port_lost;
mod seeded;
mod sight;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use keepout_planner::machine::{ContourErrorSource, MachineProfile};

/// A running panel.
pub struct PanelProcess {
    process: Child,
    /// Its address, with the token.
    pub url: String,
    /// Its folder of jobs.
    pub folder: PathBuf,
}

impl PanelProcess {
    /// An empty folder of jobs.
    fn folder(name: &str) -> PathBuf {
        let with_fault = if seeded::seeded().is_some() { "-seeded" } else { "" };
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("panel-{name}{with_fault}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// Starts the panel of the demonstration, at a free port.
    pub(crate) fn start(name: &str) -> Self {
        Self::over(Self::folder(name))
    }

    /// Starts the panel over a folder of jobs.
    fn over(folder: PathBuf) -> Self {
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

/// A simulated machine behind a port of its own, stored under the name `bench`.
pub struct BenchMill(Child);

impl BenchMill {
    /// Starts the machine, and stores it in the folder's configuration.
    fn start(folder: &Path) -> Self {
        let link = folder.join("port");
        let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
        command.args(["simulate", "--three-axes", "--drives", "none", "--link"]).arg(&link);
        let process = command.stdin(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
        let machines = folder.join("config/machine");
        std::fs::create_dir_all(&machines).unwrap();
        let profile = MachineProfile {
            name: "bench mill".into(),
            contour_error_source: ContourErrorSource::Measured("with the bench".into()),
            ..MachineProfile::simulated_three_axes()
        };
        let profile = profile.to_toml().replace("[z]", "[profile.z]");
        let port = link.display();
        let stored = format!(
            "port = \"{port}\"\ndialect = \"grbl\"\nbaud = 115200\noperator = \"keyboard\"\n\n[profile]\n{profile}"
        );
        std::fs::write(machines.join("bench.toml"), stored).unwrap();
        let begun = Instant::now();
        while !link.exists() {
            assert!(begun.elapsed() < Duration::from_secs(20), "the simulated machine does not start");
            std::thread::sleep(Duration::from_millis(20));
        }
        Self(process)
    }

    /// Pulls the cable, and puts it back.
    fn unplug(&self) {
        let done = Command::new("kill").args(["-USR1", &self.0.id().to_string()]).status().unwrap();
        assert!(done.success());
    }
}

impl Drop for BenchMill {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Drop for PanelProcess {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
