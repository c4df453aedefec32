//! The checks of killed sessions report seeded faults: in logs, in resumed sessions, and in tool positions.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};
use std::time::Duration;

use keepout_executor::session::log::{Header, LogWriter};
use keepout_executor::session::{Going, Sample, SampleKind};
use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_kernel::{Height, Vector};
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_planner::{Mm2, Mm3};
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimRun, run_scene};
use keepout_tests::kills::{JudgedLog, Watched};

/// No offset: the samples are in drawing coordinates.
const HERE: Vector = Vector { dx: 0, dy: 0 };

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("kill-judge-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn work() -> PreparedPlan {
    let bytes = include_bytes!("../../executor/cli/drawings/bracket.dxf");
    let machine = MachineProfile::simulated();
    PreparedPlan::new(PlanRequest::default().plan("bracket.dxf", bytes, &machine, &mut |_| {}).unwrap())
}

/// Runs a session in virtual time for at most `limit_s`, and returns the true positions of the tool.
fn session(work: &PreparedPlan, limit_s: u64, progress: Progress, log: &Path) -> Vec<Sample> {
    let limit = Duration::from_secs(limit_s);
    let run = SimRun { limit, progress, feed_mm_min: 3000, ..SimRun::default() };
    let scene = Scene::of(work.clone(), &run).unwrap();
    let header = Header { simulated: true, ..scene.setup.header().unwrap() };
    let event_log = Box::new(LogWriter::create(log, &header).unwrap());
    let operator = operator::named("calm", 2.0, 1).unwrap();
    let watch = &mut |_: &_, _: &_, _| Going::On;
    run_scene(&run, scene, operator, event_log, watch).unwrap().samples
}

fn objects<T>(words: &str, judgement: Result<T, String>) {
    let message = judgement.err().unwrap_or_else(|| panic!("no check reported: {words}"));
    assert!(message.contains(words), "expected {words}, found: {message}");
}

#[test]
fn incomplete_and_changed_logs_are_reported() {
    let (work, folder) = (work(), folder("logs"));
    let path = folder.join("whole.log");
    session(&work, 6, Progress::default(), &path);
    let received = JudgedLog::of(&path, &[], &[], false, &work).unwrap().unwrap().sent;
    let judged = |bytes: &[u8], may_be_torn: bool| {
        let path = folder.join("seeded.log");
        std::fs::write(&path, bytes).unwrap();
        JudgedLog::of(&path, &received, &[], may_be_torn, &work)
    };
    let whole = std::fs::read(&path).unwrap();
    judged(&whole, false).unwrap().unwrap();
    // The log lacks its end, from the last sent bytes on.
    let lines: Vec<&[u8]> = whole.split_inclusive(|&byte| byte == b'\n').collect();
    let is_sent = |line: &&[u8]| line.windows(16).any(|part| part == br#""event":{"sent":"#);
    let last = lines.iter().rposition(is_sent).unwrap();
    objects("received bytes that are not in the log", judged(&lines[..last].concat(), true));
    // The log lacks a line in the middle, or has a changed byte.
    let middle = lines[..last].iter().rposition(is_sent).unwrap();
    let without = [&lines[..middle], &lines[middle + 1..]].concat().concat();
    objects("does not match its checksum", judged(&without, true));
    let mut changed = whole.clone();
    changed[whole.len() / 2] ^= 1;
    objects("line ", judged(&changed, true));
    // Only a kill can leave an incomplete last line.
    objects("the executor was not killed", judged(&whole[..whole.len() - 3], false));
    judged(&whole[..whole.len() - 3], true).unwrap().unwrap();
    objects("no keepout log", judged(b"", true));
}

#[test]
fn session_resumed_without_the_log_is_reported() {
    let (work, folder) = (work(), folder("resumed"));
    let run = |name: &str, limit_s, progress| {
        let path = folder.join(name);
        session(&work, limit_s, progress, &path);
        JudgedLog::of(&path, &[], &[], false, &work).unwrap().unwrap()
    };
    let first = run("first.log", 9, Progress::default());
    let left = first.replay.supervisor.progress();
    assert_eq!((first.phase, left.partial.len()), (Phase::Stopping, 1));
    run("second.log", 60, left).goes_on_from(Some(&first)).unwrap();
    let fresh = run("fresh.log", 60, Progress::default());
    objects("resumed with", fresh.goes_on_from(Some(&first)));
    fresh.goes_on_from(None).unwrap();
    objects("resumed with", run("more.log", 60, first.replay.supervisor.progress()).goes_on_from(None));
}

#[test]
fn collision_monitor_reports_gouge_and_uncut_contour() {
    let (work, folder) = (work(), folder("positions"));
    let samples = session(&work, 60, Progress::default(), &folder.join("session.log"));
    let judged = |samples: Vec<Sample>| Watched::of(&[samples], &work, (HERE, Height::ZERO));
    judged(samples.clone()).unwrap();
    let cuts: Vec<usize> =
        (0..samples.len()).filter(|&index| samples[index].kind == SampleKind::Run).collect();
    let (from, to) = (cuts[cuts.len() / 3], cuts[cuts.len() / 2]);
    // The samples of a stretch become jogging, so that the contour is not cut there.
    let mut by_hand = samples.clone();
    by_hand[from..to].iter_mut().for_each(|sample| sample.kind = SampleKind::Jog);
    objects("the contour is not cut", judged(by_hand));
    // One sample moves toward the middle of the part: by 0.2 % of the distance (0.1 mm or less), and by half
    // of it.
    for share in [0.002, 0.5] {
        let mut inside = samples.clone();
        let (Mm2 { x: low_x, y: low_y }, Mm2 { x: high_x, y: high_y }) = box_of(&samples);
        let Mm3 { x, y, .. } = inside[from].position_mm;
        let toward = |at: f64, low: f64, high: f64| at + share * (f64::midpoint(low, high) - at);
        inside[from].position_mm =
            Mm2::new(toward(x, low_x, high_x), toward(y, low_y, high_y)).at_height(0.0);
        objects("the tool was in the part", judged(inside));
    }
}

fn box_of(samples: &[Sample]) -> (Mm2, Mm2) {
    let (mut low, mut high) = (Mm2::new(f64::MAX, f64::MAX), Mm2::new(f64::MIN, f64::MIN));
    for sample in samples.iter().filter(|sample| sample.kind == SampleKind::Run) {
        (low, high) = (low.min(sample.position_mm.plane()), high.max(sample.position_mm.plane()));
    }
    (low, high)
}
