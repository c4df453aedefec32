//! What judges killed sessions objects to faults that are seeded: in logs, in how a session is taken up,
//! and in where the tool was.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};
use std::time::Duration;

use keepout_executor::session::log::{Header, LogWriter};
use keepout_executor::session::{Going, Sample, SampleKind};
use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_kernel::Vector;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimRun, run_scene};
use keepout_tests::kills::{JudgedLog, Watched};

/// Where no drawing is moved: samples are in drawing coordinates.
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

/// A session in virtual time that ends after a while at the latest; where the tool truly was.
fn session(work: &PreparedPlan, limit_s: u64, progress: Progress, log: &Path) -> Vec<Sample> {
    let limit = Duration::from_secs(limit_s);
    let run = SimRun { limit, progress, feed_mm_min: 3000, ..SimRun::default() };
    let scene = Scene::of(work.clone(), &run).unwrap();
    let header = Header { simulated: true, ..scene.setup.header().unwrap() };
    let tape = Box::new(LogWriter::create(log, &header).unwrap());
    let operator = operator::named("calm", 2.0, 1).unwrap();
    let watch = &mut |_: &_, _: &_, _| Going::On;
    run_scene(&run, scene, operator, tape, watch).unwrap().samples
}

fn objects<T>(words: &str, judgement: Result<T, String>) {
    let said = judgement.err().unwrap_or_else(|| panic!("nobody noticed: {words}"));
    assert!(said.contains(words), "not for {words}, but for: {said}");
}

#[test]
fn to_logs_that_lack_what_was_sent_or_were_changed() {
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
    // The last record that was flushed before something was sent is not there.
    let lines: Vec<&[u8]> = whole.split_inclusive(|&byte| byte == b'\n').collect();
    let is_sent = |line: &&[u8]| line.windows(16).any(|part| part == br#""event":{"sent":"#);
    let last = lines.iter().rposition(is_sent).unwrap();
    objects("received what is not logged", judged(&lines[..last].concat(), true));
    // One in the middle is not there, or another.
    let middle = lines[..last].iter().rposition(is_sent).unwrap();
    let without = [&lines[..middle], &lines[middle + 1..]].concat().concat();
    objects("does not match its checksum", judged(&without, true));
    let mut changed = whole.clone();
    changed[whole.len() / 2] ^= 1;
    objects("line ", judged(&changed, true));
    // A tail that only a kill can leave.
    objects("torn though nobody killed", judged(&whole[..whole.len() - 3], false));
    judged(&whole[..whole.len() - 3], true).unwrap().unwrap();
    objects("no keepout log", judged(b"", true));
}

#[test]
fn to_sessions_that_are_taken_up_without_the_log() {
    let (work, folder) = (work(), folder("taken-up"));
    let run = |name: &str, limit_s, progress| {
        let path = folder.join(name);
        session(&work, limit_s, progress, &path);
        JudgedLog::of(&path, &[], &[], false, &work).unwrap().unwrap()
    };
    let first = run("first.log", 9, Progress::default());
    let left = first.replay.supervisor.progress();
    assert_eq!((first.phase, left.partial.len()), (Phase::Stopping, 1));
    run("second.log", 60, left).goes_on_from(Some(&first)).unwrap();
    let anew = run("anew.log", 60, Progress::default());
    objects("taken up with", anew.goes_on_from(Some(&first)));
    anew.goes_on_from(None).unwrap();
    objects("taken up with", run("more.log", 60, first.replay.supervisor.progress()).goes_on_from(None));
}

#[test]
fn to_a_tool_in_the_part_and_to_a_contour_that_is_not_cut() {
    let (work, folder) = (work(), folder("positions"));
    let samples = session(&work, 60, Progress::default(), &folder.join("session.log"));
    let judged = |samples: Vec<Sample>| Watched::of(&[samples], &work, HERE);
    judged(samples.clone()).unwrap();
    let cuts: Vec<usize> =
        (0..samples.len()).filter(|&index| samples[index].kind == SampleKind::Run).collect();
    let (from, to) = (cuts[cuts.len() / 3], cuts[cuts.len() / 2]);
    // A stretch is not cut: the tool is moved there by hand instead.
    let mut by_hand = samples.clone();
    by_hand[from..to].iter_mut().for_each(|sample| sample.kind = SampleKind::Jog);
    objects("the contour is not cut", judged(by_hand));
    // Once off toward the middle of the part: by a tenth of a millimetre or less, and half-way.
    for share in [0.002, 0.5] {
        let mut inside = samples.clone();
        let ((low_x, low_y), (high_x, high_y)) = box_of(&samples);
        let (x, y) = inside[from].position_mm;
        let toward = |at: f64, low: f64, high: f64| at + share * (f64::midpoint(low, high) - at);
        inside[from].position_mm = (toward(x, low_x, high_x), toward(y, low_y, high_y));
        objects("the tool was in the part", judged(inside));
    }
}

fn box_of(samples: &[Sample]) -> ((f64, f64), (f64, f64)) {
    let mut corners = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
    for sample in samples.iter().filter(|sample| sample.kind == SampleKind::Run) {
        let (x, y) = sample.position_mm;
        corners.0 = (corners.0.0.min(x), corners.0.1.min(y));
        corners.1 = (corners.1.0.max(x), corners.1.1.max(y));
    }
    corners
}
