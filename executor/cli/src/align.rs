//! `align`: how the workpiece lies on the machine.

use std::process::ExitCode;

use keepout_planner::align::file::{AlignmentFile, Method, VERSION};
use keepout_planner::align::{Alignment, Part, ProbePoint, ProbePoints, align as aligned};
use keepout_planner::plan::{CertifiedPlan, PlanError};
use keepout_planner::profile::Profile;
use keepout_planner::request::PlanRequestError;
use keepout_planner::text_file;
use keepout_planner::units::mm_pair;

use super::plan::{order_of, refuse_same};
use super::{AlignArguments, CliError, RunArguments, pair};

/// `DX,DY=MX,MY`: a place in the drawing and machine coordinates.
pub fn touch(text: &str) -> Result<ProbePoint, String> {
    let (drawing, machine) = text.split_once('=').ok_or_else(|| {
        format!("\"{text}\" is no touch: give drawing and machine coordinates, such as 0,0=-250.5,-200")
    })?;
    Ok(ProbePoint { drawing_mm: pair(drawing)?, machine_mm: pair(machine)? })
}

pub fn align(arguments: &AlignArguments) -> Result<ExitCode, CliError> {
    let path = &arguments.drawing.drawing;
    if arguments.drawing.rotate_deg.is_some() || arguments.drawing.offset_mm.is_some() {
        let reason = "how the drawing is turned and moved is what `register` finds: leave out --rotate-deg and --offset-mm";
        return Err(CliError::Argument(reason.into()));
    }
    refuse_same(&[path], &[&arguments.output])?;
    let part = part_of(arguments)?;
    let touches = ProbePoints {
        points: arguments.point.clone(),
        edges: arguments.edge.clone(),
        probe_diameter_mm: arguments.probe_diameter.unwrap_or(0.0),
        probe_error_mm: arguments.probe_error_mm,
        tolerance_mm: arguments.tolerance_mm,
    };
    let found = aligned(&part, &touches)?;
    let alignment = setup_of(&found, &touches, &path.file_name().unwrap_or_default().to_string_lossy());
    alignment.save(&arguments.output)?;
    println!("{}", summary(&found, &touches));
    println!("written      {}", arguments.output.display());
    Ok(ExitCode::SUCCESS)
}

fn part_of(arguments: &AlignArguments) -> Result<Part, CliError> {
    let path = &arguments.drawing.drawing;
    let wrong = |source: PlanRequestError| CliError::PlanRequest { path: path.clone(), source };
    let order = order_of(&arguments.drawing)?;
    let bytes = keepout_planner::drawing::read_file(path).map_err(|error| wrong(error.into()))?;
    let (_, chained) = order.contours(&bytes).map_err(|error| wrong(error.into()))?;
    let loops = chained.profile.loops.into_iter().filter(|each| !each.is_flat()).collect();
    Part::of(&Profile { loops }, arguments.side.into()).map_err(|error| wrong(PlanError::from(error).into()))
}

fn setup_of(found: &Alignment, touches: &ProbePoints, drawing: &str) -> AlignmentFile {
    let method = match (touches.points.is_empty(), touches.edges.is_empty()) {
        (false, false) => Method::PointsAndEdges,
        (true, _) => Method::Edges,
        (false, true) => Method::Points,
    };
    let (x, y) = found.origin_mm;
    AlignmentFile {
        version: VERSION,
        rotation_deg: found.rotation_deg,
        origin_mm: [x, y],
        drawing: drawing.into(),
        method,
        touches: touches.points.len() + touches.edges.len(),
        rotation_measured: found.turned,
        residual_mm: found.residual_mm(),
        probe_error_mm: touches.probe_error_mm,
        uncertainty_mm: found.uncertainty_mm,
    }
}

fn summary(found: &Alignment, touches: &ProbePoints) -> String {
    let measured =
        if found.turned { "" } else { " (not measured: the drawing's axes are taken for the machine's)" };
    let mut lines = vec![
        format!("rotation     {}°{measured}", found.rotation_deg),
        format!("origin       {} machine coordinates", mm_pair(found.origin_mm)),
    ];
    let points = (1..=touches.points.len()).map(|number| format!("point {number}"));
    let edges = (1..=touches.edges.len()).map(|number| format!("edge touch {number}"));
    let residuals = points.chain(edges).zip(&found.residuals_mm);
    lines.extend(residuals.map(|(touch, off)| format!("residual     {off:.4} mm at {touch}")));
    lines.push(format!(
        "uncertainty  the part can lie up to {:.4} mm off at {} of the drawing, for {} mm at each touch",
        found.uncertainty_mm,
        mm_pair(found.worst_at_mm),
        touches.probe_error_mm
    ));
    lines.push(
        "margin       no term of it: path and part shift together. It is what the part may be off in its stock, against \
         features made before, and against clamps that are drawn"
            .into(),
    );
    if found.poor {
        let gain = found.uncertainty_mm / touches.probe_error_mm;
        lines.push(format!(
            "note         that is {gain:.0} times the touch error: touch points farther apart, and edges square to each other"
        ));
    }
    lines.join("\n")
}

/// The arguments with the origin that their alignment gives for the plan.
pub fn placed(arguments: &RunArguments, plan: &CertifiedPlan) -> Result<RunArguments, CliError> {
    let mut placed = arguments.clone();
    if let Some(path) = &arguments.alignment {
        let alignment = AlignmentFile::load(path)?;
        placed.origin_mm = Some(alignment.origin_for(&plan.plan)?);
        let name = &plan.plan.provenance.name;
        if alignment.drawing != *name {
            eprintln!(
                "note: {} was found with {}, the plan is of {name}: part and clamps lie where it says only if both drawings have one origin",
                path.display(),
                text_file::shown(&alignment.drawing),
            );
        }
    }
    Ok(placed)
}
