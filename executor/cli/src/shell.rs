//! The commands `completions` and `man`, and the colours of the terminal.

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

use clap::CommandFactory as _;
use keepout_planner::file::OUTPUT;

use super::{Arguments, CliError};

/// Prints the completions for a shell.
pub fn completions(shell: clap_complete::Shell) -> Result<ExitCode, CliError> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "keepout", &mut text);
    print!("{}", String::from_utf8_lossy(&text));
    Ok(ExitCode::SUCCESS)
}

/// Writes the manual pages into a folder.
pub fn man(folder: &Path) -> Result<ExitCode, CliError> {
    let unwritable = || OUTPUT.write_error(folder);
    std::fs::create_dir_all(folder).map_err(unwritable())?;
    clap_mangen::generate_to(Arguments::command(), folder).map_err(unwritable())?;
    println!("{:<36} {}", "manual pages", folder.display());
    Ok(ExitCode::SUCCESS)
}

/// Prints lines. On a terminal, warnings and problems are coloured, unless NO_COLOR is set.
pub fn print_lines(text: &str) {
    let coloured = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    for line in text.lines() {
        let colour =
            ["PROBLEM", "WARNING", "QUESTION", "REMEDY"].iter().position(|word| line.starts_with(word));
        match colour.filter(|_| coloured) {
            Some(0) => println!("\x1b[1;31m{line}\x1b[0m"),
            Some(3) => println!("\x1b[1;36m{line}\x1b[0m"),
            Some(_) => println!("\x1b[1;33m{line}\x1b[0m"),
            None => println!("{line}"),
        }
    }
}
