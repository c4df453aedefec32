//! Dialects: decoding of any bytes, and motions there and back.

mod says;

use std::sync::{Arc as Shared, OnceLock};
use std::time::Duration;

use crate::oracle::xy;
use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::dialect::{
    Described, Description, Dialect, DialectConfig, DialectName, DialectZ, Grbl, Venus, Zaber,
};
use keepout_executor::supervisor::{Command, Mode, Reply};
use keepout_guard::{Certification, Certified, ContourMotion, Time, guard_in_open_space};
use keepout_kernel::curve::fit_arc;
use keepout_kernel::{Arc, Curve, Height, Place, Point, Segment, Turn, Vec2, Vector};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::units::{mm, vector_mm};
use keepout_planner::{Mm2, Mm3};
use keepout_sim::{SimSettings, SimulatedController, speaking};
use says::{Heard, Says};

use crate::oracle::{self, UNIT};

/// Commands that move nothing.
pub const COMMANDS: [Command; 6] =
    [Command::Query, Command::Prepare, Command::Home, Command::Arm, Command::EndHoming, Command::Abort];

/// Bytes from this one on stand for commands, the others for the controller's output.
const FIRST_COMMAND: u8 = 0xf0;
/// The byte for a stop command.
const STOP: u8 = 0xf4;
/// The byte for opening the port again.
const RESET: u8 = 0xf8;
/// Largest number of bytes that a dialect may send for one received byte.
const SENT_MAX: usize = 1000;

/// The descriptions under test: the shipped ones, and those of the tests.
const DESCRIPTIONS: [&str; 4] = [
    include_str!("../../../executor/dialects/nsk-style.toml"),
    include_str!("../../../executor/dialects/tango.toml"),
    include_str!("../../../executor/sim/tests/described/ok-style.toml"),
    include_str!("../../../executor/sim/tests/described/one-answer.toml"),
];

/// Travel of the machine of [`dialect_config`], mm.
pub const TRAVEL_MM: [f64; 2] = [400.0, 350.0];

/// The configuration of the dialects in these tests.
#[must_use]
pub fn dialect_config() -> DialectConfig {
    DialectConfig {
        offset: Vector { dx: -12_345_600, dy: 700 },
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.0005,
        travel_mm: Some(TRAVEL_MM),
        z: None,
    }
}

/// A description with a third axis.
fn three_axes() -> Shared<Description> {
    static ONE: OnceLock<Shared<Description>> = OnceLock::new();
    let text = include_str!("../../../executor/sim/tests/described/three-axes.toml");
    Shared::clone(ONE.get_or_init(|| Shared::new(Description::of(text).expect("it is one of ours"))))
}

fn description(which: usize) -> Shared<Description> {
    static ALL: OnceLock<Vec<Shared<Description>>> = OnceLock::new();
    let read = |text: &&str| Shared::new(Description::of(text).expect("it is one of ours"));
    let all = ALL.get_or_init(|| DESCRIPTIONS.iter().map(read).collect());
    Shared::clone(&all[which % all.len()])
}

/// Decodes any bytes from a GRBL or grblHAL controller, at any stage of a session, with commands between
/// them. The output is bounded. Every reply is justified by its line. After a reset the dialect understands
/// a line, whatever came before.
///
/// # Panics
/// When one of these does not hold.
pub fn grbl_decode(bytes: &[u8]) {
    let Some((hal, rest)) = bytes.split_first() else { return };
    let grbl = if hal & 1 == 0 { Grbl::new(dialect_config()) } else { Grbl::hal(dialect_config()) };
    let mut grbl = talk(grbl, rest, says::GrblCheck::default(), false);
    inspects(&grbl, rest);
    grbl.reset();
    let (report, mut out) = (b"<Idle|MPos:-123.456,0.007,0.000>\r\n", Vec::new());
    let replies: Vec<Reply> = report.iter().filter_map(|&byte| grbl.decode(byte, &mut out)).collect();
    let [Reply::Report(report)] = replies[..] else { panic!("after a reset: {replies:?}") };
    assert_eq!(report.position, Some(Point::ORIGIN.in_plane()));
}

