//! The command `align`: finds how the workpiece lies on the machine.

use std::path::Path;
use std::process::ExitCode;

use keepout_planner::Mm2;
use keepout_planner::align::file::{AlignmentFile, Method, VERSION};
use keepout_planner::align::{Alignment, PartEdges, ProbePoint, ProbePoints, align as aligned};
use keepout_planner::plan::{CertifiedPlan, PlanError};
use keepout_planner::profile::{MachinedSide, Profile};
use keepout_planner::request::PlanRequestError;

use super::before::refuse_other_drawing;
use super::job::{JobFolder, keep_earlier};
use super::plan::{refuse_same, request_of};
use super::take::{TakeMethod, Taken, take};
use super::{AlignArguments, CliError, RunArguments, pair};

/// Parses `DX,DY=MX,MY`: a place in drawing coordinates, and the same place in machine coordinates, mm.
pub fn probe_point(text: &str) -> Result<ProbePoint, String> {
    let (drawing, machine) = text.split_once('=').ok_or_else(|| {
        format!(
            "\"{text}\" is not a probe point: give drawing and machine coordinates, such as 0,0=-250.5,-200"
        )
    })?;
    Ok(ProbePoint { drawing_mm: pair(drawing)?, machine_mm: pair(machine)? })
}

pub fn align(given: &AlignArguments) -> Result<ExitCode, CliError> {
    let job = JobFolder::at(&given.drawing.drawing)?;
    let mut arguments = given.clone();
    if let Some(job) = &job {
        arguments.drawing = job.drawing_arguments(&given.drawing);
        arguments.side = given.side.or(job.file.side);
    }
    let arguments = &arguments;
    let own = job.as_ref().map(JobFolder::alignment);
    let output =
        arguments.output.clone().or(own).ok_or_else(|| {
            CliError::Argument("give the output file with -o, or the folder of a job".into())
        })?;
    let path = &arguments.drawing.drawing;
    if arguments.drawing.rotate_deg.is_some() || arguments.drawing.offset_mm.is_some() {
        let reason =
            "`align` finds the rotation and the offset itself: leave out --rotate-deg and --offset-mm";
        return Err(CliError::Argument(reason.into()));
    }
    refuse_same(&[path], &[&output])?;
    if arguments.top_mm.is_some() || arguments.take == Some(TakeMethod::Top) {
        return align_top(arguments, job.as_ref(), &output);
    }
    let profile = profile_of(arguments)?;
    let side: MachinedSide = arguments.side.map_or(MachinedSide::Outside, Into::into);
    let wrong = |source: PlanRequestError| CliError::PlanRequest { path: path.clone(), source };
    let part = PartEdges::of(&profile, side).map_err(|error| wrong(PlanError::from(error).into()))?;
    let taken = taken(arguments, job.as_ref(), &profile, side)?;
    let tool_mm = job.as_ref().and_then(|job| job.tool_mm().ok());
    let probe_points = ProbePoints {
        points: taken.points,
        edges: taken.edges,
        probe_diameter_mm: arguments.probe_diameter.or(tool_mm).unwrap_or(0.0),
        probe_error_mm: arguments.probe_error_mm,
        tolerance_mm: arguments.tolerance_mm,
    };
    let found = aligned(&part, &probe_points)?;
    let drawing = path.file_name().unwrap_or_default().to_string_lossy();
    let alignment = file_of(&found, &probe_points, &drawing);
    if job.is_some() {
        keep_earlier(&output)?;
    }
    alignment.save(&output)?;
    println!("{}", summary(&found, &probe_points));
    println!("written      {}", output.display());
    if let Some(job) = job.filter(|_| found.turned) {
        println!("next         keepout plan {}: the plan turns with the part", job.folder.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// The places of the arguments, or those that the operator takes in the program.
fn taken(
    arguments: &AlignArguments,
    job: Option<&JobFolder>,
    profile: &Profile,
    side: MachinedSide,
) -> Result<Taken, CliError> {
    let none = arguments.point.is_empty() && arguments.edge.is_empty();
    Ok(match (job, arguments.take, none) {
        (Some(job), method, true) => {
            let method = method.unwrap_or(TakeMethod::Edges);
            if !arguments.home && !arguments.homed {
                let reason = "give --home (tool raised), or --homed if the machine was homed since power-up";
                return Err(CliError::Argument(reason.into()));
            }
            let unit = arguments.display.or(job.file.display).unwrap_or_default();
            take(method, (profile, side), &job.machine()?, arguments.home, unit)?
        }
        (None, Some(_), _) => {
            let reason = "--take needs the folder of a job, which names the machine: `keepout new DRAWING`";
            return Err(CliError::Argument(reason.into()));
        }
        _ => Taken { points: arguments.point.clone(), edges: arguments.edge.clone(), ..Taken::default() },
    })
}

/// Writes the height of the top of the part into the alignment file that is there: as the arguments state it, or as the
/// operator touches it.
fn align_top(
    arguments: &AlignArguments,
    job: Option<&JobFolder>,
    output: &Path,
) -> Result<ExitCode, CliError> {
    let alignment = AlignmentFile::load(output).map_err(|error| {
        CliError::Argument(format!("{error} For the height of the part, align the other axes first."))
    })?;
    let top_mm = match arguments.top_mm {
        Some(top_mm) => top_mm,
        None => {
            let taken = taken(arguments, job, &Profile::default(), MachinedSide::Outside)?;
            taken.tip_mm.map_or(f64::NAN, |tip_mm| tip_mm - arguments.gauge_mm)
        }
    };
    let alignment = AlignmentFile { top_mm: Some(top_mm), ..alignment }.checked()?;
    if job.is_some() {
        keep_earlier(output)?;
    }
    alignment.save(output)?;
    println!("top          z {top_mm:.3} mm machine coordinates, under this tool alone");
    println!("written      {}", output.display());
    Ok(ExitCode::SUCCESS)
}

fn profile_of(arguments: &AlignArguments) -> Result<Profile, CliError> {
    let path = &arguments.drawing.drawing;
    let wrong = |source: PlanRequestError| CliError::PlanRequest { path: path.clone(), source };
    let request = request_of(&arguments.drawing)?;
    let bytes = keepout_planner::drawing::read_file(path).map_err(CliError::Drawing)?;
    let (_, chained) = request.contours(&bytes).map_err(|error| wrong(error.into()))?;
    Ok(chained.profile)
}

pub fn file_of(found: &Alignment, probe_points: &ProbePoints, drawing: &str) -> AlignmentFile {
    let method = match (probe_points.points.is_empty(), probe_points.edges.is_empty()) {
        (false, false) => Method::PointsAndEdges,
        (true, _) => Method::Edges,
        (false, true) => Method::Points,
    };
    let Mm2 { x, y } = found.origin_mm;
    AlignmentFile {
        version: VERSION,
        rotation_deg: found.rotation_deg,
        origin_mm: [x, y],
        drawing: drawing.into(),
        method,
        touches: probe_points.points.len() + probe_points.edges.len(),
        rotation_measured: found.turned,
        residual_mm: found.residual_mm(),
        probe_error_mm: probe_points.probe_error_mm,
        uncertainty_mm: found.uncertainty_mm,
        top_mm: None,
    }
}

fn summary(found: &Alignment, probe_points: &ProbePoints) -> String {
    let measured = if found.turned {
        ""
    } else {
        " (not measured: the program assumes that the drawing's axes are parallel to the machine's)"
    };
    let mut lines = vec![
        format!("rotation     {}°{measured}", found.rotation_deg),
        format!("origin       {} machine coordinates", found.origin_mm),
    ];
    let points = (1..=probe_points.points.len()).map(|number| format!("point {number}"));
    let edges = (1..=probe_points.edges.len()).map(|number| format!("edge touch {number}"));
    let residuals = points.chain(edges).zip(&found.residuals_mm);
    lines.extend(residuals.map(|(name, off)| format!("residual     {off:.4} mm at {name}")));
    lines.push(format!(
        "uncertainty  the part can lie up to {:.4} mm off at {} of the drawing, if each touch is up to {} mm \
         wrong",
        found.uncertainty_mm, found.worst_at_mm, probe_points.probe_error_mm
    ));
    lines.push(
        "margin       the uncertainty does not affect it: path and part move together. The part may sit off \
         by the uncertainty in its stock, and against features made before. Enlarge drawn clamps by it"
            .into(),
    );
    if found.poor {
        let gain = found.uncertainty_mm / probe_points.probe_error_mm;
        lines.push(format!(
            "note         the uncertainty is {gain:.0} times the probe error: touch points farther apart, \
             and edges square to each other"
        ));
    }
    lines.join("\n")
}

/// The arguments, with the origin that their alignment file gives for the plan.
pub fn placed(arguments: &RunArguments, plan: &CertifiedPlan) -> Result<RunArguments, CliError> {
    let mut placed = arguments.clone();
    if let Some(path) = &arguments.alignment {
        let alignment = AlignmentFile::load(path)?;
        placed.origin_mm = Some(alignment.origin_for(&plan.plan)?);
        placed.top_mm = arguments.top_mm.or(alignment.top_mm);
        refuse_other_drawing(&alignment, path, plan, arguments.same_origin)?;
    }
    Ok(placed)
}
