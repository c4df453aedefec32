//! Shards of the programs share no work, and together do the work of the whole run.
#![cfg(all(feature = "guard", feature = "solvers", feature = "tools"))]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use keepout_campaigns::{Shard, ShardResults, merge};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_keepout-proofs")).args(arguments).output().unwrap()
}

/// The results of one shard of a campaign, with the file.
fn results(folder: &Path, arguments: &[&str], shard: Shard) -> (PathBuf, ShardResults) {
    let path = folder.join(format!("{}-of-{}.tsv", shard.index(), shard.of()));
    let (shard, file) = (shard.to_string(), path.to_string_lossy());
    let ran = run(&[arguments, &["--shard", &shard, "--results", &file, "--revision", "here"]].concat());
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let results = ShardResults::read(&path).unwrap();
    (path, results)
}

/// Compares the merged shards with the whole run. Returns the whole run's results.
fn shards_equal_the_whole(name: &str, arguments: &[&str]) -> ShardResults {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("shards-{name}"));
    let whole = merge(&[results(&folder, arguments, Shard::WHOLE)]).unwrap();
    for of in [2, 3] {
        let files: Vec<_> = Shard::all(of).map(|shard| results(&folder, arguments, shard)).collect();
        assert_eq!(merge(&files).unwrap(), whole, "{of} shards");
        assert!(merge(&files[1..]).unwrap_err().to_string().contains(&format!("shard 1/{of}")));
    }
    whole
}

#[test]
fn shards_of_an_exploration_explore_each_world_once() {
    let whole = shards_equal_the_whole("explore", &["explore", "--only", "contour, "]);
    assert!(whole.totals["worlds"] > 3 && whole.rows.len() as u64 == whole.totals["worlds"]);
    let second = shards_equal_the_whole("second", &["explore", "--second", "--only", "heights: rise"]);
    assert_eq!(second.totals["worlds"], 1);
}

#[test]
fn shards_of_a_soak_compare_each_case_once() {
    let arguments = ["soak", "--seed", "3", "--predicates", "100000", "--queries", "0", "--arcs", "20000"];
    let whole = shards_equal_the_whole("soak", &arguments);
    assert_eq!((whole.totals["predicate cases"], whole.totals["arcs"]), (100_000, 20_000));
}

#[test]
fn violated_world_is_a_failed_row_with_the_command_that_explores_it_again() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("violated.tsv");
    let world = "pair: a copy and a swap";
    let file = path.to_string_lossy();
    let options = ["--results", &file, "--revision", "here"];
    let ran = run(&[&["explore", "--second", "--excluded", "--only", world][..], &options].concat());
    assert_eq!(ran.status.code(), Some(1));
    let results = ShardResults::read(&path).unwrap();
    assert!(results.has_failed());
    assert!(results.rows[0].detail.contains("is outside the set"), "{:?}", results.rows);
    assert!(results.rows[0].again.ends_with(&format!("--only '{world}'")), "{:?}", results.rows);
}

#[test]
fn shards_of_the_fault_catalogue_choose_each_fault_once() {
    let list = |options: &[&str]| {
        let ran = run(&[&["faults", "--list"], options].concat());
        String::from_utf8(ran.stdout).unwrap().lines().map(String::from).collect::<Vec<_>>()
    };
    let mut whole = list(&[]);
    assert!(whole.len() > 100, "{}", whole.len());
    let mut parts: Vec<_> = Shard::all(4).flat_map(|shard| list(&["--shard", &shard.to_string()])).collect();
    whole.sort();
    parts.sort();
    assert_eq!(parts, whole);
}
