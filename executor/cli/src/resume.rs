//! `run --resume`: what an earlier run left of the contours.

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

/// The progress at the end of a log, which is played again first. Loops of `recut` are forgotten.
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

/// Refuses to go on with what was cut elsewhere, or by nothing but a simulated machine.
pub fn fits(header: &Header, plan: &CertifiedPlan, arguments: &RunArguments) -> Result<(), CliError> {
    if header.simulated && arguments.port.is_some() {
        let reason =
            "the log of --resume is of a simulated machine: nothing of it is cut. Leave out --resume";
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
        "the run of --resume had the drawing's origin at {}, this one has it at {}: what is cut would be cut again beside it. \
         Give the same --origin-mm or --alignment; if the workpiece was shifted, not turned, and was measured anew, give --moved",
        shown(header.offset.dx, header.offset.dy),
        shown(dx, dy),
    )))
}

/// `LOOP` or `LOOP:PASS`, as loops are printed: counted from 1.
pub fn number(text: &str) -> Result<LoopNumber, String> {
    let wrong = || {
        format!("\"{text}\" is no loop: give its number as printed, such as 2, or 2:1 for loop 2 of pass 1")
    };
    let (index, pass) = text.split_once(':').unwrap_or((text, "1"));
    let counted = |text: &str| text.parse::<usize>().ok()?.checked_sub(1);
    Ok(LoopNumber { pass: counted(pass).ok_or_else(wrong)?, index: counted(index).ok_or_else(wrong)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_numbered_as_printed() {
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