/// Gives the same lines to the inspector.
fn inspects(dialect: &dyn Dialect, bytes: &[u8]) {
    let Some(mut inspector) = dialect.inspector() else { return };
    assert!(inspector.questions().iter().all(|question| question.len() < SENT_MAX));
    for line in bytes.split(|&byte| byte == b'\n') {
        let text = String::from_utf8_lossy(line);
        let _ = inspector.hear(text.trim_end());
    }
    let DialectConfig { steps_per_mm, arc_tolerance_mm, .. } = dialect_config();
    let found = inspector.inspected(steps_per_mm, arc_tolerance_mm);
    assert!(found.findings.iter().all(|finding| !finding.name.is_empty() && finding.value.len() < 4000));
}

/// Decodes any bytes from a Zaber controller. The output is bounded. The dialect accepts no line with a
/// wrong checksum, or without one once checksums are agreed. Positions are those of the line.
///
/// The fuzzer cannot guess message numbers and checksums. So `0xEE` stands for the number of the last line
/// sent, and `0xEF` for the right checksum and the line's end.
///
/// # Panics
/// When one of these does not hold.
pub fn zaber_decode(bytes: &[u8]) {
    let mut talk = Talk::new(Zaber::new(dialect_config()), says::ZaberCheck::default());
    for &byte in bytes {
        match byte {
            0xee => {
                let said = talk.out.windows(5).rposition(|said| said == b"/1 0 ");
                let digits = said.and_then(|at| talk.out.get(at + 5..at + 7)).unwrap_or(b"00").to_vec();
                digits.into_iter().for_each(|digit| talk.takes(digit));
            }
            0xef => {
                let sum = says::zaber_sum(talk.heard.line.get(1..).unwrap_or_default());
                format!(":{sum:02X}\n").bytes().for_each(|byte| talk.takes(byte));
            }
            _ => talk.takes(byte),
        }
    }
}

/// Decodes any bytes from a Venus-1 controller. The output is bounded. Positions are those of the line, and
/// the machine is at rest where the status states it.
///
/// # Panics
/// When one of these does not hold.
pub fn venus_decode(bytes: &[u8]) {
    talk(Venus::new(dialect_config()), bytes, says::venus, false);
}

/// Decodes any bytes from a controller that a file describes. The first byte chooses the file. The output
/// is bounded. Some line since the last report states the position and the rest.
///
/// # Panics
/// When one of these does not hold.
pub fn described_decode(bytes: &[u8]) {
    let Some((&which, rest)) = bytes.split_first() else { return };
    let dialect = Described::new(description(which.into()), dialect_config());
    talk(dialect, rest, says::DESCRIBED[usize::from(which) % says::DESCRIBED.len()], true);
}

/// Receives bytes and sends commands in turn. Carriage returns end lines if `returns` is set, otherwise
/// they are ignored.
fn talk<D: Dialect>(dialect: D, bytes: &[u8], says: impl Says, returns: bool) -> D {
    let mut talk = Talk::new(dialect, says);
    talk.heard.returns = returns;
    bytes.iter().for_each(|&byte| talk.takes(byte));
    talk.dialect
}

/// A dialect with the bytes sent and received.
struct Talk<D, S> {
    dialect: D,
    says: S,
    out: Vec<u8>,
    heard: Heard,
}

impl<D: Dialect, S: Says> Talk<D, S> {
    fn new(dialect: D, says: S) -> Self {
        Self { dialect, says, out: Vec::new(), heard: Heard::default() }
    }

