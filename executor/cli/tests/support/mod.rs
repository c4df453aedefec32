//! Runs the program as a process, for tests of the command line.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub fn keepout(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_keepout")).args(arguments).output().unwrap()
}

/// Makes an empty folder for one test.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

pub fn bracket() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("drawings/bracket.dxf").display().to_string()
}

pub fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

pub fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
