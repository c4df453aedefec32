//! `run` and `demo`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use keepout_drives::controllers::kind::Kind;
use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::operator::Panel;
use keepout_executor::session::log::{Header, LogReader, LogWriter, rfc_3339};
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{
    Ended, Engine, EventLog, Going, NoEventLog, RealClock, RunFacts, Sample, SampleKind, Session, html,
    picture_of_run, place_on_table,
};
use keepout_executor::supervisor::{Options, Phase, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::picture::svg;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{point_from_mm, point_mm};
use keepout_sim::session::{Link, Scene, SimRun, run_scene};
use keepout_sim::{ServoConfig, operator};

use super::align::placed;
use super::display::Display;
use super::operator_setup::{OperatorSetup, hands};
use super::plan::{LIMIT_S, given, load, make, refuse_same, write};
use super::resume::{fits, progress_of};
use super::{CliError, MachineArgument, RunArguments};

/// The drawing of the demonstration.
const BRACKET: &[u8] = include_bytes!("../drawings/bracket.dxf");

pub fn run(arguments: &RunArguments) -> Result<ExitCode, CliError> {
    let inputs = [Some(&arguments.plan), arguments.resume.as_ref(), arguments.alignment.as_ref()];
    let named = [&arguments.dialect, &arguments.drives, &arguments.operator];
    let files = named.map(|name| Path::new(name.strip_prefix("trace:").unwrap_or(name)));
    let outputs = [&arguments.log, &arguments.report, &arguments.picture, &arguments.record_trace];
    refuse_same(&[given(&inputs), files.to_vec()].concat(), &given(&outputs.map(Option::as_ref)))?;
    let plan = load(&arguments.plan, arguments.time)?;
    let arguments = &placed(arguments, &plan)?;
    let limit = seconds("--limit-s", arguments.limit_s)?;
    let manual = seconds("--jog-s", arguments.jog_s)?;
    let outputs = Outputs { report: arguments.report.clone(), picture: arguments.picture.clone() };
    if arguments.port.is_some() && !arguments.home && !arguments.homed {
        let reason = "a real machine needs --home (tool raised), or --homed when it was homed since power-up";
        return Err(CliError::Argument(reason.into()));
    }
    let real_time = arguments.port.is_some() || arguments.machine == MachineArgument::Sim;
    let work = PreparedPlan::new(plan);
    let progress = match &arguments.resume {
        Some(log) => {
            let (progress, header) = progress_of(log, &work, &arguments.recut)?;
            fits(&header, &work.plan, arguments)?;
            progress
        }
        None => Progress::default(),
    };
    if progress.finished.len() == work.plan.plan.loop_count() {
        println!("every contour of the plan is finished: nothing is left to do");
        return Ok(ExitCode::SUCCESS);
    }
    let hands = hands(arguments, manual.as_secs_f64(), real_time)?;
    match &arguments.port {
        Some(port) => on_port(work, port, arguments, limit, hands, progress, &outputs),
        None => {
            let run = SimRun { progress, ..simulation(arguments, limit)? };
            if let Some(note) = unlike(&work.plan, &run) {
                eprintln!("note: {note}");
            }
            let machine = run.machine.name.clone();
            let (log, operator) = (arguments.log.as_deref(), arguments.operator.as_str());
            on_simulation(work, &run, hands, &Recording { log, operator, machine, simulated: true }, &outputs)
        }
    }
}

fn seconds(name: &str, value: f64) -> Result<Duration, CliError> {
    let known = (0.0..=1e7).contains(&value);
    if known {
        Ok(Duration::from_secs_f64(value))
    } else {
        Err(CliError::Argument(format!("{name} {value} is no time")))
    }
}

/// Below half a second a healthy controller that homes or starts would be taken for gone; above a minute nobody watches.
fn answer_within(arguments: &RunArguments) -> Result<Duration, CliError> {
    let given = arguments.answer_within_s;
    if (0.5..=60.0).contains(&given) {
        Ok(Duration::from_secs_f64(given))
    } else {
        Err(CliError::Argument(format!("--answer-within-s {given} is not between 0.5 and 60")))
    }
}

/// The simulated machine, with the travel that was asked for.
pub fn simulated_machine(arguments: &RunArguments) -> Result<MachineProfile, CliError> {
    let machine = MachineProfile::simulated();
    match arguments.travel_mm {
        Some((x, y)) => Ok(MachineProfile { travel_mm: [x, y], ..machine }.checked()?),
        None => Ok(machine),
    }
}

fn simulation(arguments: &RunArguments, limit: Duration) -> Result<SimRun, CliError> {
    let machine = simulated_machine(arguments)?;
    let start = arguments.start_mm.map(|start| {
        point_from_mm(start).map_err(|error| CliError::Argument(format!("--start-mm: {error}")))
    });
    Ok(SimRun {
        machine,
        servo: drives(&arguments.drives)?,
        language: language(arguments)?,
        link: if arguments.machine == MachineArgument::Sim { Link::Pty } else { Link::Virtual },
        baud: arguments.baud,
        latency: Duration::from_millis(arguments.latency_ms),
        seed: arguments.seed,
        feed_mm_min: arguments.feed_mm_min,
        limit,
        start: start.transpose()?,
        origin_mm: arguments.origin_mm,
        progress: Progress::default(),
    })
}

/// The drives of a simulated machine: a profile, or `none`.
pub fn drives(name: &str) -> Result<Option<ServoConfig>, CliError> {
    if name == "none" {
        return Ok(None);
    }
    Ok(Some(ServoConfig { profile: DriveProfile::load(name)?, kind: Kind::Contouring }))
}

/// What is to be said when the plan's margin is not that of the drives it is run on.
fn unlike(plan: &CertifiedPlan, run: &SimRun) -> Option<String> {
    let name = &run.servo.as_ref()?.profile.name;
    let source = plan.plan.machine.contour_error_source.as_deref().unwrap_or("the machine profile alone");
    (!source.contains(name.as_str())).then(|| {
        format!(
            "the contour error in the plan's margin is of {source}, and the tool is moved by \"{name}\": it may come nearer to the part \
             than the margin says. --drives none leaves the drives out"
        )
    })
}

/// Says so when a real machine is driven with the margin of the one that comes with the program.
fn note_of_margin(machine: &MachineProfile) {
    let simulated = MachineProfile::simulated();
    // A file that `drives budget` made of the simulated machine has its name still, and a source of its own.
    if machine.name == simulated.name || machine.contour_error_source == simulated.contour_error_source {
        eprintln!(
            "note: the plan's margin and travel are of the {}, not of the machine at the port: plan with --machine-profile. \
             `keepout doctor` prints the figures of the one at the port, `keepout drives budget` writes such a file",
            simulated.name
        );
    }
}

/// Files that a run leaves.
struct Outputs {
    report: Option<PathBuf>,
    picture: Option<PathBuf>,
}

/// The dialect that was asked for.
fn language(arguments: &RunArguments) -> Result<DialectName, CliError> {
    DialectName::named(&arguments.dialect).map_err(|error| CliError::Argument(error.to_string()))
}

/// The log of a session that is wanted.
struct Recording<'a> {
    log: Option<&'a Path>,
    operator: &'a str,
    /// The machine and its port, in words.
    machine: String,
    simulated: bool,
}

