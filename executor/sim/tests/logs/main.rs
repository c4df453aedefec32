//! The log of a session: it is complete and true, and every change of it is detected.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod cable;

use std::path::{Path, PathBuf};
use std::time::Duration;

use cable::{Cable, unplugged};
use keepout_executor::operator::Operator;
use keepout_executor::session::log::{Header, Log, LogReadError, LogWriter};
use keepout_executor::session::outcome::{Ending, JobOutcome};
use keepout_executor::session::replay::{Replay, ReplayError, TimelineEntry, replay};
use keepout_executor::session::{EventLog, EventLogError, Going, LoggedEvent, VirtualClock, start_inside};
use keepout_executor::supervisor::{Phase, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::job::{LoopNumber, Progress};
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::operator::{self, Script};
use keepout_sim::session::{Scene, SimRun, run_scene};

fn work() -> PreparedPlan {
    let bytes = include_bytes!("../../../cli/drawings/bracket.dxf");
    let plan =
        PlanRequest::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap();
    PreparedPlan::new(plan)
}

fn file(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("logs-{name}.log"));
    let _ = std::fs::remove_file(&path);
    path
}

fn header(scene: &Scene) -> Header {
    Header { simulated: true, ..scene.setup.header().unwrap() }
}

/// The log of a session on the simulated machine.
fn logged(
    name: &str,
    work: &PreparedPlan,
    run: &SimRun,
    operator: Box<dyn Operator + Send>,
) -> (PathBuf, JobOutcome) {
    let path = file(name);
    let scene = Scene::of(work.clone(), run).unwrap();
    let event_log = LogWriter::create(&path, &header(&scene)).unwrap();
    let watch = &mut |_: &Supervisor, _: &CollisionMonitor, _: Time| Going::On;
    let result = run_scene(run, scene, operator, Box::new(event_log), watch).unwrap();
    assert!(result.facts.deepest_mm.unwrap() <= 0.0);
    (path, result.facts.outcome)
}

/// From home to the part's right edge, then with the cycle armed, and a feed hold.
const PAUSED: &str = "0 -1 -0.9\n1.6 -0.3 -0.3 auto\n12 pause\n14 resume\n15 0 0 auto\n";

fn short(name: &str) -> (PreparedPlan, Vec<u8>) {
    let work = work();
    let run = SimRun { feed_mm_min: 6000, limit: Duration::from_secs(60), ..SimRun::default() };
    let (path, ended) = logged(name, &work, &run, operator::named("wall", 3.0, 1).unwrap());
    assert!(ended.is_by_operator(), "{ended}");
    (work, std::fs::read(path).unwrap())
}

fn holds(log: &Log, work: &PreparedPlan) -> Replay {
    let replay = replay(log, work.clone()).unwrap_or_else(|error| panic!("{error}"));
    let sent = log.entries.iter().filter(|entry| matches!(entry.event, LoggedEvent::Sent(_))).count();
    assert_eq!(replay.counted.commands, u64::try_from(sent).unwrap());
    assert!(replay.counted.certificates > 0 && log.torn == 0);
    replay
}

#[test]
fn sessions_replay_without_difference() {
    let work = work();
    for (name, operator, homed) in
        [("home", "wall", false), ("homed", "random", true), ("calm", "calm", true)]
    {
        let start = homed.then(|| keepout_planner::units::point_from_mm(Mm2::new(-30.0, -30.0)).unwrap());
        let run = SimRun { start, feed_mm_min: 3000, seed: 4, ..SimRun::default() };
        let (path, ended) = logged(name, &work, &run, operator::named(operator, 8.0, 4).unwrap());
        assert!(ended.is_by_operator(), "{ended}");
        let log = Log::load(&path).unwrap();
        assert_eq!(log.header.home, !homed);
        let replay = holds(&log, &work);
        assert!(replay.outcome().is_by_operator(), "{}", replay.outcome());
        assert_eq!(replay.supervisor.finished().len(), 1);
        let spent = replay.timeline.spent;
        assert!(spent.by_hand >= Duration::from_secs(8) && spent.contouring > Duration::from_secs(5));
        assert!(replay.timeline.closest_mm().unwrap().0 > 0.0);
    }
}

