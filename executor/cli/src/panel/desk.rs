//! The workbench of the panel: one job at a time, step by step.
//!
//! Implements SR-28.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use keepout_executor::session::place_on_table;
use keepout_executor::session::serial::port_names;
use keepout_executor::supervisor::PreparedPlan;
use keepout_panel::bench::{
    BenchRequest, Document, DocumentName, JobStep, JobView, MapView, SessionKind, SessionWords, TouchView,
    Workbench,
};
use keepout_panel::hub::Hub;
use keepout_planner::job::Progress;
use keepout_planner::units::vector_mm;
use keepout_planner::{Mm2, Mm3};

use super::machines::{dialects, new_machine_of};
use super::open_job::OpenJob;
use super::sessions::{Running, SessionOrder, start};
use crate::error::CliError;
use crate::store::{SIMULATED, StoredMachine};
use crate::touch_places::TouchPlace;

/// Most jobs that the page lists.
const JOBS_MAX: usize = 100;

/// The workbench.
pub struct Desk {
    /// The meeting place with the browsers.
    pub hub: Hub,
    folder: PathBuf,
    /// The simulated machine of this program.
    simulated: StoredMachine,
    state: Mutex<DeskState>,
    news: Sender<DeskNews>,
    words: Mutex<SessionWords>,
    revision: AtomicU64,
    own: std::sync::Weak<Desk>,
}

/// News of the session. Its loop sends them, and never waits for the page's requests.
pub enum DeskNews {
    /// A message to the person.
    Told(String),
    /// A place was taken, machine coordinates, mm.
    Taken(Mm3),
    /// The plan of the session that begins.
    Prepared(Box<PreparedPlan>),
    /// What is cut so far.
    Progressed(Progress),
}

struct DeskState {
    job: Option<OpenJob>,
    running: Option<Running>,
    message: Option<String>,
    news: Receiver<DeskNews>,
}

impl DeskState {
    fn take(&mut self, news: DeskNews) {
        match (news, &mut self.job) {
            (DeskNews::Told(text), _) => self.message = Some(text),
            (DeskNews::Taken(at), Some(job)) => job.taken.push(at),
            (DeskNews::Prepared(work), Some(job)) => job.work = Some(*work),
            (DeskNews::Progressed(progress), Some(job)) => job.progress = progress,
            (_, None) => {}
        }
    }
}

impl Desk {
    /// The workbench over a folder of jobs.
    pub fn new(hub: Hub, folder: PathBuf, simulated: StoredMachine) -> Arc<Self> {
        let (sender, news) = channel();
        Arc::new_cyclic(|own| Self {
            hub,
            folder,
            simulated,
            state: Mutex::new(DeskState { job: None, running: None, message: None, news }),
            news: sender,
            words: Mutex::default(),
            revision: AtomicU64::new(1),
            own: own.clone(),
        })
    }

