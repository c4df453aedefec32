//! The arguments of the commands `run` and `resume`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use keepout_planner::Mm2;
use keepout_planner::plan::FEEDS_MM_MIN;

use crate::arguments::CertifyTime;
use crate::resume::Recut;
use crate::shown_unit::ShownUnit;
use crate::values::{length, pair};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MachineArgument {
    /// The simulated machine behind a pty, in real time.
    Sim,
    /// The simulated machine in virtual time: minutes pass in seconds.
    SimFast,
}

/// Feed along contours where none is given, mm/min.
pub(crate) const FEED_MM_MIN: u32 = 900;

/// The report of a job, in its folder.
#[derive(Clone, Debug)]
pub(crate) struct JobReport {
    /// Its place. `None` for a dry run.
    pub(crate) path: Option<PathBuf>,
    /// Rows of its title block.
    pub(crate) title: Vec<(String, String)>,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct RunArguments {
    /// The plan, or the folder of a job.
    pub(crate) plan: PathBuf,
    /// The job's own report.
    #[arg(skip)]
    pub(crate) job_report: Option<JobReport>,
    #[command(flatten)]
    pub(crate) time: CertifyTime,
    /// Feed drives of the simulated machine: a profile of `drives budget`, or `none`. With `none` the tool
    /// follows every command exactly.
    #[arg(long, default_value = "simulated", value_name = "PROFILE", conflicts_with = "port")]
    pub(crate) drives: String,
    /// The simulated machine of this run.
    #[arg(long, value_enum, default_value = "sim", conflicts_with = "port")]
    pub(crate) machine: MachineArgument,
    /// The serial port of a real machine, such as /dev/ttyUSB0.
    #[arg(long, value_name = "DEVICE")]
    pub(crate) port: Option<String>,
    /// Dialect of the controller: grbl, grblhal, zaber, venus, or a file that describes another dialect.
    /// Default: grbl, or the dialect of the job's machine.
    #[arg(long, value_name = "DIALECT")]
    pub(crate) dialect: Option<String>,
    /// Baud rate of the port. Default: 115200, or the baud rate of the job's machine.
    #[arg(long)]
    pub(crate) baud: Option<u32>,
    /// Machine coordinates of the drawing's origin, mm. A real machine needs this option or --alignment.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, group = "place")]
    pub(crate) origin_mm: Option<Mm2>,
    /// Machine coordinate of the top of the part, mm, for a plan with depths. A real machine needs it.
    #[arg(long, value_name = "Z", value_parser = length, allow_hyphen_values = true)]
    pub(crate) top_mm: Option<f64>,
    /// Alignment file of `keepout align`, the same file as in `keepout plan`. It gives the drawing's origin.
    #[arg(long, value_name = "FILE", group = "place")]
    pub(crate) alignment: Option<PathBuf>,
    /// Home the real machine first. Raise the tool before.
    #[arg(long)]
    pub(crate) home: bool,
    /// State that the real machine was homed since power-up, and that no alarm was unlocked by hand since
    /// then.
    #[arg(long, conflicts_with = "home")]
    pub(crate) homed: bool,
    /// State that the controller at the port is a simulator. Operator models, scripts and traces may then move it.
    #[arg(long)]
    pub(crate) simulate: bool,
    /// Start without the question on the page before the first motion.
    #[arg(long)]
    pub(crate) yes: bool,
    /// Dry run: raise the tool above the stock, and let it trace the contours. Nothing counts as cut.
    #[arg(long, conflicts_with = "report")]
    pub(crate) dry_run: bool,
    /// State that the drawing of the alignment and the drawing of the plan have the same origin.
    #[arg(long)]
    pub(crate) same_origin: bool,
    /// The operator: keyboard; gamepad or gamepad:DEVICE; handwheel or handwheel:DEVICE. At a simulated machine also
    /// a model (calm, jittery, wall, random, stuck, reversal), a script file, or trace:FILE. A port has no default;
    /// a simulated machine has the model calm.
    #[arg(long)]
    pub(crate) operator: Option<String>,
    /// Record every change of the operator's input in this new file. --operator trace:FILE plays it.
    #[arg(long, value_name = "FILE")]
    pub(crate) record_trace: Option<PathBuf>,
    /// Show the position, the wall and a small plan on the whole terminal. Has no effect without a terminal.
    #[arg(long)]
    pub(crate) view: bool,
    /// Unit of the lengths on the screen. Default: mm, or the unit of the job.
    #[arg(long, value_enum, value_name = "UNIT")]
    pub(crate) display: Option<ShownUnit>,
    /// Gamepad: radius of the dead zone, as a share of the stick's throw.
    #[arg(long, value_name = "SHARE", default_value_t = 0.12)]
    pub(crate) dead_zone: f64,
    /// Gamepad: share of the cubic term in the stick's response, 0 to 1. A larger share is finer near the
    /// centre.
    #[arg(long, value_name = "SHARE", default_value_t = 0.5)]
    pub(crate) expo: f64,
    /// Time that a modelled operator jogs before it touches the part, s.
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    pub(crate) jog_s: f64,
    /// Feed of the finishing contour, mm/min. Default: 900, or the feed of the job.
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32)
        .range(i64::from(*FEEDS_MM_MIN.start())..=i64::from(*FEEDS_MM_MIN.end())))]
    pub(crate) feed_mm_min: Option<u32>,
    /// Stop if the controller at the port does not answer within this time, s.
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    pub(crate) answer_within_s: f64,
    /// Stop the run after this time, s. Without it, a run with a person has no limit, and any other has 3600 s.
    #[arg(long, value_name = "S")]
    pub(crate) limit_s: Option<f64>,
    /// Simulated machine: added delay each way, ms.
    #[arg(long, value_name = "MS", default_value_t = 1)]
    pub(crate) latency_ms: u64,
    /// Simulated machine: travel in x and y, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair)]
    pub(crate) travel_mm: Option<Mm2>,
    /// Simulated machine: start position of the tool's centre, drawing coordinates, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub(crate) start_mm: Option<Mm2>,
    /// Simulated machine and operator: seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the event log of the run to this file, which must not exist yet. Without it, a run at a port writes its
    /// log beside the plan, with the date in its name.
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Option<PathBuf>,
    /// Continue with the remaining contours of an earlier run: the log of that run. The program replays this
    /// log first. --log must name another file.
    #[arg(long, value_name = "LOG")]
    pub(crate) resume: Option<PathBuf>,
    /// With --resume: cut this whole contour again, in all its passes, or in one. Give its number as the plan and the
    /// pictures show it: "2", or "2:1" for pass 1 alone. Can be repeated.
    #[arg(long, value_name = "CONTOUR[:PASS]", value_parser = crate::resume::recut)]
    pub(crate) recut: Vec<Recut>,
    /// With --resume: state that the workpiece was shifted on the machine since that run, not turned, and was
    /// measured again.
    #[arg(long)]
    pub(crate) moved: bool,
    /// Write a page with a picture and a table.
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Write a picture of the run.
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) picture: Option<PathBuf>,
}

impl RunArguments {
    /// Dialect of the controller.
    pub(crate) fn dialect(&self) -> &str {
        self.dialect.as_deref().unwrap_or("grbl")
    }

    /// Unit of the lengths on the screen.
    pub(crate) fn display(&self) -> ShownUnit {
        self.display.unwrap_or_default()
    }

    /// Baud rate of the port.
    pub(crate) fn baud(&self) -> u32 {
        self.baud.unwrap_or(115_200)
    }

    /// Feed of the finishing contour, mm/min.
    pub(crate) fn feed_mm_min(&self) -> u32 {
        self.feed_mm_min.unwrap_or(FEED_MM_MIN)
    }
}
