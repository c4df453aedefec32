//! The commands `doctor --conformance` and `doctor --compare`.

use std::io::{BufRead as _, IsTerminal, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use keepout_executor::dialect::DialectName;
use keepout_executor::session::RealClock;
use keepout_executor::session::serial::Serial;
use keepout_planner::machine::{ControllerProfile, MACHINE_PROFILE, MachineProfile};
use keepout_planner::text_file;
use keepout_sim::Quirks;
use keepout_sim::conformance::{
    Bench, Care, Findings, RecordError, Recording, Scenario, ScenarioRecorder, Setup, SimulatedBench, Start,
    compare, load, save, scenarios, simulate, table,
};
use toml_edit::{DocumentMut, Item, TomlError};

use super::CliError;
use super::plan::{given, refuse_same};

/// Options of `doctor` that move the machine or compare recordings.
#[derive(Debug, Args)]
pub struct ConformanceArguments {
    /// Move the raised tool in a small box, record the controller's replies, and compare them with the
    /// simulated controller. For grbl and grblhal. Sends no hold and no cancel, because the firmware can run
    /// away at either.
    #[arg(long, requires = "machine_profile")]
    pub conformance: bool,
    /// Side of the box, mm.
    #[arg(long, value_name = "MM", default_value = "20", value_parser = side, requires = "conformance")]
    box_mm: f64,
    /// Home first, then move to the nearest place where the box lies in the travel.
    #[arg(long, requires = "conformance")]
    home: bool,
    /// Begin without a question. State that the tool is raised and the box is free.
    #[arg(long, requires = "conformance")]
    yes: bool,
    /// Play only the scenarios whose names begin with NAME. Can be repeated.
    #[arg(long, value_name = "NAME", requires = "conformance")]
    only: Vec<String>,
    /// Store the recording in this file.
    #[arg(long, value_name = "FILE", requires = "conformance")]
    record: Option<PathBuf>,
    /// Store the findings in the machine profile, as its `controller` table.
    #[arg(long, requires = "conformance")]
    store: bool,
    /// Compare two recordings.
    #[arg(long, num_args = 2, value_names = ["FILE", "FILE"], conflicts_with = "conformance")]
    pub compare: Option<Vec<PathBuf>>,
}

/// Most differences that are printed after a recording.
const ROWS: usize = 40;
/// Longest answer that is read from the terminal, bytes.
const ANSWER_MAX: u64 = 64;

/// Parses the side of the box, mm.
fn side(text: &str) -> Result<f64, String> {
    let wrong = || format!("\"{text}\" is not a side between 5 and 200 mm");
    text.parse().ok().filter(|side| (5.0..=200.0).contains(side)).ok_or_else(wrong)
}

/// Compares two recordings.
pub fn compare_files(files: &[PathBuf]) -> Result<ExitCode, CliError> {
    let [first, second] = files else {
        return Err(CliError::Argument("--compare takes two recordings".into()));
    };
    print_differences(&load(first)?, &load(second)?, ["first", "second"], usize::MAX);
    Ok(ExitCode::SUCCESS)
}

/// A machine at its port.
pub struct AtPort<'a> {
    /// The port.
    pub port: &'a mut Serial,
    /// Its baud rate.
    pub baud: u32,
    /// The clock.
    pub clock: &'a mut RealClock,
    /// The dialect.
    pub dialect_name: DialectName,
    /// The machine with the controller's own figures.
    pub machine: MachineProfile,
    /// The profile's file.
    pub profile: &'a Path,
}

