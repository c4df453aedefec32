//! Whether the targets find seeded faults: `cargo run -p keepout-fuzz --example seeded [TARGET...]`.
//!
//! All switched faults of `proofs/faults.toml` go into a copy of the tree. The program of a fault's
//! target gets the fault's number, reads the corpus and the inputs that once failed, and then has a
//! minute on one core. The fault counts as found when an input fails with the expected text, and passes
//! without the fault. The answers go to the table of faults, `proofs/results/faults.tsv`.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use keepout_fuzz::{TARGETS, corpus};
use keepout_proofs::faults::results::{FaultFate, FaultRow};
use keepout_proofs::faults::{self, FaultEngine, Fuzz, tree};
use keepout_proofs::trace;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// How long a target has, after its corpus.
const WITHIN: Duration = Duration::from_secs(60);
/// How long it may take to read the corpus.
const READING: Duration = Duration::from_secs(600);

fn main() -> Outcome<()> {
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    if let Some(unknown) = chosen.iter().find(|name| TARGETS.iter().all(|target| target.name != **name)) {
        return Err(format!("there is no target {unknown}: `cargo fuzz list` names them").into());
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let catalogue = faults::catalogue()?;
    let have: BTreeSet<&str> =
        catalogue.iter().filter_map(|fault| fault.fuzz.as_ref()).map(|fuzz| fuzz.target.as_str()).collect();
    if let Some(target) = TARGETS.iter().find(|target| !have.contains(target.name)) {
        return Err(format!("faults.toml has no fault for {}", target.name).into());
    }
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| here.join("../target"), PathBuf::from);
    let folder = std::path::absolute(folder)?.join("seeded");
    let evidence = trace::read(&faults::workspace())?.evidence;
    tree::seed_switched(&folder.join("tree"), &catalogue)?;
    let programs = build(&folder)?;
    let mut missed = 0;
    for (fault, number) in catalogue.iter().zip(1..) {
        let Some(fuzz) = &fault.fuzz else { continue };
        let target = &fuzz.target;
        if !chosen.is_empty() && !chosen.contains(target) {
            continue;
        }
        let begin = Instant::now();
        let found = finds(&programs.join(target), number, &folder, fuzz)?;
        let row = FaultRow::new(fault, FaultEngine::Fuzz, found.fate(target), begin.elapsed().as_secs());
        trace::keep(row, &evidence)?;
        missed += usize::from(matches!(found, Found::Not | Found::Otherwise));
        println!("{target}\t{found}\t{}", fault.name);
    }
    if missed > 0 {
        Err(format!("{missed} faults were not found in {WITHIN:?}, or for another reason").into())
    } else {
        Ok(())
    }
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

/// Whether what failed passes when no fault is seeded: else it was not the fault that was found.
fn passes_without(program: &Path, work: &Path) -> Outcome<bool> {
    let mut inputs = fs::read_dir(work)?.filter_map(|entry| Some(entry.ok()?.path()));
    let named =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("crash-"));
    let Some(crash) = inputs.find(named) else { return Ok(false) };
    let mut command = Command::new(program);
    command.arg(crash).env_remove(tree::SWITCH).stdout(Stdio::null()).stderr(Stdio::null());
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

impl Found {
    fn fate(&self, target: &str) -> FaultFate {
        match self {
            Self::Reading(_) | Self::Fuzzing(_) => FaultFate::Noticed(vec![target.into()]),
            Self::Otherwise | Self::Not => FaultFate::Survived,
        }
    }
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
fn finds(program: &Path, number: usize, folder: &Path, fuzz: &Fuzz) -> Outcome<Found> {
    let work = folder.join("work").join(number.to_string());
    let _ = fs::remove_dir_all(&work);
    fs::create_dir_all(work.join("new"))?;
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let name = &fuzz.target;
    let dictionary = here.join("dictionaries").join(name).with_extension("dict");
    let mut command = Command::new(program);
    command.env(tree::SWITCH, number.to_string());
    // As `fuzz/run` does: what once failed is read, too.
    corpus::unpack_to(name, &work.join("corpus"))?;
    let stored = [work.join("corpus"), corpus::seeds_of(name), here.join("../tests/fuzz").join(name)];
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
            for expected in &fuzz.expect {
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
