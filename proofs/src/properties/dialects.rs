//! Dialects: decoding accepts any bytes, and reads and writes exactly.

use std::sync::{Arc, OnceLock};

use keepout_executor::dialect::{Described, Description, Dialect, DialectConfig, Grbl, Venus, Zaber};
use keepout_executor::supervisor::{Command, Mode, Reply};
use keepout_guard::guard_in_open_space;
use keepout_kernel::Vector;

use super::Xy;
use crate::draw::Draw;
use crate::families::at;
use crate::property::properties;

properties! {
    "dialects", "executor/src/dialect/";
    // Evidence for SR-18.
    short_byte_strings_are_decoded |d| {
        let (which, begin) = (d.one_of(DIALECTS), d.one_of(BEGINNINGS.len()));
        let bytes: Vec<u8> = (0..2).map(|_| byte(d)).collect();
        bytes_are_decoded(which, begin, &bytes)
    }
        => "decoding takes every string of two bytes after each beginning of an exchange, in each \
            dialect: no panic, bounded output";
        every 1 random 20_000;
    strings_of_telling_bytes_are_decoded |d| {
        let (which, begin) = (d.one_of(DIALECTS), d.one_of(BEGINNINGS.len()));
        let bytes: Vec<u8> = (0..3).map(|_| TELLING[d.one_of(TELLING.len())]).collect();
        bytes_are_decoded(which, begin, &bytes)
    }
        => "the same for every string of three bytes that mean something in some dialect";
        every 1 random 20_000;
    long_byte_strings_are_decoded |d| {
        let (which, begin, count) = (d.one_of(DIALECTS), d.one_of(BEGINNINGS.len()), d.one_of(600));
        let bytes: Vec<u8> = (0..count)
            .map(|_| if d.one_of(4) == 0 { byte(d) } else { TELLING[d.one_of(TELLING.len())] })
            .collect();
        bytes_are_decoded(which, begin, &bytes)
    }
        => "the same for strings of up to 599 bytes, longer than any line";
        random 20_000;
    only_ok_accepts |d| {
        let bytes: Vec<u8> =
            (0..3).map(|_| [b'o', b'k', b' ', b'O', b'\r', b'x', b'0'][d.one_of(7)]).collect();
        only_ok_accepts(&bytes)
    }
        => "GRBL: a line counts as an acknowledgement exactly when its text is `ok`";
        every 1 random 5_000;
    answer_to_a_spindle_switch_accepts_no_motion |d| {
        let between: Vec<&[u8]> = (0..d.one_of(4)).map(|_| BETWEEN[d.one_of(BETWEEN.len())]).collect();
        answer_to_a_spindle_switch_accepts_no_motion(d.one_of(2) == 1, &between)
    }
        => "GRBL: the first answer after a switch of the spindle is taken for the switch, and acknowledges no \
            motion, whatever is reported between; the answer after it acknowledges a motion";
        every 1 random 5_000;
    // Evidence for SR-17.
    jogs_are_written_exactly |d|
        jogs_are_written_exactly(
            (d.int(-(1 << 28), 1 << 28), d.int(-(1 << 28), 1 << 28)),
            [d.int(-(1 << 28), 1 << 28), d.int(-(1 << 28), 1 << 28)],
        )
        => "GRBL: a jog's target is written as the certified one in machine coordinates, to the last \
            unit; the line is shorter than half of the smallest receive buffer";
        random 50_000;
    positions_are_read_exactly |d|
        positions_are_read_exactly((d.int(-4_000_000, 4_000_000), d.int(-4_000_000, 4_000_000)))
        => "GRBL: a reported position is read exactly, and converted to drawing coordinates";
        random 50_000;
}

