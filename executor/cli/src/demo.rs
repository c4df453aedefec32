//! The command `demo`: a whole job on the simulated machine. A cover with an outline, two through holes and a pocket
//! is cut from solid stock, in one session.

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use keepout_executor::session::log::{Header, LogReader, LogWriter, rfc_3339};
use keepout_executor::session::{Going, html, picture_of_run, section_of_run};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::depth::{DepthParameters, FaceChoice, FaceDepth};
use keepout_planner::file::OUTPUT;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanParameters;
use keepout_planner::plan_file;
use keepout_planner::report::{RunDrawing, svg};
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimResult, SimRun, run_scene};

use super::CliError;
use super::plan::{LIMIT_S, make, write};
use super::run::exit_code;
use super::shell::print_lines;
use super::values::seconds;

/// The drawing of the demonstration.
pub const COVER: &[u8] = include_bytes!("../drawings/cover.dxf");

/// The cover is 5 mm thick, its pocket 2 mm deep, and a pass takes at most 2 mm: three depths.
fn request() -> PlanRequest {
    let pocket = FaceDepth { of: FaceChoice::Layer("POCKET".into()), depth_mm: Some(2.0) };
    let depth = DepthParameters { faces: vec![pocket], step_down_mm: Some(2.0), ..DepthParameters::of(5.0) };
    let job = PlanParameters { depth: Some(depth), ..PlanParameters::default() };
    PlanRequest { job, ..PlanRequest::default() }
}

pub fn demo(output: &Path, jog_s: f64) -> Result<ExitCode, CliError> {
    let jog_s = seconds("--jog-s", jog_s)?.as_secs_f64();
    std::fs::create_dir_all(output).map_err(OUTPUT.write_error(output))?;
    let machine = MachineProfile::simulated_three_axes();
    println!("1. Plan: a cover of 5 mm with two holes and a pocket, at three depths, 6 mm cutter.\n");
    let plan = make(Path::new("cover.dxf"), COVER, &request(), &machine, LIMIT_S)?;
    print_lines(&plan.summary());
    remove_of_demo(&output.join("session.log"), &plan.plan.provenance.name)?;
    plan_file::save(&plan.plan, &output.join("cover.plan"))?;
    write(&output.join("plan.svg"), svg(&plan, "cover.dxf", &RunDrawing::default()).as_bytes())?;
    println!(
        "\n2. Run on the simulated machine, at 9600 baud with 150 ms of added delay each way. The operator pushes at \
         the walls\n   and plunges at the part for {jog_s:.0} s, at up to {:.0} mm/s. Then the operator touches the \
         part, and the program cuts every\n   contour, depth by depth, from solid stock.\n",
        machine.max_rate_mm_s
    );
    let run = SimRun { baud: 9600, latency: Duration::from_millis(150), machine, ..SimRun::default() };
    let result = session(PreparedPlan::new(plan), &run, output, jog_s)?;
    report(&result, output)
}

/// Plays the session, with its log.
fn session(work: PreparedPlan, run: &SimRun, output: &Path, jog_s: f64) -> Result<SimResult, CliError> {
    let scene = Scene::of(work, run)?;
    let header = Header {
        began: rfc_3339(SystemTime::now()),
        simulated: true,
        operator: "wall".into(),
        setting: run.machine.name.clone(),
        ..scene.setup.header()?
    };
    let log = Box::new(LogWriter::create(&output.join("session.log"), &header)?);
    let operator = operator::named("wall", jog_s, run.seed)?;
    Ok(run_scene(run, scene, operator, log, &mut |_, _, _| Going::On)?)
}

fn report(result: &SimResult, output: &Path) -> Result<ExitCode, CliError> {
    let SimResult { facts, samples, work, .. } = result;
    let plan = &work.plan;
    let rows = facts.rows(plan, samples);
    for (name, value) in &rows {
        println!("{name:<36} {value}");
    }
    let title = format!("{}, as run", plan.plan.provenance.name);
    let picture = picture_of_run(plan, &title, samples, &facts.progress);
    let section = section_of_run(plan, &title, samples);
    let page = html(plan, facts, rows, &picture, section.as_deref());
    let mut files = vec![("picture", "run.svg", picture), ("report", "report.html", page)];
    files.extend(section.map(|section| ("section", "section.svg", section)));
    for (name, file, text) in files {
        let path = output.join(file);
        write(&path, text.as_bytes())?;
        println!("{name:<36} {}", path.display());
    }
    Ok(exit_code(facts))
}

/// Removes the log of an earlier demo. Refuses to remove any other log, because a run may need it to resume.
fn remove_of_demo(log: &Path, drawing: &str) -> Result<(), CliError> {
    if !log.exists() {
        return Ok(());
    }
    let of_demo = LogReader::open(log)
        .is_ok_and(|reader| reader.header().simulated && reader.header().drawing == drawing);
    if !of_demo {
        return Err(CliError::Argument(format!(
            "{} is not the log of a demo, so it is not overwritten. Choose another folder with --output.",
            log.display()
        )));
    }
    Ok(std::fs::remove_file(log).map_err(OUTPUT.write_error(log))?)
}