    /// Takes a byte from the controller, or sends a command.
    fn takes(&mut self, byte: u8) {
        if byte >= FIRST_COMMAND {
            let before = self.out.len();
            say(&mut self.dialect, byte - FIRST_COMMAND, &mut self.out);
            self.says.said(&self.heard, false, &self.out[before..]);
            self.heard.stopped |= byte == STOP && self.out.len() > before;
            if byte == RESET {
                self.heard = Heard { returns: self.heard.returns, ..Heard::default() };
                self.says.forget();
            }
            return;
        }
        let ended = self.heard.takes(byte);
        let before = self.out.len();
        let reply = self.dialect.decode(byte, &mut self.out);
        let said = &self.out[before..];
        assert!(said.len() < SENT_MAX, "unbounded output");
        self.says.said(&self.heard, ended, said);
        if let Some(reply) = &reply {
            self.says.is_right(&self.heard, reply);
        }
        self.heard.goes_on(ended, reply.as_ref());
    }
}

fn say(dialect: &mut dyn Dialect, which: u8, out: &mut Vec<u8>) {
    let before = out.len();
    let command = match COMMANDS.get(usize::from(which)) {
        Some(command) => *command,
        None if FIRST_COMMAND + which == RESET => return dialect.reset(),
        None => Command::Move(moves()[usize::from(which) % 3]),
    };
    if dialect.encode(&command, out).is_err() {
        assert_eq!(out.len(), before, "half a command was sent");
    }
}

/// A jog, a straight motion of a contour and an arc, made once and sent again and again.
fn moves() -> &'static [Certified; 3] {
    static MOVES: OnceLock<[Certified; 3]> = OnceLock::new();
    MOVES.get_or_init(|| {
        let far = Point::from_units(3_000_000, -2_000_000).expect("it is small");
        let [from, far] = [Point::ORIGIN, far].map(Point::in_plane);
        [jog(from, far), straight(from, far, 600), contour(ContourMotion::in_plane(bend(), 600))]
    })
}

/// A jog through empty space.
fn jog(from: Place, to: Place) -> Certified {
    let mut guard = guard_in_open_space().expect("a triangle is a region");
    guard.locate(from).expect("it is far from everything");
    guard.jog(to, 1200).expect("it is far from everything")
}

/// A straight motion of a contour through empty space.
fn straight(from: Place, to: Place, feed_mm_min: u32) -> Certified {
    let curve = Curve::Line(Segment { from: from.point, to: to.point });
    contour(ContourMotion { curve, heights: [from.height, to.height], feed_mm_min })
}

/// A quarter of a circle from the origin.
fn bend() -> Curve {
    let at = |x, y| Point::from_units(x, y).expect("it is small");
    Curve::Arc(
        Arc::new(Point::ORIGIN, at(500_000, 500_000), at(0, 500_000), Turn::CounterClockwise)
            .expect("it is round"),
    )
}

fn contour(motion: ContourMotion) -> Certified {
    let mut guard = guard_in_open_space().expect("a triangle is a region");
    guard.locate(motion.from()).expect("it is far from everything");
    guard.begin_contour(vec![motion]).expect("it begins where the tool is");
    assert_eq!(guard.certify_contour(usize::MAX), Ok(Certification::Done));
    guard.next_of_contour().expect("it is the first")
}

/// About a quarter of a circle from `from` to `to`, with the centre beside the middle. `left` chooses the
/// direction.
fn bend_to(from: Point, to: Point, left: bool) -> Option<Arc> {
    let (a, b) = (xy(from), xy(to));
    let (dx, dy) = ((b.0 - a.0) / 2.0, (b.1 - a.1) / 2.0);
    let (nx, ny) = if left { (-dy, dx) } else { (dy, -dx) };
    fit_arc(
        from,
        to,
        Vec2::new(a.0 + dx + nx, a.1 + dy + ny),
        if left { Turn::CounterClockwise } else { Turn::Clockwise },
    )
    .ok()
}

/// Reads a dialect, a position on the table, whether a third axis moves, garbage before the session, and motions.
/// Each motion arrives at its target, in height too, and the controller reports that position.
///
/// # Panics
/// When a motion arrives elsewhere, or a report differs.
pub fn round_trip(bytes: &[u8]) {
    let _ = round_trip_of(&mut Unstructured::new(bytes));
}

