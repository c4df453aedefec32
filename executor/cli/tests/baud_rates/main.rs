//! Tests of end-to-end jobs at 9600, 38400 and 115200 baud with controllers of every dialect: connect, home,
//! jog to the wall, touch it, cut the contour, quit. Each job runs in virtual time, and as the program on a
//! serial port. There, `keepout run` opens a pty, and `keepout simulate` behind it keeps to the baud rate in
//! both directions.
//!
//! `tests/transcripts` keeps the conversations: the beginning and the end of each part of a session. In
//! virtual time a conversation repeats byte by byte. On a pty the times of the queries depend on the
//! computer's threads. There, the chunks that set the controller up and home it, and the commands of the
//! contour, must equal those of the session in virtual time and of the kept transcript.
//!
//! `KEEPOUT_WRITE_TRANSCRIPTS=1` writes the files again. Check the differences before you keep them.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod conversation;
mod job;
#[path = "../support/machine.rs"]
mod machine_of_test;
mod on_a_pty;
mod throttle;
mod virtual_time;

use conversation::Conversation;
use job::{Case, Job};
use throttle::is_throttled;

/// Plays every dialect at every baud rate, each case in a thread of its own. Fails with the reasons of all
/// failed cases.
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
fn conversations_in_virtual_time_equal_the_kept_transcripts() {
    let job = Job::new("virtual");
    every_case(&job, |job, case| {
        let log = virtual_time::session(job, case)?;
        is_throttled(&log, case)?;
        if case.baud == 115_200 && is_throttled(&log, case.at(9600)).is_ok() {
            return Err("the session at 115200 baud also fits in 9600 baud".into());
        }
        let conversation = Conversation::of(&log);
        job::compare(&job::kept("virtual", case), &conversation.text(case, "virtual time"))
    });
}

#[test]
fn conversations_on_a_pty_agree_with_virtual_time_and_the_kept_transcripts() {
    let job = Job::new("pty");
    every_case(&job, |job, case| {
        let model = Conversation::of(&virtual_time::session(job, case)?);
        let log = on_a_pty::session(job, case)?;
        is_throttled(&log, case)?;
        let conversation = Conversation::of(&log);
        conversation.agrees_with(&model)?;
        let kept = job::kept("pty", case);
        job::write(&kept, &conversation.text(case, "behind a pty"))?;
        let kept = std::fs::read_to_string(&kept).map_err(|error| error.to_string())?;
        conversation.agrees_with_transcript(&Conversation::parse(&kept))
    });
}
