//! `plan`, `show` and `verify`.

use std::path::Path;
use std::process::ExitCode;

use keepout_planner::drawing::{chain, import};
use keepout_planner::machine::MachineProfile;
use keepout_planner::picture::svg;
use keepout_planner::plan::{CertifiedPlan, Job, Plan};
use keepout_planner::plan_file;

use super::{CliError, PlanArguments, ShowArguments};

/// What makes a plan of a drawing.
pub struct Source<'a> {
    /// Name of the drawing, for people.
    pub name: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
    /// Layers to take; all when empty.
    pub layers: &'a [String],
    /// Unit that overrides the file's.
    pub units: Option<&'a str>,
    /// Gaps to close, mm.
    pub join_mm: f64,
}

pub fn plan(arguments: &PlanArguments) -> Result<ExitCode, CliError> {
    let path = &arguments.drawing;
    let wrong = |source| CliError::Drawing { path: path.clone(), source };
    let machine = match &arguments.machine_profile {
        Some(path) => MachineProfile::load(path)?,
        None => MachineProfile::simulated(),
    };
    refuse_same(path, &arguments.output)?;
    if !(0.0..=1000.0).contains(&arguments.allowance_mm) {
        let reason = format!("--allowance-mm {} must be between 0 and 1000", arguments.allowance_mm);
        return Err(CliError::Argument(reason));
    }
    if !(0.0..=100.0).contains(&arguments.join_mm) {
        return Err(CliError::Argument(format!("--join-mm {} must be between 0 and 100", arguments.join_mm)));
    }
    let bytes = keepout_planner::drawing::read_file(path).map_err(wrong)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let source = Source {
        name: &name,
        bytes: &bytes,
        layers: &arguments.layer,
        units: arguments.units.as_deref(),
        join_mm: arguments.join_mm,
    };
    let job = Job {
        tool_diameter_mm: arguments.tool_diameter,
        allowance_mm: arguments.allowance_mm,
        side: arguments.side.into(),
        margin_mm: arguments.margin_mm,
    };
    let certified = make(path, &source, &job, &machine)?;
    plan_file::save(&certified.plan, &arguments.output)?;
    println!("{}", certified.summary());
    println!("written      {}", arguments.output.display());
    Ok(ExitCode::SUCCESS)
}

/// Drawing bytes to certified plan.
pub fn make(
    path: &Path,
    source: &Source<'_>,
    job: &Job,
    machine: &MachineProfile,
) -> Result<CertifiedPlan, CliError> {
    let wrong = |error| CliError::Drawing { path: path.to_path_buf(), source: error };
    let drawing = import(source.bytes, source.layers, source.units).map_err(wrong)?;
    let chained = chain(&drawing.curves, source.join_mm).map_err(wrong)?;
    let mut remarks: Vec<String> = chained.repairs.iter().map(ToString::to_string).collect();
    remarks.extend(drawing.left_out.iter().map(|(why, count)| format!("left out: {count} {why}")));
    let hash = plan_file::hash(source.bytes);
    Plan::make(source.name, hash, (drawing.unit, remarks), chained, job, machine).map_err(CliError::Plan)
}

/// Reads a plan file and certifies it.
pub fn load(path: &Path) -> Result<CertifiedPlan, CliError> {
    let plan = plan_file::load(path)?;
    plan.certify().map_err(|source| CliError::NotCertified { path: path.to_path_buf(), source })
}

pub fn show(arguments: &ShowArguments) -> Result<ExitCode, CliError> {
    refuse_same(&arguments.plan, &arguments.output)?;
    let certified = load(&arguments.plan)?;
    let picture = svg(&certified, &certified.plan.drawing, &[]);
    write(&arguments.output, picture.as_bytes())?;
    println!("written      {}", arguments.output.display());
    Ok(ExitCode::SUCCESS)
}

pub fn verify(path: &Path) -> Result<ExitCode, CliError> {
    let certified = load(path)?;
    println!("{}", certified.summary());
    println!("drawing hash {}", plan_file::hex(&certified.plan.drawing_hash));
    println!(
        "proved       contours closed, simple and apart ({} edges); every motion of the finishing path farther than \
         {:.5} mm from every edge, decided in integers",
        certified.part.edges().len(),
        keepout_planner::units::mm(certified.finishing.units())
    );
    Ok(ExitCode::SUCCESS)
}

/// Refuses an output that is the input.
pub fn refuse_same(input: &Path, output: &Path) -> Result<(), CliError> {
    let same = std::fs::canonicalize(input)
        .ok()
        .zip(std::fs::canonicalize(output).ok())
        .is_some_and(|(a, b)| a == b);
    if same {
        let reason =
            format!("{} is what is read: it is not overwritten. Choose another output.", output.display());
        return Err(CliError::Argument(reason));
    }
    Ok(())
}

/// Writes a file whole or not at all.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    plan_file::write_whole(path, bytes).map_err(|source| CliError::Write { path: path.to_path_buf(), source })
}
