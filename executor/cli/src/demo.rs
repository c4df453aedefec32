//! The command `demo`: an end-to-end job on the simulated machine. The outline is cut from outside. For each opening
//! the simulated machinist raises the tool, and lowers it inside.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use keepout_executor::session::log::{Header, LogReader, LogWriter, rfc_3339};
use keepout_executor::session::{Going, RunFacts, Sample, html, picture_of_run};
use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::Point;
use keepout_planner::file::OUTPUT;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::plan_file;
use keepout_planner::report::{RunDrawing, svg};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::point_from_mm;
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimRun, run_scene};

use super::CliError;
use super::plan::{LIMIT_S, make, write};
use super::run::exit_code;
use super::shell::print_lines;
use super::values::seconds;

/// The drawing of the demonstration.
const BRACKET: &[u8] = include_bytes!("../drawings/bracket.dxf");
/// Time that the operator jogs inside an opening, s.
const INSIDE_S: f64 = 3.0;

pub fn demo(output: &Path, jog_s: f64) -> Result<ExitCode, CliError> {
    let jog_s = seconds("--jog-s", jog_s)?.as_secs_f64();
    std::fs::create_dir_all(output).map_err(OUTPUT.write_error(output))?;
    let machine = MachineProfile::simulated();
    println!("1. Plan: a bracket with holes, arcs and an inside corner, 6 mm cutter.\n");
    let plan = make(Path::new("bracket.dxf"), BRACKET, &PlanRequest::default(), &machine, LIMIT_S)?;
    print_lines(&plan.summary());
    let openings = plan.contours().len();
    for number in 1..=openings {
        remove_of_demo(&log_path(output, number), &plan.plan.provenance.name)?;
    }
    plan_file::save(&plan.plan, &output.join("bracket.plan"))?;
    write(&output.join("plan.svg"), svg(&plan, "bracket.dxf", &RunDrawing::default()).as_bytes())?;
    println!(
        "\n2. Run on the simulated machine, at 9600 baud with 150 ms of added delay each way. The operator pushes at \
         the wall\n   for {jog_s:.0} s, at {:.0} mm/s. Then the operator touches the part, and the program cuts the \
         outline.\n   For each hole the operator raises the tool, lowers it inside, and touches the wall.\n",
        machine.max_rate_mm_s
    );
    let mut run = SimRun { baud: 9600, latency: Duration::from_millis(150), machine, ..SimRun::default() };
    let mut job = DemoJob { work: PreparedPlan::new(plan), output, facts: None, samples: Vec::new() };
    job.session(1, &run, jog_s)?;
    for number in 2..=openings {
        let Some(start) = job.next_start() else { break };
        run = SimRun { start: Some(start), progress: job.facts().progress.clone(), ..run };
        job.session(number, &run, INSIDE_S)?;
    }
    job.report()
}

fn log_path(output: &Path, number: usize) -> PathBuf {
    let name = if number == 1 { "session.log".into() } else { format!("session-{number}.log") };
    output.join(name)
}

/// The sessions of the demonstration.
struct DemoJob<'a> {
    work: PreparedPlan,
    output: &'a Path,
    facts: Option<RunFacts>,
    samples: Vec<Sample>,
}

impl DemoJob<'_> {
    fn facts(&self) -> &RunFacts {
        self.facts.as_ref().expect("the first session is over")
    }

    /// Plays a session, with its log.
    fn session(&mut self, number: usize, run: &SimRun, jog_s: f64) -> Result<(), CliError> {
        let scene = Scene::of(self.work.clone(), run)?;
        let header = Header {
            began: rfc_3339(SystemTime::now()),
            simulated: true,
            operator: "wall".into(),
            setting: run.machine.name.clone(),
            ..scene.setup.header()?
        };
        let log = Box::new(LogWriter::create(&log_path(self.output, number), &header)?);
        let operator = operator::named("wall", jog_s, run.seed)?;
        let result = run_scene(run, scene, operator, log, &mut |_, _, _| Going::On)?;
        println!("   session {number}: {}", result.facts.outcome);
        self.facts = Some(match self.facts.take() {
            Some(earlier) => result.facts.after(&earlier),
            None => result.facts,
        });
        self.samples.extend(result.samples);
        Ok(())
    }

    /// A clear place inside the first contour that is left.
    fn next_start(&self) -> Option<Point> {
        let (plan, progress) = (&self.work.plan, &self.facts().progress);
        let left = plan.contours().iter().filter(|contour| {
            !contour.loops.is_empty() && !contour.loops.iter().all(|each| progress.has_finished(*each))
        });
        let clear = |plan: &CertifiedPlan, at: Point| plan.part.free_point(at, plan.roughing).is_ok();
        left.filter_map(|contour| point_from_mm(contour.name.middle_mm).ok()).find(|&at| clear(plan, at))
    }

    fn report(&self) -> Result<ExitCode, CliError> {
        let (plan, facts) = (&self.work.plan, self.facts());
        println!();
        for (name, value) in facts.rows(plan) {
            println!("{name:<36} {value}");
        }
        let title = format!("{}, as run", plan.plan.provenance.name);
        let picture = picture_of_run(plan, &title, &self.samples, &facts.progress);
        let (drawn, page) = (self.output.join("run.svg"), self.output.join("report.html"));
        write(&drawn, picture.as_bytes())?;
        println!("{:<36} {}", "picture", drawn.display());
        write(&page, html(plan, facts, &picture).as_bytes())?;
        println!("{:<36} {}", "report", page.display());
        Ok(exit_code(facts))
    }
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
