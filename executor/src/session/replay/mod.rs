//! The replay of a log: the guard certifies every command again, and the output must be the same.
//!
//! Implements SR-23.
//!
//! There are two checks. First, the engine receives the logged inputs, and must give the logged outputs, byte
//! by byte. Second, a check without the guard tests each certificate against the part: the swept triangles
//! over the logged in-flight set, or the motion of the contour. [`check_certificates`] makes the second check
//! alone.

mod certificate;
mod certificates;
mod error;
mod motion_texts;
mod timeline;

use std::collections::VecDeque;
use std::io::BufRead;
use std::time::Duration;

use certificate::CertificateRules;
pub use certificates::{CertificateCheck, check_certificates, check_certificates_from};
pub use error::ReplayError;
use keepout_guard::Time;
use keepout_kernel::Place;
use keepout_planner::job::Progress;
use keepout_planner::{plan_file, sha256, text_file};
pub use motion_texts::MotionTextFault;
pub use timeline::{PhaseTimes, Timeline, TimelineEntry};

use super::engine::Engine;
use super::event_log::{Certificate, EventLog, EventLogError, LoggedEvent};
use super::log::{Entry, Header, Log, LogReader};
use super::outcome::{Ending, JobOutcome};
use crate::dialect::{DialectConfig, DialectName};
use crate::session::{SessionSetup, TablePlacement};
use crate::supervisor::{Options, Phase, PreparedPlan, Supervisor};

/// The result of a replay.
pub struct Replay {
    /// The supervisor at the end of the log.
    pub supervisor: Supervisor,
    /// The counts of the replay.
    pub counted: Counted,
    /// The timeline of the session.
    pub timeline: Timeline,
    /// The last logged phase, and the fault that caused it.
    pub last_phase: Option<(Phase, Option<String>)>,
    /// Whether the time limit ended the session.
    pub time_limit: bool,
}

/// The counts of a replay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// The time of the last entry.
    pub ended: Time,
    /// Chunks of bytes to the controller that match the log byte by byte.
    pub commands: u64,
    /// Certificates that hold by themselves.
    pub certificates: u64,
    /// Jog inputs.
    pub inputs: u64,
    /// Lines from the controller.
    pub replies: u64,
}

impl Replay {
    /// The outcome of the job, up to the end of the log.
    #[must_use]
    pub fn outcome(&self) -> JobOutcome {
        outcome(&self.supervisor, self.last_phase.as_ref(), self.time_limit)
    }
}

/// The outcome of a session whose log ends here.
fn outcome(
    supervisor: &Supervisor,
    last_phase: Option<&(Phase, Option<String>)>,
    time_limit: bool,
) -> JobOutcome {
    match last_phase {
        Some((Phase::Faulted, fault)) => {
            JobOutcome::of(supervisor, Ending::Fault(fault.clone().unwrap_or_default()))
        }
        Some((Phase::Done, _)) if !time_limit => JobOutcome::by_operator(supervisor),
        Some((Phase::Done, _)) => JobOutcome::of(supervisor, Ending::TimeLimit),
        other => JobOutcome::of(supervisor, Ending::NotEnded(other.map(|(phase, _)| *phase))),
    }
}

/// The outputs of the engine during a replay.
#[derive(Default)]
struct Outcome {
    events: VecDeque<LoggedEvent<'static>>,
}

