//! Whether the targets find faults: `cargo run -p keepout-fuzz --example planted [TARGET...]`.
//!
//! All faults of `planted.toml` are put into a copy of the tree, each behind a number of its own; the program of its target is told
//! that, reads the corpus and what once failed, and then has a minute on one core. It is told whether a stored input was enough,
//! and the fault counts as found when it fails with what is expected of it, over what passes without it.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use keepout_fuzz::{TARGETS, corpus};
use keepout_proofs::mutants;
use serde::Deserialize;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// How long a target has, after its corpus.
const WITHIN: Duration = Duration::from_secs(60);
/// How long it may take to read the corpus.
const READING: Duration = Duration::from_secs(600);

#[derive(Deserialize)]
struct List {
    fault: Vec<Fault>,
}

/// A fault: in `file`, `find` is replaced by `with`, in which `planted` is whether it is this fault's turn. With `more` it belongs to
/// the one before.
#[derive(Deserialize)]
struct Fault {
    target: String,
    #[serde(default)]
    more: bool,
    what: String,
    /// What its failure says, one or the other.
    #[serde(default)]
    expect: Vec<String>,
    file: PathBuf,
    find: String,
    with: String,
}

fn main() -> Outcome<()> {
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    if let Some(unknown) = chosen.iter().find(|name| TARGETS.iter().all(|target| target.name != **name)) {
        return Err(format!("there is no target {unknown}: `cargo fuzz list` names them").into());
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list: List = toml::from_str(&fs::read_to_string(here.join("planted.toml"))?)?;
    let have: BTreeSet<&str> = list.fault.iter().map(|fault| fault.target.as_str()).collect();
    for target in TARGETS {
        if !have.contains(target.name) {
            return Err(format!("planted.toml has no fault for {}", target.name).into());
        }
    }
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.join("../target"), PathBuf::from);
    let folder = std::path::absolute(folder)?.join("planted");
    plant(&list, &folder.join("tree"))?;
    let programs = build(&folder)?;
    let mut missed = 0;
    for (index, faults) in list.fault.chunk_by(|_, next| next.more).enumerate() {
        let target = faults[0].target.as_str();
        if !chosen.is_empty() && !chosen.iter().any(|name| name == target) {
            continue;
        }
        let what: Vec<&str> = faults.iter().map(|fault| fault.what.as_str()).collect();
        let found = finds(&programs.join(target), index + 1, &folder, &faults[0])?;
        missed += usize::from(matches!(found, Found::Not | Found::Otherwise));
        println!("{target}\t{found}\t{}", what.join("; "));
    }
    if missed > 0 {
        Err(format!("{missed} faults were not found in {WITHIN:?}, or for another reason").into())
    } else {
        Ok(())
    }
}

/// The tree with all faults in it, and programs that choose one.
fn plant(list: &List, tree: &Path) -> Outcome<()> {
    let source = mutants::workspace();
    mutants::copy(&source, tree)?;
    for file in list.fault.iter().map(|fault| &fault.file).collect::<BTreeSet<_>>() {
        let mut text = fs::read_to_string(source.join(file))?;
        let numbered = list.fault.chunk_by(|_, next| next.more).zip(1..);
        let faults = numbered.flat_map(|(faults, number)| faults.iter().map(move |fault| (fault, number)));
        for (fault, number) in faults.filter(|(fault, _)| fault.file == *file) {
            if text.matches(&fault.find).count() != 1 {
                return Err(
                    format!("{}: its place in {} is not there once", fault.what, file.display()).into()
                );
            }
            let of = if file.starts_with("kernel") { "crate" } else { "keepout_kernel" };
            text = text.replacen(
                &fault.find,
                &fault.with.replace("planted", &format!("{of}::planted({number})")),
                1,
            );
        }
        write(&tree.join(file), &text)?;
    }
    let kernel = Path::new("kernel/src/lib.rs");
    write(&tree.join(kernel), &format!("{}{SWITCH}", fs::read_to_string(source.join(kernel))?))?;
    for target in TARGETS {
        let program = Path::new("fuzz/fuzz_targets").join(target.name).with_extension("rs");
        let text = fs::read_to_string(source.join(&program))?;
        let chosen = "std::env::var(\"PLANTED\").ok().and_then(|number| number.parse().ok()).unwrap_or(0)";
        let told = format!("fuzz_target!(init: keepout_kernel::plant({chosen}), |");
        write(&tree.join(program), &text.replace("fuzz_target!(|", &told))?;
    }
    Ok(())
}

/// What is added to the copy of the kernel.
const SWITCH: &str = "
static PLANTED: core::sync::atomic::AtomicUsize = core::sync::atomic::AtomicUsize::new(0);

/// Chooses the fault.
pub fn plant(number: usize) {
    PLANTED.store(number, core::sync::atomic::Ordering::Relaxed);
}

