//! Tests of sessions at a port: nothing moves unasked, and a part is touched off by keys alone.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

#[path = "support/machine.rs"]
mod machine_of_test;
mod support;
#[path = "support/terminal.rs"]
mod terminal_of_test;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use keepout_planner::align::file::AlignmentFile;
use machine_of_test::MachineProcess;
use support::{bracket, code, complaint, folder, keepout};
use terminal_of_test::Terminal;

/// Longest time until the port of a simulated machine appears.
const STARTS_WITHIN: Duration = Duration::from_secs(60);

/// Starts a homed machine. It keeps the received bytes in the file `received`.
fn machine(folder: &Path) -> (MachineProcess, String) {
    let (port, received) = (folder.join("port").display().to_string(), folder.join("received"));
    let received = received.display().to_string();
    let more = ["--homed", "--start-mm", "-236.5,-203", "--received", &received];
    (MachineProcess::start(&port, &more, STARTS_WITHIN), port)
}

/// The same with a third axis, whose tip is 1 mm below the end of travel.
fn machine_of_three_axes(folder: &Path) -> (MachineProcess, String) {
    let port = folder.join("port").display().to_string();
    let more = ["--homed", "--start-mm", "-236.5,-203", "--three-axes"];
    (MachineProcess::start(&port, &more, STARTS_WITHIN), port)
}

/// A job for a stored machine at this port, with its plan. `more`: further figures of the machine.
fn job_at(folder: &Path, port: &str, more: &[&str]) -> String {
    let stored = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
        let output = command.args(arguments).env("KEEPOUT_CONFIG", folder).output().unwrap();
        assert_eq!(code(&output), 0, "{}", complaint(&output));
    };
    let figures = ["--repeatability-mm", "0.01", "--contour-error-mm", "0.05", "--operator", "keyboard"];
    stored(&[&["machine", "new", "practice", "--port", port], &figures[..], more].concat());
    let job = folder.join("job").display().to_string();
    stored(&["new", &bracket(), "--machine", "practice", "-o", &job]);
    stored(&["plan", &job]);
    job
}

/// The touch-off of a job at a simulated machine.
struct TouchOff {
    job: String,
    terminal: Terminal,
    _machine: MachineProcess,
}

impl TouchOff {
    fn begin(name: &str) -> Self {
        let folder = folder(name);
        let (machine, port) = machine(&folder);
        let job = job_at(&folder, &port, &[]);
        let align = ["align", &job, "--homed", "--take", "edges"];
        let terminal = Terminal::run(&align, Some(&folder.display().to_string()));
        Self { job, terminal, _machine: machine }
    }

    fn alignment(&self) -> PathBuf {
        Path::new(&self.job).join("alignment.toml")
    }
}

#[test]
fn three_places_are_taken_by_keys_and_no_figure_is_typed() {
    let mut touch_off = TouchOff::begin("touch-off");
    let terminal = &mut touch_off.terminal;
    let press = |terminal: &mut Terminal, key: &[u8]| {
        terminal.type_for(Duration::from_millis(200), key, Duration::from_secs(60));
    };
    terminal.wait_for("nothing is protected yet");
    terminal.wait_for("place 1 of 3: touch the long edge near (13.500, 0.000) mm");
    press(terminal, b"t");
    terminal.wait_for("taken 1 of 3: machine position (-236.500, -203.000) mm");
    press(terminal, b"s");
    press(terminal, b"4");
    terminal.wait_for("step 1 mm");
    let mut at = (-236.5, -203.0);
    // Jogs in steps of 1 mm, and waits for each few.
    let mut jog = |terminal: &mut Terminal, key: &[u8], count: u32, (dx, dy): (f64, f64)| {
        for step in 1..=count {
            terminal.type_for(Duration::from_millis(60), key, Duration::from_secs(60));
            at = (at.0 + dx, at.1 + dy);
            if step % 5 == 0 || step == count {
                terminal.wait_for(&format!("x {:>9.3}  y {:>9.3} mm", at.0, at.1));
            }
        }
    };
    jog(terminal, b"\x1b[C", 60, (1.0, 0.0));
    jog(terminal, b"\x1b[A", 1, (0.0, 1.0));
    press(terminal, b"t");
    terminal.wait_for("taken 2 of 3: machine position (-176.500, -202.000) mm");
    jog(terminal, b"\x1b[A", 40, (0.0, 1.0));
    jog(terminal, b"\x1b[D", 40, (-1.0, 0.0));
    press(terminal, b"t");
    terminal.wait_for("rotation");
    terminal.type_for(Duration::from_secs(20), b"", Duration::from_secs(60));
    assert_eq!(terminal.end(), Some(0), "{}", String::from_utf8_lossy(&terminal.shown));
    // The edge rises by 1 mm over 60 mm.
    let found = AlignmentFile::load(&touch_off.alignment()).unwrap();
    assert!((found.rotation_deg - (1.0_f64 / 60.0).atan().to_degrees()).abs() < 1e-6, "{found:?}");
    assert!(found.rotation_measured && found.touches == 3, "{found:?}");
}

