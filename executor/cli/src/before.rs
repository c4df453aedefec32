//! Checks before a run, and the page that a person confirms before the first motion.

use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use keepout_executor::session::{PlaceError, TablePlacement, place_on_table};
use keepout_kernel::Height;
use keepout_planner::Mm2;
use keepout_planner::align::file::AlignmentFile;
use keepout_planner::depth::Relief;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::text_file;
use keepout_planner::units::mm;

use super::plan::check_ending;
use super::run::dialect_name;
use super::values::seconds;
use super::{CliError, RunArguments};

/// Who operates a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OperatorName {
    /// The name, as the command line gives it.
    pub name: String,
    /// Whether a person operates.
    pub by_hand: bool,
}

impl OperatorName {
    /// The operator of the arguments. A real machine has no default, and no model moves it.
    pub fn of(arguments: &RunArguments) -> Result<Self, CliError> {
        let at_port = arguments.port.is_some();
        let name = match (&arguments.operator, at_port) {
            (Some(name), _) => name.clone(),
            (None, false) => "calm".into(),
            (None, true) => {
                let reason = "a run at a port needs an operator: give --operator keyboard, gamepad or \
                              handwheel";
                return Err(CliError::Argument(reason.into()));
            }
        };
        let kind = name.split(':').next().unwrap_or(&name);
        let by_hand = ["keyboard", "gamepad", "handwheel"].contains(&kind);
        if at_port && !by_hand && !arguments.simulate {
            return Err(CliError::Argument(format!(
                "--operator {name} is not a person. Only a person moves a real machine: give --operator keyboard, \
                 gamepad or handwheel. If the controller at the port is a simulator, state that with --simulate."
            )));
        }
        Ok(Self { name, by_hand })
    }
}

/// Refuses options without the log or port that they need, and a real machine that does not know its place or the
/// drawing's.
pub fn refuse_incomplete(arguments: &RunArguments) -> Result<(), CliError> {
    if arguments.port.is_none() && arguments.simulate {
        let reason =
            "--simulate is for a port. Without --port, the machine is simulated anyway: leave it out";
        return Err(CliError::Argument(reason.into()));
    }
    if arguments.resume.is_none() && (arguments.moved || !arguments.recut.is_empty()) {
        let reason =
            "--recut and --moved continue an earlier run: give --resume LOG, or `keepout resume JOB`";
        return Err(CliError::Argument(reason.into()));
    }
    if arguments.port.is_some() && arguments.origin_mm.is_none() {
        let reason =
            "a real machine needs the drawing's origin: --alignment, --origin-mm, or `keepout align JOB`";
        return Err(CliError::Argument(reason.into()));
    }
    if arguments.port.is_some() && !arguments.home && !arguments.homed {
        let reason = "a real machine needs --home (tool raised), or --homed if it was homed since power-up";
        return Err(CliError::Argument(reason.into()));
    }
    Ok(())
}

/// Refuses a plan whose margin is of the simulated machine, at a real one.
pub fn refuse_margin_of_simulation(
    arguments: &RunArguments,
    machine: &MachineProfile,
) -> Result<(), CliError> {
    if arguments.port.is_none() || arguments.simulate {
        return Ok(());
    }
    let simulated = MachineProfile::simulated();
    // A profile that `drives budget` made from the simulated machine keeps its name, but has its own source.
    if machine.name != simulated.name && machine.contour_error_source != simulated.contour_error_source {
        return Ok(());
    }
    Err(CliError::Argument(format!(
        "the plan's margin and travel are of the {}, not of the machine at the port. Store the machine's figures with \
         `keepout machine new`, and make the plan again with --machine NAME. If the controller at the port is a \
         simulator, state that with --simulate.",
        simulated.name
    )))
}

/// The place of the drawing on the machine.
pub fn place(
    plan: &CertifiedPlan,
    machine: &MachineProfile,
    arguments: &RunArguments,
) -> Result<TablePlacement, CliError> {
    let place = place_on_table(plan, machine, arguments.origin_mm)?;
    place.moved_by(&dialect_name(arguments)?)?;
    let lift_mm = if arguments.dry_run { dry_lift_mm(plan) } else { 0.0 };
    place.with_top(plan, arguments.top_mm.map(|top_mm| top_mm + lift_mm)).map_err(|error| match error {
        PlaceError::TopBeyond { lowest, highest } if lift_mm > 0.0 => CliError::Argument(format!(
            "a dry run goes {lift_mm:.1} mm higher than the cuts, beyond the travel of z: for a dry run --top-mm may \
             be {:.1} to {:.1}",
            lowest - lift_mm,
            highest - lift_mm
        )),
        other => other.into(),
    })
}

