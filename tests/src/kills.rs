//! Sessions that are killed at some moment, and taken up again: what was logged, what was sent, and what was cut.
//!
//! Each moment is a session of its own, of separate processes: `keepout simulate` is the machine,
//! `keepout run` the executor. One of them is killed, or the cable between them is pulled; then the log
//! is read, compared with what the machine received, and played again, and `keepout run --resume`
//! finishes the contour. A monitor looks at every true position of the tool, before and after.

mod judge;
mod process;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use judge::{JudgedLog, Watched};
use keepout_executor::session::place_on_table;
use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::Vector;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;
use keepout_sim::standalone::{positions, state};
pub use process::{Process, keepout_program};

/// What is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Victim {
    /// The executor's process.
    Executor,
    /// The controller's process; another one is switched on, unhomed, with the tool where it stood.
    Controller,
    /// The cable is pulled and put back.
    Cable,
}

/// A moment at which a session is ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KillMoment {
    /// Its number, and the seed of all that is random in it.
    pub number: u64,
    /// What is killed.
    pub victim: Victim,
    /// When, after the executor was started.
    pub after: Duration,
}

impl KillMoment {
    /// The moment of a number: the victims take turns, the times are random within the session.
    #[must_use]
    pub fn of(number: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(number);
        let victim = match number % 3 {
            0 => Victim::Executor,
            1 => Victim::Controller,
            _ => Victim::Cable,
        };
        Self { number, victim, after: Duration::from_secs_f64(random.f64() * SESSION_S) }
    }
}

/// Feed of the contour, mm/min.
pub const FEED_MM_MIN: u32 = 6000;
/// A session takes about so long, s.
const SESSION_S: f64 = 8.0;
/// The machine comes to the end of what it was sent within this.
const REST_WITHIN: Duration = Duration::from_secs(30);
/// A tool whose place has not changed for this long is at rest.
const AT_REST: Duration = Duration::from_millis(400);
/// A session that was taken up again is over within this.
const RESUMED_WITHIN: Duration = Duration::from_secs(90);

/// What came of a moment in which all was as wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct KillOutcome {
    /// The phase in which the session was ended.
    pub phase: String,
    /// Whether there was something left to be taken up.
    pub resumed: bool,
    /// Commands of both sessions that came out the same when played again.
    pub commands: u64,
    /// Positions that the monitor watched.
    pub watched: u64,
    /// Least distance of tool and part, mm.
    pub closest_mm: f64,
    /// Largest distance of the cut contour from the profile, mm.
    pub worst_mm: f64,
}

/// The plan and the program, prepared once.
#[derive(Debug)]
pub struct Trials {
    program: PathBuf,
    folder: PathBuf,
    plan: PathBuf,
    work: PreparedPlan,
    offset: Vector,
}

/// Where the drawing lies, machine coordinates, mm: near the home position.
const ORIGIN: &str = "-130,-110";
const ORIGIN_MM: (f64, f64) = (-130.0, -110.0);

impl Trials {
    /// Makes the plan, in an empty folder, for sessions of `program`: `keepout`.
    ///
    /// # Errors
    /// What a person would read.
    pub fn new(folder: &Path, program: PathBuf) -> Result<Self, String> {
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
        let machine = MachineProfile::simulated();
        let bytes = include_bytes!("../../executor/cli/drawings/bracket.dxf");
        let plan = PlanRequest::default().plan("bracket.dxf", bytes, &machine, &mut |_| {});
        let plan = plan.map_err(|error| error.to_string())?;
        let file = folder.join("part.plan");
        plan_file::save(&plan.plan, &file).map_err(|error| error.to_string())?;
        let place = place_on_table(&plan, &machine, Some(ORIGIN_MM)).map_err(|error| error.to_string())?;
        Ok(Self {
            program,
            folder: folder.to_path_buf(),
            plan: file,
            work: PreparedPlan::new(plan),
            offset: place.offset,
        })
    }

    /// Goes through a moment. Its files are removed when all was as wanted.
    ///
    /// # Errors
    /// What was not as wanted, and where the files are.
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

/// One moment under way.
struct Trial<'a> {
    trials: &'a Trials,
    folder: PathBuf,
    moment: KillMoment,
}

impl Trial<'_> {
    fn go(&self) -> Result<KillOutcome, String> {
        let mut machine = self.machine(1)?;
        let mut executor = self.executor(&self.operator()?, &["--home"], "first.log")?;
        std::thread::sleep(self.moment.after);
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
            progress.finished.is_empty() || !progress.partial.is_empty()
        });
        let mut commands = first.as_ref().map_or(0, |first| first.replay.counted.commands);
        if left {
            commands += self.finish(first.as_ref(), &phase)?;
        }
        machine.signal("TERM")?;
        machine.wait(REST_WITHIN)?;
        self.judge(phase, left, commands)
    }

    /// The machine, as a process.
    fn machine(&self, number: u32) -> Result<Process, String> {
        let (seed, path) = (self.moment.number.to_string(), |name: &str| self.path(name));
        let (link, state) = (path("port"), path("state"));
        let (received, positions) =
            (path(&format!("received.{number}")), path(&format!("positions.{number}")));
        let arguments = ["simulate", "--link", &link, "--state", &state, "--received", &received];
        let mut arguments = arguments.to_vec();
        arguments.extend(["--positions", &positions, "--seed", &seed]);
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
        arguments.extend(["--operator", operator, "--jog-s", "2.5"]);
        arguments.extend(["--feed-mm-min", feed.as_str()]);
        arguments.extend(["--limit-s", "80", "--seed", &seed]);
        arguments.extend(more);
        Process::start(&self.trials.program, &arguments, &self.folder.join("executor.txt"))
    }

    /// By turns a model, and a script that pauses the contour.
    fn operator(&self) -> Result<String, String> {
        let turn = self.moment.number / 3;
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

    /// Reads a log that holds, of a session with a machine that received this.
    fn log(&self, log: &str, received: &[u8], earlier: &[u8]) -> Result<Option<JudgedLog>, String> {
        let may_be_torn = self.moment.victim == Victim::Executor;
        JudgedLog::of(&self.folder.join(log), received, earlier, may_be_torn, &self.trials.work)
    }

    /// Takes the contour up again and finishes it; how many commands that took.
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
        if code != Some(0) {
            return Err(format!("taken up again, it ended with exit code {code:?}"));
        }
        // Another machine has received nothing of the first session.
        let (machine, earlier) = match (self.moment.victim, first) {
            (Victim::Controller, _) => (2, &[][..]),
            (_, first) => (1, first.map_or(&[][..], |first| &first.sent)),
        };
        let second = self.log("second.log", &self.received(machine)?, earlier)?;
        let second = second.ok_or("there is no second log")?;
        second.goes_on_from(first)?;
        Ok(second.replay.counted.commands)
    }

    /// Looks at the true positions of the tool.
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
