//! A job is a folder: `job.toml`, the drawing, the plan, the alignment, the logs and the reports.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::SystemTime;

use clap::{Args, ValueEnum};
use keepout_executor::session::log::rfc_3339;
use keepout_planner::Mm2;
use keepout_planner::file::{FileKind, OUTPUT};
use keepout_planner::text_file;
use serde::Deserialize;

use super::arguments::{CutArgument, SideArgument, StrokeArgument};
use super::depth::DepthArguments;
use super::run_arguments::JobReport;
use super::shown_unit::ShownUnit;
use super::store::{SIMULATED, StoredMachine, StoredTool};
use super::values::{length, pass};
use super::{CliError, DrawingArguments, MachineArgument, PlanArguments, RunArguments};

static JOB: FileKind =
    FileKind { unreadable: "Make a job with `keepout new DRAWING`.", ..FileKind::new("job file") };

/// The settings of a job.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JobFile {
    /// The drawing, in the job's folder.
    pub drawing: String,
    /// Title block of the report.
    pub title: TitleBlock,
    /// The machine's stored name.
    pub machine: String,
    /// The tool: a stored name, or a diameter such as `6` or `1/4in`.
    pub tool: String,
    pub side: Option<SideArgument>,
    pub cut: Option<CutArgument>,
    pub stock_to_leave_mm: Option<f64>,
    pub feed_mm_min: Option<u32>,
    pub passes: Vec<String>,
    pub units: Option<String>,
    pub scale: Option<f64>,
    pub join_mm: Option<f64>,
    pub layers: Vec<String>,
    pub without_layers: Vec<String>,
    pub line_types: Vec<String>,
    pub without_line_types: Vec<String>,
    pub stroke: Option<StrokeArgument>,
    pub leave_out_open: bool,
    pub keep_out_layers: Vec<String>,
    pub travel_layer: Option<String>,
    pub at: Vec<[f64; 2]>,
    /// The third axis, as the arguments of `keepout plan`.
    pub depth: DepthArguments,
    /// Unit of the lengths on the screen.
    pub display: Option<ShownUnit>,
}

/// Title block of the report: what a customer reads first.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TitleBlock {
    pub part: String,
    pub number: String,
    pub customer: String,
    pub material: String,
    pub remarks: String,
}

impl TitleBlock {
    /// The rows that are filled in.
    pub fn rows(&self) -> Vec<(String, String)> {
        let all = [
            ("part", &self.part),
            ("number", &self.number),
            ("customer", &self.customer),
            ("material", &self.material),
            ("remarks", &self.remarks),
        ];
        let filled = all.into_iter().filter(|(_, value)| !value.is_empty());
        filled.map(|(name, value)| (name.to_string(), text_file::shown(value))).collect()
    }
}

/// A job's folder, with its settings.
#[derive(Clone, Debug)]
pub struct JobFolder {
    pub folder: PathBuf,
    pub file: JobFile,
}