/// Height between the stock or a clamp and the tool in a dry run, mm.
const DRY_ABOVE_MM: f64 = 5.0;

/// How much higher a dry run goes, mm: its deepest pass is above the stock and the clamps.
fn dry_lift_mm(plan: &CertifiedPlan) -> f64 {
    let heights = |relief: &Relief| (mm(relief.clamps.units()).max(0.0), mm(relief.deepest.units()));
    plan.plan.relief.as_ref().map(heights).map_or(0.0, |(highest, deepest)| highest - deepest + DRY_ABOVE_MM)
}

/// Refuses a plan with depths at a real machine whose height of the part's top is not known.
pub fn refuse_unknown_top(arguments: &RunArguments, plan: &CertifiedPlan) -> Result<(), CliError> {
    if plan.plan.relief.is_none() || arguments.top_mm.is_some() {
        return Ok(());
    }
    let reason = "the plan has depths, and the height of the part is not known: touch its top with `keepout align \
                  JOB --take top`, or give the machine's z there with --top-mm";
    Err(CliError::Argument(reason.into()))
}

/// Refuses an alignment that was found with another drawing than the plan's.
pub fn refuse_other_drawing(
    alignment: &AlignmentFile,
    path: &Path,
    plan: &CertifiedPlan,
    same_origin: bool,
) -> Result<(), CliError> {
    let name = &plan.plan.provenance.name;
    if alignment.drawing == *name || same_origin {
        return Ok(());
    }
    Err(CliError::Argument(format!(
        "{} was found with {}, but the plan is of {name}. Part and clamps lie where the alignment states only if \
         both drawings have the same origin. If they have, give --same-origin.",
        path.display(),
        text_file::shown(&alignment.drawing),
    )))
}

/// Checks that an output file can be written in its folder, before anything moves. `wanted`: the ending of its name.
pub fn check_output(path: Option<&Path>, wanted: Option<&str>) -> Result<(), CliError> {
    let Some(path) = path else { return Ok(()) };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let probe = folder.join(format!(".keepout-{}.tmp", std::process::id()));
    let unwritable = keepout_planner::file::OUTPUT.write_error(path);
    if path.is_dir() {
        let error = std::io::Error::new(std::io::ErrorKind::IsADirectory, "it is a folder");
        return Err(unwritable(error).into());
    }
    wanted.map_or(Ok(()), |ending| check_ending(path, ending))?;
    std::fs::write(&probe, b"").map_err(unwritable)?;
    let _ = std::fs::remove_file(&probe);
    Ok(())
}

/// The time limit. A run with a person has none by default.
pub fn limit(given: Option<f64>, by_hand: bool) -> Result<Duration, CliError> {
    const UNATTENDED_S: f64 = 3600.0;
    const ATTENDED_S: f64 = 1e7;
    seconds("--limit-s", given.unwrap_or(if by_hand { ATTENDED_S } else { UNATTENDED_S }))
}

/// The log of a run at a port without --log: beside the plan, with the date in its name.
pub fn default_log(plan: &Path, began: &str) -> PathBuf {
    let stem = plan.file_stem().unwrap_or_default().to_string_lossy();
    let date: String = began.chars().map(|c| if c == ':' { '-' } else { c }).collect();
    plan.with_file_name(format!("{stem}-{}.log", date.trim_end_matches('Z')))
}

/// The page before the first motion.
pub struct ConfirmPage<'a> {
    pub plan: &'a CertifiedPlan,
    pub arguments: &'a RunArguments,
    pub operator: &'a str,
    pub port: &'a str,
    pub place: &'a TablePlacement,
    pub progress: &'a Progress,
    pub log: Option<&'a Path>,
}

