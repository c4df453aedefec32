//! The job that is open on the panel: its drawing, its plan and its progress.

use std::path::{Path, PathBuf};

use clap::Parser as _;
use keepout_executor::supervisor::PreparedPlan;
use keepout_panel::bench::{JobStep, JobView, MapView, PlanView, SessionKind};
use keepout_planner::align::file::AlignmentFile;
use keepout_planner::align::{PROBE_ERROR_MM, PartEdges, ProbePoints, TOLERANCE_MM, align};
use keepout_planner::drawing::{Chained, Drawing, read_file};
use keepout_planner::file::OUTPUT;
use keepout_planner::inspect::{Inspection, inspect};
use keepout_planner::job::Progress;
use keepout_planner::plan::PlanError;
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::{PlanRequest, PlanRequestError};
use keepout_planner::{Mm2, Mm3, plan_file};

use super::desk::{nominal_origin, touch_view};
use super::views::{
    contours_of_drawing, contours_of_plan, figures, map_of_drawing, map_of_plan, pins, plan_view,
};
use crate::align::file_of;
use crate::arguments::{Arguments, CliCommand, DrawingArguments, PlanArguments};
use crate::error::CliError;
use crate::job::{JobFolder, keep_earlier};
use crate::plan::{draw, keep_other_plan, order_of, request_of};
use crate::resume::progress_of;
use crate::run_arguments::FEED_MM_MIN;
use crate::take::touched;
use crate::touch_places::{TakeMethod, TouchPlace, places};

/// The job.
pub struct OpenJob {
    pub folder: JobFolder,
    found: Inspection,
    drawing: (Drawing, Chained),
    /// The plan, once it is made.
    pub work: Option<PreparedPlan>,
    pub map: MapView,
    view: Option<PlanView>,
    pub progress: Progress,
    /// The places to touch, and those taken, machine coordinates, mm.
    pub touches: Vec<TouchPlace>,
    pub taken: Vec<Mm3>,
    step: JobStep,
}

impl OpenJob {
    /// Opens the job of a folder.
    pub fn open(folder: &Path) -> Result<Self, CliError> {
        let missing = || CliError::Argument(format!("{} is no job", folder.display()));
        let folder = JobFolder::at(folder)?.ok_or_else(missing)?;
        let (found, drawing) = look(&folder)?;
        let map = map_of_drawing(&found, &drawing.0, &drawing.1);
        let mut job = Self {
            folder,
            found,
            drawing,
            work: None,
            map,
            view: None,
            progress: Progress::default(),
            touches: Vec::new(),
            taken: Vec::new(),
            step: JobStep::Drawing,
        };
        if job.folder.plan().is_file() && job.plan().is_ok() {
            job.step = if job.folder.alignment().is_file() { JobStep::Rough } else { JobStep::Place };
            job.read_progress();
        }
        Ok(job)
    }

    /// Changes a setting of the job, and reads the drawing again.
    pub fn set(&mut self, key: &str, value: toml_edit::Value) -> Result<(), CliError> {
        let path = self.folder.path("job.toml");
        let text = std::fs::read_to_string(&path).map_err(OUTPUT.write_error(&path))?;
        let wrong = |error: toml_edit::TomlError| CliError::Argument(format!("{}: {error}", path.display()));
        let mut document: toml_edit::DocumentMut = text.parse().map_err(wrong)?;
        document[key] = toml_edit::value(value);
        OUTPUT.write(&path, document.to_string().as_bytes())?;
        let missing = || CliError::Argument(format!("{} is no job", path.display()));
        self.folder = JobFolder::at(&self.folder.folder)?.ok_or_else(missing)?;
        (self.found, self.drawing) = look(&self.folder)?;
        self.map = map_of_drawing(&self.found, &self.drawing.0, &self.drawing.1);
        (self.work, self.step) = (None, self.step.min(JobStep::Tool));
        Ok(())
    }

    fn plan_arguments(&self) -> Result<PlanArguments, CliError> {
        let folder = self.folder.folder.to_string_lossy().into_owned();
        match Arguments::try_parse_from(["keepout", "plan", &folder]) {
            Ok(Arguments { command: CliCommand::Plan(given) }) => self.folder.plan_arguments(&given),
            _ => Err(CliError::Argument(format!("{folder} cannot be planned from the panel"))),
        }
    }

    /// Makes the plan, and saves it with its pictures.
    pub fn plan(&mut self) -> Result<(), CliError> {
        let arguments = self.plan_arguments()?;
        let (request, machine) = order_of(&arguments, self.folder.tool_mm()?)?;
        let path = self.folder.drawing();
        let bytes = read_file(&path).map_err(CliError::Drawing)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let wrong = |source| CliError::PlanRequest { path: path.clone(), source };
        let certified = request.plan(&name, &bytes, &machine, &mut |_| {}).map_err(wrong)?;
        let output = self.folder.plan();
        keep_other_plan(&certified, &output)?;
        plan_file::save(&certified.plan, &output)?;
        draw(&certified, &self.folder.path("plan.svg"))?;
        self.map = map_of_plan(&certified);
        self.view = Some(plan_view(&certified, self.folder.file.feed_mm_min.unwrap_or(FEED_MM_MIN)));
        self.work = Some(PreparedPlan::new(certified));
        self.progress = Progress::default();
        self.step = self.step.max(JobStep::Tool);
        Ok(())
    }

    /// Prepares to touch off.
    pub fn begin_touching(&mut self) -> Result<(), CliError> {
        let profile = &self.drawing.1.profile;
        self.touches = places(TakeMethod::Edges, profile, self.side())?;
        if self.is_deep()? {
            self.touches.extend(places(TakeMethod::Top, profile, self.side())?);
        }
        self.taken.clear();
        Ok(())
    }

