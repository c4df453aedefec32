//! `keepout`: machine a part by hand, straight from its drawing.

mod cli;

use clap::Parser;

fn main() -> std::process::ExitCode {
    let arguments = cli::Arguments::parse();
    match cli::execute(arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("keepout: {error}");
            error.exit_code()
        }
    }
}
