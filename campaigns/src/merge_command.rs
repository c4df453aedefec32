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