fn round_trip_of(u: &mut Unstructured<'_>) -> Result<()> {
    let described = |description| DialectName::Described { file: "described".into(), description };
    let name = match u.int_in_range(0..=8_usize)? {
        which @ 0..=3 => DialectName::named(DialectName::NAMES[which]).expect("it is built in"),
        8 => described(three_axes()),
        other => described(description(other)),
    };
    let climbs = name.needs_third_axis() || name.has_third_axis() && bool::arbitrary(u)?;
    let reach = 15_000_000;
    let offset = Vector { dx: -u.int_in_range(reach..=2 * reach)?, dy: -u.int_in_range(reach..=2 * reach)? };
    let zero = Height::from_units(-u.int_in_range(1_000_000..=4_000_000_i64)?).expect("it is small");
    let mut trip = Trip::begin(&name, offset, climbs.then_some(zero));
    for _ in 0..u.int_in_range(0..=12_u8)? {
        trip.receives_garbage(u8::arbitrary(u)?);
    }
    trip.sets_out();
    let mut from = Point::ORIGIN.in_plane();
    for _ in 0..u.int_in_range(1..=3_u8)? {
        let (x, y) = (u.int_in_range(0..=9_000_000_i64)?, u.int_in_range(0..=9_000_000_i64)?);
        let (to, feed) = (Point::from_units(x, y).expect("it is small"), u.int_in_range(60..=12_000_u32)?);
        let height = if climbs { u.int_in_range(-4_000_000..=900_000_i64)? } else { 0 };
        let to = to.at_height(Height::from_units(height).expect("it is small"));
        let way = to.point.minus(from.point);
        if way.dx.abs().max(way.dy.abs()) < 2000 {
            continue;
        }
        // The lowest bit makes a jog. The two bits above make one in four of the other motions an arc.
        let kind = u8::arbitrary(u)?;
        let bent = (kind & 7 == 2).then(|| bend_to(from.point, to.point, kind & 8 == 0)).flatten();
        let bent = bent.filter(|_| trip.dialect.abilities().arcs);
        // The supervisor sends a ramp along an arc as chords, because a line with all words of both is too long.
        let to = if bent.is_some() { to.point.at_height(from.height) } else { to };
        let motion = match (bent, kind & 1) {
            (Some(arc), _) => {
                let heights = [from.height; 2];
                contour(ContourMotion { curve: Curve::Arc(arc), heights, feed_mm_min: feed })
            }
            (None, 1) => jog(from, to),
            (None, _) => straight(from, to, feed),
        };
        trip.goes(motion, to, offset, bent);
        from = to;
    }
    Ok(())
}

/// A dialect and the simulated controller that speaks it, with a perfect link.
struct Trip {
    dialect: Box<dyn Dialect>,
    controller: Box<dyn SimulatedController>,
    /// The machine's height of the drawing's height zero. `None`: the third axis does not move.
    zero: Option<Height>,
    now: Time,
    bytes: Vec<u8>,
}

impl Trip {
    fn begin(name: &DialectName, offset: Vector, zero: Option<Height>) -> Self {
        let simulated = MachineProfile::simulated();
        let third_axis = zero.map(|zero| (zero, ZProfile::simulated()));
        let machine = MachineProfile { z: third_axis.as_ref().map(|(_, z)| z.clone()), ..simulated };
        let stated = |(zero, z): (Height, ZProfile)| DialectZ {
            zero,
            steps_per_mm: z.steps_per_mm,
            travel_mm: Some(z.travel_mm),
        };
        let config = DialectConfig { z: third_axis.map(stated), ..DialectConfig::of(&machine, offset) };
        let up_mm = zero.map_or(0.0, |zero| mm(zero.units()));
        let settings = SimSettings {
            work_offset_mm: Mm2::new(-30.0, -20.0).at_height(if zero.is_some() { -7.0 } else { 0.0 }),
            ..SimSettings::of(machine, vector_mm(offset).at_height(up_mm))
        };
        let controller = speaking(name, settings);
        let dialect = name.dialect(config);
        Self { dialect, controller, zero, now: Time::ZERO, bytes: Vec::new() }
    }

