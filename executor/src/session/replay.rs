//! Playing a log again: every command that was sent is certified again, and must come out the same.
//!
//! Two checks, one behind the other. The engine is given what went in, and must give what came out, byte by byte. And each
//! certificate is checked by itself, without the guard: the triangles over the logged in-flight set, or the motion of the
//! contour, against the part.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_kernel::offset::certify_path;
use keepout_kernel::{FreePoint, Length, Point, ProhibitedRegion};
use keepout_planner::plan_file;
use keepout_planner::units::point_mm;
use thiserror::Error;

use super::engine::Engine;
use super::log::{Certificate, Entry, Header, Log, as_entry};
use super::tape::{Record, Tape, TapeError};
use crate::link::dialect::{Language, LanguageError, Setting};
use crate::sim::{Sample, SampleKind};
use crate::supervisor::guard::MotionShape;
use crate::supervisor::{Options, Phase, Supervisor, Workpiece};
use crate::time::Time;

/// Why a log does not hold what it claims.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// It was made with another plan.
    #[error(
        "the log is of another plan: it names {logged}, this one is {given}. Give the plan that was run."
    )]
    OtherPlan {
        /// The plan's hash, as logged.
        logged: String,
        /// The hash of the plan that was given.
        given: String,
    },
    /// The plan can not be written as a file is.
    #[error(transparent)]
    Plan(#[from] keepout_planner::plan_file::PlanFileError),
    /// The dialect is not known.
    #[error(transparent)]
    Language(#[from] LanguageError),
    /// Something else came out.
    #[error("line {line} of the log, {seconds:.3} s: logged {logged}, played again {played}")]
    Differs {
        /// The line of the log, from 1.
        line: usize,
        /// Its time, s.
        seconds: f64,
        /// What is logged.
        logged: String,
        /// What came out.
        played: String,
    },
    /// A certificate does not hold.
    #[error(
        "line {line} of the log, {seconds:.3} s: the motion is not certified by what is logged: {reason}"
    )]
    NotCertified {
        /// The line of the log, from 1.
        line: usize,
        /// Its time, s.
        seconds: f64,
        /// Why not.
        reason: String,
    },
}

/// What a log holds.
pub struct Replay {
    /// The supervisor as it was when the log ended.
    pub supervisor: Supervisor,
    /// The last moment that was logged.
    pub ended: Time,
    /// Commands that came out the same, byte by byte.
    pub commands: u64,
    /// Certificates that were checked by themselves.
    pub certificates: u64,
    /// Where the tool was reported while it moved, drawing coordinates.
    pub samples: Vec<Sample>,
    /// Least clearance beyond the tool's edge of a reported position, in mm, within 5 mm.
    pub closest_mm: Option<f64>,
    /// The last phase and fault that were logged.
    pub last_phase: String,
}

/// What comes out while the engine is played.
#[derive(Default)]
struct Outcome {
    entries: VecDeque<Entry>,
}

impl Tape for Outcome {
    fn take(&mut self, _: Time, record: &Record<'_>) -> Result<(), TapeError> {
        self.entries.extend(as_entry(record));
        Ok(())
    }

    fn flush(&mut self) -> Result<(), TapeError> {
        Ok(())
    }
}

/// Plays a log again.
///
/// # Errors
/// [`ReplayError`] naming the line from which on it does not hold.
pub fn replay(log: &Log, work: Workpiece) -> Result<Replay, ReplayError> {
    check_plan(&log.header, &work)?;
    let mut player = Player::new(log, work)?;
    for (index, (time, entry)) in log.entries.iter().enumerate() {
        player.play(index + 2, *time, entry)?;
    }
    Ok(player.end(log))
}

fn check_plan(header: &Header, work: &Workpiece) -> Result<(), ReplayError> {
    let given = plan_file::hex(&plan_file::hash(&plan_file::encode(&work.plan.plan)?));
    let logged = header.plan.clone();
    if logged == given { Ok(()) } else { Err(ReplayError::OtherPlan { logged, given }) }
}

struct Player {
    engine: Engine,
    outcome: Outcome,
    result: (u64, u64, Vec<Sample>, Option<Length>, String),
}

impl Player {
    fn new(log: &Log, work: Workpiece) -> Result<Self, ReplayError> {
        let header = &log.header;
        let machine = &work.plan.plan.machine;
        let setting = Setting {
            offset: header.offset,
            steps_per_mm: machine.steps_per_mm,
            arc_tolerance_mm: machine.arc_tolerance_mm,
        };
        let options = Options {
            feed_mm_min: header.feed_mm_min,
            home: header.home,
            stroke: header.stroke,
            answer_within: Duration::from_millis(header.answer_within_ms),
            progress: header.progress.clone(),
        };
        let dialect = Language::named(&header.dialect)?.dialect(setting);
        let supervisor = Supervisor::new(work, options, dialect.abilities());
        let engine = Engine::new(supervisor, dialect);
        Ok(Self { engine, outcome: Outcome::default(), result: (0, 0, Vec::new(), None, String::new()) })
    }

    fn play(&mut self, line: usize, time: Time, entry: &Entry) -> Result<(), ReplayError> {
        let engine = &mut self.engine;
        let tape = &mut self.outcome;
        if !matches!(entry, Entry::Sent(_) | Entry::Certificate(_) | Entry::Phase(_))
            && let Some(extra) = tape.entries.pop_front()
        {
            return Err(differs(line, time, "nothing", &extra));
        }
        let fed = match entry {
            Entry::Received(bytes) => engine.receive(bytes, time, tape),
            Entry::Wish(wish) => engine.wish(*wish, time, tape),
            Entry::Tick => engine.tick(time, tape),
            Entry::Job(job) => engine.job(job.clone(), time, tape),
            Entry::PortLost(reason) => engine.port_lost(reason, time, tape),
            Entry::PortFound => engine.port_found(time, tape),
            Entry::Halt => engine.halt(time, tape),
            Entry::Sent(_) | Entry::Certificate(_) | Entry::Phase(_) => {
                return self.compare(line, time, entry);
            }
        };
        engine.drain(|_| {});
        self.see(time);
        fed.map_err(|error| differs(line, time, &error.to_string(), entry))
    }

