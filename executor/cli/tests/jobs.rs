//! Tests of jobs, of stored tools, and of the program in a shell.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use support::{bracket, code, complaint, folder, keepout};

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A job of the bracket, with its plan.
fn planned_job(name: &str) -> (PathBuf, String) {
    let folder = folder(name).join("bracket");
    let job = folder.display().to_string();
    let new = keepout(&["new", &bracket(), "-o", &job]);
    assert_eq!(code(&new), 0, "{}", complaint(&new));
    let plan = keepout(&["plan", &job]);
    assert_eq!(code(&plan), 0, "{}", complaint(&plan));
    (folder, job)
}

/// Runs a job with the modelled operator that jogs to the wall.
fn run(command: &str, job: &str, more: &[&str]) -> Output {
    let operator = ["--machine", "sim-fast", "--operator", "wall", "--jog-s", "10"];
    keepout(&[&[command, job], &operator[..], more].concat())
}

fn count(folder: &Path) -> usize {
    fs::read_dir(folder).map_or(0, Iterator::count)
}

#[test]
fn job_goes_from_a_drawing_to_a_report() {
    let (folder, job) = planned_job("job");
    for file in ["job.toml", "bracket.dxf", "part.plan", "plan.svg"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
    assert_eq!(code(&keepout(&["inspect", &job])), 0);
    let first = run("run", &job, &["--feed-mm-min", "600"]);
    assert!(code(&first) == 9 && printed(&first).contains("incomplete: 1 of 3"), "{}", complaint(&first));
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("600 mm/min") && page.contains("incomplete: 1 of 3"));
    assert!(page.len() < 100_000, "the page has {} bytes", page.len());
    assert_eq!(code(&keepout(&["report", &job])), 0);
    assert_eq!(page, fs::read_to_string(folder.join("report.html")).unwrap(), "both commands give one page");
    // The tool begins in the second contour.
    let second = run("resume", &job, &["--start-mm", "75,12"]);
    assert!(printed(&second).contains("2 of 3"), "{}{}", printed(&second), complaint(&second));
    let again = run("resume", &job, &["--recut", "1"]);
    assert!(printed(&again).contains("resumed"), "{}", complaint(&again));
    assert_eq!(count(&folder.join("logs")), 3);
    let replayed = keepout(&["replay", &job]);
    assert!(code(&replayed) == 0 && printed(&replayed).contains("2 of 3"), "{}", complaint(&replayed));
    let alone = keepout(&["replay", &job, "--certificates-only"]);
    assert!(
        code(&alone) == 0 && printed(&alone).contains("texts that say the same"),
        "{}",
        complaint(&alone)
    );
    assert_eq!(count(&folder), 7, "a resumed run replaces its report: {:?}", fs::read_dir(&folder));
}

#[test]
fn unit_of_the_screen_is_mm_or_inch() {
    let (_, job) = planned_job("job-inch");
    let wrong = keepout(&["run", &job, "--display", "yard"]);
    assert!(code(&wrong) == 2 && complaint(&wrong).contains("[possible values: mm, inch]"));
}

#[test]
fn dry_run_counts_nowhere() {
    let (folder, job) = planned_job("job-dry");
    let dry = run("run", &job, &["--dry-run"]);
    assert_eq!(code(&dry), 9, "{}", complaint(&dry));
    assert_eq!((count(&folder.join("logs")), count(&folder.join("dry-runs"))), (0, 1));
    assert!(!folder.join("report.html").exists());
    let none = run("resume", &job, &[]);
    assert!(code(&none) == 2 && complaint(&none).contains("has no log yet"), "{}", complaint(&none));
    let (plan, log) =
        (folder.join("part.plan").display().to_string(), folder.join("dry.log").display().to_string());
    assert_eq!(code(&run("run", &plan, &["--dry-run", "--log", &log])), 9);
    let resumed = run("run", &plan, &["--resume", &log]);
    assert!(code(&resumed) == 2 && complaint(&resumed).contains("dry run, which cut no part"));
    let page = folder.join("page.html").display().to_string();
    let reported = keepout(&["report", &log, "-o", &page]);
    assert!(code(&reported) == 2 && complaint(&reported).contains("dry run, which cut no part"));
}

#[test]
fn new_plan_of_a_job_keeps_the_earlier_one() {
    let (folder, job) = planned_job("job-again");
    let before = fs::read(folder.join("part.plan")).unwrap();
    assert_eq!(code(&keepout(&["plan", &job])), 0);
    assert!(!folder.join("part.1.plan").exists(), "the same plan is no new one");
    let settings = folder.join("job.toml");
    let text = fs::read_to_string(&settings).unwrap();
    fs::write(&settings, text.replace("tool = \"6\"", "tool = \"1/4in\"")).unwrap();
    let planned = keepout(&["plan", &job]);
    assert!(printed(&planned).contains("6.35 mm"), "{}", printed(&planned));
    assert_eq!(before, fs::read(folder.join("part.1.plan")).unwrap());
}

#[test]
fn bad_jobs_name_the_file_and_the_remedy() {
    let (folder, job) = planned_job("job-bad");
    let new = keepout(&["new", &bracket(), "-o", &job]);
    assert!(code(&new) == 2 && complaint(&new).contains("nothing in it was changed"), "{}", complaint(&new));
    for (text, reason) in [
        ("drawing = \"bracket.dxf\"\ntoool = \"6\"\n", "toool"),
        ("drawing = \"../bracket.dxf\"\n", "must name a file of the job's folder"),
        ("drawing = \"bracket.dxf\"\n", "name a tool"),
        ("drawing = \"bracket.dxf\"\ntool = \"6\"\npasses = [\"x\"]\n", "passes"),
    ] {
        fs::write(folder.join("job.toml"), text).unwrap();
        let output = keepout(&["plan", &job]);
        let said = complaint(&output);
        assert!(code(&output) == 2 && said.contains("job.toml") && said.contains(reason), "{said}");
    }
    fs::remove_file(folder.join("job.toml")).unwrap();
    let output = keepout(&["run", &job]);
    assert!(complaint(&output).contains("keepout new"), "{}", complaint(&output));
}

