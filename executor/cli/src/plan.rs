//! The commands `inspect`, `plan`, `show` and `verify`.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use keepout_planner::Mm2;
use keepout_planner::align::file::AlignmentFile;
use keepout_planner::file::OUTPUT;
use keepout_planner::inspect::inspect as look_at;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, Cut, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::report::{RunDrawing, inspection_svg, section_svg, svg};
use keepout_planner::request::{PlanRequest, PlanRequestError, Stage};
use keepout_planner::select::Selection;
use keepout_planner::{plan_file, sha256};

use super::job::{JobFolder, keep_earlier};
pub use super::outputs::{given, refuse_same};
use super::shell::print_lines;
use super::store::{SIMULATED, StoredMachine};
use super::{CertifyTime, CliError, DrawingArguments, InspectArguments, PlanArguments, ShowArguments};

/// Default time limit for a drawing or a plan, s.
pub const LIMIT_S: f64 = 900.0;
/// Remedy when a drawing takes longer.
const DRAWING_REMEDY: &str = "the drawing is too large or too tangled. Choose layers with --layer, export \
                              only the profile, or give more time with --limit-s.";
/// Remedy when the proof of a plan takes longer.
const PLAN_REMEDY: &str = "the plan is large. Give more time with --certify-limit-s.";

/// A progress bar over the stages of planning, and a limit on their time. The bar is hidden without a
/// terminal.
struct Progress {
    bar: ProgressBar,
    stage: Arc<Mutex<Option<Stage>>>,
    done: Arc<AtomicBool>,
}

impl Progress {
    /// Starts the bar and the time limit. After `limit_s` seconds the program prints the remedy and ends. It
    /// has not written a file then.
    fn new(limit_s: f64, remedy: &'static str) -> Self {
        let hidden = !std::io::stderr().is_terminal();
        let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(Stage::COUNT) };
        if let Ok(style) = ProgressStyle::with_template("[{bar:20}] {pos}/{len} {elapsed} {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        let (stage, done) = (Arc::new(Mutex::new(None)), Arc::new(AtomicBool::new(false)));
        watch(limit_s, remedy, Arc::clone(&stage), Arc::clone(&done));
        Self { bar, stage, done }
    }

    fn show(&self, stage: Stage) {
        self.bar.set_position(stage.number());
        self.bar.set_message(stage.to_string());
        if let Ok(mut shown) = self.stage.lock() {
            *shown = Some(stage);
        }
    }
}

/// Ends the program after the time limit, unless `done` is set. Files are written only after `done`.
fn watch(limit_s: f64, remedy: &'static str, stage: Arc<Mutex<Option<Stage>>>, done: Arc<AtomicBool>) {
    let limit = Duration::try_from_secs_f64(limit_s).unwrap_or(Duration::MAX);
    std::thread::spawn(move || {
        std::thread::sleep(limit);
        if !done.load(Ordering::SeqCst) {
            let doing = stage
                .lock()
                .ok()
                .and_then(|stage| *stage)
                .map_or(String::new(), |stage| format!(", {stage}"));
            eprintln!("keepout: not done after {limit_s} s{doing}: {remedy} Nothing was written.");
            std::process::exit(4);
        }
    });
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.done.store(true, Ordering::SeqCst);
        self.bar.finish_and_clear();
    }
}