/// Loops in a log's header that the plan lacks, or that are listed twice, would count as cut.
#[test]
fn progress_of_another_plan_is_refused() {
    let (work, log) = short("claims");
    let mut log = Log::parse(&log).unwrap();
    log.entries.clear();
    let number = |pass, index| LoopNumber { pass, index };
    for finished in [vec![number(9, 9)], vec![number(0, 0), number(0, 1), number(0, 0)]] {
        log.header.progress = Progress { finished, partial: Vec::new() };
        let error = replay(&log, work.clone()).err().expect("the progress is not of this plan").to_string();
        assert!(error.starts_with("line 1 of the log: "), "{error}");
    }
}

#[test]
fn feed_hold_is_replayed_and_in_the_timeline() {
    let work = work();
    let script = Box::new(Script::parse(PAUSED).unwrap());
    let (path, ended) = logged("paused", &work, &SimRun { feed_mm_min: 1200, ..SimRun::default() }, script);
    assert!(ended.is_by_operator(), "{ended}");
    let replay = holds(&Log::load(&path).unwrap(), &work);
    assert_eq!(replay.supervisor.finished().len(), 1);
    let timeline: Vec<&TimelineEntry> =
        replay.timeline.happenings.iter().map(|(_, entry, _)| entry).collect();
    assert!(
        timeline.contains(&&TimelineEntry::Held) && replay.timeline.spent.held >= Duration::from_millis(1900),
        "{timeline:?}"
    );
}

#[test]
fn session_stopped_by_its_time_limit_replays() {
    let work = work();
    let run = SimRun { limit: Duration::from_secs(6), ..SimRun::default() };
    let (path, ended) = logged("limit", &work, &run, operator::named("calm", 60.0, 1).unwrap());
    assert_eq!(ended.ending, Ending::TimeLimit);
    assert_eq!(holds(&Log::load(&path).unwrap(), &work).outcome(), ended);
}

#[test]
fn lost_port_and_recovery_replay() {
    let work = work();
    let run = SimRun { start: Some(start_inside(&work.plan).unwrap()), ..SimRun::default() };
    let scene = Scene::of(work.clone(), &run).unwrap();
    let path = file("lost");
    let cable = Cable::to(&work, &run, &scene);
    let event_log = LogWriter::create(&path, &header(&scene)).unwrap();
    let script = "0 0 -0.3\n1 0 0.3 auto\n9 recover\n12 resume\n13 0 0\n90 quit\n";
    let script = Box::new(Script::parse(script).unwrap());
    let again = cable.clone();
    let reopen =
        Box::new(move || if again.0.borrow().is_connected() { Ok(again.clone()) } else { Err(unplugged()) });
    let mut session = scene.setup.session(cable.clone(), script, Box::new(event_log)).recovering(reopen);
    let mut pulled_in = None;
    session
        .run(&mut VirtualClock::default(), Duration::from_secs(200), |session, now| {
            let pulled = (5.0..7.0).contains(&now.elapsed().as_secs_f64());
            if pulled == cable.0.borrow().is_connected() {
                pulled_in.get_or_insert(session.supervisor().phase());
                cable.0.borrow_mut().connect(!pulled);
            }
            Going::On
        })
        .unwrap();
    drop(session);
    assert_eq!(pulled_in, Some(Phase::Contouring));
    let log = Log::load(&path).unwrap();
    let count = |wanted: fn(&LoggedEvent<'_>) -> bool| {
        log.entries.iter().filter(|entry| wanted(&entry.event)).count()
    };
    assert_eq!(count(|event| matches!(event, LoggedEvent::PortLost(_))), 1);
    assert_eq!(count(|event| matches!(event, LoggedEvent::PortFound)), 1);
    let replay = holds(&log, &work);
    let timeline: Vec<&TimelineEntry> =
        replay.timeline.happenings.iter().map(|(_, entry, _)| entry).collect();
    assert!(
        timeline.iter().any(|each| matches!(each, TimelineEntry::Fault(_)))
            && timeline.contains(&&TimelineEntry::Recovered)
    );
    assert_eq!(replay.supervisor.finished().len(), 1, "{timeline:?}");
}