    fn side(&self) -> MachinedSide {
        self.folder.file.side.map_or(MachinedSide::Outside, Into::into)
    }

    /// Whether the job has depths.
    fn is_deep(&self) -> Result<bool, CliError> {
        Ok(self.folder.file.depth.parameters()?.is_some())
    }

    /// Finds how the part lies from the places that were taken, and plans again if it lies turned.
    /// Returns what was found, in words.
    pub fn align(&mut self) -> Result<String, CliError> {
        if self.taken.len() < self.touches.len() || self.touches.is_empty() {
            return Err(CliError::Argument(
                "ended before every place was taken: nothing was changed. Begin again.".into(),
            ));
        }
        let edges = self.touches.iter().filter(|place| place.drawing_mm.is_some()).count();
        let found = touched(TakeMethod::Edges, &self.touches[..edges], &self.taken[..edges])?;
        let path = self.folder.drawing();
        let wrong = |source: PlanRequestError| CliError::PlanRequest { path: path.clone(), source };
        let part = PartEdges::of(&self.drawing.1.profile, self.side());
        let part = part.map_err(|error| wrong(PlanError::from(error).into()))?;
        let probes = ProbePoints {
            points: found.points,
            edges: found.edges,
            probe_diameter_mm: self.folder.tool_mm()?,
            probe_error_mm: PROBE_ERROR_MM,
            tolerance_mm: TOLERANCE_MM,
        };
        let alignment = align(&part, &probes)?;
        let top_mm = self.taken.get(edges).map(|at| at.z);
        let Mm2 { x, y } = alignment.origin_mm;
        let found = format!(
            "The place of the part is known: turned by {:.3}°, its origin at ({x:.3}, {y:.3}) mm. It may sit off by \
             {:.3} mm.",
            alignment.rotation_deg, alignment.uncertainty_mm
        );
        let file = AlignmentFile { top_mm, ..file_of(&alignment, &probes, &self.folder.file.drawing) };
        let output = self.folder.alignment();
        keep_earlier(&output)?;
        file.checked()?.save(&output)?;
        self.plan()?;
        self.step = JobStep::Rough;
        Ok(found)
    }

    /// A session has ended.
    pub fn ended(&mut self, kind: SessionKind) {
        if kind == SessionKind::Cut {
            self.read_progress();
            // A session that cut nothing leads back to where it began.
            let cut = self.progress != Progress::default();
            self.step = if cut { JobStep::Report } else { JobStep::Rough };
        }
    }

    /// Reads the progress of the last part.
    fn read_progress(&mut self) {
        let progress = self.folder.last_log().ok().zip(self.work.as_ref());
        let progress = progress.and_then(|(log, work)| Some(progress_of(&log, work, &[]).ok()?.0));
        self.progress = progress.unwrap_or_default();
    }

    /// The log of a run that left contours. The next run continues it.
    pub fn interrupted(&self) -> Option<PathBuf> {
        let work = self.work.as_ref()?;
        let begun = !self.progress.finished.is_empty() || !self.progress.partial.is_empty();
        let left = self.progress.finished.len() < work.plan.plan.loop_count();
        if begun && left { self.folder.last_log().ok() } else { None }
    }

    /// Begins another part with the same plan.
    pub fn next_part(&mut self) {
        self.progress = Progress::default();
        self.step = JobStep::Place;
    }

    /// Shows the job.
    pub fn show(&self, view: &mut JobView) {
        view.name = self.folder.folder.file_name().map(|name| name.to_string_lossy().into_owned());
        view.step = self.step;
        let size = self.found.box_mm.map(|shown| shown.size());
        view.size_mm = size.map(|size| [size.x, size.y]);
        view.pins = pins(&self.found);
        view.machine.clone_from(&self.folder.file.machine);
        view.inside = self.side() == MachinedSide::Inside;
        view.tool_mm = self.folder.tool_mm().ok();
        view.touches = (self.touches.iter().map(touch_view).collect(), self.taken.len());
        view.aligned = self.folder.alignment().is_file();
        view.reported = self.folder.path("report.html").is_file();
        match &self.work {
            Some(work) => {
                view.contours = contours_of_plan(work, &self.progress);
                view.figures = figures(&work.plan);
                view.plan.clone_from(&self.view);
                let touching = view.running == Some(SessionKind::Touch);
                view.shift_mm =
                    nominal_origin(work).filter(|_| touching).map_or([0.0; 2], |origin| [origin.x, origin.y]);
            }
            None => view.contours = contours_of_drawing(&self.found),
        }
    }
}

/// Reads the drawing of a job.
fn look(folder: &JobFolder) -> Result<(Inspection, (Drawing, Chained)), CliError> {
    let path = folder.drawing();
    let given: DrawingArguments =
        match Arguments::try_parse_from(["keepout", "inspect", &path.to_string_lossy()]) {
            Ok(Arguments { command: CliCommand::Inspect(given) }) => given.drawing,
            _ => return Err(CliError::Argument(format!("{} cannot be read from the panel", path.display()))),
        };
    let request: PlanRequest = request_of(&folder.drawing_arguments(&given))?;
    let bytes = read_file(&path).map_err(CliError::Drawing)?;
    let wrong = |source: PlanRequestError| CliError::PlanRequest { path: path.clone(), source };
    let (drawing, chained) = request.contours(&bytes).map_err(|error| wrong(error.into()))?;
    let found = inspect(&drawing, &chained, &request.choice);
    Ok((found, (drawing, chained)))
}
