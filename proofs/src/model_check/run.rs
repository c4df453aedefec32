//! Running the model checker.

use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use keepout_harnesses::ModelHarness;

use super::tools::Tools;
use super::translate::{MODULE, Module};

/// The answer for one harness.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModelVerdict {
    /// The statement holds for all inputs within the bounds, and the loops need no more unwinding.
    Holds,
    /// An input that makes the harness fail: the numbers that it draws, in order.
    Fails(Vec<i32>),
    /// A loop needs more unwinding than the harness states.
    Unwinding,
    /// There was no answer in time.
    TimedOut,
    /// A program failed: its last lines.
    Broken(String),
}

/// The answer for one harness, with its time.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The answer.
    pub verdict: ModelVerdict,
    /// Seconds, for translation, formula and solver.
    pub seconds: f64,
}

/// A translated module, and the programs that check it.
#[derive(Debug)]
pub struct ModelChecker {
    tools: Tools,
    source: String,
    folder: PathBuf,
    limit_s: u64,
}

/// Linker options of the module: a small stack at address zero, and no start function.
const LINK: &str =
    "-C link-arg=-zstack-size=12288 -C link-arg=--no-entry -C link-arg=--stack-first -C target-cpu=mvp";
/// Loops of the runtime that copy or fill memory: at most so many words or bytes.
const COPIES: &str =
    "memory_copy.0:600,memory_copy.1:600,memory_copy.2:600,memory_copy.3:600,memory_fill.0:600";
/// Exit code of `timeout` when the time is over.
const TIMED_OUT: i32 = 124;

impl ModelChecker {
    /// Builds the harnesses of the tree under `workspace`, and translates them. `folder` takes the files.
    ///
    /// # Errors
    /// When a program is missing, or the tree does not build.
    pub fn new(workspace: &Path, tools: Tools, folder: &Path, limit_s: u64) -> Result<Self, String> {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let folder = folder.canonicalize().map_err(|error| format!("{}: {error}", folder.display()))?;
        let target = "wasm32-unknown-unknown";
        let mut build = Command::new("cargo");
        build.current_dir(workspace).env("RUSTFLAGS", LINK).env("CARGO_TARGET_DIR", folder.join("target"));
        build.args(["rustc", "--quiet", "-p", "keepout-harnesses", "--lib", "--profile", "model"]);
        build.args(["--target", target, "--crate-type", "cdylib"]);
        succeed(&mut build).map_err(|text| {
            let hint = if text.contains("target may not be installed") {
                "\nInstall Rust's library for WebAssembly: rustup target add wasm32-unknown-unknown"
            } else {
                ""
            };
            format!("the harnesses do not compile to WebAssembly: {text}{hint}")
        })?;
        let module = folder.join("target").join(target).join("model/keepout_harnesses.wasm");
        let c = folder.join("harnesses.c");
        succeed(tools.command("wasm2c").args(["-n", MODULE, "-o"]).args([&c, &module]))?;
        let source = std::fs::read_to_string(&c).map_err(|error| format!("{}: {error}", c.display()))?;
        Ok(Self { tools, source, folder, limit_s })
    }

    /// Checks the harnesses, some at a time, and passes each answer on.
    ///
    /// # Errors
    /// When the translation of `wasm2c` is not understood.
    pub fn check(
        &self,
        harnesses: &[&'static ModelHarness],
        threads: usize,
        tell: impl Fn(&'static ModelHarness, &Checked) + Sync,
    ) -> Result<Vec<(&'static ModelHarness, Checked)>, String> {
        let module = Module::read(&self.source)
            .ok_or("the C of wasm2c has an unknown form: version 1.0.36 is known")?;
        let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        std::thread::scope(|scope| {
            for _ in 0..threads.max(1) {
                scope.spawn(|| {
                    while let Some(&harness) = harnesses.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let checked = self.check_one(&module, harness);
                        tell(harness, &checked);
                        done.lock()
                            .unwrap_or_else(std::sync::PoisonError::into_inner)
                            .push((harness, checked));
                    }
                });
            }
        });
        Ok(done.into_inner().unwrap_or_default())
    }

    fn check_one(&self, module: &Module<'_>, harness: &ModelHarness) -> Checked {
        let begin = Instant::now();
        let checked = self.try_one(module, harness);
        let verdict = checked.unwrap_or_else(|error| ModelVerdict::Broken(error.to_string()));
        Checked { verdict, seconds: begin.elapsed().as_secs_f64() }
    }

    fn try_one(&self, module: &Module<'_>, harness: &ModelHarness) -> io::Result<ModelVerdict> {
        let Some(program) = module.program(harness.name) else {
            return Ok(ModelVerdict::Broken("the module has no such function".into()));
        };
        let file = self.folder.join(format!("{}.c", harness.name));
        std::fs::write(&file, program)?;
        let ran = self.cbmc(&file, harness, &["--slice-formula"])?;
        if let Some(line) = ran.text.lines().find(|line| line.contains("no body for")) {
            return Ok(ModelVerdict::Broken(line.into()));
        }
        let violated =
            |what: &str| ran.text.lines().any(|line| line.contains(what) && line.ends_with("FAILURE"));
        if violated("the stack is large enough") {
            return Ok(ModelVerdict::Broken("the stack of the module is too small".into()));
        }
        Ok(match ran.code {
            Some(0) => ModelVerdict::Holds,
            Some(TIMED_OUT) => ModelVerdict::TimedOut,
            Some(10) if violated("unwinding assertion") => ModelVerdict::Unwinding,
            Some(10) => ModelVerdict::Fails(self.counterexample(&file, harness)?),
            _ => ModelVerdict::Broken(last_lines(&ran.text)),
        })
    }

    /// The numbers that the harness draws in a run that fails.
    fn counterexample(&self, file: &Path, harness: &ModelHarness) -> io::Result<Vec<i32>> {
        let ran = self.cbmc(file, harness, &["--trace", "--stop-on-fail"])?;
        let drawn = ran.text.lines().filter_map(|line| line.trim().strip_prefix("input_value="));
        let number = |text: &str| text[..text.find(|c: char| !c.is_ascii_digit())?].parse::<u32>().ok();
        Ok(drawn.filter_map(number).map(u32::cast_signed).collect())
    }

    fn cbmc(&self, file: &Path, harness: &ModelHarness, more: &[&str]) -> io::Result<Ran> {
        let mut command = Command::new("timeout");
        command.arg(self.limit_s.to_string()).arg(self.tools.path("cbmc")).arg(file);
        command.args([
            "--unwind",
            &harness.unwind.to_string(),
            "--unwindset",
            COPIES,
            "--unwinding-assertions",
        ]);
        command.args(["--no-standard-checks", "--no-malloc-may-fail"]).args(more);
        command.arg("--external-sat-solver").arg(self.tools.path("kissat"));
        let ran = command.output()?;
        let text = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
        Ok(Ran { code: ran.status.code(), text })
    }
}

struct Ran {
    code: Option<i32>,
    text: String,
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let ran = command.output().map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    if ran.status.success() { Ok(()) } else { Err(last_lines(&String::from_utf8_lossy(&ran.stderr))) }
}

fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(6)..].join("\n")
}