    fn compare(&mut self, line: usize, time: Time, logged: &Entry) -> Result<(), ReplayError> {
        match self.outcome.entries.pop_front() {
            Some(played) if played == *logged => {}
            Some(played) => return Err(differs(line, time, &format!("{logged:?}"), &played)),
            None => {
                return Err(ReplayError::Differs {
                    line,
                    seconds: time.seconds(),
                    logged: format!("{logged:?}"),
                    played: "nothing".into(),
                });
            }
        }
        match logged {
            Entry::Sent(_) => self.result.0 += 1,
            Entry::Certificate(text) => {
                self.check(text).map_err(|reason| ReplayError::NotCertified {
                    line,
                    seconds: time.seconds(),
                    reason,
                })?;
                self.result.1 += 1;
            }
            Entry::Phase(phase) => self.result.4.clone_from(phase),
            _ => {}
        }
        Ok(())
    }

    /// Checks a certificate by itself.
    fn check(&self, text: &str) -> Result<(), String> {
        let certificate = Certificate::parse(text).ok_or("it can not be read")?;
        let supervisor = &self.engine.supervisor;
        let part = supervisor.work().part();
        let rules = supervisor.guard().rules();
        match certificate {
            Certificate::Jog(target, set) if !set.contains(&target) => Err("its set lacks its target".into()),
            Certificate::Jog(target, set) if supervisor.phase() == Phase::Escaping => {
                check_escape(part, rules.manual, target, &set)
            }
            Certificate::Jog(_, set) => {
                let set = if rules.shape == MotionShape::Box { corners(&set) } else { set };
                check_hull(part, rules.manual, &set)
            }
            Certificate::Contour(curve) => match certify_path(part, rules.finishing, &[curve]) {
                Ok(_) => Ok(()),
                Err(gouge) => Err(gouge.to_string()),
            },
        }
    }

    /// Keeps a reported position for the picture.
    fn see(&mut self, at: Time) {
        let supervisor = &self.engine.supervisor;
        let Some(position) = supervisor.position() else { return };
        let position_mm = point_mm(position);
        if self.result.2.last().is_some_and(|last| last.position_mm == position_mm) {
            return;
        }
        let kind = match supervisor.phase() {
            Phase::Contouring | Phase::Holding => SampleKind::Run,
            Phase::Starting => SampleKind::Rest,
            _ => SampleKind::Jog,
        };
        self.result.2.push(Sample { at, position_mm, kind });
        let clearance = supervisor.work().part().clearance(position).unwrap_or(Length::ZERO);
        self.result.3 = Some(self.result.3.map_or(clearance, |least| least.min(clearance)));
    }

    fn end(self, log: &Log) -> Replay {
        let (commands, certificates, samples, closest, last_phase) = self.result;
        let radius = self.engine.supervisor.plan().plan.tool_radius;
        let mm = |length: Length| keepout_planner::units::mm(length.units());
        Replay {
            ended: log.entries.last().map_or(Time::ZERO, |entry| entry.0),
            commands,
            certificates,
            samples,
            closest_mm: closest.map(|closest| mm(closest) - mm(radius)),
            last_phase,
            supervisor: self.engine.supervisor,
        }
    }
}

fn differs(line: usize, time: Time, logged: &str, played: &Entry) -> ReplayError {
    ReplayError::Differs {
        line,
        seconds: time.seconds(),
        logged: logged.into(),
        played: format!("{played:?}"),
    }
}

/// The hull of the points is clear, and on the free side: every triangle of them is, from a point that is free.
fn check_hull(part: &ProhibitedRegion, threshold: Length, set: &[Point]) -> Result<(), String> {
    let free: Vec<FreePoint> = set
        .iter()
        .map(|&point| part.free_point(point, threshold))
        .collect::<Result<_, _>>()
        .map_err(|blocked| blocked.to_string())?;
    for (i, &a) in free.iter().enumerate() {
        for (j, &b) in free.iter().enumerate().skip(i + 1) {
            for c in free.iter().skip(j) {
                part.fan(a, b, c.point()).map_err(|blocked| blocked.to_string())?;
            }
        }
    }
    Ok(())
}

/// The corners of the box around the points.
fn corners(set: &[Point]) -> Vec<Point> {
    let window = set.iter().map(|&point| keepout_kernel::exact::segment::Window::of(point));
    let Some(window) = window.reduce(keepout_kernel::exact::segment::Window::union) else {
        return Vec::new();
    };
    let (x0, y0, x1, y1) = window.corners();
    let corner = |x: i32, y: i32| Point::from_units(x.into(), y.into()).ok();
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].into_iter().filter_map(|(x, y)| corner(x, y)).collect()
}

/// The way out comes nearer to nothing.
fn check_escape(
    part: &ProhibitedRegion,
    threshold: Length,
    target: Point,
    set: &[Point],
) -> Result<(), String> {
    let from = set.iter().copied().find(|&point| point != target).unwrap_or(target);
    let clearance = part.clearance(from).ok_or("it begins in the part")?;
    let from = part.free_point(from, clearance).map_err(|blocked| blocked.to_string())?;
    part.recedes(from, target, threshold).map(|_| ()).map_err(|blocked| blocked.to_string())
}
