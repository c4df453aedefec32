//! A session of processes: `keepout simulate` behind a pty, `keepout run` at the serial port, then `keepout
//! replay`.

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use keepout_executor::session::LoggedEvent;
use keepout_executor::session::log::{Entry, Log};
use keepout_planner::Mm2;

use super::job::{Case, FEED_MM_MIN, Job, LATENCY_MS, ORIGIN_MM, START_MM};
use super::machine_of_test::MachineProcess;

const PROGRAM: &str = env!("CARGO_BIN_EXE_keepout");

/// Ends the machine. Fails if the tool was in the part.
fn end(mut machine: MachineProcess) -> Result<(), String> {
    match machine.end() {
        Some(0) => Ok(()),
        Some(8) => Err("the tool was in the part".into()),
        other => Err(format!("the machine ended with {other:?}")),
    }
}

/// Plays a case, and returns its log.
pub fn session(job: &Job, case: Case) -> Result<Log, String> {
    let path = |end: &str| job.at(&format!("{}.{end}", case.name()));
    let (plan, dialect, baud) = (job.plan_file(case), case.dialect(), case.baud.to_string());
    let (port, log, received) = (path("port"), path("log"), path("received"));
    let place = |Mm2 { x, y }: Mm2| format!("{x},{y}");
    let (origin, start) = (place(ORIGIN_MM), place(START_MM));
    let latency = LATENCY_MS.to_string();
    let mut arguments = vec!["--dialect", &dialect, "--baud", &baud, "--received", &received];
    arguments.extend(["--start-mm", &start, "--latency-ms", &latency]);
    arguments.extend(["--monitor", &plan, "--origin-mm", &origin]);
    let machine = MachineProcess::start(&port, &arguments, Duration::from_secs(60));
    let (script, feed) = (job.at("script"), FEED_MM_MIN.to_string());
    let mut arguments =
        vec!["run", &plan, "--simulate", "--yes", "--port", &port, "--dialect", &dialect, "--baud", &baud];
    arguments.extend(["--home", "--origin-mm", &origin, "--operator", &script, "--log", &log]);
    arguments.extend(["--feed-mm-min", &feed, "--limit-s", "300", "--answer-within-s", "60"]);
    // Exit code 0 means that the session ended as the operator wanted, with a finished contour.
    succeeds(&arguments)?;
    end(machine)?;
    succeeds(&["replay", &log, "--plan", &plan])?;
    let log = Log::load(Path::new(&log)).map_err(|error| error.to_string())?;
    let sent: Vec<u8> = log.entries.iter().flat_map(sent).copied().collect();
    if std::fs::read(&received).map_err(|error| error.to_string())? != sent {
        return Err("the machine did not receive the logged bytes".into());
    }
    Ok(log)
}

fn succeeds(arguments: &[&str]) -> Result<(), String> {
    let Output { status, stdout, stderr } =
        Command::new(PROGRAM).args(arguments).output().map_err(|error| error.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    match status.code() {
        Some(0) => Ok(()),
        code => Err(format!("{} ended with {code:?}: {}{}", arguments[0], text(&stdout), text(&stderr))),
    }
}

fn sent(entry: &Entry) -> &[u8] {
    if let LoggedEvent::Sent(bytes) = &entry.event { bytes } else { &[] }
}