    /// Decodes a garbage byte before the session. The output that it causes is lost.
    fn receives_garbage(&mut self, byte: u8) {
        let _ = self.dialect.decode(byte, &mut Vec::new());
    }

    fn sets_out(&mut self) {
        self.dialect.reset();
        self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_)));
        self.say(&Command::Prepare, |reply| matches!(reply, Reply::Prepared(..)));
        self.say(&Command::Arm, |reply| matches!(reply, Reply::Armed));
        let known = |reply: &Reply| matches!(reply, Reply::Report(report) if report.position.is_some());
        for _ in 0..3 {
            if known(&self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_)))) {
                return;
            }
        }
        panic!("no report states the position of the tool");
    }

    fn goes(&mut self, certified: Certified, to: Place, offset: Vector, bent: Option<Arc>) {
        self.say(&Command::Move(certified), |reply| *reply == Reply::Accepted);
        let report = loop {
            match self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_))) {
                Reply::Report(report) if report.mode == Mode::Idle => break report,
                _ => {}
            }
        };
        let mut samples = Vec::new();
        self.controller.take_samples(&mut samples);
        let Mm3 { x, y, z } = samples.last().expect("it has moved").position_mm;
        let half_step_mm = 0.5 / MachineProfile::simulated().steps_per_mm + 2e-5;
        let machine = to.point.translated(offset).expect("it is small");
        let off = (x - mm(machine.x.units())).abs().max((y - mm(machine.y.units())).abs());
        assert!(off <= half_step_mm, "{off} mm from {to:?} by {:?}", self.controller);
        let half_step_z_mm = 0.5 / ZProfile::simulated().steps_per_mm + 2e-5;
        if let Some(zero) = self.zero {
            let off = (z - mm(to.height.units()) - mm(zero.units())).abs();
            assert!(off <= half_step_z_mm, "{off} mm above or below {to:?} by {:?}", self.controller);
        }
        if let Some(arc) = bent {
            let arc = Curve::Arc(arc);
            // The margin's share for arcs.
            let most_mm = 4.0 * MachineProfile::simulated().arc_tolerance_mm + 2.0 * half_step_mm;
            for Mm3 { x, y, .. } in samples.iter().map(|sample| sample.position_mm) {
                let place = ((x - mm(offset.dx)) * UNIT, (y - mm(offset.dy)) * UNIT);
                let off = oracle::distance(place, [&arc].into_iter()) / UNIT;
                assert!(off <= most_mm, "{off} mm beside {arc:?} at {place:?}");
            }
        }
        let reported = report.position.expect("it is armed");
        let way = reported.point.minus(to.point);
        let off = mm(way.dx).abs().max(mm(way.dy).abs());
        assert!(off <= 4.0 * half_step_mm, "reported {off} mm from {to:?}");
        let off = (mm(reported.height.units()) - mm(to.height.units())).abs();
        assert!(
            self.zero.is_none() || off <= 4.0 * half_step_z_mm,
            "reported {off} mm above or below {to:?}"
        );
    }

    /// Sends a command and decodes replies until the wanted one.
    fn say(&mut self, command: &Command, wanted: impl Fn(&Reply) -> bool) -> Reply {
        self.dialect.encode(command, &mut self.bytes).expect("it is on the lattice");
        for _ in 0..200_000 {
            std::mem::take(&mut self.bytes).into_iter().for_each(|byte| self.controller.receive(byte));
            let next = self.controller.next_event().min(self.now.after(Duration::from_millis(20)));
            self.now = next.max(self.now.after(Duration::from_millis(1)));
            self.controller.advance(self.now);
            let mut heard = Vec::new();
            self.controller.transmit(&mut heard);
            for byte in heard {
                let Some(reply) = self.dialect.decode(byte, &mut self.bytes) else { continue };
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
}