/// The plan request of the drawing's arguments, without the parameters of the plan.
pub fn request_of(arguments: &DrawingArguments) -> Result<PlanRequest, CliError> {
    let join_mm = arguments.join_mm.unwrap_or(keepout_planner::drawing::JOIN_MM);
    if !(0.0..=100.0).contains(&join_mm) {
        return Err(CliError::Argument(format!("--join-mm {join_mm} must be between 0 and 100")));
    }
    let mut request = PlanRequest { join_mm, curve_mm: arguments.curve_mm, ..PlanRequest::default() };
    let choice = &mut request.choice;
    choice.layers.clone_from(&arguments.layer);
    choice.without.clone_from(&arguments.without_layer);
    choice.unit.clone_from(&arguments.units);
    choice.line_types.clone_from(&arguments.line_type);
    choice.without_line_types.clone_from(&arguments.without_line_type);
    choice.scale = arguments.scale;
    choice.hatches = arguments.with.contains(&super::Extra::Hatch);
    choice.solids = arguments.with.contains(&super::Extra::Solid);
    choice.placed = match (arguments.rotate_deg, arguments.offset_mm) {
        (None, None) => None,
        (degrees, offset) => Some((degrees.unwrap_or(0.0), offset.unwrap_or(Mm2::ZERO))),
    };
    if choice.placed.is_some_and(|(degrees, _)| !(-360.0..=360.0).contains(&degrees)) {
        return Err(CliError::Argument("--rotate-deg must be between -360 and 360".into()));
    }
    Ok(request)
}

pub fn inspect(given: &InspectArguments) -> Result<ExitCode, CliError> {
    let mut arguments = given.clone();
    if let Some(job) = JobFolder::at(&given.drawing.drawing)? {
        arguments.drawing = job.drawing_arguments(&given.drawing);
        arguments.output.get_or_insert_with(|| job.path("drawing.svg"));
    }
    let arguments = &arguments;
    let path = &arguments.drawing.drawing;
    let wrong = |source: PlanRequestError| CliError::PlanRequest { path: path.clone(), source };
    let request = request_of(&arguments.drawing)?;
    if let Some(output) = &arguments.output {
        refuse_same(&[path], &[output])?;
        check_ending(output, "svg")?;
    }
    let bytes = keepout_planner::drawing::read_file(path).map_err(CliError::Drawing)?;
    let progress = Progress::new(arguments.drawing.limit_s, DRAWING_REMEDY);
    progress.show(Stage::Reading);
    let (drawing, chained) = request.contours(&bytes).map_err(|error| wrong(error.into()))?;
    progress.show(Stage::Checking);
    let found = look_at(&drawing, &chained, &request.choice);
    drop(progress);
    if let Some(output) = &arguments.output {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        write(output, inspection_svg(&found, &drawing, &chained, &name).as_bytes())?;
    }
    if arguments.json {
        let json = serde_json::to_string_pretty(&found);
        println!("{}", json.map_err(|error| CliError::Argument(format!("cannot make JSON: {error}")))?);
    } else {
        print_lines(&found.to_string());
        if let Some(output) = &arguments.output {
            println!("written      {}", output.display());
        }
    }
    Ok(if found.problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(3) })
}

