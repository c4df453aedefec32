//! Logs of honest sessions: an operator at the wall of the demo part in each language, a part with depths, and hostile
//! operators on random drawings.

use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::session::Going;
use keepout_executor::session::log::{Header, LogWriter};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::depth::{DepthParameters, FaceChoice, FaceDepth};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::plan::PlanParameters;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimRun, run_scene};
use keepout_tests::hostile::{Spec, Worlds, play_logged};

use crate::lines::{contents, event, log_of};

/// The log of a session, with its plan.
#[derive(Clone)]
pub struct HonestSession {
    pub name: String,
    pub work: PreparedPlan,
    /// The plan file.
    pub plan: Vec<u8>,
    pub log: Vec<u8>,
    /// Whether the tool begins inside the jogging clearance.
    pub begins_inside: bool,
    /// Whether the header has all of the session's options. That of a hostile session has not, so it cannot replay.
    pub replays: bool,
}

impl HonestSession {
    fn of(name: String, work: PreparedPlan, log: Vec<u8>) -> Self {
        let plan = plan_file::encode(&work.plan.plan).unwrap();
        Self { name, work, plan, log, begins_inside: false, replays: true }
    }

    /// The same session with at most so many lines: without operator inputs and ticks, the first and the last lines.
    pub fn shortened(&self, most: usize) -> Self {
        let needed = |content: &String| !["", "input", "tick"].contains(&event(content));
        let mut lines = contents(&self.log);
        let header = lines.remove(0);
        lines.retain(needed);
        let left_out = lines.len().saturating_sub(most);
        // Not between a certificate and its text, nor between a report and the texts that need its work offset.
        let armed = lines.iter().rposition(|content| content.contains("$#")).map_or(0, |at| at + 30);
        let first = lines.len().min((most / 2).max(armed));
        let last = (first + left_out).min(lines.len());
        let gap =
            |at: usize| (at..lines.len()).find(|&at| event(&lines[at]) != "sent").unwrap_or(lines.len());
        let (first, last) = (gap(first), gap(last).max(gap(first)));
        lines.drain(first..last);
        lines.insert(0, header);
        Self { log: log_of(&lines), ..self.clone() }
    }
}

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("independent-replay-sessions")
}

/// All sessions.
pub fn sessions() -> &'static [HonestSession] {
    static SESSIONS: OnceLock<Vec<HonestSession>> = OnceLock::new();
    SESSIONS.get_or_init(|| {
        std::fs::create_dir_all(folder()).unwrap();
        let mut sessions = demo_sessions();
        sessions.extend(hostile_sessions());
        sessions
    })
}

const DESCRIBED: [&str; 2] = ["ok-style.toml", "three-axes.toml"];

/// The built-in languages, and two described ones.
fn languages() -> Vec<DialectName> {
    let described = DESCRIBED
        .map(|name| format!("{}/../executor/sim/tests/described/{name}", env!("CARGO_MANIFEST_DIR")));
    let names = DialectName::NAMES.into_iter().map(String::from).chain(described);
    names.map(|name| DialectName::named(&name).unwrap()).collect()
}

/// The demo part and the cover with a pocket, with an operator at the wall, in each language that can.
fn demo_sessions() -> Vec<HonestSession> {
    let mut sessions = Vec::new();
    let machine = MachineProfile { z: Some(ZProfile::simulated()), ..MachineProfile::simulated() };
    let bracket = include_bytes!("../../../executor/cli/drawings/bracket.dxf");
    let cover = include_bytes!("../../../executor/cli/drawings/cover.dxf");
    let pocket = FaceDepth { of: FaceChoice::Layer("POCKET".into()), depth_mm: Some(3.0) };
    let depth = DepthParameters { faces: vec![pocket], step_down_mm: Some(2.0), ..DepthParameters::of(6.0) };
    let job = PlanParameters { depth: Some(depth), ..PlanParameters::default() };
    let deep = PlanRequest { job, ..PlanRequest::default() };
    for (request, bytes, name) in
        [(PlanRequest::default(), &bracket[..], "bracket"), (deep, &cover[..], "cover")]
    {
        let plan = request.plan(name, bytes, &machine, &mut |_| {}).unwrap();
        let work = PreparedPlan::new(plan);
        for (number, dialect) in (1..).zip(languages()) {
            let run = SimRun {
                machine: machine.clone(),
                dialect: dialect.clone(),
                servo: None,
                seed: number,
                feed_mm_min: 3000,
                limit: Duration::from_secs(90),
                ..SimRun::default()
            };
            // Not every language moves the axes of every plan.
            let Ok(scene) = Scene::of(work.clone(), &run) else { continue };
            let path = folder().join(format!("{name}-{number}.log"));
            let _ = std::fs::remove_file(&path);
            let header = Header { simulated: true, ..scene.setup.header().unwrap() };
            let log = LogWriter::create(&path, &header).unwrap();
            let operator = operator::named("wall", 4.0, number).unwrap();
            run_scene(&run, scene, operator, Box::new(log), &mut |_, _, _| Going::On).unwrap();
            let name = format!("{name} in {}", dialect.name());
            sessions.push(HonestSession::of(name, work.clone(), std::fs::read(path).unwrap()));
        }
    }
    sessions
}

/// Sessions with hostile operators on random drawings, in each language. One in four begins inside the jogging
/// clearance. Some of the links are impaired.
fn hostile_sessions() -> Vec<HonestSession> {
    let mut sessions = Vec::new();
    for language in languages() {
        for three_axes in [false, true] {
            let worlds = Worlds { real: Vec::new(), languages: vec![language.clone()], three_axes };
            let made = (1..40).filter_map(|seed| worlds.world(seed)).take(4);
            for (number, world) in (0..).zip(made) {
                let mut spec = Spec::of(number * 7 + 1);
                spec.begins_inside = number == 1 && !world.inside.is_empty();
                spec.automatic = number % 2 == 0;
                spec.limit = spec.limit.min(Duration::from_secs(30));
                spec.driven = false;
                if number < 2 {
                    spec.faults.clear();
                }
                let name =
                    format!("{}-{three_axes}-{number}", language.name().replace(['/', '.', '\\'], "_"));
                let path = folder().join(format!("{}.log", &name[name.len().saturating_sub(60)..]));
                let _ = std::fs::remove_file(&path);
                play_logged(&world, &spec, &path).unwrap();
                let log = std::fs::read(&path).unwrap();
                let session = HonestSession::of(name, world.work, log);
                sessions.push(HonestSession { begins_inside: spec.begins_inside, replays: false, ..session });
            }
        }
    }
    sessions
}