impl EventLog for Outcome {
    fn take(&mut self, _: Time, event: &LoggedEvent<'_>) -> Result<(), EventLogError> {
        if !event.is_input() {
            self.events.push_back(event.clone().into_owned());
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), EventLogError> {
        Ok(())
    }
}

/// Replays a log.
///
/// # Errors
/// [`ReplayError`], which names the first line that does not hold.
pub fn replay(log: &Log, work: PreparedPlan) -> Result<Replay, ReplayError> {
    let mut player = Player::new(&log.header, work)?;
    for entry in &log.entries {
        player.play(entry)?;
    }
    Ok(player.end())
}

/// Replays a log while it reads it.
///
/// # Errors
/// [`ReplayError`], which names the first line that does not hold.
pub fn replay_from<R: BufRead>(log: &mut LogReader<R>, work: PreparedPlan) -> Result<Replay, ReplayError> {
    let mut player = Player::new(log.header(), work)?;
    for entry in log {
        player.play(&entry?)?;
    }
    Ok(player.end())
}

fn check_plan(header: &Header, work: &PreparedPlan) -> Result<(), ReplayError> {
    let given = sha256::hex(&sha256::hash(&plan_file::encode(&work.plan.plan)?));
    if header.plan == given {
        return Ok(());
    }
    Err(ReplayError::OtherPlan { logged: text_file::shown(&header.plan), given })
}

/// The dialect of a log's session.
fn dialect_of(header: &Header) -> Result<DialectName, ReplayError> {
    let dialect = DialectName::named(&header.dialect)?;
    let (given, logged) = (dialect.hash(), &header.description);
    if logged.is_empty() || *logged == given {
        return Ok(dialect);
    }
    let shown = text_file::shown;
    Err(ReplayError::OtherDialect { file: shown(&header.dialect), logged: shown(logged), given })
}

/// The set-up of a log's session on its plan, with this progress of earlier sessions.
fn setup_of(header: &Header, work: PreparedPlan, progress: Progress) -> Result<SessionSetup, ReplayError> {
    check_plan(header, &work)?;
    if work.plan.plan.relief.is_some() && header.z.is_none() {
        return Err(ReplayError::NoThirdAxis);
    }
    let z = header.z.as_ref().map(|z| z.place());
    let place = TablePlacement { offset: header.offset, travel: header.travel, z };
    let config = DialectConfig { travel_mm: header.travel_mm, ..place.config(&work.plan.plan.machine) };
    let options = Options {
        feed_mm_min: header.feed_mm_min,
        home: header.home,
        travel: header.travel,
        heights: place.heights(),
        answer_within: Duration::from_millis(header.answer_within_ms),
        baud: header.baud,
        progress,
    };
    Ok(SessionSetup { work, options, dialect: dialect_of(header)?, config })
}

struct Player {
    engine: Engine,
    outcome: Outcome,
    counted: Counted,
    timeline: Timeline,
    last_phase: Option<(Phase, Option<String>)>,
    /// The target of the last certified motion since a start.
    last: Option<Place>,
    time_limit: bool,
}

impl Player {
    fn new(header: &Header, work: PreparedPlan) -> Result<Self, ReplayError> {
        let setup = setup_of(header, work, header.progress.clone())?;
        header.progress.check(&setup.work.plan)?;
        let engine = setup.engine();
        Ok(Self {
            timeline: Timeline::of(&engine.supervisor),
            engine,
            outcome: Outcome::default(),
            counted: Counted::default(),
            last_phase: None,
            last: None,
            time_limit: false,
        })
    }

    fn play(&mut self, entry: &Entry) -> Result<(), ReplayError> {
        let at = entry.at;
        self.counted.ended = at;
        self.timeline.pass(self.engine.supervisor.phase(), at);
        let log = &mut self.outcome;
        if entry.event.is_input()
            && let Some(extra) = log.events.pop_front()
        {
            return Err(differs(entry, "nothing", &brief(&extra)));
        }
        let engine = &mut self.engine;
        let fed = match &entry.event {
            LoggedEvent::Received(bytes) => {
                self.counted.replies += bytes.iter().map(|&byte| u64::from(byte == b'\n')).sum::<u64>();
                engine.receive(bytes, at, log)
            }
            LoggedEvent::Input(input) => {
                self.counted.inputs += 1;
                engine.input(*input, at, log)
            }
            LoggedEvent::Command(command) => engine.command(*command, at, log),
            LoggedEvent::Tick => engine.tick(at, log),
            LoggedEvent::Job(job) => engine.job((**job).clone(), at, log),
            LoggedEvent::PortLost(reason) => engine.port_lost(reason, at, log),
            LoggedEvent::PortFound => engine.port_found(at, log),
            LoggedEvent::Halt => engine.halt(at, log),
            LoggedEvent::TimeLimit => {
                self.time_limit = true;
                engine.time_limit(at, log)
            }
            LoggedEvent::Outcome(logged) => return self.compare_outcome(entry, logged),
            LoggedEvent::Sent(_) | LoggedEvent::Certificate(_) | LoggedEvent::Phase { .. } => {
                return self.compare(entry);
            }
        };
        fed.map_err(|error| differs(entry, "an input", &error.to_string()))?;
        engine.drain(|_| {});
        self.timeline.see(&engine.supervisor, &entry.event, at);
        Ok(())
    }

