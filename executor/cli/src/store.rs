//! Machines and tools with names, in the user's configuration folder; and the commands `machine` and `tool`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use keepout_planner::contour::short;
use keepout_planner::file::FileKind;
use keepout_planner::machine::MachineProfile;
use keepout_planner::text_file;
use serde::{Deserialize, Serialize};

use super::CliError;
use super::new_machine::{NewMachine, new_machine};
use super::values::length;

static STORED: FileKind = FileKind {
    unreadable: "List the stored names with `keepout machine list` or `keepout tool list`.",
    ..FileKind::new("stored machine or tool")
};
/// Name of the built-in machine.
pub const SIMULATED: &str = "simulated";

/// A machine: its profile, and how to reach it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredMachine {
    /// The serial port. Empty for the simulated machine.
    pub port: String,
    /// The dialect.
    pub dialect: String,
    /// Baud rate of the port.
    pub baud: u32,
    /// The device that jogs: keyboard, gamepad or handwheel.
    pub operator: String,
    /// Its figures.
    pub profile: MachineProfile,
}

/// A tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredTool {
    /// Its diameter, mm.
    pub diameter_mm: f64,
}

/// The folder of stored machines or tools.
fn folder(kind: &str) -> Result<PathBuf, CliError> {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let base = variable("KEEPOUT_CONFIG")
        .or_else(|| variable("XDG_CONFIG_HOME").map(|base| base.join("keepout")))
        .or_else(|| variable("APPDATA").map(|base| base.join("keepout")))
        .or_else(|| variable("HOME").map(|home| home.join(".config/keepout")));
    let base = base.ok_or_else(|| {
        let reason = "there is no home folder: name the folder of machines and tools in KEEPOUT_CONFIG";
        CliError::Argument(reason.into())
    })?;
    Ok(base.join(kind))
}

/// The file of a name. A name is no path.
pub(super) fn path_of(kind: &str, name: &str) -> Result<PathBuf, CliError> {
    let plain = |c: char| c.is_alphanumeric() || " -_.,+()ø".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
        let reason = format!(
            "\"{}\" is not a valid name: use letters, digits, spaces and - _ . , + ( )",
            text_file::shown(name)
        );
        return Err(CliError::Argument(reason));
    }
    Ok(folder(kind)?.join(format!("{name}.toml")))
}