/// Whether it is this fault's turn.
#[must_use]
pub fn planted(number: usize) -> bool {
    PLANTED.load(core::sync::atomic::Ordering::Relaxed) == number
}
";

/// Writes what differs, so that little is built anew.
fn write(path: &Path, text: &str) -> Outcome<()> {
    if fs::read_to_string(path).is_ok_and(|there| there == text) {
        return Ok(());
    }
    Ok(fs::write(path, text)?)
}

/// Builds the programs; answers where they are.
fn build(folder: &Path) -> Outcome<PathBuf> {
    let target = folder.join("target");
    let built = Command::new("cargo")
        .current_dir(folder.join("tree"))
        .args(["+nightly", "fuzz", "build", "--features", "libfuzzer"])
        .env("CARGO_TARGET_DIR", &target)
        .env_remove("RUSTFLAGS")
        .status()?;
    if !built.success() {
        return Err(
            "the tree with the faults can not be built: is there a nightly toolchain, and cargo-fuzz?".into(),
        );
    }
    let host = Command::new("rustc").args(["+nightly", "-vV"]).output()?;
    let host = String::from_utf8(host.stdout)?;
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).ok_or("rustc names no host")?;
    Ok(target.join(host).join("release"))
}

/// libFuzzer's exit code when an input failed.
const FAILED: i32 = 77;

/// Whether what failed passes when nothing is planted: else it was not the fault that was found.
fn passes_without(program: &Path, work: &Path) -> Outcome<bool> {
    let mut inputs = fs::read_dir(work)?.filter_map(|entry| Some(entry.ok()?.path()));
    let named =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("crash-"));
    let Some(crash) = inputs.find(named) else { return Ok(false) };
    let mut command = Command::new(program);
    command.arg(crash).env_remove("PLANTED").stdout(Stdio::null()).stderr(Stdio::null());
    Ok(command.status()?.success())
}

/// Whether a fault was found.
enum Found {
    /// While the corpus was read.
    Reading(Duration),
    /// So long after that.
    Fuzzing(Duration),
    /// What failed fails without it, too, or says something else.
    Otherwise,
    Not,
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Reading(after) => write!(f, "{:.1} s\tcorpus", after.as_secs_f64()),
            Self::Fuzzing(after) => write!(f, "{:.1} s\tfuzzing", after.as_secs_f64()),
            Self::Otherwise => f.write_str("FOR ANOTHER REASON\t"),
            Self::Not => f.write_str("NOT FOUND\t"),
        }
    }
}

/// Runs the program of a target with a fault.
fn finds(program: &Path, number: usize, folder: &Path, fault: &Fault) -> Outcome<Found> {
    let work = folder.join("work").join(number.to_string());
    let _ = fs::remove_dir_all(&work);
    fs::create_dir_all(work.join("new"))?;
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR"));
    let name = &fault.target;
    let dictionary = fuzz.join("dictionaries").join(name).with_extension("dict");
    let mut command = Command::new(program);
    command.env("PLANTED", number.to_string());
    // As `fuzz/run` does: what once failed is read, too.
    corpus::unpack_to(name, &work.join("corpus"))?;
    let stored = [work.join("corpus"), corpus::seeds_of(name), fuzz.join("../tests/fuzz").join(name)];
    command.arg(work.join("new")).args(stored.iter().filter(|folder| folder.is_dir()));
    if dictionary.is_file() {
        command.arg(format!("-dict={}", dictionary.display()));
    }
    command.args(["-timeout=120", "-rss_limit_mb=2048", "-max_len=16384", "-len_control=0", "-seed=1"]);
    command.arg(format!("-artifact_prefix={}/", work.display()));
    let log = work.join("log");
    let says = |what: &str| -> Outcome<bool> { Ok(String::from_utf8_lossy(&fs::read(&log)?).contains(what)) };
    let begin = Instant::now();
    let mut running = command.stdout(Stdio::null()).stderr(fs::File::create(&log)?).spawn()?;
    let mut read = None;
    while read.map_or(begin.elapsed() < READING, |read: Instant| read.elapsed() < WITHIN) {
        let status = running.try_wait()?;
        if read.is_none() && says("INITED")? {
            read = Some(Instant::now());
        }
        if let Some(status) = status {
            let mut right = false;
            for expected in &fault.expect {
                right |= status.code() == Some(FAILED) && says(expected)?;
            }
            return Ok(match read {
                _ if !right || !passes_without(program, &work)? => Found::Otherwise,
                None => Found::Reading(begin.elapsed()),
                Some(read) => Found::Fuzzing(read.elapsed()),
            });
        }
        thread::sleep(Duration::from_millis(50));
    }
    running.kill()?;
    running.wait()?;
    Ok(Found::Not)
}
