//! Sessions that the test kills at a random moment, and resumes. It checks the log, the sent bytes and the
//! cut.
//!
//! Each moment is a session of its own, in separate processes: `keepout simulate` is the machine, `keepout
//! run` is the executor. The test kills one of them, or pulls the cable between them. Then it compares the
//! log with the bytes that the machine received, and replays the log. `keepout run --resume` finishes the
//! contour. A collision monitor checks every true position of the tool, before and after.

mod judge;
mod process;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use judge::{JudgedLog, Watched};
use keepout_executor::session::outcome::Ending;
use keepout_executor::session::place_on_table;
use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::{Height, Vector};
use keepout_planner::Mm2;
use keepout_planner::depth::{DepthParameters, EntryMove, FaceChoice, FaceDepth};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;
use keepout_sim::standalone::{positions, state};
pub use process::{Process, keepout_program};

/// The part of the set-up that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Victim {
    /// The test kills the executor's process.
    Executor,
    /// The test kills the controller's process. It starts another one, unhomed, with the tool at the same
    /// place.
    Controller,
    /// The test pulls the cable, and puts it back.
    Cable,
}

/// A moment at which the test ends a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KillMoment {
    /// Its number. It is the seed of the whole moment.
    pub number: u64,
    /// The part that fails.
    pub victim: Victim,
    /// The time since the start of the executor, as a share of a session.
    pub after: f64,
}

impl KillMoment {
    /// The moment of a number. The victims take turns, and the times are random within the session.
    #[must_use]
    pub fn of(number: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(number);
        let victim = match number % 3 {
            0 => Victim::Executor,
            1 => Victim::Controller,
            _ => Victim::Cable,
        };
        Self { number, victim, after: random.f64() }
    }

    fn share(self, session_s: f64) -> Duration {
        Duration::from_secs_f64(self.after * session_s)
    }
}

/// Feed of the contour, mm/min.
pub const FEED_MM_MIN: u32 = 6000;
/// Longest time until the machine has executed all received motions.
const REST_WITHIN: Duration = Duration::from_secs(30);
/// A tool that has not moved for this time is in position.
const AT_REST: Duration = Duration::from_millis(400);
/// Longest duration of a resumed session.
const RESUMED_WITHIN: Duration = Duration::from_secs(90);

/// The figures of a moment that passed all checks.
#[derive(Clone, Debug, PartialEq)]
pub struct KillOutcome {
    /// The phase in which the session ended.
    pub phase: String,
    /// Whether a second session resumed the contour.
    pub resumed: bool,
    /// Commands of both sessions that match in the replay.
    pub commands: u64,
    /// Positions that the collision monitor checked.
    pub watched: u64,
    /// Least distance of tool and part, mm.
    pub closest_mm: f64,
    /// Largest distance of the cut contour from the profile, mm.
    pub worst_mm: f64,
}

/// The plan and the program, which all moments share.
#[derive(Debug)]
pub struct Trials {
    program: PathBuf,
    folder: PathBuf,
    plan: PathBuf,
    part: KilledPart,
    work: PreparedPlan,
    offset: (Vector, Height),
}

/// The exit code of a session that leaves contours.
const INCOMPLETE: i32 = 9;
/// The exit code of a session that cuts every contour.
const COMPLETE: i32 = 0;
/// The drawing's origin, machine coordinates, mm: near the home position.
const ORIGIN: &str = "-130,-110";
const ORIGIN_MM: Mm2 = Mm2::new(-130.0, -110.0);
/// Machine coordinate of the top of the part with depths, mm.
const TOP: &str = "-12";
const TOP_MM: f64 = -12.0;

/// The part of the killed sessions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KilledPart {
    /// A bracket on two axes. The tool cuts its outline; the holes would need a tool that rises.
    Flat,
    /// A cover with two holes and a pocket, at two depths.
    Deep,
}

impl KilledPart {
    /// Its certified plan, and the machine.
    fn plan(self) -> Result<(CertifiedPlan, MachineProfile), String> {
        let mut request = PlanRequest::default();
        let (name, bytes, machine) = match self {
            Self::Flat => (
                "bracket.dxf",
                &include_bytes!("../../executor/cli/drawings/bracket.dxf")[..],
                MachineProfile::simulated(),
            ),
            Self::Deep => {
                let pocket = FaceDepth { of: FaceChoice::Layer("POCKET".into()), depth_mm: Some(1.0) };
                let depths = DepthParameters { entry: EntryMove::Plunge, ..DepthParameters::of(2.0) };
                request.job.depth = Some(DepthParameters { faces: vec![pocket], ..depths });
                let bytes = &include_bytes!("../../executor/cli/drawings/cover.dxf")[..];
                ("cover.dxf", bytes, MachineProfile::simulated_three_axes())
            }
        };
        let plan = request.plan(name, bytes, &machine, &mut |_| {}).map_err(|error| error.to_string())?;
        Ok((plan, machine))
    }