#[test]
fn another_plan_or_dialect_is_refused() {
    let (work, bytes) = short("other");
    let mut log = Log::parse(&bytes).unwrap();
    log.header.plan = "00".into();
    assert!(matches!(replay(&log, work.clone()), Err(ReplayError::OtherPlan { .. })));
    let mut log = Log::parse(&bytes).unwrap();
    log.header.dialect = "klingon".into();
    assert!(matches!(replay(&log, work.clone()), Err(ReplayError::DialectName(_))));
    // An intact log of a session that acted otherwise: the error names the line of the difference.
    let mut log = Log::parse(&bytes).unwrap();
    let first =
        log.entries.iter().position(|entry| matches!(entry.event, LoggedEvent::Certificate(_))).unwrap();
    log.entries.remove(first);
    let line = match replay(&log, work.clone()) {
        Err(ReplayError::Differs { line, .. }) => line,
        other => panic!("{:?}", other.err()),
    };
    assert_eq!(line, first + 3);
    let mut log = Log::parse(&bytes).unwrap();
    let sent = log.entries.iter().rposition(|entry| matches!(entry.event, LoggedEvent::Sent(_))).unwrap();
    log.entries[sent].event = LoggedEvent::Sent(b"G0X0Y0\n".to_vec().into());
    assert!(matches!(replay(&log, work), Err(ReplayError::Differs { line, .. }) if line == sent + 2));
}

fn damaged_at(bytes: &[u8]) -> Option<usize> {
    match Log::parse(bytes) {
        Err(LogReadError::Damaged { line }) => Some(line),
        // The header's own line.
        Err(LogReadError::NoLog { .. }) => Some(1),
        _ => None,
    }
}

#[test]
fn every_flipped_bit_is_detected_with_its_line() {
    let (_, bytes) = short("flipped");
    let ends: Vec<usize> = (0..bytes.len()).filter(|&index| bytes[index] == b'\n').collect();
    let line_of = |index: usize| ends.partition_point(|&end| end < index) + 1;
    // Every bit of the first lines, then random bits of all lines.
    let first_lines = &bytes[..=ends[59]];
    let mut changed = first_lines.to_vec();
    for index in 0..first_lines.len() - 1 {
        for bit in 0..8 {
            changed[index] ^= 1 << bit;
            assert_eq!(damaged_at(&changed), Some(line_of(index)), "byte {index}, bit {bit}");
            changed[index] ^= 1 << bit;
        }
    }
    let mut random = fastrand::Rng::with_seed(2);
    let mut changed = bytes.clone();
    for _ in 0..1500 {
        let (index, bit) = (random.usize(0..bytes.len() - 1), random.u8(0..8));
        changed[index] ^= 1 << bit;
        assert_eq!(damaged_at(&changed), Some(line_of(index)), "byte {index}, bit {bit}");
        changed[index] ^= 1 << bit;
    }
}

#[test]
fn tail_torn_at_any_byte_is_tolerated() {
    let (work, bytes) = short("torn");
    let whole = Log::parse(&bytes).unwrap();
    let ends: Vec<usize> = (0..bytes.len()).filter(|&index| bytes[index] == b'\n').collect();
    let first = ends[ends.len() - 25];
    for length in first + 1..=bytes.len() {
        let log = Log::parse(&bytes[..length]).unwrap();
        let lines = bytes[..length].iter().filter(|&&byte| byte == b'\n').count();
        assert_eq!(log.entries, whole.entries[..lines - 1], "{length} bytes");
        assert_eq!(log.torn, length - ends[lines - 1] - 1, "{length} bytes");
    }
    // A log that ends at any line replays.
    for lines in (2..whole.entries.len()).step_by(97) {
        let log = Log::parse(&bytes[..ends[lines] + 3]).unwrap();
        assert!(log.torn == 2 || log.torn == 0);
        replay(&log, work.clone()).unwrap_or_else(|error| panic!("{lines} lines: {error}"));
    }
    assert!(matches!(Log::parse(&bytes[..ends[0]]), Err(LogReadError::NoLog { .. })));
    assert!(matches!(Log::parse(b""), Err(LogReadError::NoLog { .. })));
}