/// Records the harmless scenarios. Prints the findings and the differences from the simulated controller.
pub fn conformance(at: AtPort<'_>, arguments: &ConformanceArguments) -> Result<ExitCode, CliError> {
    let profile = at.profile.to_path_buf();
    refuse_same(&[at.profile], &given(&[arguments.record.as_ref()]))?;
    let start = if arguments.home { Start::Homed } else { Start::Standing };
    let setup =
        Setup { box_mm: arguments.box_mm, start, ..Setup::of(at.dialect_name.clone(), at.machine.clone()) };
    announce(&setup);
    if !arguments.yes && !confirmed()? {
        return Err(CliError::Argument("the answer was not yes, so the machine did not move".into()));
    }
    let bench = Bench { port: at.port, clock: at.clock, tool: |_, _| {} };
    let mut recorder = ScenarioRecorder::begin(bench, setup.clone())?;
    let (chosen, origin) = (choose(&setup, recorder.blocks(), &arguments.only)?, recorder.origin());
    let played = play(&mut recorder, &chosen);
    let recording = recorder.finish();
    if let Some(path) = &arguments.record {
        save(&recording, path)?;
        println!("recorded     {}", path.display());
    }
    played?;
    let found = Findings::of(&recording);
    println!("\n{found}");
    let model =
        simulate(&SimulatedBench { setup, at: origin, baud: at.baud, quirks: Quirks::default() }, &chosen)?;
    print_differences(&recording, &model, ["machine", "simulated"], ROWS);
    if arguments.store {
        store(&profile, &found.profile())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn announce(setup: &Setup) {
    println!("\nConformance: the tool moves.");
    if setup.start == Start::Homed {
        println!(
            "- The machine homes. Then the tool moves to the nearest place where the box lies in the travel."
        );
    }
    let side = setup.box_mm;
    println!("- All targets lie in the plane, in a box of {side} × {side} mm around the tool.");
    let count = scenarios(&setup.frame(1)).iter().filter(|each| each.care == Care::Harmless).count();
    println!("- There are {count} scenarios. They take a few minutes, and longer on a slow machine.");
    println!("- Raise the tool and stop the spindle. Keep the emergency stop at hand.");
    println!("- The test does not change the controller's settings, and does not reset it.\n");
}

/// Whether a person at the terminal types yes.
fn confirmed() -> Result<bool, CliError> {
    if !std::io::stdin().is_terminal() {
        return Err(CliError::Argument(
            "the input is not a terminal, so doctor cannot ask: raise the tool, and give --yes".into(),
        ));
    }
    print!("Type yes when the tool is raised and the box is free: ");
    let _ = std::io::stdout().flush();
    let mut answer = String::new();
    let _ = std::io::stdin().lock().take(ANSWER_MAX).read_line(&mut answer);
    Ok(answer.trim() == "yes")
}

fn choose(setup: &Setup, blocks: u32, only: &[String]) -> Result<Vec<Scenario>, CliError> {
    let wanted = |each: &Scenario| only.is_empty() || only.iter().any(|name| each.name.starts_with(name));
    let all = scenarios(&setup.frame(blocks));
    let chosen: Vec<Scenario> =
        all.into_iter().filter(|each| each.care == Care::Harmless && wanted(each)).collect();
    if chosen.is_empty() {
        return Err(CliError::Argument(format!("no harmless scenario begins with {}", only.join(", "))));
    }
    Ok(chosen)
}

fn play(
    recorder: &mut ScenarioRecorder<'_, Serial, RealClock>,
    chosen: &[Scenario],
) -> Result<(), RecordError> {
    let hidden = !std::io::stderr().is_terminal();
    let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(chosen.len() as u64) };
    if let Ok(style) = ProgressStyle::with_template("[{bar:20}] {pos}/{len} {elapsed} {msg}") {
        bar.set_style(style);
    }
    let played = chosen.iter().try_for_each(|scenario| {
        bar.set_message(scenario.name.clone());
        bar.inc(1);
        recorder.play(scenario)
    });
    bar.finish_and_clear();
    played
}

fn print_differences(first: &Recording, second: &Recording, names: [&str; 2], rows: usize) {
    let differences = compare(first, second);
    if differences.is_empty() {
        println!("no difference between {} and {}", names[0], names[1]);
        return;
    }
    println!("{} differences between {} and {}", differences.len(), names[0], names[1]);
    print!("{}", shown(&table(&differences, names, rows)));
}

/// The text with control characters replaced, line by line. Replies come from outside.
fn shown(text: &str) -> String {
    text.lines().map(|line| text_file::shown(line) + "\n").collect()
}

/// Writes the findings into the machine profile. The rest of the file does not change.
fn store(path: &Path, controller: &ControllerProfile) -> Result<(), CliError> {
    let wrong = |error: TomlError| CliError::Argument(format!("{}: {error}", path.display()));
    let text = with_controller(&MACHINE_PROFILE.read_text(path)?, controller).map_err(wrong)?;
    MachineProfile::parse(path, &text)?;
    MACHINE_PROFILE.write(path, text.as_bytes())?;
    println!("stored       {}: make your plans again with this profile", path.display());
    Ok(())
}

/// Text of a machine profile with a new `[controller]` table, in the place of the old one. The rest of the text stays
/// as it is, with its comments.
///
/// # Errors
/// [`TomlError`] if the text is not TOML.
fn with_controller(text: &str, controller: &ControllerProfile) -> Result<String, TomlError> {
    let mut profile: DocumentMut = text.parse()?;
    let figures = toml::to_string(controller).expect("numbers and texts are TOML");
    let mut table = figures.parse::<DocumentMut>()?.as_table().clone();
    match profile.get("controller").and_then(Item::as_table) {
        Some(old) => {
            table.set_position(old.position());
            *table.decor_mut() = old.decor().clone();
        }
        None => {
            table.set_position(None);
            table.decor_mut().set_prefix("\n");
        }
    }
    profile.insert("controller", Item::Table(table));
    Ok(profile.to_string())
}

#[cfg(test)]
mod tests {
    use keepout_planner::machine::ZProfile;

    use super::*;

    fn read(text: &str) -> MachineProfile {
        MachineProfile::parse(Path::new("any.toml"), text).unwrap()
    }

    #[test]
    fn controller_table_is_replaced_and_the_rest_is_kept() {
        let text = format!("# my mill\n{}", MachineProfile::simulated().to_toml());
        let first = ControllerProfile { keeps_path_on_cancel: Some(true), ..ControllerProfile::default() };
        let second = ControllerProfile {
            firmware: "1.1h \"x\"".into(),
            keeps_path_on_cancel: Some(false),
            largest_deviation_mm: Some(0.3),
            planner_blocks: Some(15),
            ..ControllerProfile::default()
        };
        let stored = with_controller(&text, &first).unwrap();
        assert!(stored.starts_with(&format!("{text}\n[controller]\n")), "{stored}");
        let stored = with_controller(&stored, &second).unwrap();
        assert!(stored.starts_with(&text) && stored.matches("[controller]").count() == 1, "{stored}");
        assert_eq!(read(&stored), MachineProfile { controller: Some(second), ..MachineProfile::simulated() });
    }

    /// Found by a reader: a `[z]` table after `[controller]` was lost, and the machine had two axes.
    #[test]
    fn tables_after_the_controller_are_kept() {
        let plain = MachineProfile::simulated();
        let mut after = String::from("# measured in May\n[z] # the quill\n");
        after += &toml::to_string(&ZProfile::simulated()).unwrap();
        let old = "\n# by doctor\n[controller] # old\nplanner_blocks = 15\n\n";
        let text = format!("{}{old}{after}# the end\n", plain.to_toml());
        let figures = ControllerProfile { planner_blocks: Some(35), ..ControllerProfile::default() };
        let stored = with_controller(&text, &figures).unwrap();
        assert_eq!(
            read(&stored),
            MachineProfile { controller: Some(figures.clone()), ..MachineProfile::simulated_three_axes() }
        );
        assert!(
            stored.contains("# by doctor\n[controller] # old\n") && stored.ends_with("# the end\n"),
            "{stored}"
        );
        assert!(stored.contains(&after), "{stored}");
        // Other ways to write the table.
        for old in ["controller = { planner_blocks = 15 }\n", "controller.planner_blocks = 15\n"] {
            let stored = with_controller(&format!("{old}{}\n{after}", plain.to_toml()), &figures).unwrap();
            let kept = MachineProfile {
                controller: Some(figures.clone()),
                ..MachineProfile::simulated_three_axes()
            };
            assert_eq!(read(&stored), kept, "{stored}");
        }
    }
}
