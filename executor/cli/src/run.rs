//! The commands `run` and `demo`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use keepout_drives::budget::BudgetError;
use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::DialectName;
use keepout_executor::operator::Operator;
use keepout_executor::session::log::{Header, LogWriter, rfc_3339};
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{
    EventLog, Going, NoEventLog, RunFacts, Sample, SessionSetup, picture_of_run, section_of_run,
};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::Mm2;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::point_from_mm;
use keepout_sim::session::{Link, Scene, SimRun, run_scene};

use super::align::placed;
use super::at_port::PortSession;
use super::before::{
    ConfirmPage, OperatorName, check_output, default_log, limit, place, refuse_incomplete,
    refuse_margin_of_simulation, refuse_unknown_top,
};
use super::display::Display;
use super::job::{JobFolder, keep_earlier};
use super::operator_setup::set_up;
use super::plan::{given, load, refuse_same, write, write_section};
use super::resume::progress_before;
use super::values::seconds;
use super::{CliError, MachineArgument, RunArguments};

pub fn run(given: &RunArguments) -> Result<ExitCode, CliError> {
    let code = match JobFolder::at(&given.plan)? {
        None => run_plan(given),
        Some(job) => in_job(&job, given),
    }?;
    if given.dry_run {
        println!("{:<36} nothing was cut: its log does not count for `resume` and `report`", "dry run");
    }
    Ok(code)
}

/// Continues the last run of a job.
pub fn resume(given: &RunArguments) -> Result<ExitCode, CliError> {
    let Some(job) = JobFolder::at(&given.plan)? else {
        let reason = format!(
            "{} is not the folder of a job. `keepout run PLAN --resume LOG` takes files.",
            given.plan.display()
        );
        return Err(CliError::Argument(reason));
    };
    let resume = given.resume.clone().map_or_else(|| job.last_log(), Ok)?;
    in_job(&job, &RunArguments { resume: Some(resume), ..given.clone() })
}

/// Runs a job, and makes its report.
fn in_job(job: &JobFolder, given: &RunArguments) -> Result<ExitCode, CliError> {
    if given.resume.is_none() && !given.dry_run && !job.logs().is_empty() {
        let name = job.folder.display();
        eprintln!("note: this run begins a new part. `keepout resume {name}` continues the last one.");
    }
    run_plan(&job.run_arguments(given)?)
}

fn run_plan(arguments: &RunArguments) -> Result<ExitCode, CliError> {
    let operator = OperatorName::of(arguments)?;
    let inputs = [Some(&arguments.plan), arguments.resume.as_ref(), arguments.alignment.as_ref()];
    let named = [&arguments.dialect().to_string(), &arguments.drives, &operator.name];
    let files = named.map(|name| Path::new(name.strip_prefix("trace:").unwrap_or(name)));
    let outputs = [&arguments.log, &arguments.report, &arguments.picture, &arguments.record_trace];
    let written = given(&outputs.map(Option::as_ref));
    refuse_same(&[given(&inputs), files.to_vec()].concat(), &written)?;
    // Nothing is discovered after the run: the log and the trace check their own places.
    check_output(arguments.report.as_deref(), Some("html"))?;
    check_output(arguments.picture.as_deref(), Some("svg"))?;
    let plan = load(&arguments.plan, arguments.time)?;
    let arguments = &placed(arguments, &plan)?;
    let limit = limit(arguments.limit_s, operator.by_hand)?;
    let jog = seconds("--jog-s", arguments.jog_s)?;
    let began = rfc_3339(SystemTime::now());
    // A run at a port always keeps its log. The report is made from the log.
    let keeps_log = arguments.port.is_some() || arguments.report.is_some();
    let log = arguments.log.clone().or_else(|| keeps_log.then(|| default_log(&arguments.plan, &began)));
    check_output(log.as_deref(), None)?;
    let outputs = Outputs::of(arguments, log);
    refuse_incomplete(arguments)?;
    let real_time = arguments.port.is_some() || arguments.machine == MachineArgument::Sim;
    let work = PreparedPlan::new(plan);
    let progress = progress_before(arguments, &work)?;
    refuse_margin_of_simulation(arguments, &work.plan.plan.machine)?;
    if progress.finished.len() == work.plan.plan.loop_count() {
        println!("every contour of the plan is cut: this run has no work");
        return Ok(ExitCode::SUCCESS);
    }
    match &arguments.port {
        Some(port) => on_port(work, port, arguments, (limit, jog), &operator, progress, &outputs),
        None => {
            let setup = set_up(arguments, &operator, jog.as_secs_f64(), real_time)?;
            let run = SimRun { progress, ..simulation(arguments, &work.plan, limit)? };
            if let Some(note) = note_of_drives(&work.plan, &run) {
                eprintln!("note: {note}");
            }
            let machine = run.machine.name.clone();
            let (log, operator) = (outputs.log.as_deref(), operator.name.as_str());
            on_simulation(
                work,
                &run,
                (setup.operator, Display::new(setup.screen, setup.panel, arguments)),
                &LogFacts { log, operator, machine, simulated: true, dry_run: arguments.dry_run },
                &outputs,
            )
        }
    }
}