pub fn plan(given_arguments: &PlanArguments) -> Result<ExitCode, CliError> {
    let job = JobFolder::at(&given_arguments.drawing.drawing)?;
    let arguments = &match &job {
        Some(job) => job.plan_arguments(given_arguments)?,
        None => given_arguments.clone(),
    };
    let path = &arguments.drawing.drawing;
    let missing = |what: &str| CliError::Argument(format!("give {what}, or the folder of a job"));
    let output = arguments.output.as_ref().ok_or_else(|| missing("the output file with -o"))?;
    let tool_diameter_mm = arguments.tool_diameter.ok_or_else(|| missing("--tool-diameter"))?;
    refuse_same(
        &given(&[Some(path), arguments.machine_profile.as_ref(), arguments.alignment.as_ref()]),
        &[output],
    )?;
    let (request, machine) = order_of(arguments, tool_diameter_mm)?;
    let bytes = keepout_planner::drawing::read_file(path).map_err(CliError::Drawing)?;
    let certified = make(path, &bytes, &request, &machine, arguments.drawing.limit_s)?;
    let replaced = match &job {
        Some(_) => keep_other_plan(&certified, output).map(|()| false)?,
        None => refuse_to_replace(&certified, output, arguments.overwrite)?,
    };
    plan_file::save(&certified.plan, output)?;
    print_lines(&certified.summary());
    if let Some(question) = travel_question(&certified, &machine) {
        print_lines(&question);
    }
    if replaced {
        println!("replaced     the earlier plan. Logs of that plan cannot be replayed or resumed any more.");
    }
    println!("written      {}", output.display());
    if let Some(job) = &job {
        draw(&certified, &job.path("plan.svg"))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Keeps another plan of a job under another name, because its logs need it.
pub fn keep_other_plan(plan: &CertifiedPlan, path: &Path) -> Result<(), CliError> {
    if is_in(plan, path) { Ok(()) } else { keep_earlier(path) }
}

/// Draws a plan, and its section if it has depths.
pub fn draw(plan: &CertifiedPlan, picture: &Path) -> Result<(), CliError> {
    let name = &plan.plan.provenance.name;
    write(picture, svg(plan, name, &RunDrawing::default()).as_bytes())?;
    println!("written      {}", picture.display());
    write_section(picture, section_svg(plan, name, &[]))
}

/// The plan request and the machine of the arguments.
pub fn order_of(
    arguments: &PlanArguments,
    tool_diameter_mm: f64,
) -> Result<(PlanRequest, MachineProfile), CliError> {
    let machine = match (&arguments.machine_profile, &arguments.machine) {
        (Some(path), _) => MachineProfile::load(path)?,
        (None, Some(name)) if name == SIMULATED && arguments.depth.thickness_mm.is_some() => {
            MachineProfile::simulated_three_axes()
        }
        (None, Some(name)) => StoredMachine::named(name)?.profile,
        (None, None) if arguments.depth.thickness_mm.is_some() => MachineProfile::simulated_three_axes(),
        (None, None) => MachineProfile::simulated(),
    };
    let stock_to_leave_mm = arguments.stock_to_leave_mm.unwrap_or(0.2);
    if !(0.0..=1000.0).contains(&stock_to_leave_mm) {
        let reason = format!("--stock-to-leave-mm {stock_to_leave_mm} must be between 0 and 1000");
        return Err(CliError::Argument(reason));
    }
    let mut request = request_of(&arguments.drawing)?;
    if let Some(alignment) = &arguments.alignment {
        request.choice.placed = AlignmentFile::load(alignment)?.placed();
    }
    apply_choices(&mut request, arguments, (tool_diameter_mm, stock_to_leave_mm));
    request.job.depth = arguments.depth.parameters()?;
    Ok((request, machine))
}

/// Puts the choices of the command line into the request: contours, layers, and the cut.
fn apply_choices(
    request: &mut PlanRequest,
    arguments: &PlanArguments,
    (tool_diameter_mm, stock_to_leave_mm): (f64, f64),
) {
    request.selection = Selection {
        at: arguments.at.clone(),
        least_area_mm2: arguments.min_area_mm2,
        most_area_mm2: arguments.max_area_mm2,
        leave_out_open: arguments.leave_out_open,
        stroke: arguments.stroke.map(Into::into),
    };
    request.keep_out_layers.clone_from(&arguments.keep_out_layer);
    request.travel_layer.clone_from(&arguments.travel_layer);
    request.job = PlanParameters {
        tool_diameter_mm,
        stock_to_leave_mm,
        side: arguments.side.map_or(MachinedSide::Outside, Into::into),
        margin_mm: arguments.margin_mm,
        passes: arguments.pass.clone(),
        cut: arguments.cut.map_or(Cut::default(), Into::into),
        depth: None,
    };
}

/// Whether the file holds this plan.
fn is_in(plan: &CertifiedPlan, path: &Path) -> bool {
    let encoded = plan_file::encode(&plan.plan);
    std::fs::read(path).is_ok_and(|earlier| encoded.is_ok_and(|bytes| bytes == earlier))
}

/// Refuses to replace a plan file with another plan, because logs of the earlier plan need it. Returns whether one is
/// replaced.
fn refuse_to_replace(plan: &CertifiedPlan, path: &Path, overwrite: bool) -> Result<bool, CliError> {
    if !path.exists() || is_in(plan, path) {
        return Ok(false);
    }
    if overwrite {
        return Ok(true);
    }
    Err(CliError::Argument(format!(
        "{} exists and holds another plan. Logs of that plan need it to be replayed or resumed. Choose another \
         name, or give --overwrite.",
        path.display()
    )))
}

/// A warning about a part that is larger than the machine's travel.
fn travel_question(plan: &CertifiedPlan, machine: &MachineProfile) -> Option<String> {
    let size = plan.profile_size_mm();
    let [width, height] = machine.travel_mm;
    let turned_fits = size.x <= height && size.y <= width;
    (size.x > width || size.y > height).then(|| {
        format!(
            "WARNING      the part is {} mm, and {} has {width} × {height} mm of travel. {}",
            keepout_planner::size::size(size),
            machine.name,
            if turned_fits {
                "Turn it: --rotate-deg 90."
            } else {
                "Is the unit right? --units and --scale change it."
            }
        )
    })
}

/// Checks the ending of an output's name: the program writes no other form.
pub fn check_ending(path: &Path, ending: &str) -> Result<(), CliError> {
    if path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending)) {
        return Ok(());
    }
    Err(CliError::Argument(format!(
        "{} would hold {}: give it a name that ends in .{ending}",
        path.display(),
        ending.to_uppercase()
    )))
}

