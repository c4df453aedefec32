//! The command-line program of the studies.

use clap::Parser;
use keepout_studies::command::StudyArguments;

fn main() -> std::process::ExitCode {
    match StudyArguments::parse().execute() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("keepout-studies: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
