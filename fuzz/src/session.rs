//! The supervisor with a machine that executes its commands late, in part or twice, or that sends false
//! replies. The check is the guard's invariant: no motion that may still be executed leads near the part,
//! and the tool never comes near it.

mod machine;
pub mod watch;

use std::time::Duration;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::session::place_on_table;
use keepout_executor::supervisor::{
    Abilities, Event, Limits, Mode, OperatorCommand, OperatorInput, Options, Phase, Reply, Report,
    Supervisor, Unfit, text,
};
use keepout_guard::{Interpolation, OnCancel, Time};
use keepout_kernel::{Curve, Length, Point, Segment, Vector};
use keepout_planner::Mm2;
use keepout_planner::job::{ContourJob, JobError, Progress};
use keepout_proofs::properties::Xy;
use machine::{Machine, Make};

use crate::job;

/// Largest number of steps of one session.
const STEPS_MAX: usize = 400;
/// Largest number of commands from one step.
const COMMANDS_MAX: usize = 64;

/// The fault of the link or the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Arbitrary)]
enum Trouble {
    /// No fault, except that the cable is pulled and plugged in again.
    None,
    /// Lines and answers are lost.
    Loses,
    /// Lines and answers arrive twice.
    Duplicates,
    /// The controller sends false replies.
    FalseReplies,
}

/// Reads a session from any bytes: the operator's input, the machine's actions and times, and the faults.
///
/// # Panics
/// When the supervisor sends a motion that is not certified, or the tool comes too near the part.
pub fn supervisor(bytes: &[u8]) {
    let _ = session(&mut Unstructured::new(bytes));
}

fn session(u: &mut Unstructured<'_>) -> Result<()> {
    let trouble = Trouble::arbitrary(u)?;
    let make = make(u)?;
    let (mut play, undisturbed) = Play::begin(trouble, make, u)?;
    if undisturbed {
        play.starts();
        assert!(play.supervisor.phase().is_steered(), "it does not start: {:?}", play.supervisor.phase());
    }
    for _ in 0..STEPS_MAX {
        if u.is_empty() {
            break;
        }
        play.goes_on(u)?;
    }
    play.watch_progress();
    Ok(())
}

/// A kind of controller: one of the dialects', or one that a file could describe.
fn make(u: &mut Unstructured<'_>) -> Result<Make> {
    let grbl = Abilities {
        interpolation: Interpolation::Linear,
        contours: Interpolation::Linear,
        arcs: bool::arbitrary(u)?,
        queues: true,
        on_cancel: OnCancel::KeepsPath,
        checked: bool::arbitrary(u)?,
    };
    let single = Abilities { arcs: false, queues: false, ..grbl };
    let abilities = match u.int_in_range(0..=7_u8)? {
        0..=2 => grbl,
        3 => Abilities { on_cancel: OnCancel::MayStray, ..grbl },
        // As Zaber's.
        4 => Abilities { on_cancel: OnCancel::NotOffered, checked: true, ..single },
        // As Venus-1.
        5 => Abilities { interpolation: Interpolation::Independent, checked: false, ..single },
        6 => Abilities {
            interpolation: Interpolation::Independent,
            contours: Interpolation::Independent,
            on_cancel: OnCancel::NotOffered,
            ..single
        },
        _ => {
            let apart = bool::arbitrary(u)?;
            let shape = if apart { Interpolation::Independent } else { Interpolation::Linear };
            let on_cancel = [OnCancel::NotOffered, OnCancel::KeepsPath][usize::from(bool::arbitrary(u)?)];
            Abilities { interpolation: shape, queues: bool::arbitrary(u)?, on_cancel, ..single }
        }
    };
    let replaces = !abilities.queues && bool::arbitrary(u)?;
    Ok(Make { abilities, replaces, y_first: bool::arbitrary(u)? })
}

/// The supervisor and the machine, and facts about the tool.
struct Play {
    supervisor: Supervisor,
    machine: Machine,
    trouble: Trouble,
    now: Time,
    walls: Vec<(Xy, Xy)>,
    /// The tool was, or was reported, inside the jogging clearance. It may be there because a contour led
    /// to it.
    near: bool,
    input: OperatorInput,
    /// The motions of the tool on contours.
    cut: Vec<[Xy; 2]>,
    /// The last resume point.
    resume_point: Option<Point>,
    /// The cable is pulled, so no message arrives in either direction.
    pulled: bool,
}