#[test]
fn top_of_the_part_is_touched_with_paper() {
    let folder = folder("touch-off-top");
    let (_machine, port) = machine_of_three_axes(&folder);
    let third_axis = ["--third-axis", "--z-repeatability-mm", "0.01", "--z-following-error-mm", "0.02"];
    let job = job_at(&folder, &port, &third_axis);
    let configured = folder.display().to_string();
    let begins = ["align", &job, "--homed"];
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
        command.args(arguments).env("KEEPOUT_CONFIG", &folder).output().unwrap()
    };
    // There is no alignment yet that the height could complete: no one jogs in vain.
    let early = run(&[&begins[..], &["--take", "top"]].concat());
    assert!(
        code(&early) != 0 && complaint(&early).contains("align the other axes first"),
        "{}",
        complaint(&early)
    );
    assert_eq!(code(&run(&[&begins[..], &["--point", "0,0=-250,-200"]].concat())), 0);
    let gauge = ["--take", "top", "--gauge-mm", "0.25"];
    let mut terminal = Terminal::run(&[&begins[..], &gauge].concat(), Some(&configured));
    terminal.wait_for("THE SPINDLE MUST STAND");
    terminal.wait_for("place 1 of 1: lower the tool onto the paper on the top of the part");
    terminal.type_for(Duration::from_millis(300), b"s4", Duration::from_secs(60));
    terminal.wait_for("step 1 mm");
    for step in 1..=12 {
        terminal.type_for(Duration::from_millis(60), b"-", Duration::from_secs(60));
        terminal.wait_for(&format!("z {:>9.3} mm", -1.0 - f64::from(step)));
    }
    terminal.type_for(Duration::from_millis(300), b"t", Duration::from_secs(60));
    terminal.wait_for("top          z -13.250 mm machine coordinates");
    terminal.type_for(Duration::from_secs(20), b"", Duration::from_secs(60));
    assert_eq!(terminal.end(), Some(0), "{}", String::from_utf8_lossy(&terminal.shown));
    let found = AlignmentFile::load(&Path::new(&job).join("alignment.toml")).unwrap();
    assert_eq!((found.top_mm, found.origin_mm), (Some(-13.25), [-250.0, -200.0]));
    let stated = run(&[&begins[..], &["--top-mm", "-14.5"]].concat());
    assert_eq!(code(&stated), 0, "{}", complaint(&stated));
    let found = AlignmentFile::load(&Path::new(&job).join("alignment.toml")).unwrap();
    assert_eq!(found.top_mm, Some(-14.5));
}

#[test]
fn quitting_writes_no_alignment() {
    let mut touch_off = TouchOff::begin("touch-off-quit");
    let terminal = &mut touch_off.terminal;
    terminal.wait_for("place 1 of 3");
    terminal.type_for(Duration::from_secs(20), b"q", Duration::from_secs(1));
    assert_eq!(terminal.end(), Some(2));
    assert!(String::from_utf8_lossy(&terminal.shown).contains("no alignment was written"));
    assert!(!touch_off.alignment().exists());
}

/// A plan for the simulated machine.
fn planned(folder: &Path) -> String {
    let plan = folder.join("bracket.plan").display().to_string();
    let made = keepout(&["plan", &bracket(), "--tool-diameter", "6", "-o", &plan]);
    assert_eq!(code(&made), 0, "{}", complaint(&made));
    plan
}

