//! A session in virtual time: it repeats byte by byte.

use std::path::Path;
use std::time::Duration;

use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::session::log::{Header, Log, LogWriter};
use keepout_executor::session::replay::replay;
use keepout_executor::session::{Going, SessionSetup, VirtualClock, place_on_table};
use keepout_executor::supervisor::Options;
use keepout_kernel::Height;
use keepout_planner::job::Progress;
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::operator::Script;
use keepout_sim::{PositioningError, SimMachine, SimSettings, VirtualPort, speaking};

use super::job::{Case, FEED_MM_MIN, Job, LATENCY_MS, ORIGIN_MM, SCRIPT, START_MM};

/// Plays a case, checks the replay of its log, and returns the log.
pub fn session(job: &Job, case: Case) -> Result<Log, String> {
    let work = job.work(case);
    let machine = work.plan.plan.machine.clone();
    let dialect_name = DialectName::named(&case.dialect()).map_err(|error| error.to_string())?;
    let place = place_on_table(&work.plan, &machine, Some(ORIGIN_MM)).map_err(|error| error.to_string())?;
    let config = DialectConfig::of(&machine, place.offset);
    let options = Options {
        feed_mm_min: FEED_MM_MIN,
        home: true,
        travel: place.travel,
        heights: place.heights(),
        answer_within: Duration::from_secs(5),
        baud: case.baud,
        progress: Progress::default(),
    };
    let setup = SessionSetup { work: work.clone(), options, dialect: dialect_name.clone(), config };
    let header = Header { simulated: true, ..setup.header().map_err(|error| error.to_string())? };
    let error = PositioningError::wandering(machine.repeatability_mm, machine.steps_per_mm, 1);
    let sim = SimSettings { homed: false, ..SimSettings::of(machine, START_MM.at_height(0.0)) };
    let latency = Duration::from_millis(LATENCY_MS);
    let port =
        VirtualPort { machine: SimMachine::new(speaking(&dialect_name, sim), case.baud, latency, error) };
    let path = job.at(&format!("{}.virtual.log", case.name()));
    let log = LogWriter::create(Path::new(&path), &header).map_err(|error| error.to_string())?;
    let operator = Box::new(Script::parse(SCRIPT).unwrap());
    let mut session = setup.session(port, operator, Box::new(log));
    let mut monitor = CollisionMonitor::new(
        work.levels().clone(),
        work.plan.plan.tool_radius,
        (place.offset, Height::ZERO),
    );
    let ended = session.run(&mut VirtualClock::default(), Duration::from_secs(120), |session, _| {
        let mut samples = Vec::new();
        if let Some(port) = session.port() {
            port.machine.take_samples(&mut samples);
        }
        samples.iter().for_each(|sample| monitor.watch(sample));
        Going::On
    });
    let ended = ended.map_err(|error| error.to_string())?;
    let supervisor = session.into_supervisor();
    if !ended.is_by_operator() || supervisor.finished().len() != 1 || monitor.deepest().is_some() {
        let (fault, notices) = (supervisor.fault(), supervisor.notices());
        return Err(format!("{ended:?}, {fault:?}, {notices:?}, {:?}", monitor.deepest()));
    }
    let log = Log::load(Path::new(&path)).map_err(|error| error.to_string())?;
    replay(&log, work).map_err(|error| error.to_string())?;
    Ok(log)
}