#[test]
fn tools_and_machines_have_names() {
    let folder = folder("store");
    let stored = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
        command.args(arguments).env("KEEPOUT_CONFIG", &folder).stdin(Stdio::null()).output().unwrap()
    };
    assert_eq!(code(&stored(&["tool", "new", "end mill 6", "--diameter", "1/4in"])), 0);
    assert!(printed(&stored(&["tool", "list"])).contains("end mill 6"));
    let again = stored(&["tool", "new", "end mill 6", "--diameter", "5"]);
    assert!(code(&again) == 2 && complaint(&again).contains("--overwrite"), "{}", complaint(&again));
    let wrong = stored(&["tool", "new", "../mill", "--diameter", "5"]);
    assert!(code(&wrong) == 2 && complaint(&wrong).contains("is not a valid name"), "{}", complaint(&wrong));
    assert!(printed(&stored(&["machine", "list"])).contains("simulated"));
    let job = folder.join("job").display().to_string();
    let unknown = stored(&["new", &bracket(), "-o", &job, "--machine", "lathe"]);
    assert!(code(&unknown) == 2 && complaint(&unknown).contains("lathe"), "{}", complaint(&unknown));
    assert!(!Path::new(&job).exists(), "a refused job leaves no folder");
    assert_eq!(code(&stored(&["new", &bracket(), "-o", &job, "--tool", "end mill 6"])), 0);
    assert!(printed(&stored(&["plan", &job])).contains("6.35 mm"));
    assert_eq!(code(&stored(&["tool", "remove", "end mill 6"])), 0);
    assert!(!printed(&stored(&["tool", "list"])).contains("end mill 6"));
    let gone = stored(&["tool", "remove", "end mill 6"]);
    assert!(code(&gone) == 2 && complaint(&gone).contains("there is no tool"), "{}", complaint(&gone));
    let built_in = stored(&["machine", "remove", "simulated"]);
    assert!(code(&built_in) == 2 && complaint(&built_in).contains("built in"), "{}", complaint(&built_in));
}

#[test]
fn no_output_is_lost_or_found_unwritable_after_the_run() {
    let folder = folder("outputs");
    let plan = folder.join("part.plan").display().to_string();
    let make = |more: &[&str]| keepout(&[&["plan", &bracket(), "-o", &plan], more].concat());
    assert_eq!(code(&make(&["--tool-diameter", "6"])), 0);
    let before = fs::read(&plan).unwrap();
    let other = make(&["--tool-diameter", "4"]);
    assert!(code(&other) == 2 && complaint(&other).contains("--overwrite"), "{}", complaint(&other));
    assert_eq!(fs::read(&plan).unwrap(), before);
    let report = folder.join("no/such/report.html").display().to_string();
    let log = folder.join("run.log");
    let run =
        ["run", &plan, "--machine", "sim-fast", "--report", &report, "--log", &log.display().to_string()];
    let output = keepout(&run);
    assert_eq!((code(&output), log.exists()), (7, false), "{}", complaint(&output));
}

#[test]
fn other_files_are_named_with_one_remedy() {
    let folder = folder("types");
    let cases: [(&[u8], &str); 4] = [
        (b"%PDF-1.7\n", "a PDF document. Export the drawing as DXF"),
        (b"AC1032\0\0\0", "a DWG drawing. Save it as DXF"),
        (b"PK\x03\x04....", "a ZIP archive. Unpack it"),
        (b"\x89PNG\r\n", "a PNG picture. A picture has no contours"),
    ];
    for (bytes, said) in cases {
        let path = folder.join("drawing.dxf");
        fs::write(&path, bytes).unwrap();
        let output = keepout(&["inspect", &path.display().to_string()]);
        let complaint = complaint(&output);
        assert!(code(&output) == 3 && complaint.contains(said), "{complaint}");
        assert!(!complaint.contains("Export it again"), "{complaint}");
    }
}

#[test]
fn program_behaves_in_a_shell() {
    let folder = folder("shell");
    for shell in ["bash", "zsh", "fish", "powershell"] {
        assert!(printed(&keepout(&["completions", shell])).contains("keepout"), "{shell}");
    }
    let pages = folder.join("man").display().to_string();
    assert_eq!(code(&keepout(&["man", "-o", &pages])), 0);
    assert!(count(Path::new(&pages)) > 10);
    let version = printed(&keepout(&["--version"]));
    assert!(version.starts_with("keepout ") && version.contains('.'), "{version}");
    let (_, job) = planned_job("shell-job");
    let plan = format!("{job}/part.plan");
    let picture = keepout(&["show", &plan, "-o", &folder.join("x.png").display().to_string()]);
    assert!(code(&picture) == 2 && complaint(&picture).contains("svg"), "{}", complaint(&picture));
    assert!(!folder.join("x.png").exists());
}

/// A reader that has gone ends the program without a message.
#[test]
fn closed_pipe_ends_the_program_quietly() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_keepout"))
        .args(["inspect", &bracket()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((code(&output), complaint(&output)), (0, String::new()));
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_is_named() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
    let output = command.args(["inspect", &bracket()]).stdout(full).output().unwrap();
    assert_eq!(code(&output), 7);
    assert!(complaint(&output).contains("cannot write the output: No space left"), "{}", complaint(&output));
}