const DIALECTS: usize = 5;
/// Beginnings of answers, each with the number of the command that is sent first.
const BEGINNINGS: [(usize, &[u8]); 9] = [
    (0, b""),
    (0, b"<Idle|MPos:1.000,2.0"),
    (0, b"<Run|Bf:15,12"),
    (1, b"ok\r\n$100="),
    (2, b"ok\r\n[G54:1.000,"),
    (0, b"erro"),
    (0, b"@01 0 00 OK IDLE -- "),
    (1, b"12.5 -3.0\r\n1"),
    (3, b"\x00\xff\n>:"),
];
const TELLING: &[u8] = b"\r\n:<>|[]$=,.-+0159 @#okIMWBaEG\x00\x7f\xff";

fn byte<D: Draw>(d: &mut D) -> u8 {
    u8::try_from(d.int(0, 255)).unwrap_or(0)
}

fn config() -> DialectConfig {
    DialectConfig {
        offset: Vector { dx: -12_345_600, dy: 700 },
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.0005,
        travel_mm: Some([400.0, 350.0]),
        z: None,
        spindle_rpm: Some(10_000),
    }
}

fn dialect(which: usize) -> Box<dyn Dialect> {
    static DESCRIPTION: OnceLock<Arc<Description>> = OnceLock::new();
    match which {
        0 => Box::new(Grbl::new(config())),
        1 => Box::new(Grbl::hal(config())),
        2 => Box::new(Zaber::new(config())),
        3 => Box::new(Venus::new(config())),
        _ => {
            let text = include_str!("../../../executor/dialects/nsk-style.toml");
            let description =
                DESCRIPTION.get_or_init(|| Arc::new(Description::of(text).expect("it is described")));
            Box::new(Described::new(Arc::clone(description), config()))
        }
    }
}

fn bytes_are_decoded(which: usize, beginning: usize, bytes: &[u8]) {
    let mut dialect = dialect(which);
    let (command, first) = BEGINNINGS[beginning];
    let mut out = Vec::new();
    let commands = [Command::Query, Command::Prepare, Command::Arm, Command::Abort];
    let _ = dialect.encode(&commands[command], &mut out);
    for &byte in first.iter().chain(bytes) {
        let before = out.len();
        let _ = dialect.decode(byte, &mut out);
        assert!(out.len() - before < 1000, "{which} {beginning} {bytes:?}: unbounded output");
    }
    dialect.reset();
    let _ = dialect.decode(b'\n', &mut out);
}

/// A GRBL dialect that is ready for motions.
fn ready() -> Grbl {
    let mut grbl = Grbl::new(config());
    let mut out = Vec::new();
    for command in [Command::Prepare, Command::Arm] {
        grbl.encode(&command, &mut out).expect("the command moves no axis");
        let answer: &[u8] = match command {
            Command::Prepare => {
                // The arc tolerance is stored, and then everything is read back.
                b"ok\r\n[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\nok\r\n$10=3\r\n$12=0.002\r\n$13=0\r\n\
                  $22=1\r\n$100=400\r\n$101=400\r\nok\r\n$N0=\r\n$N1=G80\r\nok\r\nok\r\n$10=3\r\n\
                  $12=0.001\r\n$13=0\r\n$22=1\r\n$100=400\r\n$101=400\r\nok\r\n$N0=\r\n$N1=G80\r\nok\r\n"
            }
            _ => {
                b"ok\r\nok\r\n[G54:0.000,0.000,0.000]\r\n[G92:0.000,0.000,0.000]\r\nok\r\n\
                  <Idle|MPos:0.000,0.000,0.000|Bf:15,128|WCO:0.000,0.000,0.000>\r\n\
                  <Idle|MPos:0.000,0.000,0.000|Bf:15,128>\r\n"
            }
        };
        let replies: Vec<Reply> = answer.iter().filter_map(|&byte| grbl.decode(byte, &mut out)).collect();
        assert!(matches!(replies[0], Reply::Prepared(_) | Reply::Armed), "{replies:?}");
    }
    grbl
}

fn only_ok_accepts(bytes: &[u8]) {
    let mut grbl = ready();
    let mut out = Vec::new();
    let mut line = bytes.to_vec();
    line.push(b'\n');
    let accepted =
        line.iter().filter_map(|&byte| grbl.decode(byte, &mut out)).any(|reply| reply == Reply::Accepted);
    let text: Vec<u8> = bytes.iter().copied().filter(|&byte| byte != b'\r').collect();
    assert_eq!(accepted, text == b"ok", "{bytes:?}");
}