#[test]
fn lines_changed_removed_swapped_or_duplicated_are_detected() {
    let (_, bytes) = short("swapped");
    let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let mut random = fastrand::Rng::with_seed(9);
    for _ in 0..300 {
        let at = random.usize(1..lines.len() - 1);
        let mut removed = lines.clone();
        removed.remove(at);
        assert_eq!(damaged_at(&removed.concat()), Some(at + 1), "line {} removed", at + 1);
        let mut doubled = lines.clone();
        doubled.insert(at, lines[at]);
        assert_eq!(damaged_at(&doubled.concat()), Some(at + 2), "line {} doubled", at + 1);
        let mut swapped = lines.clone();
        swapped.swap(at, at + 1);
        assert_eq!(damaged_at(&swapped.concat()), Some(at + 1), "line {} swapped", at + 1);
        // Cut off before its checksum, so that the next line follows directly.
        let mut cut = lines.clone();
        cut[at] = &lines[at][..lines[at].len() - 9];
        assert_eq!(damaged_at(&cut.concat()), Some(at + 1), "line {} cut", at + 1);
        // Another log's line.
        let mut foreign = lines.clone();
        foreign[at] = b"0 h\t00000000\n";
        assert_eq!(damaged_at(&foreign.concat()), Some(at + 1), "line {} replaced", at + 1);
    }
}

/// A log on a disk that is full after `left` events.
struct Filling {
    log: LogWriter,
    left: usize,
}

impl EventLog for Filling {
    fn take(&mut self, now: Time, record: &LoggedEvent<'_>) -> Result<(), EventLogError> {
        self.left = self.left.checked_sub(1).ok_or(std::io::Error::from(std::io::ErrorKind::StorageFull))?;
        self.log.take(now, record)
    }

    fn flush(&mut self) -> Result<(), EventLogError> {
        self.log.flush()
    }
}

#[test]
fn full_disk_stops_the_machine_and_leaves_a_valid_log() {
    let work = work();
    let run = SimRun { start: Some(start_inside(&work.plan).unwrap()), ..SimRun::default() };
    // While jogging, at the wall, in the contour.
    for left in [5, 100, 700, 1300, 1900] {
        let scene = Scene::of(work.clone(), &run).unwrap();
        let path = file("full");
        let cable = Cable::to(&work, &run, &scene);
        let mut monitor = scene.monitor();
        let log = LogWriter::create(&path, &header(&scene)).unwrap();
        let operator = operator::named("wall", 5.0, 1).unwrap();
        let event_log = Box::new(Filling { log, left });
        let mut session = scene.setup.session(cable.clone(), operator, event_log);
        let mut last = Time::ZERO;
        let ended = session.run(&mut VirtualClock::default(), run.limit, |_, now| {
            last = now;
            Going::On
        });
        assert!(matches!(ended, Err(EventLogError::Write(_))), "{left}: {ended:?}");
        drop(session);
        let settled = last.after(Duration::from_secs(2));
        cable.samples(settled).iter().for_each(|sample| monitor.watch(sample));
        let later = cable.samples(settled.after(Duration::from_secs(30)));
        assert!(
            later.windows(2).all(|pair| pair[0].position_mm == pair[1].position_mm),
            "{left}: the tool moves on"
        );
        assert_eq!(monitor.deepest(), None);
        let log = Log::load(&path).unwrap();
        assert_eq!((log.entries.len(), log.torn), (left, 0));
        replay(&log, work.clone()).unwrap_or_else(|error| panic!("{left}: {error}"));
    }
}
