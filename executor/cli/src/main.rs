//! `keepout`: machine a part by hand, straight from its drawing.

mod align;
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
mod view;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};
pub use error::CliError;
use keepout_planner::align::{PROBE_ERROR_MM, ProbePoint, TOLERANCE_MM};
use keepout_planner::job::LoopNumber;
use keepout_planner::plan::{Cut, FEEDS_MM_MIN, PassParameters};
use keepout_planner::profile::MachinedSide;

/// Machine a part by hand, straight from its drawing: the computer keeps the tool out of the part, whatever you do,
/// and then cuts the finishing contour by itself.
#[derive(Debug, Parser)]
#[command(version, after_help = EXIT_CODES)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done · 2 wrong arguments · 3 the drawing can not be used · 4 no plan can be made \
(tool, margin, contours) · 5 a plan or log is damaged, or does not hold when it is proved again · 6 port, controller or machine fault · 7 a file \
can not be written · 8 the witness saw the tool in the part · 9 the run ended before the contour was finished";

#[derive(Debug, Subcommand)]
enum Command {
    /// Say what was understood of a DXF drawing: layers, contours, repairs, problems; and draw it.
    Inspect(InspectArguments),
    /// Find how the workpiece lies on the machine, from points or edges of it that were touched.
    Align(AlignArguments),
    /// Make a plan from a DXF drawing: what is kept out of, and the finishing path.
    Plan(PlanArguments),
    /// Draw a plan as an SVG picture.
    Show(ShowArguments),
    /// Prove a plan again from nothing but its own data.
    Verify {
        /// The plan.
        plan: PathBuf,
        #[command(flatten)]
        time: CertifyTime,
    },
    /// Steer the machine by hand around the part, then let it cut the contour.
    Run(RunArguments),
    /// Play the log of a run again: certify every command that was sent once more, and draw the run.
    Replay(replay::ReplayArguments),
    /// Make the page that is kept with the part from the log of its run.
    Report(report::ReportArguments),
    /// Look at a controller before anything is entrusted to it: who it is, how it is set up, how quickly it answers.
    Doctor(doctor::DoctorArguments),
    /// Feed drives: work out the contour-error term of the margin.
    #[command(subcommand)]
    Drives(drives::DrivesCommand),
    /// A simulated machine behind a pty, as a program of its own: for trying out hosts and programs around this one.
    #[cfg(unix)]
    Simulate(simulate::SimulateArguments),
    /// The whole job on the built-in drawing and the simulated machine, with a report to look at.
    Demo {
        /// Where the plan, the pictures and the report go.
        #[arg(short, long, default_value = "keepout-demo")]
        output: PathBuf,
        /// How long the operator pushes at the wall, seconds of machine time.
        #[arg(long, default_value_t = 60.0)]
        jog_s: f64,
    },
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SideArgument {
    /// The tool works outside the contour; the part is inside it.
    Outside,
    /// The tool works inside the contour; the part is around it.
    Inside,
}

impl From<SideArgument> for MachinedSide {
    fn from(side: SideArgument) -> Self {
        match side {
            SideArgument::Outside => Self::Outside,
            SideArgument::Inside => Self::Inside,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum CutArgument {
    /// Part on the left of the path: the cutter does not pull itself in where a drive has play.
    Conventional,
    /// Part on the right of the path, for drives without play.
    Climb,
}

impl From<CutArgument> for Cut {
    fn from(cut: CutArgument) -> Self {
        match cut {
            CutArgument::Conventional => Self::Conventional,
            CutArgument::Climb => Self::Climb,
        }
    }
}

/// Entities that bound contours only when asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Extra {
    /// The boundaries of hatches.
    Hatch,
    /// The outlines of solids and traces.
    Solid,
}

/// What is taken of a drawing.
#[derive(Debug, Args)]
struct DrawingArguments {
    /// The drawing: a DXF file, ASCII or binary.
    drawing: PathBuf,
    /// Only these layers of the drawing; may be given more than once.
    #[arg(long, value_name = "NAME")]
    layer: Vec<String>,
    /// Not these layers; may be given more than once.
    #[arg(long, value_name = "NAME")]
    without_layer: Vec<String>,
    /// The drawing's unit, when the file states none or a wrong one: mm, cm, m, in, ft.
    #[arg(long, value_name = "UNIT")]
    units: Option<String>,
    /// Gaps up to this are closed, and listed, mm.
    #[arg(long, value_name = "MM", default_value_t = keepout_planner::drawing::JOIN_MM)]
    join_mm: f64,
    /// Splines and ellipses become arcs and lines within this, mm.
    #[arg(long, value_name = "MM", default_value_t = keepout_planner::drawing::CURVE_MM)]
    curve_mm: f64,
    /// Take lines of this line type though it has gaps; may be given more than once.
    #[arg(long, value_name = "NAME")]
    line_type: Vec<String>,
    /// Take what is no contour of its own, too.
    #[arg(long, value_enum)]
    with: Vec<Extra>,
    /// Turn the drawing about its origin, counter-clockwise: how the workpiece lies on the table.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    rotate_deg: Option<f64>,
    /// Move the drawing, after turning it, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    offset_mm: Option<(f64, f64)>,
    /// Give up after this time, s.
    #[arg(long, value_name = "S", default_value_t = plan::LIMIT_S, value_parser = time)]
    limit_s: f64,
}

/// How long a plan may take to be proved again.
#[derive(Clone, Copy, Debug, Args)]
struct CertifyTime {
    /// Give up when the plan is not proved again after this time, s.
    #[arg(long, value_name = "S", default_value_t = plan::LIMIT_S, value_parser = time)]
    certify_limit_s: f64,
}

#[derive(Debug, Args)]
struct InspectArguments {
    #[command(flatten)]
    drawing: DrawingArguments,
    /// Draw what was understood, with repairs and problems marked.
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct AlignArguments {
    #[command(flatten)]
    drawing: DrawingArguments,
    /// Which side of the contour is machined: edges are touched from there.
    #[arg(long, value_enum, default_value = "outside")]
    side: SideArgument,
    /// A point of the drawing and the machine coordinates of the tool's centre on it, mm. Two or more measure the rotation
    /// too; one alone gives the offset.
    #[arg(long, value_name = "DX,DY=MX,MY", value_parser = align::touch, allow_hyphen_values = true)]
    point: Vec<ProbePoint>,
    /// A place near a straight edge of the drawing, and the machine coordinates of the tool's centre where the tool touched
    /// that edge, mm. Two along one edge and one of another measure the rotation too; one each of two edges give the offset.
    #[arg(long, value_name = "DX,DY=MX,MY", value_parser = align::touch, allow_hyphen_values = true,
        requires = "probe_diameter")]
    edge: Vec<ProbePoint>,
    /// Diameter of the probe or tool that touched the edges, mm.
    #[arg(long, value_name = "MM")]
    probe_diameter: Option<f64>,
    /// How far a touch may be wrong, mm.
    #[arg(long, value_name = "MM", default_value_t = PROBE_ERROR_MM)]
    probe_error_mm: f64,
    /// How far drawing and machine may disagree, mm.
    #[arg(long, value_name = "MM", default_value_t = TOLERANCE_MM)]
    tolerance_mm: f64,
    /// Where the alignment goes, a TOML file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Debug, Args)]
struct PlanArguments {
    #[command(flatten)]
    drawing: DrawingArguments,
    /// Turn the drawing as the workpiece lies: the file that `keepout align` wrote. `run` wants it too.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rotate_deg", "offset_mm"])]
    alignment: Option<PathBuf>,
    /// Diameter of the cutter, mm.
    #[arg(long, value_name = "MM")]
    tool_diameter: f64,
    /// Which side of the contour is machined.
    #[arg(long, value_enum, default_value = "outside")]
    side: SideArgument,
    /// Stock that roughing by hand leaves for the finishing cut, mm.
    #[arg(long, value_name = "MM", default_value_t = 0.2)]
    stock_to_leave_mm: f64,
    /// The whole margin for the machine's errors, mm. Without it the machine profile's figures are used.
    #[arg(long, value_name = "MM")]
    margin_mm: Option<f64>,
    /// Only the smallest contour around this point, and those directly within it; may be given more than once.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    at: Vec<(f64, f64)>,
    /// Only contours of at least this area, mm².
    #[arg(long, value_name = "MM2")]
    min_area_mm2: Option<f64>,
    /// Only contours of at most this area, mm².
    #[arg(long, value_name = "MM2")]
    max_area_mm2: Option<f64>,
    /// Leave out curves that do not close, and list them, instead of refusing the drawing.
    #[arg(long)]
    leave_out_open: bool,
    /// The tool keeps out of what is closed on this layer, too: clamps, a vice. May be given more than once.
    #[arg(long, value_name = "NAME")]
    keep_out_layer: Vec<String>,
    /// This layer holds a rectangle that the tool's centre stays in: the machine's travel.
    #[arg(long, value_name = "NAME")]
    travel_layer: Option<String>,
    /// A finishing pass: the stock it leaves in mm, with its feed in mm/min after a colon. Twice for the double pass,
    /// such as --pass 0.1:900 --pass 0:600. Without any, one pass along the contour itself.
    #[arg(long, value_name = "MM[:F]", value_parser = pass)]
    pass: Vec<PassParameters>,
    /// Which way round the tool cuts, for a cutter that turns clockwise seen from above.
    #[arg(long, value_enum, default_value = "conventional")]
    cut: CutArgument,
    /// The machine's figures, a TOML file. Without it the simulated machine's are used.
    #[arg(long, value_name = "FILE")]
    machine_profile: Option<PathBuf>,
    /// Where the plan goes.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Debug, Args)]
struct ShowArguments {
    /// The plan.
    plan: PathBuf,
    #[command(flatten)]
    time: CertifyTime,
    /// Where the picture goes.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MachineArgument {
    /// The simulated machine behind a pty, in real time.
    Sim,
    /// The simulated machine in virtual time: minutes pass in seconds.
    SimFast,
}

#[derive(Clone, Debug, Args)]
struct RunArguments {
    /// The plan.
    plan: PathBuf,
    #[command(flatten)]
    time: CertifyTime,
    /// The simulated machine's feed drives: a profile as of `drives budget`, or `none` for a tool that is always where it is
    /// commanded to be.
    #[arg(long, default_value = "simulated", value_name = "PROFILE", conflicts_with = "port")]
    drives: String,
    /// A simulated machine to run on.
    #[arg(long, value_enum, default_value = "sim", conflicts_with = "port")]
    machine: MachineArgument,
    /// The serial port of a real machine, such as /dev/ttyUSB0.
    #[arg(long, value_name = "DEVICE", requires = "place")]
    port: Option<String>,
    /// What the controller speaks: grbl, grblhal, zaber, venus, or a file that describes its language.
    #[arg(long, value_name = "DIALECT", default_value = "grbl")]
    dialect: String,
    /// Baud rate of the port.
    #[arg(long, default_value_t = 115_200)]
    baud: u32,
    /// Where the drawing's origin lies on the machine, machine coordinates, mm. A real machine does not move without it.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, group = "place")]
    origin_mm: Option<(f64, f64)>,
    /// Where it lies, as the file says that `keepout align` wrote, and that the plan was made with.
    #[arg(long, value_name = "FILE", group = "place")]
    alignment: Option<PathBuf>,
    /// Home the real machine first, tool raised.
    #[arg(long)]
    home: bool,
    /// The real machine was homed since power-up, and no alarm was unlocked by hand since.
    #[arg(long, conflicts_with = "home")]
    homed: bool,
    /// Who steers: keyboard; gamepad or gamepad:DEVICE; handwheel or handwheel:DEVICE; a model: calm, jittery, wall, random,
    /// stuck, reversal; a script file; trace:FILE.
    #[arg(long, default_value = "calm")]
    operator: String,
    /// LoggedEvent every change of the operator's input to this new file, to be played by --operator trace:FILE.
    #[arg(long, value_name = "FILE")]
    record_trace: Option<PathBuf>,
    /// Show position, wall and a small plan on the whole terminal. Without a terminal it is left out.
    #[arg(long)]
    view: bool,
    /// Gamepad: radius of the dead zone, share of the throw.
    #[arg(long, value_name = "SHARE", default_value_t = 0.12)]
    dead_zone: f64,
    /// Gamepad: share of the cubic in the stick's response, 0 to 1; the more, the finer near the middle.
    #[arg(long, value_name = "SHARE", default_value_t = 0.5)]
    expo: f64,
    /// How long a modelled operator steers before touching the part, s.
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    jog_s: f64,
    /// Feed of the finishing contour, mm/min.
    #[arg(long, value_name = "F", default_value_t = 900, value_parser = clap::value_parser!(u32).range(i64::from(*FEEDS_MM_MIN.start())..=i64::from(*FEEDS_MM_MIN.end())))]
    feed_mm_min: u32,
    /// Stop when the controller at the port says nothing for so long, s.
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    answer_within_s: f64,
    /// The run is stopped after this time, s.
    #[arg(long, value_name = "S", default_value_t = 3600.0)]
    limit_s: f64,
    /// Simulated machine: added delay each way, ms.
    #[arg(long, value_name = "MS", default_value_t = 1)]
    latency_ms: u64,
    /// Simulated machine: travel in x and y, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair)]
    travel_mm: Option<(f64, f64)>,
    /// Simulated machine: where the tool is let down, drawing coordinates, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    start_mm: Option<(f64, f64)>,
    /// Simulated machine and operator: seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write everything that happens to this file, which must not exist yet.
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Take up what an earlier run left of the contours: the log of that run, which is played again first. This run's own
    /// log is another file.
    #[arg(long, value_name = "LOG")]
    resume: Option<PathBuf>,
    /// With --resume: cut this loop anew, whatever was cut of it. Its number as printed, "LOOP", or "LOOP:PASS" for another
    /// pass than the first; may be given more than once.
    #[arg(long, value_name = "LOOP[:PASS]", value_parser = resume::number, requires = "resume")]
    recut: Vec<LoopNumber>,
    /// With --resume: the workpiece was shifted on the machine since the run that is resumed, not turned, and was measured anew.
    #[arg(long, requires = "resume")]
    moved: bool,
    /// Write a page with picture and table.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the picture of the run.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

/// `X,Y` as two numbers.
fn pair(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("\"{text}\" is not two numbers with a comma between, such as -200,-175");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let number =
        |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
    Ok((number(x)?, number(y)?))
}

/// A time that work may take, s.
fn time(text: &str) -> Result<f64, String> {
    let wrong = || format!("\"{text}\" is no time between 0.001 and 10⁷ s");
    text.parse().ok().filter(|time| (0.001..=1e7).contains(time)).ok_or_else(wrong)
}

/// `ALLOWANCE` or `ALLOWANCE:FEED`.
fn pass(text: &str) -> Result<PassParameters, String> {
    let wrong = || {
        format!("\"{text}\" is no pass: the stock it leaves in mm, and its feed in mm/min, such as 0.1:900")
    };
    let (stock_to_leave, feed) =
        text.split_once(':').map_or((text, None), |(stock_to_leave, feed)| (stock_to_leave, Some(feed)));
    let stock_to_leave_mm = stock_to_leave
        .parse::<f64>()
        .ok()
        .filter(|value| (0.0..=1000.0).contains(value))
        .ok_or_else(wrong)?;
    let feed = feed.map(|feed| feed.parse::<u32>().ok().filter(|feed| FEEDS_MM_MIN.contains(feed)));
    match feed {
        Some(None) => Err(wrong()),
        feed => Ok(PassParameters { stock_to_leave_mm, feed_mm_min: feed.flatten() }),
    }
}

/// Runs the command.
fn execute(arguments: Arguments) -> Result<ExitCode, CliError> {
    match arguments.command {
        Command::Inspect(arguments) => plan::inspect(&arguments),
        Command::Align(arguments) => align::align(&arguments),
        Command::Plan(arguments) => plan::plan(&arguments),
        Command::Show(arguments) => plan::show(&arguments),
        Command::Verify { plan, time } => plan::verify(&plan, time),
        Command::Run(arguments) => run::run(&arguments),
        Command::Replay(arguments) => replay::replay(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Doctor(arguments) => doctor::doctor(&arguments),
        Command::Drives(command) => drives::drives(&command),
        #[cfg(unix)]
        Command::Simulate(arguments) => simulate::simulate(&arguments),
        Command::Demo { output, jog_s } => run::demo(&output, jog_s),
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
