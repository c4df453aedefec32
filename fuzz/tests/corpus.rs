//! Every target over its stored inputs, inputs that once failed, mutations of these, and random bytes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use arbitrary::{Arbitrary, Unstructured};
use keepout_fuzz::sketch::Sketch;
use keepout_fuzz::{TARGETS, Target, certificates_of_log, corpus, is_certified_plan};
use keepout_planner::machine::MachineProfile;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files of a folder in order. A missing folder counts as empty.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    paths
}

/// A target's seeds and pack, and its folders in `tests/fuzz`, which hold inputs that once failed.
fn inputs(name: &str) -> Vec<Vec<u8>> {
    let stored = corpus::stored(name).unwrap_or_else(|error| panic!("{error}"));
    let failed = here().join("../tests/fuzz");
    let folders = [failed.join(name), failed.join("slow").join(name)];
    let drawings = (name == "dxf_import").then(|| here().join("../tests/drawings"));
    let others = folders.iter().chain(&drawings).flat_map(|folder| files(folder));
    let others = others.map(|path| std::fs::read(path).expect("readable"));
    stored.into_iter().map(|input| input.bytes).chain(others).collect()
}

/// The input with some bytes flipped, replaced, cut out, duplicated or taken from another input.
fn mutated(bytes: &[u8], others: &[Vec<u8>], random: &mut fastrand::Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..random.usize(1..5) {
        let at = random.usize(0..=bytes.len());
        let end = (at + random.usize(0..16)).min(bytes.len());
        match random.u8(0..5) {
            0 => bytes[at..end].iter_mut().for_each(|byte| *byte ^= 1 << random.u8(0..8)),
            1 => bytes[at..end].iter_mut().for_each(|byte| *byte = random.u8(..)),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.extend_from_within(at..end),
            _ => {
                let other = &others[random.usize(0..others.len())];
                let from = random.usize(0..=other.len());
                let to = (from + random.usize(0..64)).min(other.len());
                bytes.splice(at..end, other[from..to].iter().copied());
            }
        }
    }
    bytes
}

fn check(name: &str, rounds: usize) {
    let Target { holds, .. } = TARGETS.iter().find(|target| target.name == name).expect("it is a target");
    let inputs = inputs(name);
    assert!(!inputs.is_empty(), "{name} has a corpus");
    let holds = |bytes: &[u8]| {
        if std::panic::catch_unwind(|| holds(bytes)).is_err() {
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-fails"));
            std::fs::write(&path, bytes).expect("writable");
            panic!("the input is in {}", path.display());
        }
    };
    inputs.iter().for_each(|bytes| holds(bytes));
    let mut random = fastrand::Rng::with_seed(43);
    for _ in 0..rounds {
        let bytes = mutated(&inputs[random.usize(0..inputs.len())], &inputs, &mut random);
        holds(&bytes);
        let bytes: Vec<u8> = (0..random.usize(0..300)).map(|_| random.u8(..)).collect();
        holds(&bytes);
    }
}

/// At least a quarter of the stored drawings can be planned, so that the checks of plans see many of them.
#[test]
fn a_quarter_of_the_drawings_can_be_planned() {
    let inputs = inputs("drawing");
    let machine = MachineProfile::simulated();
    let planned = |bytes: &&Vec<u8>| {
        let Ok(sketch) = Sketch::arbitrary(&mut Unstructured::new(bytes)) else { return false };
        sketch.order.plan("corpus", sketch.dxf().as_bytes(), &machine, &mut |_| {}).is_ok()
    };
    let count = inputs.iter().filter(planned).count();
    assert!(4 * count >= inputs.len(), "{count} of {}", inputs.len());
}

/// The logs of the seeds replay and have certificates, so the checks of logs see some. The wrong one is refused.
#[test]
fn seeds_of_logs_replay_with_certificates() {
    for path in files(&here().join("seeds/session_log")) {
        let count = certificates_of_log(&std::fs::read(&path).expect("readable"));
        let wrong = path.ends_with("jog-that-was-not-certified");
        assert_eq!(count == 0, wrong, "{}: run `cargo run -p keepout-fuzz --example seeds`", path.display());
    }
}

/// The seeds that were planned are certified. With seeds of another version, the target sees only the errors of the
/// reader.
#[test]
fn planned_seeds_are_certified() {
    let is_planned = |path: &PathBuf| path.to_string_lossy().ends_with("-planned");
    let planned: Vec<PathBuf> =
        files(&here().join("seeds/plan_file")).into_iter().filter(is_planned).collect();
    let refused = planned.iter().find(|path| !is_certified_plan(&std::fs::read(path).expect("readable")));
    assert!(
        !planned.is_empty() && refused.is_none(),
        "{refused:?}: run `cargo run -p keepout-fuzz --example seeds`"
    );
}

macro_rules! tests {
    ($($name:ident $rounds:literal),+ $(,)?) => {
        $(#[test] fn $name() { check(stringify!($name), $rounds); })+

        /// Every target has a test, a libFuzzer program, a pack, and an entry in the manifest.
        #[test]
        fn every_target_is_complete() {
            let listed: BTreeSet<String> = TARGETS.iter().map(|target| target.name.into()).collect();
            assert_eq!(listed, BTreeSet::from([$(stringify!($name).to_string()),+]), "tests");
            let stem = |path: PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
            let programs: BTreeSet<String> =
                files(&here().join("fuzz_targets")).into_iter().filter_map(stem).collect();
            assert_eq!(listed, programs, "programs");
            let packs = files(&here().join("corpora")).into_iter().filter_map(stem);
            let packs: BTreeSet<String> = packs.map(|name| name.replace(".tar", "")).collect();
            assert_eq!(listed, packs, "packs");
            let seeds: BTreeSet<String> = files(&here().join("seeds")).into_iter().filter_map(stem).collect();
            assert!(seeds.is_subset(&listed), "seeds {seeds:?}");
            let manifest = std::fs::read_to_string(here().join("Cargo.toml")).expect("readable");
            for name in &listed {
                assert!(manifest.contains(&format!("name = \"{name}\"")), "{name} in the manifest");
            }
        }
    };
}

tests! {
    dxf_import 400,
    drawing 300,
    index 1500,
    index_check 1500,
    mesh 1500,
    offset 150,
    clear 1500,
    plan_file 400,
    session_log 400,
    machine_profile 1500,
    small_files 1500,
    grbl_decode 3000,
    zaber_decode 3000,
    venus_decode 3000,
    described_decode 3000,
    round_trip 100,
    panel 3000,
    supervisor 300,
    property 1500,
}
