//! Round trips: a simulated controller reads each dialect's motions to the resolution that the margin
//! assumes.

use std::time::Duration;

use keepout_executor::dialect::{Dialect, DialectConfig, DialectName};
use keepout_executor::supervisor::{Command, Mode, Reply};
use keepout_guard::{ContourMotion, Guard, Time, guard_in_open_space};
use keepout_kernel::{Curve, Point, Segment, Vector};
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::units::mm;

use super::{SimSettings, SimulatedController, speaking};

/// A jog to a target in lattice units.
fn jog_to(x: i64, y: i64, feed_mm_min: u32) -> Command {
    let mut guard = at_origin();
    Command::Move(guard.jog(Point::from_units(x, y).unwrap().in_plane(), feed_mm_min).unwrap())
}

/// A straight contour motion from the origin to a target in lattice units.
fn contour_to(x: i64, y: i64, feed_mm_min: u32) -> Command {
    let line = Segment { from: Point::ORIGIN, to: Point::from_units(x, y).unwrap() };
    let mut guard = at_origin();
    guard.begin_contour(vec![ContourMotion::in_plane(Curve::Line(line), feed_mm_min)]).unwrap();
    guard.certify_contour(1).unwrap();
    Command::Move(guard.next_of_contour().unwrap())
}

fn at_origin() -> Guard {
    let mut guard = guard_in_open_space().unwrap();
    guard.locate(Point::ORIGIN.in_plane()).unwrap();
    guard
}

struct Pair {
    dialect: Box<dyn Dialect>,
    sim: Box<dyn SimulatedController>,
    now: Time,
    bytes: Vec<u8>,
}

impl Pair {
    fn new(language: &DialectName, offset: Vector) -> Self {
        let machine = MachineProfile::simulated();
        let setting = DialectConfig::of(&machine, offset);
        let settings = SimSettings {
            work_offset_mm: Mm2::new(-30.0, -20.0).at_height(0.0),
            ..SimSettings::of(machine, Mm2::new(-10.0, -10.0).at_height(0.0))
        };
        let sim = speaking(language, settings);
        Self { dialect: language.dialect(setting), sim, now: Time::ZERO, bytes: Vec::new() }
    }

    /// Sends a command, and waits for the wanted reply.
    fn say(&mut self, command: &Command, wanted: impl Fn(&Reply) -> bool) -> Reply {
        self.dialect.encode(command, &mut self.bytes).unwrap();
        for _ in 0..100_000 {
            std::mem::take(&mut self.bytes).into_iter().for_each(|byte| self.sim.receive(byte));
            self.now = self.now.after(Duration::from_millis(1));
            self.sim.advance(self.now);
            let mut received = Vec::new();
            self.sim.transmit(&mut received);
            let replies: Vec<Reply> =
                received.into_iter().filter_map(|byte| self.dialect.decode(byte, &mut self.bytes)).collect();
            for reply in replies {
                assert!(
                    !matches!(reply, Reply::Garbled(_) | Reply::Refused { .. }),
                    "{command:?}: {reply:?}"
                );
                if wanted(&reply) {
                    return reply;
                }
            }
        }
        panic!("no answer to {command:?}");
    }

    fn report(&mut self) -> keepout_executor::supervisor::Report {
        let Reply::Report(report) = self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_)))
        else {
            panic!("no report");
        };
        report
    }

    fn place_mm(&mut self) -> Mm2 {
        let mut samples = Vec::new();
        self.sim.take_samples(&mut samples);
        samples.last().unwrap().position_mm.plane()
    }
}

/// Moves to points of the lattice, and compares the machine's position and the report.
fn through(language: &str) {
    let language = DialectName::named(language).unwrap();
    let mut random = fastrand::Rng::with_seed(11);
    let offset = Vector { dx: -30_012_345, dy: -20_000_007 };
    let mut pair = Pair::new(&language, offset);
    pair.report();
    pair.say(&Command::Prepare, |reply| matches!(reply, Reply::Prepared(..)));
    pair.say(&Command::Arm, |reply| matches!(reply, Reply::Armed));
    let half_step_mm = 0.5 / MachineProfile::simulated().steps_per_mm + 2e-5;
    for round in 0..60 {
        let to = (random.i64(0..20_000_000), random.i64(0..15_000_000));
        let make = if round % 2 == 0 { jog_to } else { contour_to };
        pair.say(&make(to.0, to.1, 60 + random.u32(0..12_000)), |reply| *reply == Reply::Accepted);
        let report = loop {
            let report = pair.report();
            if report.mode == Mode::Idle && report.position.is_some() {
                break report;
            }
        };
        let at = Point::from_units(to.0, to.1).unwrap();
        let Mm2 { x, y } = pair.place_mm();
        let off = |is: f64, units: i32| (is - mm(units)).abs();
        let machine = at.translated(offset).unwrap();
        assert!(off(x, machine.x.units()) <= half_step_mm && off(y, machine.y.units()) <= half_step_mm);
        let reported = report.position.unwrap().point.minus(at);
        // Half a step for the target, and half a step or half the last digit for the report.
        let most = 4.0 * half_step_mm;
        assert!(mm(reported.dx).abs() <= most && mm(reported.dy).abs() <= most, "{reported:?}");
    }
}

#[test]
fn grbl() {
    through("grbl");
    through("grblhal");
}

#[test]
fn zaber() {
    through("zaber");
}

#[test]
fn venus() {
    through("venus");
}

#[test]
fn described() {
    for file in ["nsk-style", "tango", "../sim/tests/described/ok-style", "../sim/tests/described/one-answer"]
    {
        through(&format!("{}/../dialects/{file}.toml", env!("CARGO_MANIFEST_DIR")));
    }
}