impl Recording<'_> {
    fn tape(
        &self,
        work: &PreparedPlan,
        language: &DialectName,
        options: &Options,
        setting: &DialectConfig,
    ) -> Result<Box<dyn EventLog>, CliError> {
        let Some(path) = self.log else { return Ok(Box::new(NoEventLog)) };
        let header = Header {
            keepout_log: keepout_executor::session::log::VERSION,
            began: rfc_3339(SystemTime::now()),
            plan: plan_file::hex(&plan_file::hash(&plan_file::encode(&work.plan.plan)?)),
            drawing: work.plan.plan.provenance.name.clone(),
            dialect: language.name().into(),
            description: language.hash(),
            simulated: self.simulated,
            offset: setting.offset,
            travel_mm: setting.travel_mm,
            travel: options.travel,
            feed_mm_min: options.feed_mm_min,
            home: options.home,
            answer_within_ms: u64::try_from(options.answer_within.as_millis()).unwrap_or(u64::MAX),
            baud: options.baud,
            progress: options.progress.clone(),
            operator: self.operator.into(),
            setting: self.machine.clone(),
        };
        Ok(Box::new(LogWriter::create(path, &header)?))
    }
}

fn on_simulation(
    work: PreparedPlan,
    run: &SimRun,
    hands: OperatorSetup,
    recording: &Recording<'_>,
    outputs: &Outputs,
) -> Result<ExitCode, CliError> {
    let mut display = Display::new(hands.screen, hands.panel);
    let scene = Scene::of(&work.plan, run)?;
    let tape = recording.tape(&work, &run.language, &scene.options, &scene.setting)?;
    let operator = hands.operator;
    let result = run_scene(work, run, scene, operator, tape, |_| {}, &mut |supervisor, monitor, now| {
        display.show(supervisor, monitor.closest_mm(), now);
        Going::On
    })?;
    display.finish();
    finish(&result.work.plan, &result.facts, &result.samples, outputs)
}

