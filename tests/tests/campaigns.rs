//! Shards of campaigns, started as the schedulers start them, do together what the whole run does.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};
use std::process::Command;

use keepout_campaigns::{Shard, ShardResults, merge};

const HOSTILE: &str = env!("CARGO_BIN_EXE_hostile");
/// A small campaign. The first drawings have plans and others have none.
const SMALL: &str = "--seed 1 --drawings 12 --per-drawing 3 --revision here";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// An empty folder for the results of one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("campaigns-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn succeed(command: &mut Command) {
    let ran = command.output().unwrap();
    assert!(ran.status.success(), "{command:?}: {}", String::from_utf8_lossy(&ran.stderr));
}

/// The merged results files of a folder.
fn merged(folder: &Path) -> ShardResults {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<_> = entries.map(|path| (path.clone(), ShardResults::read(&path).unwrap())).collect();
    merge(&files).unwrap()
}

/// The results of the small campaign as one run.
fn whole(name: &str, threads: &str) -> ShardResults {
    let folder = folder(name);
    let mut command = Command::new(HOSTILE);
    command.args(SMALL.split(' ')).args(["--threads", threads, "--results"]);
    succeed(command.arg(folder.join("whole.tsv")));
    merged(&folder)
}

#[test]
fn shards_of_a_hostile_run_play_the_sessions_of_the_whole_run() {
    let whole = whole("whole", "2");
    assert!(whole.totals["sessions"] >= 12 && whole.totals["simulated time, ms"] > 0, "{whole:?}");
    let folder = folder("shards");
    for shard in Shard::all(3) {
        let mut command = Command::new(HOSTILE);
        command.args(SMALL.split(' ')).args(["--shard", &shard.to_string(), "--threads", "1", "--results"]);
        succeed(command.arg(folder.join(format!("{}.tsv", shard.index()))));
    }
    assert_eq!(merged(&folder), whole);
}

#[test]
fn tasks_of_a_slurm_array_are_the_whole_run() {
    let folder = folder("slurm");
    for task in ["1", "2"] {
        let mut command = Command::new(root().join("campaigns/slurm.sh"));
        command.args(["2", HOSTILE]).args(SMALL.split(' '));
        succeed(command.env("SLURM_ARRAY_TASK_ID", task).env("RESULTS", &folder));
    }
    assert_eq!(merged(&folder), whole("slurm-whole", "1"));
}

#[test]
fn indexes_of_a_kubernetes_job_are_the_whole_run() {
    let folder = folder("kubernetes");
    let manifest = std::fs::read_to_string(root().join("campaigns/kubernetes.yaml")).unwrap();
    let between = |begin: &str, end: &str| {
        let text = manifest.split_once(begin).unwrap().1.split_once(end).unwrap().0;
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let indexes: u32 = between("completions: ", "\n").parse().unwrap();
    let command = between("- >-", "resources:").replace("target/release/hostile", HOSTILE);
    let command = command.replace("--seed 1 --drawings 16000", SMALL);
    let command = command.replace("/results/", &format!("{}/", folder.display()));
    assert!(command.contains(SMALL) && !command.contains("target/release/hostile "), "{command}");
    for index in 0..indexes {
        let mut bash = Command::new("bash");
        succeed(bash.args(["-euc", &command]).env("JOB_COMPLETION_INDEX", index.to_string()));
    }
    assert_eq!(merged(&folder), whole("kubernetes-whole", "1"));
}

#[cfg(target_os = "linux")]
mod fuzzing {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    /// Stands for `cargo`: four targets, of which `c` fails.
    const CARGO: &str = "#!/bin/sh\n[ \"$2 $3\" != 'fuzz list' ] || printf 'a\\nb\\nc\\nd\\n'\n";
    const RUSTC: &str = "#!/bin/sh\necho 'host: here'\n";
    const CORPUS: &str = "#!/bin/sh\nmkdir -p \"$3\"\n";
    /// Stands for a target: it uses processor time until the script stops it.
    const TARGET: &str = "#!/bin/bash
trap 'echo stat::number_of_executed_units: 50; exit 0' USR1
printf '#10\\tINITED cov: 1 ft: 1 corp: 1\\n'
while :; do :; done
";
    const FAILING: &str = "#!/bin/bash
for option in \"$@\"; do case $option in -artifact_prefix=*) printf bad >\"${option#*=}crash\" ;; esac; done
exit 77
";

    fn program(path: &Path, text: &str) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }

    #[test]
    fn shards_of_a_fuzzing_campaign_run_each_target_once() {
        let folder = folder("fuzzing");
        let (tree, results) = (folder.join("tree"), folder.join("results"));
        program(&tree.join("fuzz/run"), &std::fs::read_to_string(root().join("fuzz/run")).unwrap());
        program(&folder.join("tools/cargo"), CARGO);
        program(&folder.join("tools/rustc"), RUSTC);
        program(&tree.join("target/debug/examples/corpus"), CORPUS);
        for (name, text) in [("a", TARGET), ("b", TARGET), ("c", FAILING), ("d", TARGET)] {
            program(&tree.join("target/here/release").join(name), text);
        }
        let path = format!("{}:{}", folder.join("tools").display(), std::env::var("PATH").unwrap());
        for (shard, code) in [("1/3", 0), ("2/3", 0), ("3/3", 1)] {
            let file = results.join(shard.replace('/', "-of-")).with_extension("tsv");
            let mut command = Command::new(tree.join("fuzz/run"));
            command.args(["1", "--shard", shard, "--revision", "here", "--results"]).arg(file);
            let ran = command.env("PATH", &path).env("JOBS", "1").env_remove("CARGO_TARGET_DIR").output();
            let ran = ran.unwrap();
            assert_eq!(ran.status.code(), Some(code), "{shard}: {}", String::from_utf8_lossy(&ran.stderr));
        }
        let merged = merged(&results);
        let items: Vec<_> = merged.rows.iter().map(|row| row.item.as_str()).collect();
        assert_eq!(items, ["c", "a", "b", "d"]);
        // The bytes of the input, and the file on the machine that found it.
        let failed = &merged.rows[0];
        assert!(failed.detail.ends_with("fuzz/artifacts/c/crash is in base64: YmFk"), "{failed:?}");
        assert!(failed.again.ends_with("--example replay -- c fuzz/artifacts/c/crash"), "{failed:?}");
        assert_eq!(merged.totals["executions"], 3 * 40);
    }
}
