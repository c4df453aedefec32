//! An engine on the simulated machine in virtual time, one decision at a time. Benchmarks measure each
//! decision.

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::{Engine, NoEventLog, Sample, SessionSetup, nearest_wall, place_on_table};
use keepout_executor::supervisor::{OperatorInput, Options, Phase, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_kernel::{Height, Point};
use keepout_planner::job::Progress;
use keepout_planner::units::{mm, point_from_mm, point_mm};
use keepout_planner::{Box2, Mm2};
use keepout_sim::{PositioningError, SimMachine, SimSettings, speaking};

/// The cause of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Bytes from the controller.
    Reply,
    /// A jog input of the operator.
    OperatorInput,
    /// A tick of the clock.
    Tick,
}

/// An engine and a machine, stepped from one decision to the next.
pub struct Decisions {
    engine: Engine,
    machine: SimMachine,
    operator: Box<dyn Operator>,
    now: Time,
    input_due: Time,
    bytes: Vec<u8>,
    samples: Vec<Sample>,
    wall: Option<Mm2>,
    inputs: u32,
    part_box: Box2,
}

/// Inputs from one search of the nearest wall to the next: a person's eye is not faster.
const LOOK_EVERY: u32 = 10;

impl Decisions {
    /// Builds an engine for the plan on a simulated GRBL machine. The tool starts outside the part's box, by
    /// twice the jogging clearance in x and y, and at the safe height.
    ///
    /// # Errors
    /// The reason why the plan does not fit the machine.
    pub fn new(work: PreparedPlan, operator: Box<dyn Operator>) -> Result<Self, String> {
        let mut machine = work.plan.plan.machine.clone();
        machine.travel_mm = [1000.0, 1000.0];
        let place = place_on_table(&work.plan, &machine, None).map_err(|error| error.to_string())?;
        let part_box = work.plan.part_box();
        let start = part_box.grown(2.0 * mm(work.plan.roughing.units())).low;
        let start = point_from_mm(start).map_err(|error| error.to_string())?;
        let on_machine: Point = start.translated(place.offset).map_err(|error| error.to_string())?;
        let zero = place.z.map_or(Height::ZERO, |z| z.zero);
        let safe = work.plan.plan.relief.as_ref().map_or(Height::ZERO, |relief| relief.safe);
        let up_mm = mm(safe.units()) + mm(zero.units());
        let settings = SimSettings {
            work_offset_mm: Mm2::ZERO.at_height(0.0),
            ..SimSettings::of(machine.clone(), point_mm(on_machine).at_height(up_mm))
        };
        let config = place.config(&machine);
        let options = Options {
            feed_mm_min: 6000,
            home: false,
            travel: place.travel,
            heights: place.heights(),
            answer_within: Duration::from_secs(5),
            baud: 115_200,
            progress: Progress::default(),
        };
        let setup = SessionSetup { work, options, dialect: DialectName::Grbl, config };
        let error =
            PositioningError::wandering(0.0, machine.steps_per_mm, 1).of_three_axes(machine.z.as_ref());
        let machine =
            SimMachine::new(speaking(&DialectName::Grbl, settings), 115_200, Duration::from_millis(1), error);
        Ok(Self {
            engine: setup.engine(),
            machine,
            operator,
            now: Time::ZERO,
            input_due: Time::ZERO,
            bytes: Vec::with_capacity(4096),
            samples: Vec::with_capacity(4096),
            wall: None,
            inputs: 0,
            part_box,
        })
    }

    /// The supervisor's phase.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.engine.supervisor.phase()
    }

    /// Machine time.
    #[must_use]
    pub fn now(&self) -> Time {
        self.now
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.engine.supervisor
    }

    /// Advances to the next decisions, and passes each to `decide`, which must call it. A decision takes an
    /// input, and gives the bytes to send. The planner's computation of a contouring job happens outside of
    /// `decide`.
    pub fn step(&mut self, mut decide: impl FnMut(Cause, &mut dyn FnMut())) {
        let due = self.engine.supervisor.due().min(self.input_due).min(self.machine.next_event());
        self.now = due.max(self.now.after(Duration::from_micros(1)));
        let now = self.now;
        self.machine.advance(now);
        self.bytes.clear();
        self.machine.host_reads(&mut self.bytes, now);
        let (engine, bytes) = (&mut self.engine, &self.bytes);
        if !bytes.is_empty() {
            decide(Cause::Reply, &mut || drop(engine.receive(bytes, now, &mut NoEventLog)));
        }
        if now >= self.input_due {
            let input = self.input();
            self.input_due = now.after(self.operator.every());
            let (engine, operator) = (&mut self.engine, &mut self.operator);
            decide(Cause::OperatorInput, &mut || {
                if let Some(command) = operator.command() {
                    drop(engine.command(command, now, &mut NoEventLog));
                }
                drop(engine.input(input, now, &mut NoEventLog));
            });
        }
        let engine = &mut self.engine;
        if now >= engine.supervisor.due() {
            decide(Cause::Tick, &mut || drop(engine.tick(now, &mut NoEventLog)));
        }
        if let Some(request) = self.engine.wanted_job() {
            let job = request.work_out(self.engine.supervisor.plan());
            let _ = self.engine.job(job, now, &mut NoEventLog);
        }
        let machine = &mut self.machine;
        self.engine.drain(|chunk| machine.host_writes(chunk, now));
        self.machine.take_samples(&mut self.samples);
        self.samples.clear();
    }

    fn input(&mut self) -> OperatorInput {
        let supervisor = &self.engine.supervisor;
        self.inputs += 1;
        if self.inputs.is_multiple_of(LOOK_EVERY) {
            self.wall = supervisor.position().and_then(|position| nearest_wall(supervisor.plan(), position));
        }
        self.operator.input(&self.view(), self.now)
    }

    /// What the operator sees.
    #[must_use]
    pub fn view(&self) -> OperatorView {
        let supervisor = &self.engine.supervisor;
        OperatorView {
            position_mm: supervisor.position().map(|place| point_mm(place.point)),
            height_mm: supervisor.height_mm(),
            wall_mm: self.wall,
            part_box: self.part_box,
            end_mm: supervisor.guard().end().map(|end| point_mm(end.point())),
            unacknowledged: supervisor.guard().unacknowledged(),
            spindle_runs: supervisor.spindle_runs() == Some(true),
            phase: supervisor.phase(),
            contoured: !supervisor.finished().is_empty(),
        }
    }
}
