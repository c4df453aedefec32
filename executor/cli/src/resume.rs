//! The option `run --resume`: continues with the remaining contours of an earlier run.

use std::path::Path;

use keepout_executor::session::PlacedZ;
use keepout_executor::session::log::{Header, HeaderZ};
use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::Vector;
use keepout_planner::job::{LoopNumber, Progress};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::mm;

use super::before::place;
use super::replay::{Played, open};
use super::run::simulated_machine;
use super::{CliError, RunArguments};

/// A contour to cut again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recut {
    /// Number of the contour in the drawing, from 1.
    contour: usize,
    /// The pass, from 0; `None` for all passes.
    pass: Option<usize>,
}

impl Recut {
    /// The loops of the plan that cut the contour.
    fn loops(self, plan: &CertifiedPlan) -> Result<Vec<LoopNumber>, CliError> {
        let contour = plan.contour_numbered(self.contour).ok_or_else(|| {
            let names: Vec<String> = plan.contours().iter().map(|each| each.name.short()).collect();
            CliError::Argument(format!(
                "--recut: the plan has no contour {}. It has: {}.",
                self.contour,
                names.join(", ")
            ))
        })?;
        let of_pass = |number: &&LoopNumber| self.pass.is_none_or(|pass| number.pass == pass);
        let loops: Vec<LoopNumber> = contour.loops.iter().filter(of_pass).copied().collect();
        if loops.is_empty() {
            let reason = format!("--recut: the plan does not cut {} in that pass", contour.name.short());
            return Err(CliError::Argument(reason));
        }
        Ok(loops)
    }
}

/// Replays a log, and returns the progress at its end. Drops the progress of the contours in `recut`.
pub fn progress_of(log: &Path, work: &PreparedPlan, recut: &[Recut]) -> Result<(Progress, Header), CliError> {
    let played = Played::with(log, &mut open(log)?, work.clone())?;
    let mut progress = played.replay.supervisor.progress();
    for each in recut {
        each.loops(&work.plan)?.into_iter().for_each(|number| progress.forget(number));
    }
    let outcome = played.replay.outcome();
    println!("{:<36} {}; log checksum {:08x}", "resumed", outcome.tally, played.checksum);
    Ok((progress, played.header))
}

/// The progress of the run that the arguments continue: none if they begin a new part.
pub fn progress_before(arguments: &RunArguments, work: &PreparedPlan) -> Result<Progress, CliError> {
    let Some(log) = &arguments.resume else { return Ok(Progress::default()) };
    let (progress, header) = progress_of(log, work, &arguments.recut)?;
    fits(&header, &work.plan, arguments)?;
    Ok(progress)
}

/// Refuses to resume a run that cut at another place, or that only a simulated machine made.
fn fits(header: &Header, plan: &CertifiedPlan, arguments: &RunArguments) -> Result<(), CliError> {
    if header.dry_run {
        let reason = "the log of --resume is of a dry run, which cut no part. Leave out --resume";
        return Err(CliError::Argument(reason.into()));
    }
    if header.simulated && arguments.port.is_some() && !arguments.simulate {
        let reason = "the log of --resume is of a simulated machine, which cut no part. Leave out --resume";
        return Err(CliError::Argument(reason.into()));
    }
    let machine = match arguments.port {
        Some(_) => plan.plan.machine.clone(),
        None => simulated_machine(arguments, plan)?,
    };
    let now = place(plan, &machine, arguments)?;
    let Vector { dx, dy } = now.offset;
    let there = header.offset == now.offset && header.z.as_ref().map(HeaderZ::place) == now.z;
    if there || arguments.moved {
        return Ok(());
    }
    if header.offset == now.offset {
        let top = |z: Option<PlacedZ>| z.map_or("none".into(), |z| format!("{:.3}", mm(z.zero.units())));
        return Err(CliError::Argument(format!(
            "the run of --resume had the top of the part at z {}, this run has it at {}: the depths would not \
             fit. Give the same --top-mm. If the tool was measured again, give --moved.",
            top(header.z.as_ref().map(HeaderZ::place)),
            top(now.z),
        )));
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

/// Parses `CONTOUR` or `CONTOUR:PASS`. Printed numbers of contours and passes count from 1.
pub fn recut(text: &str) -> Result<Recut, String> {
    let wrong = || {
        format!(
            "\"{text}\" is not a contour: give its number as printed, such as 2, or 2:1 for pass 1 of contour 2"
        )
    };
    let number = |text: &str| text.parse::<usize>().ok().filter(|number| *number > 0).ok_or_else(wrong);
    let (contour, pass) = match text.split_once(':') {
        Some((contour, pass)) => (contour, Some(number(pass)? - 1)),
        None => (text, None),
    };
    Ok(Recut { contour: number(contour)?, pass })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contour_numbers_are_read_as_printed() {
        for (text, contour, pass) in [("1", 1, None), ("3", 3, None), ("2:4", 2, Some(3))] {
            assert_eq!(recut(text), Ok(Recut { contour, pass }));
        }
        for wrong in ["", "0", "1:0", "-1", "a", "1:2:3"] {
            assert!(recut(wrong).is_err(), "{wrong}");
        }
    }
}
