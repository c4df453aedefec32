//! The arguments of the program's commands.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use keepout_planner::Mm2;
use keepout_planner::align::{PROBE_ERROR_MM, ProbePoint, TOLERANCE_MM};
use keepout_planner::plan::{Cut, PassParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::select::InkSide;
use serde::Deserialize;

use crate::depth::DepthArguments;
use crate::run_arguments::RunArguments;
use crate::shown_unit::ShownUnit;
use crate::values::{length, pair, pass, time};

/// Machine a part by hand, straight from its drawing. The computer keeps the tool out of the part, whatever
/// you do. Then it cuts the finishing contour by itself.
#[derive(Debug, Parser)]
#[command(name = "keepout", version, after_help = EXIT_CODES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: CliCommand,
}

const EXIT_CODES: &str = "Exit codes: 0 done · 2 wrong arguments · 3 the drawing cannot be used \
    · 4 no plan can be made (tool, margin, contours) · 5 a plan or log is damaged, or does not hold when it \
    is proved again · 6 port, controller or machine fault · 7 a file cannot be written \
    · 8 the collision monitor saw the tool in the part · 9 the run ended with contours left: incomplete, stopped, or \
    over its time limit";

#[derive(Debug, Subcommand)]
pub(crate) enum CliCommand {
    /// Make a job, a folder, of a drawing. Every later command takes the folder.
    New(crate::job::NewArguments),
    /// Store machines under names.
    #[command(subcommand)]
    Machine(crate::store::MachineCommand),
    /// Store tools under names.
    #[command(subcommand)]
    Tool(crate::store::ToolCommand),
    /// List the layers, contours, repairs and problems of a DXF drawing, and draw them.
    Inspect(InspectArguments),
    /// Find how the workpiece lies on the machine, from probe points or probed edges.
    Align(AlignArguments),
    /// Make a plan from a DXF drawing: the part, the keep-out zones and the finishing toolpath.
    Plan(PlanArguments),
    /// Draw a plan as an SVG picture.
    Show(ShowArguments),
    /// Prove a plan again, from the plan file alone.
    Verify {
        /// The plan, or the folder of a job.
        plan: PathBuf,
        #[command(flatten)]
        time: CertifyTime,
    },
    /// Jog the machine around the part by hand, then let it cut the contour.
    Run(RunArguments),
    /// Continue with the remaining contours of the last run of a job.
    Resume(RunArguments),
    /// Replay the log of a run: certify every sent command again, and draw the run.
    Replay(crate::replay::ReplayArguments),
    /// Make the page that is kept with the part, from the log of its run.
    Report(crate::report::ReportArguments),
    /// Check a controller before the first session: its identity, its settings and its answer times.
    ///
    /// Sends only queries: the machine does not move, and no setting changes. With --conformance it moves the
    /// tool in a small box, after you confirm. The exit code is 0 if a session can begin. It is 6 if the port
    /// or the controller does not answer, or if its settings do not allow a session.
    Doctor(crate::doctor::DoctorArguments),
    /// Identify and tune feed drives, and compute or measure the contour-error term of the margin.
    #[command(subcommand)]
    Drives(crate::drives::DrivesCommand),
    /// Simulate a machine behind a pty, to try out hosts and other programs.
    ///
    /// Prints the name of the device to open, and runs until SIGINT or SIGTERM. SIGUSR1 unplugs the cable and
    /// plugs it in again: the program closes the device and opens another.
    #[cfg(unix)]
    Simulate(crate::simulate::SimulateArguments),
    /// Print the completions for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages of all commands into a folder.
    Man {
        /// The folder.
        #[arg(short, long, value_name = "FOLDER")]
        output: PathBuf,
    },
    /// Serve the operator's panel to a browser: from the drawing to the report, by touch.
    #[cfg(unix)]
    Panel(crate::panel::PanelArguments),
    /// Run an end-to-end job with the built-in drawing and the simulated machine, and write a report.
    Demo {
        /// Folder for the plan, the pictures and the report.
        #[arg(short, long, default_value = "keepout-demo")]
        output: PathBuf,
        /// Time that the operator pushes at the wall, seconds of machine time.
        #[arg(long, default_value_t = 60.0)]
        jog_s: f64,
    },
}

#[derive(Clone, Copy, Debug, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SideArgument {
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

#[derive(Clone, Copy, Debug, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum CutArgument {
    /// Part on the left of the path. The cutter does not pull itself into the part when a drive has backlash.
    Conventional,
    /// Part on the right of the path, for drives without backlash.
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

/// The contour of an outline that is drawn as a stroke with width.
#[derive(Clone, Copy, Debug, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum StrokeArgument {
    /// The outer boundary of the ink.
    Outer,
    /// The inner boundary of the ink.
    Inner,
    /// Both: the part is as thin as the ink.
    Part,
}

