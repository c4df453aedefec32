//! Helpers for the tests of several dialects.

use keepout_guard::{ContourMotion, Guard, guard_in_open_space};
use keepout_kernel::{Curve, Height, Place, Point, Segment};

use super::Dialect;
use crate::supervisor::Command;

/// A jog to a target in lattice units.
pub(crate) fn jog_to(x: i64, y: i64, feed_mm_min: u32) -> Command {
    let mut guard = at(Point::ORIGIN.in_plane());
    Command::Move(guard.jog(Point::from_units(x, y).unwrap().in_plane(), feed_mm_min).unwrap())
}

/// A straight contour motion from the origin to a target in lattice units.
pub(crate) fn contour_to(x: i64, y: i64, feed_mm_min: u32) -> Command {
    let line = Segment { from: Point::ORIGIN, to: Point::from_units(x, y).unwrap() };
    contour_of(ContourMotion::in_plane(Curve::Line(line), feed_mm_min))
}

/// A contour of one motion.
pub(super) fn contour_of(motion: ContourMotion) -> Command {
    let mut guard = at(motion.from());
    guard.begin_contour(vec![motion]).unwrap();
    guard.certify_contour(1).unwrap();
    Command::Move(guard.next_of_contour().unwrap())
}

fn at(place: Place) -> Guard {
    let mut guard = guard_in_open_space().unwrap();
    guard.locate(place).unwrap();
    guard
}

/// A place in lattice units.
pub(super) fn place(x: i64, y: i64, z: i64) -> Place {
    Point::from_units(x, y).unwrap().at_height(Height::from_units(z).unwrap())
}

/// The text of a command, each byte as the character with its number.
pub(super) fn encoded(dialect: &mut impl Dialect, command: &Command) -> String {
    let mut out = Vec::new();
    dialect.encode(command, &mut out).unwrap();
    out.into_iter().map(char::from).collect()
}

/// Random bytes and commands give some replies and bounded output.
pub(super) fn decode_is_total(make: impl Fn() -> Box<dyn Dialect>, alphabet: &[u8]) {
    let mut random = fastrand::Rng::with_seed(7);
    let mut dialect = make();
    let mut out = Vec::new();
    for round in 0..20_000 {
        if round % 50 == 0 {
            let commands = [
                Command::Prepare,
                Command::Arm,
                Command::Home,
                Command::Abort,
                Command::EndHoming,
                Command::Query,
                jog_to(random.i64(-9_000_000..9_000_000), 5, 600),
                contour_to(random.i64(-9_000_000..9_000_000), 5, random.u32(..)),
            ];
            let _ = dialect.encode(&commands[random.usize(0..commands.len())], &mut out);
        }
        if round % 997 == 0 {
            dialect.reset();
        }
        for _ in 0..random.usize(0..40) {
            let byte =
                if random.u8(0..20) == 0 { random.u8(..) } else { alphabet[random.usize(0..alphabet.len())] };
            let before = out.len();
            let _ = dialect.decode(byte, &mut out);
            assert!(out.len() - before < 1000);
        }
        out.clear();
    }
}