/// The simulated machine, with the travel of the arguments. For a plan with depths it has the plan's third axis.
pub fn simulated_machine(arguments: &RunArguments, plan: &CertifiedPlan) -> Result<MachineProfile, CliError> {
    let z = plan.plan.relief.as_ref().and(plan.plan.machine.z.clone());
    let machine = MachineProfile { z, ..MachineProfile::simulated() };
    match arguments.travel_mm {
        Some(Mm2 { x, y }) => Ok(MachineProfile { travel_mm: [x, y], ..machine }.checked()?),
        None => Ok(machine),
    }
}

fn simulation(arguments: &RunArguments, plan: &CertifiedPlan, limit: Duration) -> Result<SimRun, CliError> {
    let machine = simulated_machine(arguments, plan)?;
    let start = arguments.start_mm.map(|start| {
        point_from_mm(start).map_err(|error| CliError::Argument(format!("--start-mm: {error}")))
    });
    Ok(SimRun {
        machine,
        servo: drives(&arguments.drives)?,
        dialect: dialect_name(arguments)?,
        link: if arguments.machine == MachineArgument::Sim { Link::Pty } else { Link::Virtual },
        baud: arguments.baud(),
        latency: Duration::from_millis(arguments.latency_ms),
        seed: arguments.seed,
        feed_mm_min: arguments.feed_mm_min(),
        limit,
        start: start.transpose()?,
        origin_mm: arguments.origin_mm,
        top_mm: arguments.top_mm,
        progress: Progress::default(),
    })
}

/// The drives of a simulated machine, from a profile. The name `none` gives no drives.
pub fn drives(name: &str) -> Result<Option<DriveProfile>, CliError> {
    if name == "none" {
        return Ok(None);
    }
    let profile = DriveProfile::load(name)?;
    if profile.controller.is_none() {
        return Err(CliError::Argument(BudgetError::NoController(profile.name).to_string()));
    }
    Ok(Some(profile))
}

/// The note for a run whose drives are not the drives of the plan's margin.
fn note_of_drives(plan: &CertifiedPlan, run: &SimRun) -> Option<String> {
    let name = &run.servo.as_ref()?.name;
    let source = &plan.plan.machine.contour_error_source;
    (!source.details().contains(name.as_str())).then(|| {
        format!(
            "the contour error in the plan's margin is {source}. But the drives \"{name}\" move the tool: \
             it may come nearer to the part than the margin allows. --drives none leaves the drives out"
        )
    })
}

/// Output files of a run.
pub struct Outputs {
    report: Option<PathBuf>,
    picture: Option<PathBuf>,
    pub log: Option<PathBuf>,
    /// Whether the program chose the log's name.
    names_log: bool,
    /// The report of the job.
    job_report: Option<PathBuf>,
    /// Whether an earlier report of the job stays under another name: the run begins a new part.
    keeps_earlier: bool,
    /// Rows of the report's title block.
    title: Vec<(String, String)>,
}

impl Outputs {
    pub fn of(arguments: &RunArguments, log: Option<PathBuf>) -> Self {
        let page = arguments.job_report.as_ref();
        Self {
            report: arguments.report.clone(),
            picture: arguments.picture.clone(),
            log,
            names_log: arguments.log.is_none(),
            job_report: page.and_then(|page| page.path.clone()),
            keeps_earlier: arguments.resume.is_none(),
            title: page.map_or(Vec::new(), |page| page.title.clone()),
        }
    }
}

/// The dialect of the arguments.
pub fn dialect_name(arguments: &RunArguments) -> Result<DialectName, CliError> {
    DialectName::named(arguments.dialect()).map_err(|error| CliError::Argument(error.to_string()))
}

