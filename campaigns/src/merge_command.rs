//! `merge`: adds up the results files of all shards of a campaign.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use keepout_campaigns::{ShardResults, merge, table};

/// Checks that the files hold every shard of one campaign once, and adds them up.
#[derive(Debug, Parser)]
#[command(
    name = "merge",
    version,
    after_help = "Exit codes: 0 every item holds · 1 an item failed · 2 the files do not fit together"
)]
struct Arguments {
    /// The files that --results wrote.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Write the merged results to this file, in the form of the other files.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

fn main() -> ExitCode {
    match merged(&Arguments::parse()) {
        Ok(results) => {
            print!("{}", table(&results));
            ExitCode::from(u8::from(results.has_failed()))
        }
        Err(error) => {
            eprintln!("merge: {error}");
            ExitCode::from(2)
        }
    }
}

fn merged(arguments: &Arguments) -> Result<ShardResults, Box<dyn std::error::Error>> {
    let mut files = Vec::new();
    for path in &arguments.files {
        files.push((path.clone(), ShardResults::read(path)?));
    }
    let results = merge(&files)?;
    if let Some(path) = &arguments.output {
        results.write(path)?;
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;
    use keepout_campaigns::{Campaign, Shard};

    #[test]
    fn damaged_foreign_doubled_and_missing_files_are_refused_and_others_merged() {
        let folder = std::env::temp_dir().join(format!("keepout-merge-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, seed: &str, shard: Shard| {
            let campaign = Campaign {
                program: "hostile".into(),
                revision: "476b5c9".into(),
                arguments: format!("--seed {seed}"),
                data: String::new(),
            };
            let results =
                ShardResults { campaign, shard, totals: [("sessions".into(), 2)].into(), rows: Vec::new() };
            results.write(&folder.join(name)).unwrap();
        };
        for shard in Shard::all(3) {
            write(&format!("{}.tsv", shard.index()), "1", shard);
        }
        write("foreign.tsv", "2", Shard::WHOLE);
        std::fs::write(folder.join("damaged.tsv"), &std::fs::read(folder.join("3.tsv")).unwrap()[..90])
            .unwrap();
        let run = |files: &[&str]| {
            let output = Some(folder.join("merged.tsv"));
            let files = files.iter().map(|name| folder.join(name)).collect();
            merged(&Arguments { files, output }).map_err(|error| error.to_string())
        };
        for (files, reason) in [
            (&["1.tsv", "2.tsv"][..], "there is no file for shard 3/3"),
            (&["1.tsv", "2.tsv", "3.tsv", "2.tsv"], "both hold shard 2/3"),
            (&["1.tsv", "foreign.tsv"], "are not of one campaign"),
            (&["1.tsv", "2.tsv", "damaged.tsv"], "the file is damaged or cut off"),
            (&["none.tsv"], "cannot read the results file"),
        ] {
            let error = run(files).unwrap_err();
            assert!(error.contains(reason), "{error}");
            assert!(!folder.join("merged.tsv").exists(), "{files:?}");
        }
        let merged = run(&["1.tsv", "2.tsv", "3.tsv"]).unwrap();
        assert_eq!(merged.totals["sessions"], 6);
        assert_eq!(ShardResults::read(&folder.join("merged.tsv")).unwrap(), merged);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
