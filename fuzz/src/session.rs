//! The supervisor with a machine that executes its commands late, in part or twice, or that sends false
//! replies. The check is the guard's invariant: no motion that may still be executed leads near the part,
//! and the tool never comes near it.

mod events;
mod machine;
pub mod watch;

use std::time::Duration;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::session::place_on_table;
use keepout_executor::supervisor::{
    Abilities, Event, OperatorInput, Options, Phase, PreparedPlan, Supervisor, text,
};
use keepout_guard::{Interpolation, OnCancel, Time};
use keepout_kernel::{Length, Point};
use keepout_planner::job::{LoopNumber, Progress};
use machine::{Machine, Make, Tip};
use watch::comes_near_to;

use crate::job;

/// Largest number of steps of one session.
const STEPS_MAX: usize = 400;
/// Largest number of commands from one step.
const COMMANDS_MAX: usize = 64;

/// The fault of the link or the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// Heights of a session with depths, lattice units.
#[derive(Clone, Copy, Debug)]
struct Heights {
    /// The table.
    floor: i64,
    /// Where the tool crosses.
    safe: i64,
}

/// Reads a session from any bytes: two axes or three, the operator's input, the machine's actions and times, and
/// the faults.
///
/// # Panics
/// When the supervisor sends a motion that is not certified, or the tool comes too near the part.
pub fn supervisor(bytes: &[u8]) {
    let _ = session(&mut Unstructured::new(bytes));
}

fn session(u: &mut Unstructured<'_>) -> Result<()> {
    let kind = u32::arbitrary(u)?;
    let troubles = [Trouble::None, Trouble::Loses, Trouble::Duplicates, Trouble::FalseReplies];
    let (trouble, depths) = (troubles[(kind >> 30) as usize], kind % 2 == 1);
    let make = make(depths, u)?;
    let (mut play, undisturbed) = Play::begin(trouble, make, depths, u)?;
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
fn make(depths: bool, u: &mut Unstructured<'_>) -> Result<Make> {
    let grbl = Abilities {
        interpolation: Interpolation::Linear,
        contours: Interpolation::Linear,
        arcs: bool::arbitrary(u)?,
        queues: true,
        on_cancel: OnCancel::KeepsPath,
        checked: bool::arbitrary(u)?,
        spindle: depths,
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
    work: PreparedPlan,
    /// `None` in a session with two axes.
    heights: Option<Heights>,
    /// The tool was, or was reported, inside the jogging clearance. It may be there because a contour led
    /// to it.
    near: bool,
    input: OperatorInput,
    /// The motions of the tool on contours.
    cut: Vec<[Tip; 2]>,
    /// The last resume point, and its loop.
    resume_point: Option<(LoopNumber, Point)>,
    /// The cable is pulled, so no message arrives in either direction.
    pulled: bool,
}

impl Play {
    /// A session, and whether it has no fault before the operator can jog.
    fn begin(trouble: Trouble, make: Make, depths: bool, u: &mut Unstructured<'_>) -> Result<(Self, bool)> {
        const STARTS_MM: [(i64, i64); 5] = [(-10, -10), (10, 40), (10, 30), (40, 5), (-4, 8)];
        let work = if depths { job::deep_work() } else { job::work() };
        let heights =
            work.plan.plan.relief.as_ref().map(|relief| Heights {
                floor: relief.floor.units().into(),
                safe: relief.safe.units().into(),
            });
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
        // Above the plate, or as deep as the middle of a pass.
        let height = match heights {
            Some(heights) if start % 7 < 5 && bool::arbitrary(u)? => heights.safe,
            Some(_) => -100_000,
            None => 0,
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
            supervisor: Supervisor::new(work.clone(), options, make.abilities),
            machine: Machine::new(make, Tip { at: tool, height }),
            trouble,
            now: Time::ZERO,
            work,
            heights,
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
                let (input, command) = events::input(self.heights.is_some(), u)?;
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
                    let mut worked_out = wanted.work_out(&self.work.plan);
                    if self.trouble == Trouble::FalseReplies {
                        events::forge(&mut worked_out, u)?;
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
            let to = self.machine.tool;
            let standing = self.standing(from.height.min(to.height));
            let near = comes_near_to(&standing, [from.at, to.at, to.at], kept);
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
                let event = events::false_event(self.heights.is_some(), u)?;
                self.step(event);
            }
        }
        Ok(())
    }
}