#[test]
fn port_has_no_default_operator_and_no_model_moves_it() {
    let folder = folder("nobody");
    let plan = planned(&folder);
    let (mut machine, port) = machine(&folder);
    let run = ["run", &plan, "--port", &port, "--origin-mm", "-250,-200", "--homed"];
    for (more, said) in [
        (&[][..], "a run at a port needs an operator"),
        (&["--operator", "calm"], "is not a person"),
        (&["--operator", "keyboard"], "the plan's margin and travel are of the"),
        (&["--operator", "keyboard", "--simulate"], "a person confirms this page"),
    ] {
        let output = keepout(&[&run[..], more].concat());
        assert!(code(&output) == 2 && complaint(&output).contains(said), "{more:?}: {}", complaint(&output));
    }
    assert_eq!(machine.end(), Some(0));
    assert_eq!(std::fs::read(folder.join("received")).unwrap_or_default(), b"", "no byte was sent");
}

#[test]
fn page_before_the_first_motion_tells_what_will_be_cut_and_waits() {
    let folder = folder("page");
    let (_machine, port) = machine(&folder);
    let received = folder.join("received");
    let job = job_at(&folder, &port, &[]);
    std::fs::write(&received, b"").unwrap();
    let config = folder.display().to_string();
    let file = Path::new(&job).join("job.toml");
    let settings = std::fs::read_to_string(&file).unwrap();
    for (unit, tool) in [("mm", "Ø 6 mm"), ("inch", "Ø 0.2362 in")] {
        std::fs::write(&file, format!("display = \"{unit}\"\n{settings}")).unwrap();
        let run = ["run", &job, "--homed", "--origin-mm", "-250,-200"];
        let mut terminal = Terminal::run(&run, Some(&config));
        terminal.wait_for("Type y and press Enter to start");
        let shown = String::from_utf8_lossy(&terminal.shown).into_owned();
        for line in ["operator", "stock to leave", "feed", "drawing's origin", "alignment", tool] {
            assert!(shown.contains(line), "{line}: {shown}");
        }
        assert!(shown.contains("3 hole Ø 8.000") && shown.contains("will be cut"), "{shown}");
        terminal.type_for(Duration::from_secs(10), b"n\n", Duration::from_secs(60));
        assert_eq!(terminal.end(), Some(2));
        assert!(String::from_utf8_lossy(&terminal.shown).contains("not confirmed: nothing was moved"));
    }
    assert_eq!(std::fs::read(&received).unwrap(), b"", "no byte was sent");
}

#[test]
fn lost_machine_is_a_fault_with_its_remedy_without_the_view() {
    let folder = folder("lost");
    let plan = planned(&folder);
    let (machine, port) = machine(&folder);
    let run = ["run", &plan, "--port", &port, "--origin-mm", "-250,-200", "--homed", "--simulate", "--yes"];
    let run = [&run[..], &["--operator", "keyboard"]].concat();
    let config = folder.display().to_string();
    let mut terminal = Terminal::run(&run, Some(&config));
    terminal.wait_for("jogging");
    drop(machine);
    terminal.wait_for("STOPPED:");
    // A recovery that does not succeed changes nothing.
    terminal.type_for(Duration::from_secs(1), b"f", Duration::from_secs(60));
    terminal.type_for(Duration::from_secs(20), b"q", Duration::from_secs(1));
    let shown = String::from_utf8_lossy(&terminal.shown).into_owned();
    assert_eq!(terminal.end(), Some(6), "{shown}");
    let ends_with_log = |entry: &std::fs::DirEntry| entry.path().extension().is_some_and(|end| end == "log");
    let logs = std::fs::read_dir(&folder).unwrap().flatten().filter(ends_with_log).count();
    assert_eq!(logs, 1, "a run at a port keeps its log");
    assert!(shown.contains("stopped by a fault: the port was lost") && shown.contains("Check"), "{shown}");
}

#[test]
fn locked_machine_is_not_ready() {
    let folder = folder("locked");
    let port = folder.join("port").display().to_string();
    let _machine = MachineProcess::start(&port, &[], STARTS_WITHIN);
    let output = keepout(&["doctor", "--port", &port]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("locked") && !said.contains("A session can begin."), "{said}");
}