    /// How the resumed session ends: its exit code, its ending, and the contours that are cut then.
    fn end(self) -> (i32, Ending, usize) {
        match self {
            Self::Flat => (INCOMPLETE, Ending::Incomplete, 1),
            Self::Deep => (COMPLETE, Ending::Complete, 4),
        }
    }

    /// Duration of a session, about, s.
    fn session_s(self) -> f64 {
        match self {
            Self::Flat => 8.0,
            Self::Deep => 16.0,
        }
    }
}

impl Trials {
    /// Makes the plan in an emptied folder, for sessions of `program`, which is `keepout`.
    ///
    /// # Errors
    /// The message for the operator.
    pub fn new(folder: &Path, program: PathBuf, part: KilledPart) -> Result<Self, String> {
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
        let (plan, machine) = part.plan()?;
        let file = folder.join("part.plan");
        plan_file::save(&plan.plan, &file).map_err(|error| error.to_string())?;
        let place = place_on_table(&plan, &machine, Some(ORIGIN_MM))
            .and_then(|place| place.with_top(&plan, Some(TOP_MM)))
            .map_err(|error| error.to_string())?;
        Ok(Self {
            program,
            folder: folder.to_path_buf(),
            plan: file,
            work: PreparedPlan::new(plan),
            offset: (place.offset, place.z.map_or(Height::ZERO, |z| z.zero)),
            part,
        })
    }

    /// Runs a moment. It removes the moment's files if all checks pass.
    ///
    /// # Errors
    /// The failed check, and the folder of the files.
    pub fn go(&self, moment: KillMoment) -> Result<KillOutcome, String> {
        let folder = self.folder.join(format!("{:05}", moment.number));
        std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
        let trial = Trial { trials: self, folder: folder.clone(), moment };
        let outcome = trial.go();
        match outcome {
            Ok(outcome) => {
                let _ = std::fs::remove_dir_all(&folder);
                Ok(outcome)
            }
            Err(reason) => Err(format!("{moment:?}: {reason} (see {})", folder.display())),
        }
    }
}

/// A moment that runs.
struct Trial<'a> {
    trials: &'a Trials,
    folder: PathBuf,
    moment: KillMoment,
}

