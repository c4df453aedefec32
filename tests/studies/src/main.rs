//! The command-line program of the studies.

use clap::Parser;
use keepout_studies::command::Arguments;

fn main() -> std::process::ExitCode {
    match Arguments::parse().execute() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("keepout-studies: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
