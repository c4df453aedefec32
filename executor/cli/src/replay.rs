//! The command `replay`, and the replay of a log with its plan for `report` and `run --resume`.

use std::io::{BufRead, BufReader, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use keepout_executor::session::log::{Header, LOG, LogReader};
use keepout_executor::session::picture_of_log;
use keepout_executor::session::replay::{Replay, ReplayError, check_certificates_from, replay_from};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::plan_file::PLAN_FILE;
use keepout_planner::{plan_file, sha256, text_file};

use super::job::JobFolder;
use super::plan::{load, refuse_same, write};
use super::{CertifyTime, CliError};

#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// The log of a run, or the folder of a job: its last log.
    log: PathBuf,
    /// The plan of the run. Without it, the program searches the log's folder for a *.plan file with the
    /// log's hash.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    time: CertifyTime,
    /// Check each certificate by itself, and the text that was sent for it. The run is not played again.
    #[arg(long, conflicts_with = "output")]
    certificates_only: bool,
    /// Draw the run from the log.
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
}

pub fn replay(arguments: &ReplayArguments) -> Result<ExitCode, CliError> {
    let (plan, output) = (arguments.plan.as_deref(), arguments.output.as_deref());
    let log = match JobFolder::at(&arguments.log)? {
        Some(job) => job.last_log()?,
        None => arguments.log.clone(),
    };
    if arguments.certificates_only {
        return check_alone(&log, plan, arguments.time);
    }
    let played = Played::of(&log, plan, output, arguments.time)?;
    for (name, value) in played.rows() {
        println!("{name:<36} {value}");
    }
    if let Some(output) = &arguments.output {
        write(output, picture_of_log(&played.header, &played.replay).as_bytes())?;
        println!("{:<36} {}", "picture", output.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// Checks the certificates of a log, and prints their numbers.
fn check_alone(log: &Path, plan: Option<&Path>, time: CertifyTime) -> Result<ExitCode, CliError> {
    let mut reader = open(log)?;
    let plan = plan.map_or_else(|| find_plan(log, reader.header()), |plan| Ok(plan.to_path_buf()))?;
    let work = PreparedPlan::new(load(&plan, time)?);
    let checked = check_certificates_from(&mut reader, &work).map_err(|source| refusal(log, source))?;
    let texts = checked.texts.map_or("not compared in this language".into(), |texts| texts.to_string());
    for (name, value) in [
        ("lines, each matching the one before", reader.lines().to_string()),
        ("jogs that hold", checked.jogs.to_string()),
        ("motions of contours that hold", checked.contours.to_string()),
        ("texts that say the same", texts),
    ] {
        println!("{name:<36} {value}");
    }
    Ok(ExitCode::SUCCESS)
}

fn refusal(log: &Path, source: ReplayError) -> CliError {
    match source {
        ReplayError::Log(error) => CliError::LogRead(error),
        source => CliError::Replay { path: log.to_path_buf(), source },
    }
}

/// A log whose replay agreed with it.
pub struct Played {
    pub header: Header,
    pub replay: Replay,
    /// Number of whole lines.
    pub lines: usize,
    /// Bytes of an incomplete last line.
    pub torn: usize,
    pub checksum: u32,
}

impl Played {
    /// Replays a log with its plan. Refuses an output that is the log or the plan.
    pub fn of(
        log: &Path,
        plan: Option<&Path>,
        output: Option<&Path>,
        time: CertifyTime,
    ) -> Result<Self, CliError> {
        let mut reader = open(log)?;
        let found = match plan {
            Some(plan) => plan.to_path_buf(),
            None => find_plan(log, reader.header())?,
        };
        refuse_same(&[log, &found], output.as_slice())?;
        Self::with(log, &mut reader, PreparedPlan::new(load(&found, time)?))
    }

    /// Replays a log with a loaded plan.
    pub fn with<R: BufRead>(
        log: &Path,
        reader: &mut LogReader<R>,
        work: PreparedPlan,
    ) -> Result<Self, CliError> {
        let replay = replay_from(reader, work).map_err(|source| refusal(log, source))?;
        Ok(Self {
            header: reader.header().clone(),
            replay,
            lines: reader.lines(),
            torn: reader.torn(),
            checksum: reader.checksum(),
        })
    }

    fn rows(&self) -> Vec<(&'static str, String)> {
        let counted = &self.replay.counted;
        let torn = match self.torn {
            0 => "none".into(),
            bytes => format!("{bytes} bytes of a last line, left out: the program ended while it wrote them"),
        };
        vec![
            ("drawing", text_file::shown(&self.header.drawing)),
            ("began", text_file::shown(&self.header.began)),
            ("time span", format!("{:.3} s", counted.ended.elapsed().as_secs_f64())),
            ("outcome", self.replay.outcome().to_string()),
            ("lines, each matching the one before", self.lines.to_string()),
            ("incomplete last line", torn),
            ("operator inputs", counted.inputs.to_string()),
            ("lines from the controller", counted.replies.to_string()),
            ("commands equal, byte by byte", counted.commands.to_string()),
            ("certificates checked independently", counted.certificates.to_string()),
            ("log checksum", format!("{:08x}", self.checksum)),
        ]
    }
}

/// Opens a log. A terminal shows the progress of the reading.
pub fn open(path: &Path) -> Result<LogReader<impl BufRead + use<>>, CliError> {
    let file = LOG.open(path)?;
    let length = file.metadata().map_err(LOG.read_error(path))?.len();
    let hidden = !std::io::stderr().is_terminal();
    let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(length) };
    if let Ok(style) =
        ProgressStyle::with_template("[{bar:20}] {bytes}/{total_bytes} {elapsed} replaying the log")
    {
        bar.set_style(style.progress_chars("##-"));
    }
    let file = bar.with_finish(indicatif::ProgressFinish::AndClear).wrap_read(file);
    Ok(LogReader::new(BufReader::with_capacity(1 << 16, file), path)?)
}

/// Searches the log's folder for the plan with the log's hash.
fn find_plan(log: &Path, header: &Header) -> Result<PathBuf, CliError> {
    let folder = log.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // The logs of a job are in a folder below its plans.
    let job = folder.parent().filter(|job| job.join("job.toml").is_file());
    find_plan_of(log, header, job.unwrap_or(folder))
}

/// The plan of a log, among the plans in a folder.
pub fn find_plan_in(log: &Path, folder: &Path) -> Result<PathBuf, CliError> {
    find_plan_of(log, open(log)?.header(), folder)
}

fn find_plan_of(log: &Path, header: &Header, folder: &Path) -> Result<PathBuf, CliError> {
    let files = std::fs::read_dir(folder).map(|entries| entries.flatten().map(|entry| entry.path()));
    let mut seen = 0;
    for path in files.into_iter().flatten().filter(|path| path.extension().is_some_and(|end| end == "plan")) {
        let readable = path.metadata().is_ok_and(|it| it.is_file() && it.len() <= plan_file::SIZE_MAX);
        if !readable {
            continue;
        }
        seen += 1;
        let hash = PLAN_FILE.read(&path, plan_file::SIZE_MAX).map(|bytes| sha256::hex(&sha256::hash(&bytes)));
        if hash.is_ok_and(|hash| hash == header.plan) {
            return Ok(path);
        }
    }
    Err(CliError::NoPlan {
        log: log.to_path_buf(),
        hash: text_file::shown(&header.plan),
        drawing: text_file::shown(&header.drawing),
        folder: folder.to_path_buf(),
        seen,
    })
}