fn on_port(
    work: PreparedPlan,
    name: &str,
    arguments: &RunArguments,
    limit: Duration,
    hands: OperatorSetup,
    progress: Progress,
    outputs: &Outputs,
) -> Result<ExitCode, CliError> {
    let machine = work.plan.plan.machine.clone();
    let language = language(arguments)?;
    note_of_margin(&machine);
    let place = place_on_table(&work.plan, &machine, arguments.origin_mm)?;
    let options = Options {
        feed_mm_min: arguments.feed_mm_min,
        home: arguments.home,
        travel: place.travel,
        answer_within: answer_within(arguments)?,
        baud: arguments.baud,
        progress,
    };
    let setting = DialectConfig::of(&machine, place.offset);
    let loops_before = options.progress.finished.len();
    let on = format!("{} on {name}, {} baud", machine.name, arguments.baud);
    let port = Serial::open(name, arguments.baud)?;
    let dialect = language.dialect(setting);
    let (log, operator) = (arguments.log.as_deref(), arguments.operator.as_str());
    let recording = Recording { log, operator, machine: on.clone(), simulated: false };
    let tape = recording.tape(&work, &language, &options, &setting)?;
    let supervisor = Supervisor::new(work, options, dialect.abilities());
    let mut session = Session::new(Engine::new(supervisor, dialect), port, hands.operator, tape);
    if hands.recovers {
        session = session.recovering(Box::new(|| Serial::open(name, arguments.baud)));
    }
    let mut display = Display::new(hands.screen, hands.panel);
    let mut samples: Vec<Sample> = Vec::new();
    let mut last = Time::ZERO;
    let ended = session.run(&mut RealClock::default(), limit, |session, now| {
        let supervisor = session.supervisor();
        display.show(supervisor, None, now);
        last = now;
        let sample = reported(supervisor, now).filter(|_| samples.len() < 2_000_000);
        let before = samples.last().map(|last| last.position_mm);
        samples.extend(sample.filter(|sample| before != Some(sample.position_mm)));
        Going::On
    })?;
    display.finish();
    let supervisor = session.into_supervisor();
    let facts = RunFacts {
        ended,
        fault: supervisor.fault().map(ToString::to_string),
        seconds: last.elapsed().as_secs_f64(),
        counts: supervisor.counts(),
        loops: (supervisor.finished().len(), supervisor.plan().plan.loop_count()),
        loops_before,
        partial: supervisor.progress().partial.len(),
        unreached: supervisor.unreached(),
        interrupted: supervisor.is_interrupted(),
        deepest_mm: None,
        closest_mm: None,
        closest_by_hand_mm: None,
        coverage: None,
        setting: format!("{on}; positions as reported"),
        notices: supervisor.notices().to_vec(),
    };
    finish(supervisor.plan(), &facts, &samples, outputs)
}