impl JobFolder {
    /// The job at a path; `None` if the path is no folder.
    pub fn at(path: &Path) -> Result<Option<Self>, CliError> {
        if !path.is_dir() {
            return Ok(None);
        }
        let place = path.join("job.toml");
        let file: JobFile = toml::from_str(&JOB.read_text(&place)?).map_err(|error| {
            CliError::Argument(format!(
                "{}: {}. Correct the file.",
                place.display(),
                text_file::reason(&error)
            ))
        })?;
        if file.drawing.is_empty() || Path::new(&file.drawing).components().count() != 1 {
            let reason = format!("{}: drawing must name a file of the job's folder", place.display());
            return Err(CliError::Argument(reason));
        }
        Ok(Some(Self { folder: path.to_path_buf(), file }))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    pub fn drawing(&self) -> PathBuf {
        self.path(&self.file.drawing)
    }

    pub fn plan(&self) -> PathBuf {
        self.path("part.plan")
    }

    pub fn alignment(&self) -> PathBuf {
        self.path("alignment.toml")
    }

    /// The machine of the job.
    pub fn machine(&self) -> Result<StoredMachine, CliError> {
        StoredMachine::named(if self.file.machine.is_empty() { SIMULATED } else { &self.file.machine })
    }

    /// Diameter of the job's tool, mm.
    pub fn tool_mm(&self) -> Result<f64, CliError> {
        let tool = &self.file.tool;
        if tool.is_empty() {
            let reason = format!("{}: name a tool, or give its diameter", self.path("job.toml").display());
            return Err(CliError::Argument(reason));
        }
        length(tool).or_else(|_| Ok(StoredTool::named(tool)?.diameter_mm))
    }

    /// The logs of the job, the last one last.
    pub fn logs(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.path("logs")).into_iter().flatten().flatten();
        let mut logs: Vec<PathBuf> = entries
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|end| end == "log"))
            .collect();
        logs.sort();
        logs
    }

    /// The last log.
    pub fn last_log(&self) -> Result<PathBuf, CliError> {
        self.logs().pop().ok_or_else(|| {
            let reason = format!("{} has no log yet: run the job first", self.folder.display());
            CliError::Argument(reason)
        })
    }

    /// The drawing arguments, where the command line gives no others.
    pub fn drawing_arguments(&self, given: &DrawingArguments) -> DrawingArguments {
        let file = &self.file;
        DrawingArguments {
            drawing: self.drawing(),
            layer: given_or(&given.layer, &file.layers),
            without_layer: given_or(&given.without_layer, &file.without_layers),
            units: given.units.clone().or_else(|| file.units.clone()),
            scale: given.scale.or(file.scale),
            join_mm: given.join_mm.or(file.join_mm),
            line_type: given_or(&given.line_type, &file.line_types),
            without_line_type: given_or(&given.without_line_type, &file.without_line_types),
            ..given.clone()
        }
    }

    /// The arguments of a plan, where the command line gives no others.
    pub fn plan_arguments(&self, given: &PlanArguments) -> Result<PlanArguments, CliError> {
        let file = &self.file;
        let passes: Result<Vec<_>, String> = file.passes.iter().map(|text| pass(text)).collect();
        let passes = passes.map_err(|reason| {
            CliError::Argument(format!("{}: passes: {reason}", self.path("job.toml").display()))
        })?;
        let alignment =
            given.alignment.clone().or_else(|| Some(self.alignment()).filter(|path| path.is_file()));
        let at: Vec<Mm2> = file.at.iter().map(|&[x, y]| Mm2::new(x, y)).collect();
        Ok(PlanArguments {
            drawing: self.drawing_arguments(&given.drawing),
            alignment,
            tool_diameter: Some(given.tool_diameter.map_or_else(|| self.tool_mm(), Ok)?),
            side: given.side.or(file.side),
            stock_to_leave_mm: given.stock_to_leave_mm.or(file.stock_to_leave_mm),
            at: given_or(&given.at, &at),
            leave_out_open: given.leave_out_open || file.leave_out_open,
            stroke: given.stroke.or(file.stroke),
            keep_out_layer: given_or(&given.keep_out_layer, &file.keep_out_layers),
            travel_layer: given.travel_layer.clone().or_else(|| file.travel_layer.clone()),
            pass: given_or(&given.pass, &passes),
            cut: given.cut.or(file.cut),
            depth: given.depth.or(&file.depth),
            machine: given
                .machine
                .clone()
                .or_else(|| Some(file.machine.clone()).filter(|name| !name.is_empty())),
            output: Some(given.output.clone().unwrap_or_else(|| self.plan())),
            ..given.clone()
        })
    }

    /// The arguments of a run, where the command line gives no others.
    pub fn run_arguments(&self, given: &RunArguments) -> Result<RunArguments, CliError> {
        let machine = self.machine()?;
        // A dry run cuts nothing, so its log must not be resumed or reported.
        let logs = self.path(if given.dry_run { "dry-runs" } else { "logs" });
        std::fs::create_dir_all(&logs).map_err(OUTPUT.write_error(&logs))?;
        let date: String =
            rfc_3339(SystemTime::now()).chars().map(|c| if c == ':' { '-' } else { c }).collect();
        let log = free_name(&logs, date.trim_end_matches('Z'));
        let simulated = machine.port.is_empty() && given.port.is_none();
        let virtual_time = given.machine == MachineArgument::SimFast;
        let alignment = self.alignment();
        let placed = given.origin_mm.is_some() || given.alignment.is_some() || !alignment.is_file();
        Ok(RunArguments {
            plan: self.plan(),
            port: given.port.clone().or_else(|| Some(machine.port.clone()).filter(|port| !port.is_empty())),
            dialect: given.dialect.clone().or(Some(machine.dialect)),
            baud: given.baud.or(Some(machine.baud)),
            alignment: if placed { given.alignment.clone() } else { Some(alignment) },
            operator: given.operator.clone().or_else(|| {
                let by_hand = !(simulated && virtual_time);
                by_hand.then(|| machine.operator.clone())
            }),
            view: given.view || !virtual_time,
            display: given.display.or(self.file.display),
            feed_mm_min: given.feed_mm_min.or(self.file.feed_mm_min),
            log: Some(given.log.clone().unwrap_or(log)),
            job_report: Some(JobReport {
                path: (!given.dry_run).then(|| self.path("report.html")),
                title: self.file.title.rows(),
            }),
            ..given.clone()
        })
    }
}

/// Renames a file before another takes its place, so that no earlier one is lost: `part.plan` becomes
/// `part.1.plan`.
pub fn keep_earlier(path: &Path) -> Result<(), CliError> {
    if !path.exists() {
        return Ok(());
    }
    let (stem, ending) = (path.file_stem().unwrap_or_default(), path.extension().unwrap_or_default());
    let (stem, ending) = (stem.to_string_lossy(), ending.to_string_lossy());
    let earlier = (1..10_000)
        .map(|number: u32| path.with_file_name(format!("{stem}.{number}.{ending}")))
        .find(|earlier| !earlier.exists());
    let Some(earlier) = earlier else { return Ok(()) };
    std::fs::rename(path, &earlier).map_err(OUTPUT.write_error(&earlier))?;
    println!("{:<36} {}", "kept the earlier one as", earlier.display());
    Ok(())
}

