//! Tests of operators on the command line. A trace repeats its session. The keyboard jogs from a terminal and
//! restores the terminal. A missing device gives an error with the remedy.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

#[cfg(unix)]
#[path = "support/terminal.rs"]
mod terminal_of_test;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{PoisonError, RwLock};

use keepout_executor::session::LoggedEvent;
use keepout_executor::session::log::Log;

/// A program inherits the open terminals of this process. Who closes one takes this lock for writing, so that no other
/// program keeps it open.
static PROGRAMS: RwLock<()> = RwLock::new(());

fn keepout(arguments: &[&str]) -> Output {
    let _runs = PROGRAMS.read().unwrap_or_else(PoisonError::into_inner);
    Command::new(env!("CARGO_BIN_EXE_keepout")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// Makes a folder with a plan for one test.
fn planned(name: &str) -> (PathBuf, String) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let drawing = Path::new(env!("CARGO_MANIFEST_DIR")).join("drawings/bracket.dxf");
    let plan = folder.join("bracket.plan").display().to_string();
    let made = keepout(&["plan", &drawing.display().to_string(), "--tool-diameter", "6", "-o", &plan]);
    assert!(made.status.success());
    (folder, plan)
}

#[test]
fn trace_repeats_its_recorded_session() {
    for operator in ["wall", "random"] {
        let (folder, plan) = planned(&format!("trace-{operator}"));
        let file = |name: &str| folder.join(name).display().to_string();
        let (first, second, trace) = (file("first.log"), file("second.log"), file("run.trace"));
        let run = |operator: &str, more: &[&str]| {
            let fixed = ["run", &plan, "--machine", "sim-fast", "--jog-s", "10", "--operator", operator];
            keepout(&[&fixed, more].concat())
        };
        let recorded = run(operator, &["--log", &first, "--record-trace", &trace]);
        assert_eq!(recorded.status.code(), Some(9), "{recorded:?}");
        let played = run(&format!("trace:{trace}"), &["--log", &second, "--view"]);
        assert_eq!(played.stdout, recorded.stdout);
        // The headers differ: they state the operator and the time.
        let log = |path: &str| Log::load(Path::new(path)).unwrap();
        assert!(log(&first).entries == log(&second).entries);
        let again = run(operator, &["--record-trace", &trace]);
        assert_eq!(again.status.code(), Some(2), "a trace is not overwritten");
    }
}

#[test]
fn missing_operators_are_named_with_the_remedy() {
    let (folder, plan) = planned("missing");
    let none = folder.join("event0").display().to_string();
    let cases: [(&[&str], &str); 5] = [
        (&["--operator", "keyboard"], "start keepout in a terminal"),
        (&["--operator", "keyboard", "--machine", "sim-fast"], "--machine sim"),
        (&["--operator", &format!("gamepad:{none}")], "event0"),
        (&["--operator", &format!("trace:{none}")], "cannot read the trace"),
        (&["--operator", "gamepad", "--dead-zone", "2"], "choose 0 to 0.9"),
    ];
    for (arguments, wanted) in cases {
        let output = keepout(&[&["run", &plan], arguments].concat());
        let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{complaint}");
        assert!(complaint.contains(wanted), "{arguments:?}: {complaint}");
    }
}

#[cfg(unix)]
mod terminal {
    use std::io::{Read, Write};
    use std::time::{Duration, Instant};

    use super::terminal_of_test::Terminal;
    use super::*;

    /// Reads until the program asks the terminal for its abilities, and does not answer.
    fn let_ask(terminal: &mut Terminal) {
        let (mut shown, mut bytes, began) = (Vec::<u8>::new(), [0; 4096], Instant::now());
        while !shown.windows(3).any(|question| question == b"\x1b[c") {
            assert!(began.elapsed() < Duration::from_secs(60), "the program asks nothing");
            if let Ok(count) = terminal.keys.read(&mut bytes) {
                shown.extend(&bytes[..count]);
            }
        }
    }

    /// Closes the terminal, and checks that the program ends and that its log has an end.
    fn close(terminal: Terminal, log: &Path) {
        let Terminal { keys, mut child, _end: end, .. } = terminal;
        drop((keys, end));
        let began = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if began.elapsed() > Duration::from_secs(20) {
                child.kill().unwrap();
                panic!("the program goes on without its terminal");
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let log = Log::load(log).unwrap();
        let last = log.entries.last().map(|entry| entry.event.clone());
        assert!(matches!(last, Some(LoggedEvent::Outcome(_))), "{last:?}");
    }

    /// A window that is closed left a process that used a whole core, and once a log without an end: after a whole
    /// key, after a part of one, and before the terminal answered its first query.
    #[test]
    fn closing_the_window_ends_the_program_and_its_log() {
        for view in [true, false] {
            for last in [Some("\x1b[D"), Some("\x1b["), None] {
                let (folder, plan) = planned(&format!("closed-{view}"));
                let log = folder.join("run.log");
                let path = log.display().to_string();
                let mut run = vec!["run", &plan, "--operator", "keyboard", "--log", &path];
                run.extend(view.then_some("--view"));
                let _alone = PROGRAMS.write().unwrap_or_else(PoisonError::into_inner);
                let mut terminal = Terminal::run(&run, None);
                if let Some(last) = last {
                    terminal.type_for(Duration::from_secs(2), b"\x1b[D", Duration::from_millis(30));
                    terminal.keys.write_all(last.as_bytes()).unwrap();
                } else {
                    let_ask(&mut terminal);
                }
                close(terminal, &log);
            }
        }
    }

    #[test]
    fn keyboard_jogs_and_restores_the_terminal() {
        let (folder, plan) = planned("keyboard");
        let trace = folder.join("keys.trace").display().to_string();
        let run = ["run", &plan, "--operator", "keyboard", "--view", "--record-trace", &trace];
        let _runs = PROGRAMS.read().unwrap_or_else(PoisonError::into_inner);
        let mut terminal = Terminal::run(&run, None);
        let (held, once) = (Duration::from_millis(30), Duration::from_secs(60));
        terminal.wait_for("\u{1b}[?1049h");
        terminal.type_for(Duration::from_secs(3), b"", once);
        terminal.type_for(Duration::from_millis(300), b"4", once);
        terminal.type_for(Duration::from_millis(600), b"\x1b[D", held);
        terminal.type_for(Duration::from_millis(600), b"", once);
        terminal.type_for(Duration::from_secs(60), b"q", Duration::from_secs(1));
        assert_eq!(terminal.end(), Some(9), "ended in order, without a contour");
        let inputs = std::fs::read_to_string(&trace).unwrap();
        let pushed = inputs.lines().find(|line| line.contains(" -1 0 0 0 -")).unwrap();
        let released = inputs.lines().skip_while(|line| *line != pushed).nth(1).unwrap();
        let at = |line: &str| line.split(' ').next().unwrap().parse::<f64>().unwrap();
        assert!(released.ends_with(" 0 0 0 0 -"), "{inputs}");
        assert!((0.5..2.0).contains(&(at(released) - at(pushed))), "{inputs}");
        assert!(inputs.contains(" q\n"), "{inputs}");
        let shown = String::from_utf8_lossy(&terminal.shown).into_owned();
        let (enter, leave) = (shown.find("\u{1b}[?1049h"), shown.rfind("\u{1b}[?1049l"));
        assert!(enter.is_some() && leave > enter && shown.rfind("\u{1b}[?25h") > enter);
    }
}
