//! Runs `proofs/check_log.py`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The verdict of the script on a log.
pub struct ScriptVerdict {
    /// Whether every rule holds.
    pub holds: bool,
    /// The script's line.
    pub text: String,
}

/// The script, and a folder for its inputs.
pub struct CheckScript {
    folder: PathBuf,
}

impl CheckScript {
    /// The script with a folder of this name. `None`, and a note, if this computer has no Python.
    pub fn found(name: &str) -> Option<Self> {
        let version = Command::new("python3").arg("--version").output();
        if !version.is_ok_and(|output| output.status.success()) {
            assert!(std::env::var_os("CI").is_none(), "CI skips nothing: install python3");
            println!("skipped: no python3");
            return None;
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("independent-replay-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Some(Self { folder })
    }

    /// The verdicts on logs of one plan, from two processes at the same time. `band` widens the clearance at arcs.
    pub fn verdicts(&self, plan: &[u8], logs: &[Vec<u8>], band: i32) -> Vec<ScriptVerdict> {
        let plan_path = self.folder.join("part.plan");
        std::fs::write(&plan_path, plan).unwrap();
        let paths: Vec<PathBuf> = (0..logs.len()).map(|i| self.folder.join(format!("{i}.log"))).collect();
        for (path, log) in paths.iter().zip(logs) {
            std::fs::write(path, log).unwrap();
        }
        let (first, second) = paths.split_at(paths.len().div_ceil(2));
        std::thread::scope(|scope| {
            let second = scope.spawn(|| go(&plan_path, second, band));
            let mut verdicts = go(&plan_path, first, band);
            verdicts.extend(second.join().unwrap());
            verdicts
        })
    }

    /// Keeps a case in the folder, and returns its place.
    pub fn keep(&self, plan: &[u8], log: &[u8], number: usize) -> String {
        let path = |end: &str| self.folder.join(format!("difference-{number}.{end}"));
        std::fs::write(path("plan"), plan).unwrap();
        std::fs::write(path("log"), log).unwrap();
        path("log").display().to_string()
    }
}

/// The verdicts on these logs, from one process.
fn go(plan: &Path, logs: &[PathBuf], band: i32) -> Vec<ScriptVerdict> {
    if logs.is_empty() {
        return Vec::new();
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../proofs/check_log.py");
    let mut command = Command::new("python3");
    command.arg("-I").arg(script).arg("--band").arg(band.to_string()).arg(plan).args(logs);
    let output = command.output().unwrap();
    let (text, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr).into_owned());
    assert!(errors.is_empty(), "{errors}");
    let lines: Vec<&str> = text.lines().collect();
    let verdict = |index: usize| {
        // The first line is about the plan. If it is refused, there is no other.
        let text = (*lines.get(index + 1).or(lines.first()).unwrap()).to_string();
        ScriptVerdict { holds: text.contains(": every rule holds: "), text }
    };
    let verdicts: Vec<ScriptVerdict> = (0..logs.len()).map(verdict).collect();
    let all = verdicts.iter().all(|verdict| verdict.holds);
    assert_eq!(output.status.code(), Some(if all { 0 } else { 5 }), "{text}");
    verdicts
}
