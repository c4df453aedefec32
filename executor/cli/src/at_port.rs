//! A session at a port, whoever steers it.

use std::path::Path;
use std::time::Duration;

use keepout_executor::operator::Operator;
#[cfg(unix)]
use keepout_executor::session::outcome::JobOutcome;
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{
    Going, RealClock, RunFacts, Sample, SampleKind, SessionSetup, TablePlacement,
};
use keepout_executor::supervisor::{Options, Phase, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_planner::job::Progress;
use keepout_planner::units::place_mm;

use super::run::{LogFacts, dialect_name};
use super::{CliError, RunArguments};
#[cfg(unix)]
use super::{
    align::placed,
    before::{limit, place, refuse_incomplete, refuse_margin_of_simulation, refuse_unknown_top},
    plan::load,
    resume::progress_before,
    run::{Outputs, finish},
};

/// Checks the longest answer time, 0.5 to 60 s.
///
/// Below 0.5 s a healthy controller that homes or starts would count as silent. After 60 s the operator no
/// longer watches.
fn answer_within(arguments: &RunArguments) -> Result<Duration, CliError> {
    let given = arguments.answer_within_s;
    if (0.5..=60.0).contains(&given) {
        Ok(Duration::from_secs_f64(given))
    } else {
        Err(CliError::Argument(format!("--answer-within-s {given} is not between 0.5 and 60 s")))
    }
}

/// A session at a port.
pub struct PortSession<'a> {
    pub work: PreparedPlan,
    pub place: TablePlacement,
    pub arguments: &'a RunArguments,
    pub progress: Progress,
    pub log: Option<&'a Path>,
    pub operator: &'a str,
    pub limit: Duration,
}

/// A callback after every round of a session at a port.
pub type WatchPort<'a> = dyn FnMut(&Supervisor, Time) -> Going + 'a;

impl PortSession<'_> {
    /// Runs the session to its end. The operator may be able to recover from a fault.
    pub fn run(
        self,
        port: Serial,
        (operator, recovers): (Box<dyn Operator + Send>, bool),
        watch: &mut WatchPort<'_>,
    ) -> Result<(Supervisor, RunFacts, Vec<Sample>), CliError> {
        let Self { work, place, arguments, progress, log, limit, .. } = self;
        let machine = work.plan.plan.machine.clone();
        let options = Options {
            feed_mm_min: arguments.feed_mm_min(),
            home: arguments.home,
            travel: place.travel,
            heights: place.heights(),
            answer_within: answer_within(arguments)?,
            baud: arguments.baud(),
            progress,
        };
        let (dialect, config) = (dialect_name(arguments)?, place.config(&machine));
        let setup = SessionSetup { work, options, dialect, config };
        let name = arguments.port.clone().unwrap_or_default();
        let on = format!("{} on {name}, {} baud", machine.name, arguments.baud());
        let recording = LogFacts {
            log,
            operator: self.operator,
            machine: on.clone(),
            simulated: arguments.simulate,
            dry_run: arguments.dry_run,
        };
        let event_log = recording.event_log(&setup)?;
        let mut session = setup.session(port, operator, event_log);
        if recovers {
            let baud = arguments.baud();
            session = session.recovering(Box::new(move || Serial::open(&name, baud)));
        }
        let mut samples: Vec<Sample> = Vec::new();
        let mut last = Time::ZERO;
        let outcome = session.run(&mut RealClock::default(), limit, |session, now| {
            let supervisor = session.supervisor();
            last = now;
            let sample = reported(supervisor, now).filter(|_| samples.len() < 2_000_000);
            let before = samples.last().map(|last| last.position_mm);
            samples.extend(sample.filter(|sample| before != Some(sample.position_mm)));
            watch(supervisor, now)
        })?;
        let supervisor = session.into_supervisor();
        let facts = RunFacts {
            setting: format!("{on}; positions as reported"),
            ..RunFacts::of(&supervisor, outcome, last.elapsed().as_secs_f64())
        };
        Ok((supervisor, facts, samples))
    }
}

/// A run of a job that the panel steers. It ends with the job's report, as a run on the terminal does.
#[cfg(unix)]
pub fn steered(
    arguments: &RunArguments,
    operator: Box<dyn Operator + Send>,
    prepared: &mut dyn FnMut(&PreparedPlan),
    watch: &mut WatchPort<'_>,
) -> Result<JobOutcome, CliError> {
    let plan = load(&arguments.plan, arguments.time)?;
    let arguments = &placed(arguments, &plan)?;
    let work = PreparedPlan::new(plan);
    let progress = progress_before(arguments, &work)?;
    refuse_incomplete(arguments)?;
    refuse_margin_of_simulation(arguments, &work.plan.plan.machine)?;
    refuse_unknown_top(arguments, &work.plan)?;
    let place = place(&work.plan, &work.plan.plan.machine, arguments)?;
    let outputs = Outputs::of(arguments, arguments.log.clone());
    prepared(&work);
    let port = Serial::open(arguments.port.as_deref().unwrap_or_default(), arguments.baud())?;
    let limit = limit(arguments.limit_s, true)?;
    let log = outputs.log.as_deref();
    let at_port = PortSession { work, place, arguments, progress, log, operator: "panel", limit };
    let (supervisor, facts, samples) = at_port.run(port, (operator, true), watch)?;
    finish(supervisor.work(), &facts, &samples, &outputs)?;
    Ok(facts.outcome)
}

/// The sample of the tool's last reported position.
fn reported(supervisor: &Supervisor, at: Time) -> Option<Sample> {
    let contouring = supervisor.phase() == Phase::Contouring;
    let kind = if contouring { SampleKind::Run } else { SampleKind::Jog };
    Some(Sample { at, position_mm: place_mm(supervisor.position()?), kind })
}