impl ConfirmPage<'_> {
    fn lines(&self) -> Vec<String> {
        let Self { plan, arguments, operator, port, place, progress, log } = self;
        let made = &plan.plan;
        let row = |name: &str, value: String| format!("  {name:<16} {value}");
        let (offset, unit) = (place.offset, arguments.display());
        let origin = unit.place(Mm2::new(mm(offset.dx), mm(offset.dy)));
        let origin = format!("{origin} in machine coordinates");
        let aligned = match &arguments.alignment {
            Some(path) => format!("by {}", path.display()),
            None => "stated by --origin-mm; the rotation is not measured".into(),
        };
        let homing = if arguments.home { "the machine homes first: RAISE THE TOOL" } else { "homed before" };
        let mut lines = vec![
            "Before the first motion".to_string(),
            row("machine", format!("{} at {port}; {homing}", made.machine.name)),
            row("operator", (*operator).into()),
            row("drawing", made.provenance.name.clone()),
            row("part", format!("{}, {}", unit.size(plan.profile_size_mm()), plan.side_words())),
            row("tool", format!("Ø {}", unit.length(2.0 * mm(made.tool_radius.units())))),
            row("stock to leave", unit.length(mm(made.stock_to_leave.units()))),
            row("feed", format!("{} along contours", unit.feed(arguments.feed_mm_min()))),
            row("drawing's origin", origin),
            row("alignment", aligned),
            row("log", log.map_or("none".into(), |log| log.display().to_string())),
        ];
        lines.extend(self.spindle().map(|spindle| row("spindle", spindle)));
        if let (Some(relief), Some(z)) = (&made.relief, place.z) {
            let on_machine = |height: Height| unit.length(mm(height.units()) + mm(z.zero.units()));
            lines.push(row(
                "top of the part",
                format!("z {} in machine coordinates", on_machine(Height::ZERO)),
            ));
            let (safe, deepest) = (on_machine(relief.safe), on_machine(relief.deepest));
            lines.push(row("heights", format!("crosses at z {safe}, cuts down to z {deepest}")));
        }
        if arguments.dry_run && made.relief.is_some() {
            let lift = unit.length(dry_lift_mm(plan));
            lines.push(format!(
                "  DRY RUN: {lift} higher than the cuts, above stock and clamps. Nothing counts as cut."
            ));
        } else if arguments.dry_run {
            lines.push("  DRY RUN: RAISE THE TOOL above stock and clamps. Nothing counts as cut.".into());
        }
        for contour in plan.contours() {
            let done =
                !contour.loops.is_empty() && contour.loops.iter().all(|each| progress.has_finished(*each));
            let fate = match (contour.loops.is_empty(), done, arguments.dry_run) {
                (true, ..) => "WILL NOT BE CUT, the tool does not fit",
                (false, true, _) => "is cut already",
                (false, false, true) => "will be traced",
                (false, false, false) => "will be cut",
            };
            lines.push(format!("  {:<40} {fate}", contour.name.short()));
        }
        let unknown = match made.relief {
            Some(_) => "the spindle, or clamps that are not drawn. It takes the height of the top from you",
            None => "the spindle, the tool's height, or clamps that are not drawn",
        };
        lines.push(format!("Keepout does not know {unknown}."));
        lines
    }

    /// Who switches the spindle. `None` where the machine profile does not name its speed.
    fn spindle(&self) -> Option<String> {
        let rpm = self.plan.plan.machine.spindle_rpm?;
        Some(if dialect_name(self.arguments).is_ok_and(|dialect| dialect.switches_spindle()) {
            format!(
                "the controller starts it at {rpm} rpm when you ask twice. After a fault it keeps running"
            )
        } else {
            "switched by you: this dialect has no words for it".into()
        })
    }

    /// Shows the page, and waits for the person's consent.
    pub fn confirm(&self) -> Result<(), CliError> {
        for line in self.lines() {
            eprintln!("{line}");
        }
        if self.arguments.yes {
            return Ok(());
        }
        if !std::io::stdin().is_terminal() {
            let reason =
                "a person confirms this page, and the input is not a terminal. A script gives --yes.";
            return Err(CliError::Argument(reason.into()));
        }
        eprint!("Type y and press Enter to start; anything else ends: ");
        let _ = std::io::stderr().flush();
        let mut answer = String::new();
        let _ = std::io::stdin().lock().read_line(&mut answer);
        match answer.trim() {
            "y" | "Y" | "yes" => Ok(()),
            _ => Err(CliError::Argument("not confirmed: nothing was moved".into())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_run_without_a_person_has_a_limit_of_its_own() {
        assert!(limit(None, true).unwrap() > Duration::from_secs(100 * 3600));
        assert_eq!(limit(None, false).unwrap(), Duration::from_secs(3600));
        assert_eq!(limit(Some(60.0), true).unwrap(), Duration::from_secs(60));
        assert!(limit(Some(-1.0), true).is_err());
    }
}
