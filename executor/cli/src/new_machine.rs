//! The command `machine new`: asks the controller what it knows, and a person for what it does not.

use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::session::RealClock;
use keepout_executor::session::serial::Serial;
use keepout_kernel::Vector;
use keepout_planner::Mm2;
use keepout_planner::machine::{ContourErrorSource, ControllerProfile, MachineProfile, ZProfile};
use keepout_planner::text_file;

use super::CliError;
use super::examine::{Examination, examine};
use super::store::{SIMULATED, StoredMachine, path_of, write};
use super::values::{full_path, length, pair};

#[derive(Debug, Args)]
pub struct NewMachine {
    /// Its name, such as mill.
    pub(crate) name: String,
    /// The serial port, such as /dev/ttyUSB0.
    #[arg(long, value_name = "DEVICE")]
    pub(crate) port: String,
    /// Dialect of the controller: grbl, grblhal, zaber, venus, or a file that describes another dialect.
    #[arg(long, value_name = "DIALECT", default_value = "grbl")]
    pub(crate) dialect: String,
    /// Baud rate of the port.
    #[arg(long, default_value_t = 115_200)]
    pub(crate) baud: u32,
    /// The device that jogs: keyboard, gamepad or handwheel.
    #[arg(long)]
    pub(crate) operator: Option<String>,
    /// Travel of x and y, if the controller does not state it, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair)]
    pub(crate) travel_mm: Option<Mm2>,
    /// Half the spread of ten returns to one place by a dial gauge, mm.
    #[arg(long, value_name = "MM", value_parser = length)]
    pub(crate) repeatability_mm: Option<f64>,
    /// Largest distance of the true path from the commanded path in motion, mm.
    #[arg(long, value_name = "MM", value_parser = length)]
    pub(crate) contour_error_mm: Option<f64>,
    /// Keepout moves a third axis, z. Without this option, the program asks a person at a terminal.
    #[arg(long)]
    pub(crate) third_axis: bool,
    /// With a third axis: half the spread of ten returns to one height by a dial gauge, mm.
    #[arg(long, value_name = "MM", value_parser = length)]
    pub(crate) z_repeatability_mm: Option<f64>,
    /// With a third axis: largest distance of the true height from the commanded height in motion, mm.
    #[arg(long, value_name = "MM", value_parser = length)]
    pub(crate) z_following_error_mm: Option<f64>,
    /// Replace the machine of this name.
    #[arg(long)]
    pub(crate) overwrite: bool,
}

/// Examines the controller, asks for the other figures, and stores the machine.
pub fn new_machine(arguments: &NewMachine) -> Result<ExitCode, CliError> {
    let (stored, path) = store(arguments, std::io::stdin().is_terminal())?;
    print!("{}", toml::to_string(&stored).unwrap_or_default());
    println!("\n{:<36} {}", format!("machine \"{}\"", arguments.name), path.display());
    println!(
        "Check every figure. `keepout doctor --machine \"{}\"` tells whether a session can begin.",
        arguments.name
    );
    Ok(ExitCode::SUCCESS)
}

/// Examines the controller and stores the machine. `asks`: a person at the terminal answers what the controller does
/// not.
pub fn store(arguments: &NewMachine, asks: bool) -> Result<(StoredMachine, PathBuf), CliError> {
    // A name that exists is an error before the questions.
    let path = path_of("machine", &arguments.name)?;
    if arguments.name == SIMULATED {
        return Err(CliError::Argument("\"simulated\" is built in. Choose another name.".into()));
    }
    if path.exists() && !arguments.overwrite {
        let reason =
            format!("the machine \"{}\" exists. Choose another name, or give --overwrite.", arguments.name);
        return Err(CliError::Argument(reason));
    }
    let dialect_name =
        DialectName::named(&arguments.dialect).map_err(|error| CliError::Argument(error.to_string()))?;
    let simulated = MachineProfile::simulated();
    let mut dialect = dialect_name.dialect(DialectConfig::of(&simulated, Vector { dx: 0, dy: 0 }));
    let mut port = Serial::open(&arguments.port, arguments.baud)?;
    let needed = (simulated.steps_per_mm, simulated.arc_tolerance_mm);
    let found = examine(&mut port, &mut RealClock::default(), dialect.as_mut(), QUERIES, needed)?;
    drop(port);
    let questions = Questions { asks };
    let z = if dialect_name.has_third_axis() { questions.third_axis(arguments, &found)? } else { None };
    let profile = MachineProfile { z, ..questions.profile_of(arguments, &found, &simulated)? }.checked()?;
    let operator = questions.answer(
        arguments.operator.clone(),
        "Which device jogs: keyboard, gamepad or handwheel",
        "keyboard".into(),
        |text| ["keyboard", "gamepad", "handwheel"].contains(&text).then(|| text.to_string()),
    )?;
    let stored = StoredMachine {
        port: arguments.port.clone(),
        dialect: full_path(&arguments.dialect),
        baud: arguments.baud,
        operator,
        profile,
    };
    let path = write("machine", &arguments.name, &stored, arguments.overwrite)?;
    Ok((stored, path))
}

/// Number of timed queries.
const QUERIES: usize = 30;

/// The questions to a person.
#[derive(Clone, Copy)]
struct Questions {
    /// A person at the terminal answers them. Without one, what is missing is an error.
    asks: bool,
}