impl Trial<'_> {
    fn go(&self) -> Result<KillOutcome, String> {
        let mut machine = self.machine(1)?;
        let mut executor = self.executor(&self.operator()?, &["--home"], "first.log")?;
        std::thread::sleep(self.moment.share(self.trials.part.session_s()));
        match self.moment.victim {
            Victim::Executor => executor.kill()?,
            Victim::Controller => machine.kill()?,
            Victim::Cable => machine.signal("USR1")?,
        }
        executor.wait(REST_WITHIN)?;
        if self.moment.victim == Victim::Controller {
            machine = self.machine(2)?;
        }
        self.rest()?;
        let first = self.log("first.log", &self.received(1)?, &[])?;
        let phase = first.as_ref().map_or(String::new(), |first| format!("{:?}", first.phase));
        let left = first.as_ref().is_none_or(|first| {
            let progress = first.replay.supervisor.progress();
            let wanted = match self.trials.part {
                KilledPart::Flat => 1,
                KilledPart::Deep => self.trials.work.plan.plan.loop_count(),
            };
            progress.finished.len() < wanted || !progress.partial.is_empty()
        });
        let mut commands = first.as_ref().map_or(0, |first| first.replay.counted.commands);
        if left {
            commands += self.finish(first.as_ref(), &phase)?;
        }
        machine.signal("TERM")?;
        machine.wait(REST_WITHIN)?;
        self.judge(phase, left, commands)
    }

    /// Starts the simulated machine as a process.
    fn machine(&self, number: u32) -> Result<Process, String> {
        let (seed, path) = (self.moment.number.to_string(), |name: &str| self.path(name));
        let (link, state) = (path("port"), path("state"));
        let (received, positions) =
            (path(&format!("received.{number}")), path(&format!("positions.{number}")));
        let arguments = ["simulate", "--link", &link, "--state", &state, "--received", &received];
        let mut arguments = arguments.to_vec();
        arguments.extend(["--positions", &positions, "--seed", &seed]);
        if self.trials.part == KilledPart::Deep {
            arguments.push("--three-axes");
        }
        let machine = Process::start(&self.trials.program, &arguments, &self.folder.join("machine.txt"))?;
        let begun = Instant::now();
        while !self.folder.join("port").exists() {
            if begun.elapsed() > REST_WITHIN {
                return Err("the simulated machine does not start".into());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(machine)
    }

    fn executor(&self, operator: &str, more: &[&str], log: &str) -> Result<Process, String> {
        let (plan, port, log) = (self.trials.plan.display().to_string(), self.path("port"), self.path(log));
        let (seed, feed) = (self.moment.number.to_string(), FEED_MM_MIN.to_string());
        let mut arguments = vec!["run", &plan, "--port", &port, "--origin-mm", ORIGIN, "--log", &log];
        arguments.extend(["--simulate", "--yes"]);
        arguments.extend(["--operator", operator, "--jog-s", "2.5"]);
        arguments.extend(["--feed-mm-min", feed.as_str()]);
        arguments.extend(["--limit-s", "80", "--seed", &seed]);
        if self.trials.part == KilledPart::Deep {
            arguments.extend(["--top-mm", TOP]);
        }
        arguments.extend(more);
        Process::start(&self.trials.program, &arguments, &self.folder.join("executor.txt"))
    }

    /// The operator: a model and a script with a feed hold, in turns.
    fn operator(&self) -> Result<String, String> {
        let turn = self.moment.number / 3;
        if self.trials.part == KilledPart::Deep {
            return Ok(if turn.is_multiple_of(2) { "wall" } else { "calm" }.into());
        }
        if turn.is_multiple_of(2) {
            return Ok(if turn.is_multiple_of(4) { "wall" } else { "calm" }.into());
        }
        let script =
            "0 -0.7 -0.7\n1 0.4 -0.9\n1.4 -0.9 0.3\n2 -0.6 -0.6 auto\n4 pause\n5.5 resume\n6 0 0 auto\n";
        std::fs::write(self.folder.join("script"), script).map_err(|error| error.to_string())?;
        Ok(self.path("script"))
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    /// Waits until the tool stands still.
    fn rest(&self) -> Result<(), String> {
        let begun = Instant::now();
        let look = || state(&self.folder.join("state")).map_err(|error| error.to_string());
        let (mut at, mut since) = (look()?, Instant::now());
        while since.elapsed() < AT_REST {
            std::thread::sleep(Duration::from_millis(20));
            let here = look()?;
            if here != at {
                (at, since) = (here, Instant::now());
            }
            if begun.elapsed() > REST_WITHIN {
                return Err("the tool does not come to rest".into());
            }
        }
        Ok(())
    }

    fn received(&self, machine: u32) -> Result<Vec<u8>, String> {
        std::fs::read(self.folder.join(format!("received.{machine}"))).map_err(|error| error.to_string())
    }

    /// Reads and checks a log. `received` are the bytes that the machine received.
    fn log(&self, log: &str, received: &[u8], earlier: &[u8]) -> Result<Option<JudgedLog>, String> {
        let may_be_torn = self.moment.victim == Victim::Executor;
        JudgedLog::of(&self.folder.join(log), received, earlier, may_be_torn, &self.trials.work)
    }

    /// Resumes the contour and finishes it. Returns the count of commands.
    fn finish(&self, first: Option<&JudgedLog>, phase: &str) -> Result<u64, String> {
        let log = self.path("first.log");
        let homed = self.moment.victim != Victim::Controller && !["", "Starting"].contains(&phase);
        let home = if homed { "--homed" } else { "--home" };
        let mut more = vec![home];
        if first.is_some() {
            more.extend(["--resume", &log]);
        }
        let mut executor = self.executor("calm", &more, "second.log")?;
        let code = executor.wait(RESUMED_WITHIN)?;
        let (wanted, ending, cut) = self.trials.part.end();
        if code != Some(wanted) {
            return Err(format!("the resumed session ended with exit code {code:?}"));
        }
        // A new machine has received no bytes of the first session.
        let (machine, earlier) = match (self.moment.victim, first) {
            (Victim::Controller, _) => (2, &[][..]),
            (_, first) => (1, first.map_or(&[][..], |first| &first.sent)),
        };
        let second = self.log("second.log", &self.received(machine)?, earlier)?;
        let second = second.ok_or("there is no second log")?;
        second.goes_on_from(first)?;
        let outcome = second.replay.outcome();
        if outcome.ending != ending || outcome.tally.cut != cut {
            return Err(format!("the resumed session ended as \"{outcome}\""));
        }
        Ok(second.replay.counted.commands)
    }

    /// Checks the true positions of the tool.
    fn judge(&self, phase: String, resumed: bool, commands: u64) -> Result<KillOutcome, String> {
        let mut machines = Vec::new();
        for number in 1..=2 {
            let path = self.folder.join(format!("positions.{number}"));
            if path.exists() {
                machines.push(positions(&path).map_err(|error| error.to_string())?);
            }
        }
        let Watched { positions: watched, closest_mm, worst_mm } =
            Watched::of(&machines, &self.trials.work, self.trials.offset)?;
        Ok(KillOutcome { phase, resumed, commands, watched, closest_mm, worst_mm })
    }
}
