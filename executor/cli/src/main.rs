//! The program `keepout`: machines a part by hand, straight from its drawing.

mod align;
mod arguments;
mod at_port;
mod before;
mod conformance;
mod demo;
mod depth;
mod display;
mod doctor;
#[cfg(all(test, unix))]
mod documents;
mod drive_tools;
mod drives;
mod error;
mod examine;
mod input;
mod job;
mod new_machine;
mod operator_setup;
mod outputs;
#[cfg(unix)]
mod panel;
mod plan;
mod replay;
mod report;
mod resume;
mod run;
mod run_arguments;
mod screen;
mod shell;
mod shown_unit;
#[cfg(unix)]
mod simulate;
mod store;
mod take;
mod taken;
mod touch_places;
mod values;
mod view;

use std::process::ExitCode;

use arguments::{
    AlignArguments, Arguments, CertifyTime, CliCommand, DrawingArguments, Extra, InspectArguments,
    PlanArguments, ShowArguments,
};
use clap::Parser;
pub use error::CliError;
use run_arguments::{MachineArgument, RunArguments};
use values::pair;

/// Runs the command.
fn execute(arguments: Arguments) -> Result<ExitCode, CliError> {
    match arguments.command {
        CliCommand::New(arguments) => job::new(&arguments),
        CliCommand::Machine(command) => store::machine(&command),
        CliCommand::Tool(command) => store::tool(&command),
        CliCommand::Inspect(arguments) => plan::inspect(&arguments),
        CliCommand::Align(arguments) => align::align(&arguments),
        CliCommand::Plan(arguments) => plan::plan(&arguments),
        CliCommand::Show(arguments) => plan::show(&arguments),
        CliCommand::Verify { plan, time } => plan::verify(&plan, time),
        CliCommand::Run(arguments) => run::run(&arguments),
        CliCommand::Resume(arguments) => run::resume(&arguments),
        CliCommand::Replay(arguments) => replay::replay(&arguments),
        CliCommand::Report(arguments) => report::report(&arguments),
        CliCommand::Doctor(arguments) => doctor::doctor(&arguments),
        #[cfg(unix)]
        CliCommand::Panel(arguments) => panel::panel(&arguments),
        CliCommand::Drives(command) => drives::drives(&command),
        #[cfg(unix)]
        CliCommand::Simulate(arguments) => simulate::simulate(&arguments),
        CliCommand::Completions { shell } => shell::completions(shell),
        CliCommand::Man { output } => shell::man(&output),
        CliCommand::Demo { output, jog_s } => demo::demo(&output, jog_s),
    }
}

/// Ends the program quietly when the reader of its output has gone, as in `keepout inspect … | head`.
fn end_at_closed_pipe() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let text = panic.payload().downcast_ref::<String>().map_or("", String::as_str);
        if text.starts_with("failed printing to std") {
            input::terminal::restore();
            if text.contains("Broken pipe") {
                std::process::exit(0);
            }
            // Any other failure, such as a full disk or a closed terminal, is no success.
            let reason = text.split_once(": ").map_or(text, |(_, reason)| reason);
            let _ = std::io::Write::write_fmt(
                &mut std::io::stderr(),
                format_args!("keepout: cannot write the output: {reason}\n"),
            );
            std::process::exit(7);
        }
        before(panic);
    }));
}

fn main() -> ExitCode {
    end_at_closed_pipe();
    match execute(Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("keepout: {error}\n"));
            error.exit_code()
        }
    }
}