/// The values of the command line, or without any those of the job.
fn given_or<T: Clone>(given: &[T], own: &[T]) -> Vec<T> {
    if given.is_empty() { own.to_vec() } else { given.to_vec() }
}

/// A log's name that no file has.
fn free_name(folder: &Path, date: &str) -> PathBuf {
    let name = |number: u32| if number == 0 { format!("{date}.log") } else { format!("{date}-{number}.log") };
    let free = (0..10_000).map(|number| folder.join(name(number))).find(|path| !path.exists());
    free.unwrap_or_else(|| folder.join("last.log"))
}

#[derive(Debug, Args)]
pub struct NewArguments {
    /// The drawing: a DXF file. The job gets a copy of it.
    drawing: PathBuf,
    /// The job's folder. Without it, the drawing's name gives the folder's name.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// The machine's stored name; see `keepout machine`. Without it, the job is for the simulated machine.
    #[arg(long, value_name = "NAME", default_value = SIMULATED)]
    machine: String,
    /// The tool: a stored name (see `keepout tool`), or a diameter such as 6 or 1/4in.
    #[arg(long, value_name = "TOOL", default_value = "6")]
    tool: String,
    /// Machined side of the contour.
    #[arg(long, value_enum, default_value = "outside")]
    side: SideArgument,
}

/// Makes a job of a drawing.
pub fn new(arguments: &NewArguments) -> Result<ExitCode, CliError> {
    let NewArguments { drawing, output, machine, tool, side } = arguments;
    let bytes = keepout_planner::drawing::read_file(drawing).map_err(CliError::Drawing)?;
    // A name that is not stored is an error now, and not at the machine.
    StoredMachine::named(machine)?;
    if length(tool).is_err() {
        StoredTool::named(tool)?;
    }
    let name = drawing.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = drawing.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = output.clone().unwrap_or_else(|| PathBuf::from(&stem));
    if folder.exists() {
        let reason = format!(
            "{} exists, and nothing in it was changed. Give the job another folder with -o.",
            folder.display()
        );
        return Err(CliError::Argument(reason));
    }
    write_job(&folder, (&name, &bytes), machine, tool, *side)?;
    let shown = folder.display();
    println!("{:<36} {shown}", "job");
    println!("Next:");
    println!("  keepout inspect {shown}      the drawing, its contours and its problems");
    println!("  keepout plan {shown}         the plan; its settings are in {shown}/job.toml");
    println!("  keepout align {shown} --take edges --home      where the part lies on the machine");
    println!("  keepout run {shown} --homed  jog, and cut the contours");
    println!("  keepout report {shown}       the page that goes with the part");
    Ok(ExitCode::SUCCESS)
}

/// Makes a job of a drawing in a new folder, for a tool of 6 mm outside the part.
#[cfg(unix)]
pub fn make(folder: &Path, name: &str, bytes: &[u8], machine: &str) -> Result<(), CliError> {
    write_job(folder, (name, bytes), machine, "6", SideArgument::Outside)
}

/// Writes the folder of a job: the drawing and the settings.
fn write_job(
    folder: &Path,
    (name, bytes): (&str, &[u8]),
    machine: &str,
    tool: &str,
    side: SideArgument,
) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(OUTPUT.write_error(folder))?;
    OUTPUT.write(&folder.join(name), bytes)?;
    let text = |value: &str| toml::Value::String(value.into()).to_string();
    let side = side.to_possible_value().map_or(String::new(), |value| value.get_name().into());
    let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
    let file = TEMPLATE
        .replace("{drawing}", &text(name))
        .replace("{machine}", &text(machine))
        .replace("{tool}", &text(tool))
        .replace("{side}", &text(&side))
        .replace("{part}", &text(&stem));
    Ok(OUTPUT.write(&folder.join("job.toml"), file.as_bytes())?)
}

const TEMPLATE: &str = "\
# A job of Keepout. Every command takes this folder: inspect, plan, align, run, resume, report.
drawing = {drawing}
machine = {machine}        # `keepout machine list` lists the stored machines
tool = {tool}              # a stored tool, or a diameter such as \"6\" or \"1/4in\"
side = {side}              # outside: the part is inside the contour. inside: the part is around it
stock_to_leave_mm = 0.2    # stock that jogging leaves for the finishing cut
feed_mm_min = 900          # feed along contours
cut = \"conventional\"       # or \"climb\"
# display = \"inch\"         # unit of the lengths on the screen
passes = []                # such as [\"0.1:900\", \"0:600\"]: stock that each pass leaves, and its feed

# How the drawing is read.
# units = \"mm\"
# scale = 1.0
# join_mm = 0.01
layers = []                # take only these layers
without_layers = []
line_types = []            # take these line types although they have gaps
without_line_types = []
keep_out_layers = []       # clamps, a vice
# travel_layer = \"TABLE\"
# stroke = \"outer\"         # for outlines that are drawn as strokes with width

# The head of the report.
[title]
part = {part}
number = \"\"
customer = \"\"
material = \"\"
remarks = \"\"
";