impl Play {
    /// A session, and whether it has no fault before the operator can jog.
    fn begin(trouble: Trouble, make: Make, u: &mut Unstructured<'_>) -> Result<(Self, bool)> {
        const STARTS_MM: [(i64, i64); 5] = [(-10, -10), (10, 40), (10, 30), (40, 5), (-4, 8)];
        let work = job::work();
        let walls = watch::ends_of_edges(&work.plan.part);
        let place =
            place_on_table(&work.plan, &work.plan.plan.machine, None).expect("the plate lies on the table");
        let between = work.plan.roughing.units().midpoint(work.plan.finishing.units());
        // Of eight sessions, four begin with homing, and two begin with a fault.
        let start = u.int_in_range(0..=55_u8)?;
        let tool = match start % 7 {
            // Where only retract moves are allowed: beside the left edge, or in the slot's mouth.
            5 => (-i64::from(between), 800_000),
            6 => (600_000 + i64::from(between), 1_500_000),
            start => {
                let (x, y) = STARTS_MM[usize::from(start)];
                (x * 100_000, y * 100_000)
            }
        };
        let options = Options {
            feed_mm_min: 900,
            home: start / 7 % 2 == 1,
            travel: place.travel,
            heights: place.heights(),
            answer_within: Duration::from_secs(5),
            baud: 115_200,
            progress: Progress::default(),
        };
        let play = Self {
            supervisor: Supervisor::new(work, options, make.abilities),
            machine: Machine::new(make, tool),
            trouble,
            now: Time::ZERO,
            walls,
            near: false,
            input: OperatorInput::default(),
            cut: Vec::new(),
            resume_point: None,
            pulled: false,
        };
        Ok((play, start / 7 < 6))
    }

    /// Runs until the operator can jog.
    fn starts(&mut self) {
        for _ in 0..40 {
            if self.supervisor.phase().is_steered() {
                return;
            }
            self.passes(Duration::from_millis(100));
            self.delivers_all();
        }
    }

    fn delivers_all(&mut self) {
        while !self.machine.wire.is_empty() {
            self.machine.receives();
        }
        while !self.machine.answers.is_empty() {
            self.receives_answer();
        }
    }

    /// Delivers the next answer, unless the cable is pulled.
    fn receives_answer(&mut self) {
        if let Some(reply) = self.machine.answers.pop_front().filter(|_| !self.pulled) {
            self.step(Event::Reply(reply));
        }
    }

    fn goes_on(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        match u.int_in_range(0..=15_u8)? {
            0 | 1 => self.machine.receives(),
            2 | 3 => self.moves(f64::from(u8::arbitrary(u)?) / 128.0),
            4 | 5 => self.receives_answer(),
            6 | 7 => {
                let (input, command) = input(u)?;
                self.input = input;
                if let Some(command) = command {
                    self.step(Event::Command(command));
                }
                self.step(Event::Input(self.input));
            }
            8 => self.passes(Duration::from_millis(u64::from(u16::arbitrary(u)?) / 16)),
            9 => self.suffers(u)?,
            10 => {
                if let Some(wanted) = self.supervisor.wanted_job() {
                    let mut worked_out = wanted.work_out(&job::work().plan);
                    if self.trouble == Trouble::FalseReplies {
                        forge(&mut worked_out, u)?;
                    }
                    self.step(Event::Job(Box::new(worked_out)));
                }
            }
            // A normal sequence without delays, for a while.
            rounds => {
                for _ in 10..rounds {
                    self.step(Event::Input(self.input));
                    self.passes(Duration::from_millis(50));
                    self.moves(0.6);
                    self.delivers_all();
                }
            }
        }
        Ok(())
    }

    fn passes(&mut self, span: Duration) {
        self.now = self.now.after(span);
        self.step(Event::Tick);
    }

    fn step(&mut self, event: Event) {
        let mut commands = Vec::new();
        self.supervisor.step(event, self.now, &mut commands);
        assert!(commands.len() <= COMMANDS_MAX, "{} commands at once", commands.len());
        let inside = self.supervisor.guard().is_inside_jogging_clearance();
        self.near |= inside || matches!(self.supervisor.phase(), Phase::Contouring | Phase::Holding);
        for command in commands {
            self.watch(&command, inside);
            self.machine.wire.extend(Some(command).filter(|_| !self.pulled));
        }
        if self.trouble != Trouble::FalseReplies {
            self.watch_hull();
        }
        self.watch_cut();
    }

    /// Moves the tool on. Without false replies it comes nowhere near the part.
    fn moves(&mut self, share: f64) {
        let rules = self.supervisor.guard().rules();
        let off = 3 * i64::from(rules.resolution.units()) + 4;
        let kept = |threshold: Length| i64::from(threshold.units()) - off;
        let kept = if self.near { kept(rules.finishing_clearance) } else { kept(rules.jogging_clearance) };
        let mut left = share;
        while left > 0.0 {
            let from = self.machine.tool;
            let cuts = self.machine.is_contouring();
            let Some(used) = self.machine.moves(left) else { break };
            left -= used;
            let near = self.is_near([from, self.machine.tool, self.machine.tool], kept);
            let to = self.machine.tool;
            self.cut.extend(cuts.then_some([from, to]));
            assert!(
                !near || self.trouble == Trouble::FalseReplies,
                "the tool comes nearer than {kept}: {from:?} to {to:?}"
            );
        }
        if self.trouble != Trouble::FalseReplies {
            self.watch_hull();
        }
    }