    /// The state, after all news of the session.
    fn state(&self) -> MutexGuard<'_, DeskState> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        while let Ok(news) = state.news.try_recv() {
            state.take(news);
        }
        state
    }

    fn changed(&self) {
        self.revision.fetch_add(1, Ordering::Relaxed);
    }

    /// Takes news of the session. It never waits.
    pub fn hear(&self, news: DeskNews) {
        let _ = self.news.send(news);
        self.changed();
    }

    /// Takes the words of the session, unless the page just reads them. Returns whether they were taken.
    pub fn say(&self, words: SessionWords) -> bool {
        match self.words.try_lock() {
            Ok(mut slot) => *slot = words,
            Err(TryLockError::Poisoned(broken)) => *broken.into_inner() = words,
            Err(TryLockError::WouldBlock) => return false,
        }
        true
    }

    /// A session has ended: with an outcome, or with what went wrong.
    pub fn session_ended(&self, kind: SessionKind, told: Result<Option<String>, String>) {
        let mut state = self.state();
        state.running = None;
        let message = match (told, kind, &mut state.job) {
            (Ok(_), SessionKind::Touch, Some(job)) => {
                Some(job.align().unwrap_or_else(|error| error.to_string()))
            }
            (Ok(outcome), kind, Some(job)) => {
                job.ended(kind);
                outcome
            }
            (Err(reason), ..) => Some(reason),
            (Ok(outcome), ..) => outcome,
        };
        state.message = message;
        drop(state);
        self.changed();
    }

    /// The machine of a job. The simulated one is behind a port of this program.
    fn machine_of(&self, job: &OpenJob) -> Result<StoredMachine, CliError> {
        let machine = job.folder.machine()?;
        Ok(if machine.port.is_empty() { self.simulated.clone() } else { machine })
    }

    /// Ends the session that runs, and waits for it.
    pub fn shut_down(&self) {
        let running = self.state().running.take();
        if let Some(running) = running {
            running.halt.store(true, Ordering::Relaxed);
            let _ = running.thread.join();
        }
    }

    fn act(&self, request: BenchRequest) -> Result<(), CliError> {
        let mut state = self.state();
        state.message = None;
        match (request, &state.running) {
            (BenchRequest::End {}, running) => {
                running.iter().for_each(|running| running.halt.store(true, Ordering::Relaxed));
                Ok(())
            }
            (BenchRequest::Take {}, running) => {
                running.iter().for_each(|running| _ = running.takes.fetch_add(1, Ordering::Relaxed));
                Ok(())
            }
            (_, Some(_)) => Err(CliError::Argument("a session runs: end it first".into())),
            (BenchRequest::Open { name }, None) => {
                let folder = job_folder(&self.folder, &name)?;
                state.job = Some(OpenJob::open(&folder)?);
                Ok(())
            }
            (BenchRequest::Close {}, None) => {
                state.job = None;
                Ok(())
            }
            (BenchRequest::Begin { kind, home }, None) => self.begin(&mut state, kind, home),
            (request, None) => change(&mut state, request),
        }
    }

    /// Begins a session of the job.
    fn begin(&self, state: &mut DeskState, kind: SessionKind, home: bool) -> Result<(), CliError> {
        let job = state.job.as_mut().ok_or_else(no_job)?;
        let machine = self.machine_of(job)?;
        if kind == SessionKind::Touch {
            job.begin_touching()?;
        }
        let resume = job.interrupted().filter(|_| kind == SessionKind::Cut);
        let order = SessionOrder {
            kind,
            home,
            simulated: machine.port == self.simulated.port,
            job: job.folder.clone(),
            machine,
            resume,
            touches: job.touches.len(),
        };
        let own = self.own.upgrade().ok_or_else(no_job)?;
        let failed = |error| CliError::Argument(format!("the session cannot begin: {error}"));
        state.running = Some(start(&own, order).map_err(failed)?);
        Ok(())
    }
}

fn no_job() -> CliError {
    CliError::Argument("open a job first".into())
}

/// Changes a setting of the job.
fn change(state: &mut DeskState, request: BenchRequest) -> Result<(), CliError> {
    let job = state.job.as_mut().ok_or_else(no_job)?;
    match request {
        BenchRequest::Unit { unit } => job.set("units", unit.into()),
        BenchRequest::LeaveOutOpen {} => job.set("leave_out_open", true.into()),
        BenchRequest::Side { inside } => job.set("side", if inside { "inside" } else { "outside" }.into()),
        BenchRequest::Machine { name } => {
            StoredMachine::named(&name)?;
            job.set("machine", name.into())
        }
        BenchRequest::NewMachine { .. } => {
            let name = new_machine_of(request)?;
            job.set("machine", name.into())
        }
        BenchRequest::Plan { tool_um } => {
            job.set("tool", format!("{}", f64::from(tool_um) / 1000.0).into())?;
            job.plan()
        }
        BenchRequest::NextPart {} => {
            job.next_part();
            Ok(())
        }
        _ => Ok(()),
    }
}

/// The names of the jobs in a folder, in order.
fn jobs_of(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_job = |path: &PathBuf| path.join("job.toml").is_file();
    let names = entries.map(|entry| entry.path()).filter(is_job);
    let mut names: Vec<String> =
        names.filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names.truncate(JOBS_MAX);
    names
}

/// The folder of a job with this name. Only names of the folder count, so no path leads elsewhere.
fn job_folder(folder: &Path, name: &str) -> Result<PathBuf, CliError> {
    let known = jobs_of(folder).into_iter().find(|known| known == name);
    let unknown =
        || CliError::Argument(format!("there is no job \"{}\"", keepout_planner::text_file::shown(name)));
    known.map(|name| folder.join(name)).ok_or_else(unknown)
}