impl From<StrokeArgument> for InkSide {
    fn from(stroke: StrokeArgument) -> Self {
        match stroke {
            StrokeArgument::Outer => Self::Outer,
            StrokeArgument::Inner => Self::Inner,
            StrokeArgument::Part => Self::Part,
        }
    }
}

/// Entities that bound contours only when the user requests them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Extra {
    /// The boundaries of hatches.
    Hatch,
    /// The outlines of solids and traces.
    Solid,
}

/// Choice of the entities of a drawing.
#[derive(Clone, Debug, Args)]
pub(crate) struct DrawingArguments {
    /// The drawing: a DXF file, ASCII or binary; or the folder of a job.
    pub(crate) drawing: PathBuf,
    /// Use only these layers of the drawing. Can be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) layer: Vec<String>,
    /// Leave out these layers. Can be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) without_layer: Vec<String>,
    /// The drawing's unit, if the file states no unit or a wrong one: mm, cm, m, µm (or um), in, ft, mil.
    #[arg(long, value_name = "UNIT")]
    pub(crate) units: Option<String>,
    /// Multiply all coordinates by this factor, besides the unit.
    #[arg(long, value_name = "FACTOR")]
    pub(crate) scale: Option<f64>,
    /// Largest gap that is closed, mm. The output lists each closed gap. Default: 0.01, or the value of the job.
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    pub(crate) join_mm: Option<f64>,
    /// Tolerance of the arcs and lines that replace splines and ellipses, mm.
    #[arg(long, value_name = "MM", default_value_t = keepout_planner::drawing::CURVE_MM, value_parser = length,
        allow_hyphen_values = true)]
    pub(crate) curve_mm: f64,
    /// Use lines of this line type although it has gaps. Can be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) line_type: Vec<String>,
    /// State that lines of this gapped line type bound no contour, even if they surround the part. Can be
    /// repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) without_line_type: Vec<String>,
    /// Use these entities as contours, too.
    #[arg(long, value_enum)]
    pub(crate) with: Vec<Extra>,
    /// Rotation of the workpiece on the table. Turns the drawing about its origin, counter-clockwise.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub(crate) rotate_deg: Option<f64>,
    /// Move the drawing after its rotation, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) offset_mm: Option<Mm2>,
    /// Stop if the work takes longer than this time, s.
    #[arg(long, value_name = "S", default_value_t = crate::plan::LIMIT_S, value_parser = time)]
    pub(crate) limit_s: f64,
}