fn names(kind: &str) -> Result<Vec<String>, CliError> {
    let entries = std::fs::read_dir(folder(kind)?).into_iter().flatten().flatten();
    let stem =
        |path: PathBuf| path.extension().is_some_and(|end| end == "toml").then(|| path.with_extension(""));
    let mut names: Vec<String> = entries
        .filter_map(|entry| Some(stem(entry.path())?.file_name()?.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    Ok(names)
}

/// The names of all machines, the simulated one first.
#[cfg(unix)]
pub fn machine_names() -> Vec<String> {
    let stored = names("machine").unwrap_or_default();
    std::iter::once(SIMULATED.to_string()).chain(stored).collect()
}

/// The file of a name that is stored.
fn known(kind: &str, name: &str) -> Result<PathBuf, CliError> {
    let path = path_of(kind, name)?;
    if path.is_file() {
        return Ok(path);
    }
    let known = names(kind)?;
    let known =
        if known.is_empty() { "none is stored yet".into() } else { format!("stored: {}", known.join(", ")) };
    Err(CliError::Argument(format!(
        "there is no {kind} \"{name}\" ({known}). Make one with `keepout {kind} new`."
    )))
}

/// Removes a stored machine or tool.
fn remove(kind: &str, name: &str) -> Result<(), CliError> {
    let path = known(kind, name)?;
    std::fs::remove_file(&path).map_err(STORED.write_error(&path))?;
    println!("{:<36} {}", "removed", path.display());
    Ok(())
}

fn read<T: for<'a> Deserialize<'a>>(kind: &str, name: &str) -> Result<T, CliError> {
    let path = known(kind, name)?;
    toml::from_str(&STORED.read_text(&path)?).map_err(|error| {
        let reason = text_file::reason(&error);
        CliError::Argument(format!("{} is no {kind}: {reason}. Correct the file.", path.display()))
    })
}

pub(super) fn write<T: Serialize>(
    kind: &str,
    name: &str,
    value: &T,
    overwrite: bool,
) -> Result<PathBuf, CliError> {
    let path = path_of(kind, name)?;
    if path.exists() && !overwrite {
        let reason = format!("the {kind} \"{name}\" exists. Choose another name, or give --overwrite.");
        return Err(CliError::Argument(reason));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(STORED.write_error(&path))?;
    let text =
        toml::to_string(value).map_err(|error| CliError::Argument(format!("cannot be stored: {error}")))?;
    STORED.write(&path, text.as_bytes())?;
    Ok(path)
}

impl StoredMachine {
    /// The simulated machine, which is built in.
    pub fn simulated() -> Self {
        Self {
            port: String::new(),
            dialect: "grbl".into(),
            baud: 115_200,
            operator: "keyboard".into(),
            profile: MachineProfile::simulated(),
        }
    }

    /// The machine with this name.
    pub fn named(name: &str) -> Result<Self, CliError> {
        if name == SIMULATED {
            return Ok(Self::simulated());
        }
        let stored: Self = read("machine", name)?;
        Ok(Self { profile: stored.profile.checked()?, ..stored })
    }
}

impl StoredTool {
    /// The tool with this name.
    pub fn named(name: &str) -> Result<Self, CliError> {
        read("tool", name)
    }
}

/// Subcommands of `machine`.
#[derive(Debug, Subcommand)]
pub enum MachineCommand {
    /// Store a machine under a name. The controller states what it knows; you answer what it does not.
    New(NewMachine),
    /// List the stored machines.
    List,
    /// Show a stored machine and its file.
    Show {
        /// Its name.
        name: String,
    },
    /// Remove a stored machine.
    Remove {
        /// Its name.
        name: String,
    },
}

/// Subcommands of `tool`.
#[derive(Debug, Subcommand)]
pub enum ToolCommand {
    /// Store a tool under a name.
    New {
        /// Its name, such as "6 mm end mill".
        name: String,
        /// Its measured diameter: mm, or with a unit, such as 1/4in.
        #[arg(long, value_name = "MM", value_parser = length)]
        diameter: f64,
        /// Replace the tool of this name.
        #[arg(long)]
        overwrite: bool,
    },
    /// List the stored tools.
    List,
    /// Remove a stored tool.
    Remove {
        /// Its name.
        name: String,
    },
}

pub fn machine(command: &MachineCommand) -> Result<ExitCode, CliError> {
    match command {
        MachineCommand::New(arguments) => return new_machine(arguments),
        MachineCommand::List => {
            println!("{SIMULATED:<24} built in");
            for name in names("machine")? {
                let StoredMachine { port, dialect, baud, operator, .. } = StoredMachine::named(&name)?;
                println!("{name:<24} {dialect} at {port}, {baud} baud, jogged by {operator}");
            }
        }
        MachineCommand::Show { name } => {
            let stored = StoredMachine::named(name)?;
            if name != SIMULATED {
                println!("# {}", path_of("machine", name)?.display());
            }
            print!("{}", toml::to_string(&stored).unwrap_or_default());
        }
        MachineCommand::Remove { name } if name == SIMULATED => {
            return Err(CliError::Argument("\"simulated\" is built in and stays.".into()));
        }
        MachineCommand::Remove { name } => remove("machine", name)?,
    }
    Ok(ExitCode::SUCCESS)
}

pub fn tool(command: &ToolCommand) -> Result<ExitCode, CliError> {
    match command {
        ToolCommand::New { name, diameter, overwrite } => {
            if !(0.001..=500.0).contains(diameter) {
                let reason = format!("--diameter {diameter} must be between 0.001 and 500 mm");
                return Err(CliError::Argument(reason));
            }
            let path = write("tool", name, &StoredTool { diameter_mm: *diameter }, *overwrite)?;
            println!("{:<36} {}", format!("tool \"{name}\", Ø {} mm", short(*diameter)), path.display());
        }
        ToolCommand::List => {
            for name in names("tool")? {
                println!("{name:<24} Ø {} mm", short(StoredTool::named(&name)?.diameter_mm));
            }
        }
        ToolCommand::Remove { name } => remove("tool", name)?,
    }
    Ok(ExitCode::SUCCESS)
}
