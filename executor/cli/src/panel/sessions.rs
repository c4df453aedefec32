//! The sessions of the panel, each in its own thread: touching off, dry runs, and cutting.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use clap::Parser as _;
use keepout_executor::session::outcome::ContourTally;
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{Going, NoEventLog, RealClock};
use keepout_executor::supervisor::{PreparedPlan, Supervisor};
use keepout_panel::bench::{SessionKind, SessionWords};
use keepout_panel::hub::{Hub, SessionWindow};

use super::desk::{Desk, DeskNews};
use crate::arguments::{Arguments, CliCommand};
use crate::at_port::steered;
use crate::error::CliError;
use crate::job::JobFolder;
use crate::run_arguments::RunArguments;
use crate::store::StoredMachine;
use crate::take::{climbs, touch_session};
use crate::taken::{SpindleStands, TakeOutcome, TakenPlaces};

/// Longest session of a person.
const LONGEST: Duration = Duration::from_secs(24 * 3600);
/// Most notices that the page shows.
const NOTICES_MAX: usize = 4;

/// A session that runs.
#[derive(Debug)]
pub struct Running {
    pub kind: SessionKind,
    /// Set to end it: the machine comes to rest first.
    pub halt: Arc<AtomicBool>,
    /// Number of places that the operator asked to take.
    pub takes: Arc<AtomicUsize>,
    pub thread: JoinHandle<()>,
}

/// What a session needs.
pub struct SessionOrder {
    pub kind: SessionKind,
    pub home: bool,
    pub job: JobFolder,
    pub machine: StoredMachine,
    /// The machine is simulated: its log says so.
    pub simulated: bool,
    /// The log of the run that this one continues.
    pub resume: Option<PathBuf>,
    /// Number of places to touch.
    pub touches: usize,
}

/// Starts a session.
pub fn start(desk: &Arc<Desk>, order: SessionOrder) -> std::io::Result<Running> {
    let (kind, halt, takes) = (order.kind, Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
    let (desk, halted, asked) = (Arc::clone(desk), Arc::clone(&halt), Arc::clone(&takes));
    let work = move || {
        let hub = desk.hub.clone();
        let told = match order.kind {
            SessionKind::Touch => touch(&desk, &hub, &order, &halted, &asked).map(|()| None),
            SessionKind::DryRun | SessionKind::Cut => cut(&desk, &hub, &order, &halted).map(Some),
        };
        hub.session_ended();
        desk.session_ended(order.kind, told.map_err(|error| error.to_string()));
    };
    let thread = std::thread::Builder::new().name("session".into()).spawn(work)?;
    Ok(Running { kind, halt, takes, thread })
}

/// Lets the operator touch places, and tells the desk each one.
fn touch(
    desk: &Desk,
    hub: &Hub,
    order: &SessionOrder,
    halt: &AtomicBool,
    takes: &AtomicUsize,
) -> Result<(), CliError> {
    let setup = touch_session(&order.machine, order.home)?;
    let port = Serial::open(&order.machine.port, order.machine.baud)?;
    let operator = Box::new(SpindleStands::new(hub.operator(), climbs(&order.machine)?));
    let mut session = setup.session(port, operator, Box::new(NoEventLog));
    let (mut shown, mut places, mut seen) = (Shown::new(hub, order.kind), TakenPlaces::default(), 0);
    let outcome = session.run(&mut RealClock::default(), LONGEST, |session, now| {
        let supervisor = session.supervisor();
        shown.show(desk, supervisor);
        let left = places.taken.len() < order.touches;
        let key = left && takes.load(Ordering::Relaxed) > seen;
        seen = takes.load(Ordering::Relaxed);
        match places.watch(supervisor, key, now) {
            TakeOutcome::Nothing => {}
            TakeOutcome::Taken(at) => desk.hear(DeskNews::Taken(at)),
            TakeOutcome::Refused(reason) => desk.hear(DeskNews::Told(reason.into())),
        }
        // After the last place the person raises the tool first.
        if halt.load(Ordering::Relaxed) { Going::Halt } else { Going::On }
    })?;
    match outcome.fault() {
        Some(fault) => Err(CliError::Stopped(fault.to_string())),
        None => Ok(()),
    }
}

/// Runs the job. Returns the outcome in words.
fn cut(desk: &Desk, hub: &Hub, order: &SessionOrder, halt: &AtomicBool) -> Result<String, CliError> {
    let arguments = arguments_of(order)?;
    let mut shown = Shown::new(hub, order.kind);
    let mut prepared = |work: &PreparedPlan| desk.hear(DeskNews::Prepared(Box::new(work.clone())));
    let outcome = steered(&arguments, Box::new(hub.operator()), &mut prepared, &mut |supervisor, _| {
        shown.show(desk, supervisor);
        if halt.load(Ordering::Relaxed) { Going::Halt } else { Going::On }
    })?;
    Ok(outcome.to_string())
}

/// The arguments of a run of the job.
fn arguments_of(order: &SessionOrder) -> Result<RunArguments, CliError> {
    let folder = order.job.folder.to_string_lossy().into_owned();
    let homing = if order.home { "--home" } else { "--homed" };
    let parsed = Arguments::try_parse_from(["keepout", "run", &folder, homing, "--yes"]);
    let Ok(Arguments { command: CliCommand::Run(given) }) = parsed else {
        return Err(CliError::Argument(format!("{folder} cannot be run from the panel")));
    };
    let machine = &order.machine;
    order.job.run_arguments(&RunArguments {
        dry_run: order.kind == SessionKind::DryRun,
        resume: order.resume.clone(),
        port: Some(machine.port.clone()),
        dialect: Some(machine.dialect.clone()),
        baud: Some(machine.baud),
        simulate: order.simulated,
        ..given
    })
}

/// Shows a session to the page: numbers after every round, words when they change.
struct Shown {
    window: SessionWindow,
    kind: SessionKind,
    words: (usize, usize),
    begun: bool,
}

impl Shown {
    fn new(hub: &Hub, kind: SessionKind) -> Self {
        Self { window: hub.window(), kind, words: (0, 0), begun: false }
    }

    fn show(&mut self, desk: &Desk, supervisor: &Supervisor) {
        self.window.show(supervisor);
        let words = (supervisor.finished().len(), supervisor.notices().len());
        if words == self.words && self.begun {
            return;
        }
        let notices = supervisor.notices();
        let last = notices.iter().skip(notices.len().saturating_sub(NOTICES_MAX)).map(ToString::to_string);
        let said = SessionWords { tally: ContourTally::of(supervisor).to_string(), notices: last.collect() };
        // A dry run and a touch-off cut nothing.
        let cuts = self.kind == SessionKind::Cut && (words.0 != self.words.0 || !self.begun);
        if desk.say(said) {
            if cuts {
                desk.hear(DeskNews::Progressed(supervisor.progress()));
            }
            (self.words, self.begun) = (words, true);
        }
    }
}