/// Makes a certified plan from the bytes of a drawing.
pub fn make(
    path: &Path,
    bytes: &[u8],
    request: &PlanRequest,
    machine: &MachineProfile,
    limit_s: f64,
) -> Result<CertifiedPlan, CliError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let progress = Progress::new(limit_s, DRAWING_REMEDY);
    request
        .plan(&name, bytes, machine, &mut |stage| progress.show(stage))
        .map_err(|source| CliError::PlanRequest { path: path.to_path_buf(), source })
}

/// Reads a plan file and certifies it.
pub fn load(path: &Path, time: CertifyTime) -> Result<CertifiedPlan, CliError> {
    let plan = plan_file::load(path)?;
    let progress = Progress::new(time.certify_limit_s, PLAN_REMEDY);
    progress.show(Stage::Certifying);
    plan.certify().map_err(|source| CliError::NotCertified { path: path.to_path_buf(), source })
}

/// The plan file at a path, or of the job there.
pub fn plan_path(path: &Path) -> Result<PathBuf, CliError> {
    Ok(JobFolder::at(path)?.map_or_else(|| path.to_path_buf(), |job| job.plan()))
}

pub fn show(arguments: &ShowArguments) -> Result<ExitCode, CliError> {
    let own = JobFolder::at(&arguments.plan)?.map(|job| job.path("plan.svg"));
    let output =
        arguments.output.clone().or(own).ok_or_else(|| {
            CliError::Argument("give the output file with -o, or the folder of a job".into())
        })?;
    let plan = plan_path(&arguments.plan)?;
    check_ending(&output, "svg")?;
    refuse_same(&[&plan], &[&output])?;
    let certified = load(&plan, arguments.time)?;
    draw(&certified, &output)?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the section view of a plan with depths beside its picture, as `NAME-section.svg`.
pub fn write_section(picture: &Path, section: Option<String>) -> Result<(), CliError> {
    let Some(section) = section else { return Ok(()) };
    let name = picture.file_stem().unwrap_or_default().to_string_lossy();
    let path = picture.with_file_name(format!("{name}-section.svg"));
    write(&path, section.as_bytes())?;
    println!("{:<36} {}", "section", path.display());
    Ok(())
}

pub fn verify(path: &Path, time: CertifyTime) -> Result<ExitCode, CliError> {
    let certified = load(&plan_path(path)?, time)?;
    print_lines(&certified.summary());
    println!("drawing hash {}", sha256::hex(&certified.plan.provenance.hash));
    println!("{}", certified.proved());
    Ok(ExitCode::SUCCESS)
}

/// Writes a whole file. On an error, an existing file does not change.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    Ok(OUTPUT.write(path, bytes)?)
}
