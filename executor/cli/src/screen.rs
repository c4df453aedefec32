//! The view on the terminal. A thread of its own draws, so that a slow terminal does not delay the session
//! loop.

use std::collections::VecDeque;
use std::io::{Write, stdout};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crossterm::style::{Attribute, Color, SetAttribute, SetForegroundColor};
use crossterm::{cursor, queue, terminal};
use keepout_executor::operator::Panel;
use keepout_executor::session::free_way_mm;
use keepout_executor::supervisor::{Notice, Phase, Supervisor};
use keepout_guard::Time;
use keepout_kernel::exact::ring::Ring;
use keepout_planner::Mm2;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{mm, point_mm};

use super::RunArguments;
use super::display::TallyLine;
use super::operator_setup::{FAULT_KEYS, HELP};
use super::shown_unit::ShownUnit;
use super::view::{Headline, ScreenOutline, Tone, ViewFacts, draw, headline_lines};
use crate::input::TerminalError;
use crate::input::terminal::SecondScreen;

/// Least time between two pictures: at most 20 pictures per second.
const EVERY: Duration = Duration::from_millis(50);
/// Time between two queries of the terminal's size. On some systems the query starts a program.
const MEASURE_EVERY: Duration = Duration::from_millis(500);
/// Distance at which the tool counts as at the wall, or at the soft limit, mm.
const AT_WALL_MM: f64 = 0.1;
/// Most points of the trail.
const TRAIL_MAX: usize = 1500;
/// Most notices that the view keeps.
const NOTICES_MAX: usize = 4;
/// Time over which the speed is measured.
const SPEED_OVER: Duration = Duration::from_millis(250);

/// The view on the terminal. Dropping it restores the terminal.
pub struct Screen {
    pictures: Option<SyncSender<ViewFacts>>,
    thread: Option<JoinHandle<()>>,
    due: Option<Instant>,
    outline: Option<Arc<ScreenOutline>>,
    trail: Vec<Mm2>,
    track: VecDeque<(Time, Mm2)>,
    panel: Panel,
    /// The last notices.
    notices: Vec<String>,
    /// Numbers of notices taken from the panel and from the supervisor.
    taken: (usize, usize),
    tally: TallyLine,
    unit: ShownUnit,
    keys: &'static str,
    _screen: SecondScreen,
}

impl Screen {
    /// Opens the view on the terminal. `keys` is the line that explains the keys, `panel` is the operator's
    /// panel.
    pub fn open(panel: Panel, keys: &'static str, arguments: &RunArguments) -> Result<Self, TerminalError> {
        let screen = SecondScreen::enter()?;
        let (pictures, received) = sync_channel(1);
        let thread = std::thread::Builder::new().name("view".into()).spawn(move || show_all(&received))?;
        Ok(Self {
            pictures: Some(pictures),
            thread: Some(thread),
            due: None,
            outline: None,
            trail: Vec::new(),
            track: VecDeque::new(),
            panel,
            notices: Vec::new(),
            taken: (0, 0),
            tally: TallyLine::new(arguments.dry_run),
            unit: arguments.display(),
            keys,
            _screen: screen,
        })
    }

    /// Shows the present state, at most 20 times per second. Drops the picture if the terminal is not ready.
    pub fn show(&mut self, supervisor: &Supervisor, now: Time) {
        let clock = Instant::now();
        if self.due.is_some_and(|due| clock < due) {
            return;
        }
        self.due = Some(clock + EVERY);
        let facts = self.facts(supervisor, now);
        let Some(pictures) = &self.pictures else { return };
        if let Err(TrySendError::Disconnected(_)) = pictures.try_send(facts) {
            self.pictures = None;
        }
    }

    fn facts(&mut self, supervisor: &Supervisor, now: Time) -> ViewFacts {
        let plan = supervisor.plan();
        let outline = self.outline.get_or_insert_with(|| Arc::new(outline_of(plan)));
        let outline = Arc::clone(outline);
        let position_mm = supervisor.position().map(|place| point_mm(place.point));
        let wall_mm = free_way_mm(supervisor);
        let height_mm = supervisor.position().filter(|_| plan.plan.relief.is_some());
        self.follow(position_mm, now);
        self.take_notices(supervisor.notices());
        ViewFacts {
            headline: headline(supervisor, wall_mm),
            position_mm,
            height_mm: height_mm.map(|place| mm(place.height.units())),
            wall_mm,
            speed_mm_s: self.speed_mm_s(),
            unit: self.unit,
            tool_radius_mm: mm(plan.plan.tool_radius.units()),
            outline,
            trail: self.trail.clone(),
            status: self.panel.status(),
            notices: self.notices.clone(),
            tally: self.tally.of(supervisor).into(),
            help: if self.panel.help() { &HELP } else { &[] },
            keys: match supervisor.phase() {
                Phase::Faulted if !self.keys.is_empty() => FAULT_KEYS,
                _ => self.keys,
            }
            .into(),
            seconds: now.elapsed().as_secs_f64(),
        }
    }

    /// Takes the new notices of the panel and of the supervisor.
    fn take_notices(&mut self, supervisor: &[Notice]) {
        let (new, count) = self.panel.since(self.taken.0);
        self.notices.extend(new);
        self.notices.extend(supervisor.iter().skip(self.taken.1).map(ToString::to_string));
        self.taken = (count, supervisor.len());
        let old = self.notices.len().saturating_sub(NOTICES_MAX);
        self.notices.drain(..old);
    }