impl Questions {
    /// The figures that the controller states, and the answers for the others.
    fn profile_of(
        self,
        arguments: &NewMachine,
        found: &Examination,
        simulated: &MachineProfile,
    ) -> Result<MachineProfile, CliError> {
        let stated = found.inspector.as_ref();
        let travel = stated.and_then(|stated| stated.travel_mm).map(|[x, y]| Mm2::new(x, y));
        let travel = match travel.or(arguments.travel_mm) {
            Some(travel) => travel,
            None => {
                self.answer(None, "Travel of x and y, mm, such as 400,350", Mm2::new(400.0, 350.0), |text| {
                    pair(text).ok()
                })?
            }
        };
        let limit = |value: Option<f64>, question: &str, default: f64| match value
            .filter(|value| value.is_finite() && *value > 0.0)
        {
            Some(value) => Ok(value),
            None => self.answer(None, question, default, positive),
        };
        let limits = stated.map(|stated| stated.limits);
        let repeatability_mm = self.answer(
            arguments.repeatability_mm,
            "Repeatability: half the spread of ten returns to one place by a dial gauge, mm",
            0.01,
            figure,
        )?;
        let contour_error_mm = self.answer(
            arguments.contour_error_mm,
            "Contour error: largest distance of the true path from the commanded one in motion, mm",
            0.05,
            figure,
        )?;
        Ok(MachineProfile {
            name: arguments.name.clone(),
            travel_mm: [travel.x, travel.y],
            max_rate_mm_s: limit(limits.map(|limits| limits.speed_mm_s), "Top speed of an axis, mm/s", 50.0)?,
            acceleration_mm_s2: limit(
                limits.map(|limits| limits.acceleration_mm_s2),
                "Acceleration of an axis, mm/s²",
                200.0,
            )?,
            steps_per_mm: limit(
                stated.and_then(|stated| stated.steps_per_mm),
                "Steps per mm of an axis",
                400.0,
            )?,
            report_digit_mm: stated
                .and_then(|stated| stated.report_digit_mm)
                .unwrap_or(simulated.report_digit_mm),
            arc_tolerance_mm: simulated.arc_tolerance_mm,
            repeatability_mm,
            contour_error_mm,
            z: None,
            spindle_rpm: None,
            contour_error_source: ContourErrorSource::Stated("with keepout machine new".into()),
            controller: Some(ControllerProfile {
                firmware: text_file::shown(
                    &stated.and_then(|stated| stated.firmware.clone()).unwrap_or_default(),
                ),
                report_latency_ms: Some(found.round_trip(50).as_secs_f64() * 1e3),
                ..ControllerProfile::default()
            }),
        })
    }

    /// The third axis, if Keepout moves one.
    fn third_axis(self, arguments: &NewMachine, found: &Examination) -> Result<Option<ZProfile>, CliError> {
        let asked = self.asks && !arguments.third_axis;
        let yes_or_no = |text: &str| ["yes", "no"].contains(&text).then(|| text.to_string());
        let moves = arguments.third_axis
            || asked
                && self.answer(
                    None,
                    "Does Keepout move a third axis, z: yes or no",
                    "no".to_string(),
                    yes_or_no,
                )? == "yes";
        if !moves {
            return Ok(None);
        }
        let stated = found.inspector.as_ref().map(|stated| stated.z).unwrap_or_default();
        let limit = |value: Option<f64>, question: &str, default: f64| {
            self.answer(value, question, default, positive)
        };
        Ok(Some(ZProfile {
        travel_mm: limit(stated.travel_mm, "Travel of z, mm", 100.0)?,
        max_rate_mm_s: limit(stated.max_rate_mm_s, "Top speed of z, mm/s", 10.0)?,
        acceleration_mm_s2: limit(stated.acceleration_mm_s2, "Acceleration of z, mm/s²", 50.0)?,
        steps_per_mm: limit(stated.steps_per_mm, "Steps per mm of z", 400.0)?,
        repeatability_mm: self.answer(
            arguments.z_repeatability_mm,
            "Repeatability of z: half the spread of ten returns to one height by a dial gauge, mm",
            0.01,
            figure,
        )?,
        following_error_mm: self.answer(
            arguments.z_following_error_mm,
            "Following error of z: largest distance of the true height from the commanded one in motion, mm",
            0.05,
            figure,
        )?,
    }))
    }

    /// The given value, or the answer of a person at a terminal. Without a terminal the value must be given.
    fn answer<T: Clone + std::fmt::Debug>(
        self,
        given: Option<T>,
        question: &str,
        default: T,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, CliError> {
        if let Some(value) = given {
            return Ok(value);
        }
        if !self.asks {
            let reason = format!(
                "the controller does not answer this question, and the input is not a terminal: {question}? Give its \
             option; see `keepout machine new --help`."
            );
            return Err(CliError::Argument(reason));
        }
        for _ in 0..5 {
            eprint!("{question} [{}]: ", shown(&default));
            let _ = std::io::stderr().flush();
            let mut text = String::new();
            let _ = std::io::stdin().lock().read_line(&mut text);
            match text.trim() {
                "" => return Ok(default),
                text => match parse(text) {
                    Some(value) => return Ok(value),
                    None => eprintln!("\"{}\" is no answer.", text_file::shown(text)),
                },
            }
        }
        Err(CliError::Argument(format!(
            "no answer to: {question}. Give a value of this form, or press Return for the proposal."
        )))
    }
}

/// A length of at most 10 mm.
fn figure(text: &str) -> Option<f64> {
    length(text).ok().filter(|value| (0.0..=10.0).contains(value))
}

/// A positive number, as speeds and steps are.
fn positive(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|value| (1e-3..=1e6).contains(value))
}

fn shown(value: &impl std::fmt::Debug) -> String {
    format!("{value:?}").replace('"', "").replace("Mm2 { x: ", "").replace(" y: ", "").replace(" }", "")
}