/// The name of a job for a drawing: letters and digits of the drawing's name.
fn job_name(drawing: &str) -> String {
    let stem = Path::new(drawing).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' };
    let name: String = stem.chars().map(plain).take(60).collect();
    if name.trim_matches('-').is_empty() { "drawing".into() } else { name }
}

impl Workbench for Desk {
    fn job(&self) -> JobView {
        // No file is read under the lock.
        let (jobs, machines) = (jobs_of(&self.folder), crate::store::machine_names());
        let state = self.state();
        let mut view = JobView {
            jobs,
            machines,
            ports: port_names(),
            dialects: dialects(),
            running: state.running.as_ref().map(|running| running.kind),
            message: state.message.clone(),
            ..JobView::default()
        };
        let Some(job) = &state.job else { return view };
        job.show(&mut view);
        view.step = match (&view.running, view.step) {
            (Some(SessionKind::Touch | SessionKind::DryRun), _) => JobStep::Place,
            (Some(SessionKind::Cut), _) => JobStep::Rough,
            (None, step) => step,
        };
        view
    }

    fn map(&self) -> MapView {
        self.state().job.as_ref().map(|job| job.map.clone()).unwrap_or_default()
    }

    fn revision(&self) -> u64 {
        self.revision.load(Ordering::Relaxed)
    }

    fn ask(&self, request: BenchRequest) -> Result<(), String> {
        let done = self.act(request).map_err(|error| error.to_string());
        self.changed();
        done
    }

    fn drawing(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        let made = || -> Result<(), CliError> {
            let mut state = self.state();
            if state.running.is_some() {
                return Err(CliError::Argument("a session runs: end it first".into()));
            }
            let stem = job_name(name);
            let free = (1..1000)
                .map(|number| if number == 1 { stem.clone() } else { format!("{stem}-{number}") })
                .find(|name| !self.folder.join(name).exists());
            let free =
                free.ok_or_else(|| CliError::Argument("too many jobs of this name: remove some".into()))?;
            let folder = self.folder.join(free);
            crate::job::make(&folder, &format!("{stem}.dxf"), bytes, SIMULATED)?;
            state.job = Some(OpenJob::open(&folder)?);
            state.message = None;
            Ok(())
        };
        let done = made().map_err(|error| error.to_string());
        self.changed();
        done
    }

    fn document(&self, name: DocumentName) -> Option<Document> {
        let folder = self.state().job.as_ref()?.folder.clone();
        let (file, media) = match name {
            DocumentName::Picture => ("plan.svg", "image/svg+xml"),
            DocumentName::Section => ("plan-section.svg", "image/svg+xml"),
            DocumentName::Report => ("report.html", "text/html; charset=utf-8"),
        };
        Some(Document { media, bytes: std::fs::read(folder.path(file)).ok()? })
    }

    fn words(&self) -> SessionWords {
        self.words.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// A place to touch, for the page.
pub fn touch_view(place: &TouchPlace) -> TouchView {
    TouchView { words: place.words.into(), at_mm: place.drawing_mm.map(|at| [at.x, at.y]) }
}

/// Where the drawing's origin probably lies, machine coordinates, mm: in the middle of the table.
pub fn nominal_origin(work: &PreparedPlan) -> Option<Mm2> {
    let place = place_on_table(&work.plan, &work.plan.plan.machine, None).ok()?;
    Some(vector_mm(place.offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-28.
    #[test]
    fn jobs_are_those_of_the_folder() {
        let root = std::env::temp_dir().join(format!("keepout-jobs-{}", std::process::id()));
        let folder = root.join("jobs");
        for job in [&root.join("outside"), &folder.join("cover")] {
            std::fs::create_dir_all(job).unwrap();
            std::fs::write(job.join("job.toml"), "").unwrap();
        }
        let outside = root.join("outside").display().to_string();
        let names = ["cover", "../outside", &outside, "cover/../../outside", "cover/", ".", "", "none"];
        let found = names.map(|name| job_folder(&folder, name).ok());
        std::fs::remove_dir_all(&root).unwrap();
        let mut wanted = [const { None }; 8];
        wanted[0] = Some(folder.join("cover"));
        assert_eq!(found, wanted);
    }
}