    fn follow(&mut self, position_mm: Option<Mm2>, now: Time) {
        let Some(position) = position_mm else { return };
        self.track.push_back((now, position));
        while self.track.len() > 2 && now.since(self.track[1].0) >= SPEED_OVER {
            self.track.pop_front();
        }
        if self.trail.last() != Some(&position) {
            self.trail.push(position);
        }
        if self.trail.len() > TRAIL_MAX {
            self.trail.drain(..TRAIL_MAX / 3);
        }
    }

    fn speed_mm_s(&self) -> Option<f64> {
        let ((since, _), (now, _)) = (self.track.front()?, self.track.back()?);
        let seconds = now.since(*since).as_secs_f64();
        let steps = self.track.iter().zip(self.track.iter().skip(1));
        let length: f64 = steps.map(|(a, b)| a.1.distance(b.1)).sum();
        (seconds > 0.0).then(|| length / seconds)
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        self.pictures = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn headline(supervisor: &Supervisor, wall_mm: Option<f64>) -> Headline {
    match supervisor.phase() {
        Phase::Starting => Headline::Starting,
        Phase::Sliding | Phase::Manual if supervisor.is_armed() => Headline::Armed,
        Phase::Sliding | Phase::Manual if wall_mm.is_some_and(|wall| wall <= AT_WALL_MM) => {
            Headline::AtTheWall
        }
        Phase::Manual | Phase::Sliding if at_the_end_of_travel(supervisor) => Headline::EndOfTravel,
        Phase::Manual | Phase::Sliding => Headline::Manual,
        Phase::Retracting => Headline::Retracting,
        Phase::Touching => Headline::Touching,
        Phase::Holding if supervisor.is_at_rest() => Headline::Paused,
        Phase::Holding => Headline::Pausing,
        Phase::Contouring => Headline::Contouring { percent: percent(supervisor) },
        Phase::Stopping => Headline::Stopping,
        Phase::Done => Headline::Done,
        Phase::Faulted => Headline::stopped(&supervisor.fault().map_or(String::new(), ToString::to_string)),
    }
}

/// Whether the tool stands at a soft limit.
fn at_the_end_of_travel(supervisor: &Supervisor) -> bool {
    let Some(position) = supervisor.position() else { return false };
    let (x0, y0, x1, y1) = supervisor.guard().rules().travel.corners();
    let (x, y) = (position.point.x.units(), position.point.y.units());
    [x - x0, x1 - x, y - y0, y1 - y].into_iter().any(|room| mm(room) <= AT_WALL_MM)
}

fn percent(supervisor: &Supervisor) -> Option<u8> {
    let (sent, all) = supervisor.guard().contour_progress()?;
    u8::try_from((sent * 100).checked_div(all)?.min(100)).ok()
}

/// The rings of the part and of the keep-out zones.
fn outline_of(plan: &CertifiedPlan) -> ScreenOutline {
    let rings = plan.part.region().rings().iter().chain(plan.part.zones());
    let closed = |ring: &Ring| -> Vec<Mm2> {
        let corners = ring.vertices();
        corners.iter().chain(corners.first()).copied().map(point_mm).collect()
    };
    ScreenOutline::new(&rings.map(closed).collect::<Vec<_>>())
}

/// The drawing thread: shows each picture until the view closes, or the terminal fails.
fn show_all(pictures: &Receiver<ViewFacts>) {
    let mut shown = Shown::default();
    while let Ok(facts) = pictures.recv() {
        if shown.show(&facts).is_err() {
            return;
        }
    }
}

/// Present content of the terminal. Only lines that change are drawn again.
#[derive(Default)]
struct Shown {
    size: (u16, u16),
    measured: Option<Instant>,
    tone: Option<Tone>,
    lines: Vec<String>,
}

impl Shown {
    fn show(&mut self, facts: &ViewFacts) -> std::io::Result<()> {
        let clock = Instant::now();
        let known = self.measured.filter(|at| clock.duration_since(*at) < MEASURE_EVERY);
        let size = if known.is_some() { self.size } else { terminal::size()? };
        let (width, height) = (usize::from(size.0), usize::from(size.1));
        let lines = draw(facts, width, height);
        let tone = facts.headline.tone();
        let mut out = Vec::new();
        if size != self.size {
            queue!(out, terminal::Clear(terminal::ClearType::All))?;
            self.lines.clear();
        }
        let head = headline_lines(width, height);
        for (index, line) in lines.iter().enumerate() {
            let repaint = index < head && self.tone != Some(tone);
            if !repaint && self.lines.get(index) == Some(line) {
                continue;
            }
            queue!(out, cursor::MoveTo(0, u16::try_from(index).unwrap_or(u16::MAX)))?;
            queue!(out, terminal::Clear(terminal::ClearType::CurrentLine))?;
            if index < head {
                queue!(out, SetForegroundColor(colour(tone)), SetAttribute(Attribute::Bold))?;
            }
            out.extend_from_slice(line.as_bytes());
            if index < head {
                queue!(out, SetForegroundColor(Color::Reset), SetAttribute(Attribute::Reset))?;
            }
        }
        *self = Self { size, measured: known.or(Some(clock)), tone: Some(tone), lines };
        let mut terminal = stdout().lock();
        terminal.write_all(&out)?;
        terminal.flush()
    }
}

fn colour(tone: Tone) -> Color {
    match tone {
        Tone::Calm => Color::Green,
        Tone::Alert => Color::Yellow,
        Tone::Alarm => Color::Red,
    }
}