/// Lines that a controller can send by itself.
const BETWEEN: [&[u8]; 4] = [
    b"<Idle|MPos:1.000,2.000,0.000|Bf:15,128|FS:0,10000>\r\n",
    b"[MSG:Pgm End]\r\n",
    b"\r\n",
    b">G54:ok\r\n",
];

fn answer_to_a_spindle_switch_accepts_no_motion(runs: bool, between: &[&[u8]]) {
    let mut grbl = ready();
    let mut out = Vec::new();
    grbl.encode(&Command::Spindle { runs }, &mut out).expect("the session switches the spindle");
    assert_eq!(out, if runs { &b"M3S10000\n"[..] } else { b"M5\n" });
    let lines = between.iter().copied().chain([&b"ok\r\n"[..], b"ok\r\n"]);
    let answers: Vec<Reply> = lines
        .flatten()
        .filter_map(|&byte| grbl.decode(byte, &mut out))
        .filter(|reply| matches!(reply, Reply::SpindleSwitched | Reply::Accepted))
        .collect();
    assert_eq!(answers, [Reply::SpindleSwitched, Reply::Accepted], "{between:?}");
}

/// Lattice units from text in mm, read digit by digit.
fn units(text: &str) -> i64 {
    let (sign, text) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let padded = format!("{fraction:0<5}");
    assert_eq!(padded.len(), 5, "no more than five decimals: {text}");
    sign * (whole.parse::<i64>().expect("digits") * 100_000 + padded.parse::<i64>().expect("digits"))
}

fn jogs_are_written_exactly(to: Xy, offset: [i64; 2]) {
    let narrow = |c: i64| i32::try_from(c).unwrap_or(0);
    let offset = Vector { dx: narrow(offset[0]), dy: narrow(offset[1]) };
    let mut grbl = Grbl::new(DialectConfig { offset, ..config() });
    let mut guard = guard_in_open_space().expect("a triangle is a region");
    guard.locate(at((0, 0)).in_plane()).expect("it is clear");
    let certified = guard.jog(at(to).in_plane(), 6000).expect("it is clear");
    let mut out = Vec::new();
    let encoded = grbl.encode(&Command::Move(certified), &mut out);
    let machine = (to.0 + i64::from(offset.dx), to.1 + i64::from(offset.dy));
    assert!(encoded.is_ok(), "both are within half of the lattice");
    let text = std::str::from_utf8(&out).expect("ASCII");
    let words = text.strip_prefix("$J=G53G90G21X").and_then(|rest| rest.strip_suffix("F6000\n"));
    let (x, y) = words.and_then(|words| words.split_once('Y')).expect("two words");
    assert_eq!((units(x), units(y)), machine, "{text}");
    assert!(2 * text.len() < 127, "{text}");
}

fn positions_are_read_exactly(thousandths: Xy) {
    let mut grbl = ready();
    let mut out = Vec::new();
    let written = |c: i64| {
        let sign = if c < 0 { "-" } else { "" };
        format!("{sign}{}.{:03}", c.abs() / 1000, c.abs() % 1000)
    };
    let line =
        format!("<Jog|MPos:{},{},0.000|Bf:14,128>\r\n", written(thousandths.0), written(thousandths.1));
    let replies: Vec<Reply> = line.bytes().filter_map(|byte| grbl.decode(byte, &mut out)).collect();
    let [Reply::Report(report)] = replies[..] else { panic!("{line}: {replies:?}") };
    assert!(report.mode == Mode::Moving && report.waiting == Some(false), "{line}: {report:?}");
    let offset = config().offset;
    let place = (thousandths.0 * 100 - i64::from(offset.dx), thousandths.1 * 100 - i64::from(offset.dy));
    assert_eq!(report.position, Some(at(place).in_plane()), "{line}");
}
