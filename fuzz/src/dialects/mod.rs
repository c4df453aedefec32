//! Dialects: decoding of any bytes, and motions there and back.

mod says;
mod trip;

use std::sync::{Arc as Shared, OnceLock};

use keepout_executor::dialect::{Described, Description, Dialect, DialectConfig, Grbl, Venus, Zaber};
use keepout_executor::supervisor::{Command, Reply};
use keepout_guard::{Certification, Certified, ContourMotion, guard_in_open_space};
use keepout_kernel::{Arc, Curve, Place, Point, Segment, Turn, Vector};
use says::{Heard, Says};
pub use trip::round_trip;

/// Commands that move nothing.
pub const COMMANDS: [Command; 8] = [
    Command::Query,
    Command::Prepare,
    Command::Home,
    Command::Arm,
    Command::EndHoming,
    Command::Abort,
    Command::Spindle { runs: true },
    Command::Spindle { runs: false },
];

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
        spindle_rpm: Some(10_000),
    }
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