/// Facts about a session that its log states.
pub struct LogFacts<'a> {
    /// The log file, if the user wants one.
    pub log: Option<&'a Path>,
    pub operator: &'a str,
    /// Name of the machine and its port.
    pub machine: String,
    pub simulated: bool,
    pub dry_run: bool,
}

impl LogFacts<'_> {
    /// Creates the event log, or a log that drops its events.
    pub fn event_log(&self, setup: &SessionSetup) -> Result<Box<dyn EventLog>, CliError> {
        let Some(path) = self.log else { return Ok(Box::new(NoEventLog)) };
        let header = Header {
            began: rfc_3339(SystemTime::now()),
            simulated: self.simulated,
            dry_run: self.dry_run,
            operator: self.operator.into(),
            setting: self.machine.clone(),
            ..setup.header()?
        };
        Ok(Box::new(LogWriter::create(path, &header)?))
    }
}

fn on_simulation(
    work: PreparedPlan,
    run: &SimRun,
    (operator, mut display): (Box<dyn Operator + Send>, Display),
    recording: &LogFacts<'_>,
    outputs: &Outputs,
) -> Result<ExitCode, CliError> {
    let scene = Scene::of(work, run)?;
    let log = recording.event_log(&scene.setup)?;
    let result = run_scene(run, scene, operator, log, &mut |supervisor, monitor, now| {
        display.show(supervisor, monitor.closest_mm(), now);
        Going::On
    })?;
    display.finish();
    finish(&result.work, &result.facts, &result.samples, outputs)
}

fn on_port(
    work: PreparedPlan,
    name: &str,
    arguments: &RunArguments,
    (limit, jog): (Duration, Duration),
    operator: &OperatorName,
    progress: Progress,
    outputs: &Outputs,
) -> Result<ExitCode, CliError> {
    refuse_unknown_top(arguments, &work.plan)?;
    let place = place(&work.plan, &work.plan.plan.machine, arguments)?;
    let log = outputs.log.as_deref();
    let page = ConfirmPage {
        plan: &work.plan,
        arguments,
        operator: &operator.name,
        port: name,
        place: &place,
        progress: &progress,
        log,
    };
    let port = Serial::open(name, arguments.baud())?;
    page.confirm()?;
    let setup = set_up(arguments, operator, jog.as_secs_f64(), true)?;
    let mut display = Display::new(setup.screen, setup.panel, arguments);
    let at_port = PortSession { work, place, arguments, progress, log, operator: &operator.name, limit };
    let (supervisor, facts, samples) =
        at_port.run(port, (setup.operator, setup.recovers), &mut |supervisor, now| {
            display.show(supervisor, None, now);
            Going::On
        })?;
    display.finish();
    finish(supervisor.work(), &facts, &samples, outputs)
}

/// Prints the summary, writes the output files, and returns the exit code.
pub fn finish(
    work: &PreparedPlan,
    facts: &RunFacts,
    samples: &[Sample],
    outputs: &Outputs,
) -> Result<ExitCode, CliError> {
    let plan = &work.plan;
    for (name, value) in facts.rows(plan, samples) {
        println!("{name:<36} {value}");
    }
    if let Some(path) = &outputs.picture {
        let title = format!("{}, as run", plan.plan.provenance.name);
        let picture = picture_of_run(plan, &title, samples, &facts.progress);
        write(path, picture.as_bytes())?;
        println!("{:<36} {}", "picture", path.display());
        write_section(path, section_of_run(plan, &title, samples))?;
    }
    if let Some(page) = outputs.job_report.as_ref().filter(|_| outputs.keeps_earlier) {
        keep_earlier(page)?;
    }
    for path in [&outputs.report, &outputs.job_report].into_iter().flatten() {
        let log = outputs.log.as_deref().unwrap_or(path);
        super::report::of_log(log, work.clone(), path, &outputs.title)?;
    }
    if let Some(log) = outputs.log.as_ref().filter(|_| outputs.names_log) {
        println!("{:<36} {}", "log", log.display());
    }
    Ok(exit_code(facts))
}

pub fn exit_code(facts: &RunFacts) -> ExitCode {
    if facts.deepest_mm.is_some_and(|depth| depth > 0.0) {
        return ExitCode::from(8);
    }
    ExitCode::from(facts.outcome.code())
}
