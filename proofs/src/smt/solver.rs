//! Solvers as processes. Each question is SMT-LIB text for a process of its own, with a time limit.

use std::fmt;
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A known solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SolverKind {
    /// Z3.
    Z3,
    /// cvc5.
    Cvc5,
}

impl fmt::Display for SolverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Z3 => "z3",
            Self::Cvc5 => "cvc5",
        })
    }
}

/// A solver's answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SolverAnswer {
    /// The facts can hold together.
    Satisfiable,
    /// The facts cannot hold together.
    Unsatisfiable,
    /// Any other outcome: unknown, an error, or no answer within the time limit. It never counts as a
    /// proof.
    None(String),
}

impl fmt::Display for SolverAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Satisfiable => f.write_str("sat"),
            Self::Unsatisfiable => f.write_str("unsat"),
            Self::None(why) => f.write_str(why),
        }
    }
}

/// The solver was not found.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error(
    "{kind} was not found. Install both solvers with `python3 -m pip install z3-solver cvc5`, \
     or name a program in {}.",
    variable(*kind)
)]
pub struct MissingSolver {
    kind: SolverKind,
}

/// A solver that can be started.
#[derive(Clone, Debug)]
pub struct Solver {
    /// The kind of solver.
    pub kind: SolverKind,
    /// Its version, as it reports it.
    pub version: String,
    /// Time limit for one question.
    pub limit: Duration,
    command: Vec<String>,
}

/// Programs for the Python packages. These bring the solvers as modules, and their executables need not be
/// on the path.
const CVC5_MODULE: &str = "
import sys, cvc5
solver = cvc5.Solver()
parser = cvc5.InputParser(solver)
parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, sys.stdin.read(), 'question')
symbols = parser.getSymbolManager()
while not (command := parser.nextCommand()).isNull():
    print(command.invoke(solver, symbols), end='')
";
const Z3_MODULE: &str = "
import sys, z3
print(z3.Z3_eval_smtlib2_string(z3.main_ctx().ref(), sys.stdin.read()), end='')
";

fn variable(kind: SolverKind) -> &'static str {
    match kind {
        SolverKind::Z3 => "KEEPOUT_Z3",
        SolverKind::Cvc5 => "KEEPOUT_CVC5",
    }
}

/// Commands that run the solver, and that print its version, the preferred ones first.
fn ways(kind: SolverKind) -> Vec<[Vec<String>; 2]> {
    let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
    let named = std::env::var(variable(kind)).ok();
    let program = |name: &str| {
        let run = match kind {
            SolverKind::Z3 => words(&[name, "-smt2", "-in"]),
            SolverKind::Cvc5 => words(&[name, "--lang", "smt2", "--quiet", "-"]),
        };
        [run, words(&[name, "--version"])]
    };
    let module = match kind {
        SolverKind::Z3 => [
            words(&["python3", "-c", Z3_MODULE]),
            words(&["python3", "-c", "import z3; print(z3.get_version_string())"]),
        ],
        SolverKind::Cvc5 => [
            words(&["python3", "-c", CVC5_MODULE]),
            words(&["python3", "-c", "import cvc5; print(cvc5.__version__)"]),
        ],
    };
    let by_path = program(&kind.to_string());
    match (named, kind) {
        (Some(name), _) => vec![program(&name)],
        (None, SolverKind::Z3) => vec![by_path, module],
        // Debian's cvc5 is built without the library that it needs for polynomials.
        (None, SolverKind::Cvc5) => vec![module, by_path],
    }
}

impl Solver {
    /// Finds the solver.
    ///
    /// # Errors
    /// [`MissingSolver`] with what to install.
    pub fn find(kind: SolverKind, limit: Duration) -> Result<Self, MissingSolver> {
        for [command, version] in ways(kind) {
            let output = Command::new(&version[0]).args(&version[1..]).stderr(Stdio::null()).output();
            let Some(output) = output.ok().filter(|output| output.status.success()) else { continue };
            let text = String::from_utf8_lossy(&output.stdout);
            let number = |word: &str| word.contains('.') && word.starts_with(|c: char| c.is_ascii_digit());
            let version = text.split_whitespace().find(|&word| number(word)).unwrap_or("unknown").to_owned();
            return Ok(Self { kind, version, limit, command });
        }
        Err(MissingSolver { kind })
    }

    /// A solver that this command starts, of unknown version.
    #[must_use]
    pub fn of_command(kind: SolverKind, command: &[&str], limit: Duration) -> Self {
        let command = command.iter().map(|&word| word.to_owned()).collect();
        Self { kind, version: "unknown".to_owned(), limit, command }
    }

    /// Asks one question.
    #[must_use]
    pub fn ask(&self, script: &str) -> SolverAnswer {
        self.run(script).unwrap_or_else(|error| SolverAnswer::None(format!("could not be run: {error}")))
    }

    fn run(&self, script: &str) -> std::io::Result<SolverAnswer> {
        let mut child = Command::new(&self.command[0])
            .args(&self.command[1..])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        if let Some(mut stdin) = child.stdin.take() {
            // A solver may end before it has read everything. Its output counts.
            let _ = stdin.write_all(script.as_bytes());
        }
        if !ends_within(&mut child, self.limit)? {
            child.kill()?;
            child.wait()?;
            return Ok(SolverAnswer::None(format!("no answer in {} s", self.limit.as_secs())));
        }
        let mut text = String::new();
        if let Some(mut stdout) = child.stdout.take() {
            stdout.read_to_string(&mut text)?;
        }
        Ok(match text.trim() {
            "sat" => SolverAnswer::Satisfiable,
            "unsat" => SolverAnswer::Unsatisfiable,
            other => SolverAnswer::None(format!("answered {:?}", other.lines().next().unwrap_or("nothing"))),
        })
    }
}

fn ends_within(child: &mut Child, limit: Duration) -> std::io::Result<bool> {
    let begin = Instant::now();
    let mut pause = Duration::from_millis(1);
    while begin.elapsed() < limit {
        if child.try_wait()?.is_some() {
            return Ok(true);
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(20));
    }
    Ok(false)
}
