//! Faults put into the trusted core one at a time (`mutants.toml`), in a copy of the tree: each must make a property fail.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use std::{fs, io};

use keepout_planner::plan_file::{hash, hex, write_whole};
use serde::Deserialize;

/// A fault.
#[derive(Clone, Debug, Deserialize)]
pub struct Mutant {
    /// What it is.
    pub what: String,
    /// The file that it is in.
    pub file: PathBuf,
    /// What is replaced; it is in the file once.
    pub find: String,
    /// By what.
    pub with: String,
    /// Why nobody can notice it.
    pub equivalent: Option<String>,
}

impl Mutant {
    /// The fault itself, hashed: results of a fault that was changed since are none of it.
    #[must_use]
    pub fn digest(&self) -> String {
        let file = self.file.to_string_lossy();
        let bytes = [file.as_bytes(), b"\0", self.find.as_bytes(), b"\0", self.with.as_bytes()].concat();
        hex(&hash(&bytes)[..8])
    }

    /// What came of it, when it was run.
    #[must_use]
    pub fn result<'a>(&self, results: &'a [Result]) -> Option<&'a Result> {
        let digest = self.digest();
        results.iter().find(|result| result.what == self.what && result.digest == digest)
    }

    /// Whether somebody noticed it, or nobody can.
    #[must_use]
    pub fn is_settled(&self, results: &[Result]) -> bool {
        self.result(results).is_some_and(|result| ["killed", "equivalent"].contains(&result.fate.as_str()))
    }
}

#[derive(Deserialize)]
struct List {
    mutant: Vec<Mutant>,
}

/// What became of a mutant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// This property failed.
    Killed(String),
    /// Nothing failed.
    Survived,
    /// It was not decided in ten minutes.
    Endless,
    /// It can not be built: the list is wrong.
    Unbuilt(String),
}

/// A mutant and its fate, as kept in the results file.
#[derive(Clone, Debug)]
pub struct Result {
    /// What the fault is.
    pub what: String,
    /// What became of it: `killed`, `survived`, `does not build`.
    pub fate: String,
    /// The property that failed.
    pub by: String,
    /// Seconds.
    pub seconds: u64,
    /// The fault's [digest](Mutant::digest).
    pub digest: String,
}

/// The workspace that this was built in.
#[must_use]
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Where results are kept.
#[must_use]
pub fn results_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("results/mutants.tsv")
}

/// The list.
///
/// # Errors
/// When the file can not be read.
pub fn list() -> io::Result<Vec<Mutant>> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("mutants.toml"))?;
    let list: List = toml::from_str(&text).map_err(io::Error::other)?;
    Ok(list.mutant)
}

/// Runs the mutants whose numbers are chosen in a copy of the tree under `folder`, and keeps what came of each.
///
/// # Errors
/// When the tree can not be copied, a fault's place is not found once, or the unchanged tree fails.
pub fn run(folder: &Path, chosen: impl Fn(usize) -> bool) -> io::Result<()> {
    let tree = folder.join("tree");
    copy(&workspace(), &tree)?;
    for (number, mutant) in list()?.iter().enumerate().filter(|(number, _)| chosen(*number)) {
        let path = tree.join(&mutant.file);
        let original = fs::read_to_string(&path)?;
        if original.matches(&mutant.find).count() != 1 {
            return Err(io::Error::other(format!(
                "mutant {number}, {}: its place is not there once",
                mutant.what
            )));
        }
        fs::write(&path, original.replacen(&mutant.find, &mutant.with, 1))?;
        let begin = Instant::now();
        let fate = fate(folder, &tree, &mutant.file);
        fs::write(&path, original)?;
        let seconds = begin.elapsed().as_secs();
        let (fate, by) = match fate? {
            Fate::Killed(by) => ("killed", by),
            Fate::Survived if mutant.equivalent.is_some() => ("equivalent", String::new()),
            Fate::Survived => ("survived", String::new()),
            Fate::Endless => ("not decided", String::new()),
            Fate::Unbuilt(why) => ("does not build", why),
        };
        println!("{number}\t{}\t{fate}\t{by}\t{seconds} s", mutant.what);
        // Others may run beside: what they have kept is read again.
        let mut results = results();
        results.retain(|result| result.what != mutant.what);
        let digest = mutant.digest();
        results.push(Result { what: mutant.what.clone(), fate: fate.into(), by, seconds, digest });
        keep(&results)?;
    }
    Ok(())
}

