//! Whole sessions at 9600, 38400 and 115200 baud with controllers of every language: connect, home, steer to the wall, touch,
//! contour, quit. In virtual time, and as the program on a serial port: `keepout run` on a pty, behind which `keepout simulate`
//! takes and gives no more bytes than its baud rate lets through.
//!
//! What was said is kept in `tests/transcripts`: the beginning and the end of each part of a session. In virtual time it is the same to
//! the byte. On a pty the questions come as the threads of the computer take turns; what sets the controller up and homes
//! it, and the commands of the contour, must be those of the session in virtual time, and of the transcript that is kept.
//!
//! `KEEPOUT_WRITE_TRANSCRIPTS=1` writes the files anew; look at the difference before it is kept.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod conversation;
mod job;
mod on_a_pty;
mod throttle;
mod virtual_time;

use conversation::Conversation;
use job::{Case, Job};
use throttle::is_throttled;

/// Every language at every rate, each case in a thread of its own; what went wrong in any.
fn every_case(job: &Job, play: impl Fn(&Job, Case) -> Result<(), String> + Sync) {
    let cases = Case::all();
    assert_eq!(cases.len(), 18);
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let play = &play;
        let threads: Vec<_> =
            cases.iter().map(|&case| (case, scope.spawn(move || play(job, case)))).collect();
        let failed = threads.into_iter().filter_map(|(case, thread)| {
            let outcome = thread.join().unwrap_or_else(|_| Err("stopped".into()));
            outcome.err().map(|reason| format!("{}: {reason}", case.name()))
        });
        failed.collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn in_virtual_time_word_for_word() {
    let job = Job::new("virtual");
    every_case(&job, |job, case| {
        let log = virtual_time::session(job, case)?;
        is_throttled(&log, case)?;
        if case.baud == 115_200 && is_throttled(&log, case.at(9600)).is_ok() {
            return Err("it would pass for a session at 9600 baud".into());
        }
        let said = Conversation::of(&log);
        job::compare(&job::kept("virtual", case), &said.text(case, "virtual time"))
    });
}

#[test]
fn on_a_pty_as_programs() {
    let job = Job::new("pty");
    every_case(&job, |job, case| {
        let model = Conversation::of(&virtual_time::session(job, case)?);
        let log = on_a_pty::session(job, case)?;
        is_throttled(&log, case)?;
        let said = Conversation::of(&log);
        said.agrees_with(&model)?;
        let kept = job::kept("pty", case);
        job::write(&kept, &said.text(case, "behind a pty"))?;
        let kept = std::fs::read_to_string(&kept).map_err(|error| error.to_string())?;
        said.is_told_by(&Conversation::parse(&kept))
    });
}