    fn suffers(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let (there, machine) = (bool::arbitrary(u)?, &mut self.machine);
        match self.trouble {
            Trouble::None if !there => {}
            Trouble::None if self.pulled => {
                self.pulled = false;
                self.step(Event::PortFound);
            }
            Trouble::None => {
                self.pulled = true;
                machine.answers.clear();
                // Earlier messages may still arrive.
                if bool::arbitrary(u)? {
                    machine.wire.clear();
                }
                self.step(Event::PortLost(text("pulled")));
            }
            Trouble::Loses if there => drop(machine.wire.pop_front()),
            Trouble::Loses => drop(machine.answers.pop_front()),
            Trouble::Duplicates if there => {
                machine.wire.extend(machine.wire.front().copied().filter(|_| machine.wire.len() == 1))
            }
            Trouble::Duplicates => {
                if let Some(&reply) = machine.answers.front() {
                    machine.answers.push_front(reply);
                }
            }
            Trouble::FalseReplies => {
                let event = false_event(u)?;
                self.step(event);
            }
        }
        Ok(())
    }
}

fn input(u: &mut Unstructured<'_>) -> Result<(OperatorInput, Option<OperatorCommand>)> {
    // No stick or wheel gives the values at the ends of the range.
    let share = |u: &mut Unstructured<'_>| {
        Ok(match i8::arbitrary(u)? {
            i8::MIN => f64::NAN,
            -127 => f64::NEG_INFINITY,
            126 => 1e308,
            i8::MAX => f64::INFINITY,
            usual => f64::from(usual) / 100.0,
        })
    };
    let velocity = Mm2::new(share(u)?, share(u)?);
    let turned_mm = if u.int_in_range(0..=7_u8)? == 0 { Mm2::new(share(u)?, share(u)?) } else { Mm2::ZERO };
    let command = match u.int_in_range(0..=31_u8)? {
        0 => Some(OperatorCommand::FeedHold),
        1 | 2 => Some(OperatorCommand::CycleStart),
        3 => Some(OperatorCommand::Recover),
        4 => Some(OperatorCommand::Stop),
        _ => None,
    };
    let input = OperatorInput { velocity, turned_mm, ..OperatorInput::default() };
    Ok((OperatorInput { armed: u.int_in_range(0..=2_u8)? == 0, ..input }, command))
}

/// Changes a contour job: an error, a motion to another place, a motion left out, or no change.
fn forge(job: &mut std::result::Result<ContourJob, JobError>, u: &mut Unstructured<'_>) -> Result<()> {
    let what = u.int_in_range(0..=7_u8)?;
    let Ok(legs) = job.as_mut().map(|job| &mut job.legs) else { return Ok(()) };
    let which = if legs.is_empty() { 0 } else { u.choose_index(legs.len())? };
    let Some(curves) = legs.get_mut(which).map(|leg| &mut leg.curves).filter(|curves| !curves.is_empty())
    else {
        return Ok(());
    };
    let at = u.choose_index(curves.len())?;
    match what {
        0 => *job = Err(JobError::Failed),
        1 => drop(curves.remove(at)),
        2 => curves.swap(0, at),
        3 | 4 => {
            let from = curves[at].from();
            let (dx, dy) = (i32::from(i16::arbitrary(u)?) << 6, i32::from(i16::arbitrary(u)?) << 6);
            let Ok(to) = from.translated(Vector { dx, dy }) else { return Ok(()) };
            curves[at] = Curve::Line(Segment { from, to });
            // The following motions go on from there, or are left out.
            if what == 3 {
                curves.truncate(at + 1);
            }
        }
        _ => {}
    }
    Ok(())
}

/// Any event that a controller's reply or the port can cause.
fn false_event(u: &mut Unstructured<'_>) -> Result<Event> {
    const MODES: [Mode; 7] =
        [Mode::Idle, Mode::Moving, Mode::Slowing, Mode::Held, Mode::Homing, Mode::Alarm, Mode::Other];
    let reply = match u.int_in_range(0..=39_u8)? {
        36 => Reply::NotHomed,
        37 => Reply::Displaced,
        38 => Reply::Unfit(Unfit { name: "$32", value: 1.0, needed: "0" }),
        39 => Reply::Message(text("a message")),
        0..=8 | 20..=28 => {
            let place = (i64::from(i32::arbitrary(u)? >> 6), i64::from(i32::arbitrary(u)? >> 6));
            Reply::Report(Report {
                mode: *u.choose(&MODES)?,
                position: if u.int_in_range(0..=7_u8)? == 0 {
                    None
                } else {
                    Point::from_units(place.0, place.1).ok().map(Point::in_plane)
                },
                queued: Option::<u8>::arbitrary(u)?.map(usize::from),
                waiting: Option::<bool>::arbitrary(u)?,
            })
        }
        9 | 10 | 29 | 30 => Reply::Accepted,
        11 | 31 => Reply::Refused { code: 8, meaning: "", transient: bool::arbitrary(u)? },
        12 | 32 => Reply::Restarted,
        13 | 33 => Reply::Alarm { code: 1, meaning: "" },
        14 | 34 => Reply::Homed,
        15 | 35 => Reply::Armed,
        16 => Reply::Prepared(Limits::of(f64::from(u8::arbitrary(u)?), f64::from(u8::arbitrary(u)?))),
        17 => Reply::Garbled(text("?")),
        18 => return Ok(Event::PortLost(text("pulled"))),
        _ => return Ok(Event::PortFound),
    };
    Ok(Event::Reply(reply))
}