/// Where the tool was last reported.
fn reported(supervisor: &Supervisor, at: Time) -> Option<Sample> {
    let contouring = supervisor.phase() == Phase::Contouring;
    let kind = if contouring { SampleKind::Run } else { SampleKind::Jog };
    Some(Sample { at, position_mm: point_mm(supervisor.position()?), kind })
}

/// Prints the table, writes what was asked for, and answers with the exit code.
fn finish(
    plan: &CertifiedPlan,
    facts: &RunFacts,
    samples: &[Sample],
    outputs: &Outputs,
) -> Result<ExitCode, CliError> {
    for (name, value) in facts.rows(plan) {
        println!("{name:<36} {value}");
    }
    let title = format!("{}, as run", plan.plan.provenance.name);
    let picture = picture_of_run(plan, &title, samples);
    if let Some(path) = &outputs.picture {
        write(path, picture.as_bytes())?;
        println!("{:<36} {}", "picture", path.display());
    }
    if let Some(path) = &outputs.report {
        write(path, html(plan, facts, &picture).as_bytes())?;
        println!("{:<36} {}", "report", path.display());
    }
    Ok(exit_code(facts))
}

fn exit_code(facts: &RunFacts) -> ExitCode {
    if facts.deepest_mm.is_some_and(|depth| depth > 0.0) {
        return ExitCode::from(8);
    }
    let nothing = facts.loops.0 == facts.loops_before;
    let begun = facts.interrupted && facts.loops.0 < facts.loops.1;
    match facts.ended {
        Ended::Faulted => ExitCode::from(6),
        Ended::OutOfTime => ExitCode::from(9),
        Ended::Done if nothing || begun || facts.partial > 0 || facts.unreached > 0 => ExitCode::from(9),
        Ended::Done => ExitCode::SUCCESS,
    }
}

/// Removes the log that an earlier demo wrote; another's is kept: it may be needed to go on with a part.
fn remove_of_demo(log: &Path, drawing: &str) -> Result<(), CliError> {
    if !log.exists() {
        return Ok(());
    }
    let of_demo = LogReader::open(log)
        .is_ok_and(|reader| reader.header().simulated && reader.header().drawing == drawing);
    if !of_demo {
        return Err(CliError::Argument(format!(
            "{} is no log of a demo: it is not overwritten. Choose another folder with --output.",
            log.display()
        )));
    }
    std::fs::remove_file(log).map_err(|source| CliError::Write { path: log.to_path_buf(), source })
}

pub fn demo(output: &Path, jog_s: f64) -> Result<ExitCode, CliError> {
    let jog_s = seconds("--jog-s", jog_s)?.as_secs_f64();
    std::fs::create_dir_all(output)
        .map_err(|source| CliError::Write { path: output.to_path_buf(), source })?;
    let machine = MachineProfile::simulated();
    println!("1. Plan: a bracket with holes, arcs and an inside corner, 6 mm cutter.\n");
    let plan = make(Path::new("bracket.dxf"), BRACKET, &PlanRequest::default(), &machine, LIMIT_S)?;
    println!("{}\n", plan.summary());
    let log = output.join("session.log");
    remove_of_demo(&log, &plan.plan.provenance.name)?;
    plan_file::save(&plan.plan, &output.join("bracket.plan"))?;
    write(&output.join("plan.svg"), svg(&plan, "bracket.dxf", &[]).as_bytes())?;
    println!(
        "2. Run on the simulated machine: {jog_s:.0} s of an operator pushing at the wall at {:.0} mm/s, over 9600 baud \
         with 150 ms added each way;\n   then the operator touches the part, and the contour is cut.\n",
        machine.max_rate_mm_s
    );
    let run = SimRun { baud: 9600, latency: Duration::from_millis(150), machine, ..SimRun::default() };
    let operator = operator::named("wall", jog_s, run.seed)?;
    let outputs = Outputs { report: Some(output.join("report.html")), picture: Some(output.join("run.svg")) };
    let hands = OperatorSetup { operator, screen: None, panel: Panel::default(), recovers: false };
    let recording =
        Recording { log: Some(&log), operator: "wall", machine: run.machine.name.clone(), simulated: true };
    on_simulation(PreparedPlan::new(plan), &run, hands, &recording, &outputs)
}