/// Builds the narrow set of proofs that can see the file, and runs it.
fn fate(folder: &Path, tree: &Path, file: &Path) -> io::Result<Fate> {
    let kernel = file.starts_with("kernel");
    let cargo = |of: &[&str]| {
        let mut command = Command::new("cargo");
        command.current_dir(tree).args(of).args([
            "-p",
            "keepout-proofs",
            "--bin",
            "check",
            "--no-default-features",
        ]);
        command.args(if kernel { [].as_slice() } else { ["--features", "guard"].as_slice() });
        command.env("CARGO_TARGET_DIR", folder.join("target")).env("CARGO_INCREMENTAL", "1");
        command.env("CARGO_PROFILE_DEV_DEBUG", "none").env("RUSTFLAGS", "--cap-lints allow");
        command
    };
    let built = cargo(&["build", "--quiet"]).output()?;
    if !built.status.success() {
        let text = String::from_utf8_lossy(&built.stderr);
        let why = text.lines().find(|line| line.starts_with("error")).unwrap_or("").to_string();
        // A constant that does not hold any more is a proof, too.
        let asserted =
            text.contains("evaluation panicked") || text.contains("evaluation of constant value failed");
        return Ok(if asserted { Fate::Killed("a constant assertion".into()) } else { Fate::Unbuilt(why) });
    }
    let groups = if kernel { "" } else { "guard,dialects" };
    let ran =
        Command::new("timeout").arg("600").arg(folder.join("target/debug/check")).arg(groups).output()?;
    let text = String::from_utf8_lossy(&ran.stdout);
    let failed = text.lines().find_map(|line| line.strip_prefix("fails: "));
    Ok(match (ran.status.success(), failed) {
        (true, _) => Fate::Survived,
        (false, Some(name)) => Fate::Killed(name.into()),
        (false, None) if ran.status.code() == Some(124) => Fate::Endless,
        (false, None) => Fate::Killed("ends abnormally".into()),
    })
}

/// What is kept of earlier runs.
#[must_use]
pub fn results() -> Vec<Result> {
    let text = fs::read_to_string(results_file()).unwrap_or_default();
    let read = |line: &str| {
        let mut fields = line.split('\t');
        let mut next = || fields.next().map(str::to_string);
        let (what, fate, by) = (next()?, next()?, next()?);
        Some(Result { what, fate, by, seconds: next()?.parse().ok()?, digest: next()? })
    };
    text.lines().filter_map(read).collect()
}

fn keep(results: &[Result]) -> io::Result<()> {
    let line = |r: &Result| format!("{}\t{}\t{}\t{}\t{}\n", r.what, r.fate, r.by, r.seconds, r.digest);
    let file = results_file();
    fs::create_dir_all(file.parent().unwrap_or(Path::new(".")))?;
    write_whole(&file, results.iter().map(line).collect::<String>().as_bytes())
}

/// Copies what is not there or differs, so that little is built anew, and takes away what is there no more.
///
/// # Errors
/// The system's.
pub fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(to)? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| !from.join(name).exists()) {
            if path.is_dir() { fs::remove_dir_all(path)? } else { fs::remove_file(path)? }
        }
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if name == "target" || name.to_string_lossy().starts_with('.') {
            continue;
        }
        let target = to.join(&name);
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else if fs::read(entry.path())? != fs::read(&target).unwrap_or_default() || !target.exists() {
            fs::copy(entry.path(), &target)?;
        }
    }
    Ok(())
}
