//! The option `run --resume`: continues with the remaining contours of an earlier run.

use std::path::Path;

use keepout_executor::session::log::Header;
use keepout_executor::session::place_on_table;
use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::Vector;
use keepout_planner::job::{LoopNumber, Progress};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::mm;

use super::replay::{Played, open};
use super::run::simulated_machine;
use super::{CliError, RunArguments};

/// Replays a log, and returns the progress at its end. Drops the progress of the loops in `recut`.
pub fn progress_of(
    log: &Path,
    work: &PreparedPlan,
    recut: &[LoopNumber],
) -> Result<(Progress, Header), CliError> {
    let played = Played::with(log, &mut open(log)?, work.clone())?;
    let mut progress = played.replay.supervisor.progress();
    for &number in recut {
        if !number.is_of(&work.plan) {
            return Err(CliError::Argument(format!("--recut: the plan has no {number}")));
        }
        progress.forget(number);
    }
    println!(
        "{:<36} {} of {} loops finished, {} cut in part; log checksum {:08x}",
        "resumed",
        progress.finished.len(),
        work.plan.plan.loop_count(),
        progress.partial.len(),
        played.checksum,
    );
    Ok((progress, played.header))
}

/// Refuses to resume a run that cut at another place, or that only a simulated machine made.
pub fn fits(header: &Header, plan: &CertifiedPlan, arguments: &RunArguments) -> Result<(), CliError> {
    if header.simulated && arguments.port.is_some() {
        let reason = "the log of --resume is of a simulated machine, which cut no part. Leave out --resume";
        return Err(CliError::Argument(reason.into()));
    }
    let machine = match arguments.port {
        Some(_) => plan.plan.machine.clone(),
        None => simulated_machine(arguments)?,
    };
    let Vector { dx, dy } = place_on_table(plan, &machine, arguments.origin_mm)?.offset;
    if header.offset == (Vector { dx, dy }) || arguments.moved {
        return Ok(());
    }
    let shown = |dx: i32, dy: i32| format!("{:.3},{:.3}", mm(dx), mm(dy));
    Err(CliError::Argument(format!(
        "the run of --resume had the drawing's origin at {}, this run has it at {}: the contours would be \
         cut again beside themselves. Give the same --origin-mm or --alignment. If the workpiece was \
         shifted, not turned, and was measured again, give --moved.",
        shown(header.offset.dx, header.offset.dy),
        shown(dx, dy),
    )))
}

/// Parses `LOOP` or `LOOP:PASS`. Printed numbers of loops and passes count from 1.
pub fn number(text: &str) -> Result<LoopNumber, String> {
    let wrong = || {
        format!(
            "\"{text}\" is not a loop: give its number as printed, such as 2, or 2:1 for loop 2 of pass 1"
        )
    };
    let (index, pass) = text.split_once(':').unwrap_or((text, "1"));
    let counted = |text: &str| text.parse::<usize>().ok()?.checked_sub(1);
    Ok(LoopNumber { pass: counted(pass).ok_or_else(wrong)?, index: counted(index).ok_or_else(wrong)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loop_numbers_are_read_as_printed() {
        for (text, wanted) in [("1", (0, 0)), ("3", (0, 2)), ("2:4", (3, 1))] {
            let read = number(text).unwrap();
            assert_eq!((read.pass, read.index), wanted, "{text}");
            let words: Vec<String> = read.to_string().split(' ').map(String::from).collect();
            assert_eq!(number(&format!("{}:{}", words[1], words[4])), Ok(read));
        }
        for wrong in ["", "0", "1:0", "-1", "a", "1:2:3"] {
            assert!(number(wrong).is_err(), "{wrong}");
        }
    }
}
