//! Building copies with faults in them, and running the programs that must notice.

use std::io;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use super::results::{FaultFate, FaultRow};
use super::{FaultEngine, SeededFault, tree, workspace};
use crate::model_check::run::{ModelChecker, ModelVerdict};
use crate::model_check::tools::Tools;

/// The property groups that notice faults outside the kernel.
const OUTSIDE_THE_KERNEL: &str = "guard,heights,dialects";
/// The group that notices faults of the dialects: a choice without the worlds, which run no dialect.
const DIALECTS: &str = "dialects";

/// Seconds that `check` may take for one fault.
const CHECK_S: u64 = 600;
/// Exit code of `timeout` when the time is over.
const TIMED_OUT: i32 = 124;

/// Sessions that the hostile simulation plays, up to the first verdict.
const SESSIONS: [&str; 9] =
    ["--seed", "1", "--hours", "1000000", "--per-drawing", "60", "--threads", "1", "--first"];

/// Where copies lie and what is built of them, and how long the hostile simulation may look for one fault.
#[derive(Clone, Copy, Debug)]
pub struct Workshop<'a> {
    /// A folder for the copies.
    pub folder: &'a Path,
    /// Minutes of hostile simulation for one fault.
    pub minutes: f64,
}

impl Workshop<'_> {
    /// Runs the chosen faults of the catalogue (numbers from 1 on) under the chosen engines, prints a
    /// line for each and gives the row to `keep`, with the number. Fuzz targets have a runner of their own,
    /// `cargo run -p keepout-fuzz --example seeded`.
    ///
    /// # Errors
    /// When a tree cannot be copied, an edit's place is not there once, or a program cannot be run; or the error of
    /// `keep`.
    pub fn run(
        &self,
        catalogue: &[SeededFault],
        chosen: impl Fn(usize, FaultEngine) -> bool,
        mut keep: impl FnMut(usize, FaultRow) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut built = false;
        for (fault, number) in catalogue.iter().zip(1..) {
            for engine in fault.engines().into_iter().filter(|engine| *engine != FaultEngine::Fuzz) {
                if !chosen(number, engine) {
                    continue;
                }
                if fault.is_switched() && engine.runs_switched() && !built {
                    self.build_switched(catalogue)?;
                    built = true;
                }
                let begin = Instant::now();
                let fate = match engine {
                    FaultEngine::Hostile => self.hostile(fault, number)?,
                    FaultEngine::Tests => self.tests(fault)?,
                    FaultEngine::Model => self.model(fault)?,
                    FaultEngine::Theorem => self.theorem(fault)?,
                    _ if fault.is_switched() => self.check(&mut self.switched_check(number), fault)?,
                    _ => self.check_alone(fault)?,
                };
                let equivalent = fate == FaultFate::Survived && fault.equivalent.is_some();
                let fate = if equivalent { FaultFate::Equivalent } else { fate };
                let seconds = begin.elapsed().as_secs();
                println!("{number}\t{}\t{}\t{fate}\t{seconds} s", fault.name, engine.name());
                keep(number, FaultRow::new(fault, engine, fate, seconds))?;
            }
        }
        Ok(())
    }

    fn cargo(&self, tree: &Path, arguments: &[&str]) -> io::Result<Output> {
        let mut command = Command::new("cargo");
        command.current_dir(tree).args(["build", "--quiet"]).args(arguments);
        command.env("CARGO_TARGET_DIR", self.folder.join("target")).env("CARGO_INCREMENTAL", "1");
        command.env("CARGO_PROFILE_DEV_DEBUG", "none").env("RUSTFLAGS", "--cap-lints allow").output()
    }

    /// One copy with all switched faults, and the two programs that must notice them.
    fn build_switched(&self, catalogue: &[SeededFault]) -> io::Result<()> {
        let tree = self.folder.join("switched");
        tree::seed_switched(&tree, catalogue)?;
        for arguments in [["keepout-proofs", "check"], ["keepout-tests", "hostile"]] {
            let [package, program] = arguments;
            let built = self.cargo(&tree, &["--release", "-p", package, "--bin", program])?;
            if !built.status.success() {
                return Err(io::Error::other(String::from_utf8_lossy(&built.stderr).into_owned()));
            }
        }
        self.pass_without_faults()
    }

    /// Runs both programs with no fault chosen: a program that fails anyway would notice every fault.
    fn pass_without_faults(&self) -> io::Result<()> {
        let check = self.switched("check", 0).arg(OUTSIDE_THE_KERNEL).output()?;
        let hostile = self.switched("hostile", 0).args(SESSIONS).args(["--minutes", "0.2"]).output()?;
        for (program, ran) in [("check", check), ("hostile", hostile)] {
            if !ran.status.success() {
                let text = String::from_utf8_lossy(&ran.stdout);
                return Err(io::Error::other(format!("{program} fails without a seeded fault: {text}")));
            }
        }
        Ok(())
    }

    fn switched(&self, program: &str, number: usize) -> Command {
        let mut command = Command::new("timeout");
        let limit_s = CHECK_S + Duration::from_secs_f64(self.minutes * 60.0).as_secs();
        command.arg(limit_s.to_string()).arg(self.folder.join("target/release").join(program));
        command.env(tree::SWITCH, number.to_string());
        command
    }

    fn switched_check(&self, number: usize) -> Command {
        self.switched("check", number)
    }

    /// Builds the narrow set of proofs that can see a fault in a copy of its own, and runs it.
    fn check_alone(&self, fault: &SeededFault) -> io::Result<FaultFate> {
        let tree = self.folder.join("alone");
        tree::seed_one(&tree, fault)?;
        let features: &[&str] = if fault.is_in_kernel() { &[] } else { &["--features", "guard"] };
        let program = ["-p", "keepout-proofs", "--bin", "check", "--no-default-features"];
        let built = self.cargo(&tree, &[&program, features].concat())?;
        if !built.status.success() {
            let text = String::from_utf8_lossy(&built.stderr);
            let why = text.lines().find(|line| line.starts_with("error")).unwrap_or("").to_string();
            // A constant assertion that fails is a proof, too.
            let asserted =
                ["evaluation panicked", "evaluation of constant value failed"].map(|end| text.contains(end));
            let noticed = asserted.contains(&true);
            let fate = if noticed {
                FaultFate::Noticed(vec!["a constant assertion".into()])
            } else {
                FaultFate::Unbuilt(why)
            };
            return Ok(fate);
        }
        let mut command = Command::new("timeout");
        command.arg(CHECK_S.to_string()).arg(self.folder.join("target/debug/check"));
        self.check(&mut command, fault)
    }

    /// Gives the fault's harness to the model checker, in a copy with the fault.
    fn model(&self, fault: &SeededFault) -> io::Result<FaultFate> {
        let tree = self.folder.join("alone");
        tree::seed_one(&tree, fault)?;
        let harnesses: Vec<_> = keepout_harnesses::all()
            .into_iter()
            .filter(|harness| fault.model.as_deref() == Some(harness.name))
            .collect();
        let tools = Tools::find(&workspace()).map_err(io::Error::other)?;
        let checker = ModelChecker::new(&tree, tools, &self.folder.join("model"), CHECK_S);
        let checked =
            checker.and_then(|checker| checker.check(&harnesses, 1, |_, _| {})).map_err(io::Error::other)?;
        Ok(match checked.first().map(|(harness, checked)| (harness.name, &checked.verdict)) {
            Some((name, ModelVerdict::Fails(inputs))) => {
                FaultFate::Noticed(vec![format!("{name} with the inputs {inputs:?}")])
            }
            Some((_, ModelVerdict::Holds)) => FaultFate::Survived,
            Some((_, ModelVerdict::TimedOut)) => FaultFate::Undecided,
            other => FaultFate::Unbuilt(format!("{other:?}")),
        })
    }

    /// Proves the fault's theorem, in a copy with the fault: the solver must refute it.
    fn theorem(&self, fault: &SeededFault) -> io::Result<FaultFate> {
        let tree = self.folder.join("alone");
        tree::seed_one(&tree, fault)?;
        let built = self.cargo(&tree, &["-p", "keepout-proofs", "--bin", "keepout-proofs"])?;
        if !built.status.success() {
            return Ok(unbuilt(&built));
        }
        let name = fault.theorem.clone().unwrap_or_default();
        let mut command = Command::new("timeout");
        command.arg(CHECK_S.to_string()).arg(self.folder.join("target/debug/keepout-proofs"));
        let ran = command.args(["prove", "--single", "--only", &name]).output()?;
        Ok(match ran.status.code() {
            Some(0) => FaultFate::Survived,
            Some(1) => FaultFate::Noticed(vec![name]),
            Some(TIMED_OUT) => FaultFate::Undecided,
            _ => unbuilt(&ran),
        })
    }

    /// Runs the chosen tests in a copy with the fault, up to the first program in which one fails.
    fn tests(&self, fault: &SeededFault) -> io::Result<FaultFate> {
        let tree = self.folder.join("alone");
        tree::seed_one(&tree, fault)?;
        let mut command = Command::new("timeout");
        command
            .arg(CHECK_S.to_string())
            .args(["cargo", "test", "--quiet"])
            .args(fault.tests.iter().flatten());
        command.current_dir(&tree).env("CARGO_TARGET_DIR", self.folder.join("target"));
        command.env("CARGO_INCREMENTAL", "1").env("CARGO_PROFILE_TEST_DEBUG", "none");
        let ran = command.env("RUSTFLAGS", "--cap-lints allow").output()?;
        let text = String::from_utf8_lossy(&ran.stdout);
        let failed: Vec<String> = text
            .lines()
            .filter_map(|line| line.strip_prefix("---- ")?.strip_suffix(" stdout ----"))
            .map(String::from)
            .collect();
        Ok(match ran.status.code() {
            Some(0) => FaultFate::Survived,
            Some(TIMED_OUT) => FaultFate::Undecided,
            _ if !failed.is_empty() => FaultFate::Noticed(failed),
            _ => unbuilt(&ran),
        })
    }

    /// Runs `check` over the groups that can see the fault.
    #[expect(clippy::unused_self, reason = "beside its neighbours")]
    fn check(&self, command: &mut Command, fault: &SeededFault) -> io::Result<FaultFate> {
        let groups = if fault.is_in_kernel() {
            ""
        } else if fault.is_under("executor/src/dialect") {
            DIALECTS
        } else {
            OUTSIDE_THE_KERNEL
        };
        let ran = command.arg(groups).output()?;
        let text = String::from_utf8_lossy(&ran.stdout);
        let failed: Vec<String> =
            text.lines().filter_map(|line| line.strip_prefix("fails: ")).map(String::from).collect();
        Ok(match ran.status.code() {
            Some(0) => FaultFate::Survived,
            _ if !failed.is_empty() => FaultFate::Noticed(failed),
            Some(TIMED_OUT) => FaultFate::Undecided,
            Some(125..=127) => FaultFate::Unbuilt("the program cannot be run".into()),
            _ => FaultFate::Noticed(vec!["ends abnormally".into()]),
        })
    }

    /// Plays the sessions that can show the fault, up to the first verdict of the collision monitor.
    fn hostile(&self, fault: &SeededFault, number: usize) -> io::Result<FaultFate> {
        let mut command = self.switched("hostile", number);
        command
            .args(SESSIONS)
            .arg("--minutes")
            .arg(self.minutes.to_string())
            .args(fault.hostile.iter().flatten());
        let ran = command.output()?;
        let text = String::from_utf8_lossy(&ran.stdout);
        Ok(match text.lines().find_map(|line| line.strip_prefix("verdict: ")) {
            Some(verdict) => FaultFate::Noticed(vec![verdict.into()]),
            None if ran.status.success() => FaultFate::Survived,
            None if ran.status.code() == Some(TIMED_OUT) => FaultFate::Undecided,
            None => unbuilt(&ran),
        })
    }
}

/// The fate of a fault whose programs cannot be built or run: the first line of the error.
fn unbuilt(ran: &Output) -> FaultFate {
    FaultFate::Unbuilt(String::from_utf8_lossy(&ran.stderr).lines().take(1).collect())
}