/// Time limit for the proof of a plan.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct CertifyTime {
    /// Stop if the proof of the plan takes longer than this time, s.
    #[arg(long, value_name = "S", default_value_t = crate::plan::LIMIT_S, value_parser = time)]
    pub(crate) certify_limit_s: f64,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct InspectArguments {
    #[command(flatten)]
    pub(crate) drawing: DrawingArguments,
    /// Draw the contours, with repairs and problems marked.
    #[arg(short, long, value_name = "FILE.svg")]
    pub(crate) output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct AlignArguments {
    #[command(flatten)]
    pub(crate) drawing: DrawingArguments,
    /// Machined side of the contour. The probe touches edges from this side.
    /// A job has its own side; otherwise it is outside.
    #[arg(long, value_enum)]
    pub(crate) side: Option<SideArgument>,
    /// Unit of the lengths on the screen during a touch-off. Default: mm, or the unit of the job.
    #[arg(long, value_enum, value_name = "UNIT")]
    pub(crate) display: Option<ShownUnit>,
    /// A point of the drawing, and the machine coordinates of the tool's centre on this point, mm. Two or
    /// more points also measure the rotation. One point alone gives the offset.
    #[arg(long, value_name = "DX,DY=MX,MY", value_parser = crate::align::probe_point, allow_hyphen_values = true)]
    pub(crate) point: Vec<ProbePoint>,
    /// A place near a straight edge of the drawing, and the machine coordinates of the tool's centre when the
    /// tool touched that edge, mm. Two on one edge and one on another edge also measure the rotation. One on
    /// each of two edges gives the offset.
    #[arg(long, value_name = "DX,DY=MX,MY", value_parser = crate::align::probe_point, allow_hyphen_values = true,
        requires = "probe_diameter")]
    pub(crate) edge: Vec<ProbePoint>,
    /// Touch off in the program: jog to the places that it names, and take each with t. The machine's own position is
    /// read. Without points and edges, a job does this.
    #[arg(long, value_enum, conflicts_with_all = ["point", "edge"])]
    pub(crate) take: Option<crate::take::TakeMethod>,
    /// Machine coordinate of the top of the part, mm, under the tool that will cut. Goes into the alignment file that
    /// is there; `--take top` measures it.
    #[arg(long, value_name = "Z", allow_hyphen_values = true, conflicts_with_all = ["point", "edge", "take"])]
    pub(crate) top_mm: Option<f64>,
    /// With `--take top`: thickness of the paper or gauge between tool and part, mm.
    #[arg(long, value_name = "MM", default_value_t = 0.1, value_parser = length)]
    pub(crate) gauge_mm: f64,
    /// Home the machine first. Raise the tool before.
    #[arg(long)]
    pub(crate) home: bool,
    /// State that the machine was homed since power-up.
    #[arg(long, conflicts_with = "home")]
    pub(crate) homed: bool,
    /// Diameter of the probe or tool that touched the edges, mm.
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    pub(crate) probe_diameter: Option<f64>,
    /// Largest error of a probe point, mm.
    #[arg(long, value_name = "MM", default_value_t = PROBE_ERROR_MM, value_parser = length)]
    pub(crate) probe_error_mm: f64,
    /// Largest accepted difference between drawing and machine, mm.
    #[arg(long, value_name = "MM", default_value_t = TOLERANCE_MM, value_parser = length)]
    pub(crate) tolerance_mm: f64,
    /// Output file of the alignment, TOML. A job has its own place.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    pub(crate) drawing: DrawingArguments,
    /// Alignment file of `keepout align`. Turns the drawing as the workpiece lies. `run` needs the same file.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rotate_deg", "offset_mm"])]
    pub(crate) alignment: Option<PathBuf>,
    /// Diameter of the cutter: mm, or with a unit, such as 1/4in.
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    pub(crate) tool_diameter: Option<f64>,
    /// Machined side of the contour. Without it: outside.
    #[arg(long, value_enum)]
    pub(crate) side: Option<SideArgument>,
    /// Stock to leave: the stock that jogging leaves for the finishing cut, mm. Without it: 0.2.
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    pub(crate) stock_to_leave_mm: Option<f64>,
    /// Total margin for the machine's errors, mm. Without it, the figures of the machine profile give the
    /// margin.
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    pub(crate) margin_mm: Option<f64>,
    /// Use only the smallest contour around this point, and the contours directly inside it. Can be repeated.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) at: Vec<Mm2>,
    /// Use only contours of at least this area, mm².
    #[arg(long, value_name = "MM2")]
    pub(crate) min_area_mm2: Option<f64>,
    /// Use only contours of at most this area, mm².
    #[arg(long, value_name = "MM2")]
    pub(crate) max_area_mm2: Option<f64>,
    /// Leave out curves that do not close, and list them. Without this option they make the drawing unusable.
    #[arg(long)]
    pub(crate) leave_out_open: bool,
    /// Outlines that are drawn as strokes with width: the contour to take.
    #[arg(long, value_enum)]
    pub(crate) stroke: Option<StrokeArgument>,
    /// Layer of keep-out zones: the tool also keeps out of its closed contours, such as clamps or a vice. Can
    /// be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) keep_out_layer: Vec<String>,
    /// Layer of the machine's travel: one rectangle that the tool's centre does not leave.
    #[arg(long, value_name = "NAME")]
    pub(crate) travel_layer: Option<String>,
    /// A finishing pass: the stock that it leaves in mm, then a colon and its feed in mm/min. Give it twice
    /// for a double pass, such as --pass 0.1:900 --pass 0:600. Without it, one pass cuts the contour itself.
    #[arg(long, value_name = "MM[:F]", value_parser = pass)]
    pub(crate) pass: Vec<PassParameters>,
    /// Cutting direction, for a cutter that turns clockwise seen from above. Without it: conventional.
    #[arg(long, value_enum)]
    pub(crate) cut: Option<CutArgument>,
    #[command(flatten)]
    pub(crate) depth: DepthArguments,
    /// A stored machine; see `keepout machine`.
    #[arg(long, value_name = "NAME", conflicts_with = "machine_profile")]
    pub(crate) machine: Option<String>,
    /// Machine profile, a TOML file. Without a machine, the plan uses the figures of the simulated machine.
    #[arg(long, value_name = "FILE")]
    pub(crate) machine_profile: Option<PathBuf>,
    /// Output file of the plan. A job has its own place.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Replace a plan file that exists. Logs of the earlier plan then have no plan any more.
    #[arg(long)]
    pub(crate) overwrite: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct ShowArguments {
    /// The plan, or the folder of a job.
    pub(crate) plan: PathBuf,
    #[command(flatten)]
    pub(crate) time: CertifyTime,
    /// Output file of the picture, SVG. A job has its own place.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}
