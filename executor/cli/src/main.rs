//! The program `keepout`: machines a part by hand, straight from its drawing.

mod align;
mod arguments;
mod before;
mod conformance;
mod display;
mod doctor;
#[cfg(all(test, unix))]
mod documents;
mod drives;
mod error;
mod examine;
mod input;
mod operator_setup;
mod plan;
mod replay;
mod report;
mod resume;
mod run;
mod screen;
#[cfg(unix)]
mod simulate;
mod values;
mod view;

use std::process::ExitCode;

use arguments::{
    AlignArguments, Arguments, CertifyTime, CliCommand, DrawingArguments, Extra, InspectArguments,
    MachineArgument, PlanArguments, RunArguments, ShowArguments,
};
use clap::Parser;
pub use error::CliError;
use values::pair;

/// Runs the command.
fn execute(arguments: Arguments) -> Result<ExitCode, CliError> {
    match arguments.command {
        CliCommand::Inspect(arguments) => plan::inspect(&arguments),
        CliCommand::Align(arguments) => align::align(&arguments),
        CliCommand::Plan(arguments) => plan::plan(&arguments),
        CliCommand::Show(arguments) => plan::show(&arguments),
        CliCommand::Verify { plan, time } => plan::verify(&plan, time),
        CliCommand::Run(arguments) => run::run(&arguments),
        CliCommand::Replay(arguments) => replay::replay(&arguments),
        CliCommand::Report(arguments) => report::report(&arguments),
        CliCommand::Doctor(arguments) => doctor::doctor(&arguments),
        CliCommand::Drives(command) => drives::drives(&command),
        #[cfg(unix)]
        CliCommand::Simulate(arguments) => simulate::simulate(&arguments),
        CliCommand::Demo { output, jog_s } => run::demo(&output, jog_s),
    }
}

fn main() -> ExitCode {
    match execute(Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("keepout: {error}");
            error.exit_code()
        }
    }
}