    fn compare(&mut self, entry: &Entry) -> Result<(), ReplayError> {
        let played = self.outcome.events.pop_front();
        if played.as_ref() != Some(&entry.event) {
            let played = played.as_ref().map_or("nothing".into(), brief);
            return Err(differs(entry, &brief(&entry.event), &played));
        }
        match &entry.event {
            LoggedEvent::Sent(_) => self.counted.commands += 1,
            LoggedEvent::Certificate(certificate) => {
                self.check(certificate).map_err(|reason| ReplayError::NotCertified {
                    line: entry.line,
                    seconds: entry.at.elapsed().as_secs_f64(),
                    reason,
                })?;
                self.counted.certificates += 1;
            }
            LoggedEvent::Phase { phase, fault } => {
                self.last = self.last.filter(|_| *phase != Phase::Starting);
                self.last_phase = Some((*phase, fault.clone()));
            }
            _ => {}
        }
        Ok(())
    }

    /// Checks the logged outcome. A session that did not come to rest within its time has no phase for it.
    fn compare_outcome(&self, entry: &Entry, logged: &str) -> Result<(), ReplayError> {
        let supervisor = &self.engine.supervisor;
        let played = outcome(supervisor, self.last_phase.as_ref(), self.time_limit);
        let in_motion =
            self.time_limit && JobOutcome::of(supervisor, Ending::TimeLimit).to_string() == logged;
        if in_motion || played.to_string() == logged {
            return Ok(());
        }
        Err(differs(entry, logged, &played.to_string()))
    }

    /// Checks a certificate by itself.
    fn check(&mut self, certificate: &Certificate) -> Result<(), String> {
        let supervisor = &self.engine.supervisor;
        // The log has a change of phase after the bytes of that step. So the motion may belong to either
        // phase.
        let before = self.last_phase.as_ref().map(|(phase, _)| *phase);
        let retracts = supervisor.phase() == Phase::Retracting || before == Some(Phase::Retracting);
        let (levels, rules) = (supervisor.work().levels(), supervisor.guard().rules());
        CertificateRules { levels, rules, retracts }.check(certificate, self.last)?;
        self.last = Some(certificate.target());
        if let Certificate::Contour { curve, .. } = certificate {
            self.timeline.sent(curve);
        }
        Ok(())
    }

    fn end(self) -> Replay {
        Replay {
            counted: self.counted,
            timeline: self.timeline,
            last_phase: self.last_phase,
            time_limit: self.time_limit,
            supervisor: self.engine.supervisor,
        }
    }
}

/// Most characters of an event in a message.
const BRIEF: usize = 200;

fn differs(entry: &Entry, logged: &str, played: &str) -> ReplayError {
    ReplayError::Differs {
        line: entry.line,
        seconds: entry.at.elapsed().as_secs_f64(),
        logged: logged.into(),
        played: played.into(),
    }
}

/// The beginning of an event's text, for a message.
fn brief(event: &LoggedEvent<'_>) -> String {
    let whole = match event {
        LoggedEvent::Sent(bytes) => format!("sent \"{}\"", bytes.escape_ascii()),
        other => format!("{other:?}"),
    };
    let mut characters = whole.chars();
    let mut brief: String = characters.by_ref().take(BRIEF).collect();
    if characters.next().is_some() {
        brief.push('…');
    }
    brief
}
