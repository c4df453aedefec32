//! The content of a line of each dialect, read a second time and in another way.

use keepout_executor::supervisor::{Mode, Reply, Report};
use keepout_kernel::Point;
use keepout_planner::units::mm;

use super::{TRAVEL_MM, dialect_config};

/// The received lines.
#[derive(Default)]
pub struct Heard {
    /// The current line, without its end.
    pub line: Vec<u8>,
    /// The non-empty lines before it since the last report.
    pub before: Vec<Vec<u8>>,
    /// A stop was sent since then. It waits for no answer, so its echo may stand anywhere.
    pub stopped: bool,
    /// Carriage returns end lines, too. Otherwise they are ignored everywhere.
    pub returns: bool,
}

impl Heard {
    /// Takes a byte and returns whether it ends the line. Other bytes join the line, except carriage
    /// returns.
    pub fn takes(&mut self, byte: u8) -> bool {
        let ends = byte == b'\n' || self.returns && byte == b'\r';
        if !ends && byte != b'\r' {
            self.line.push(byte);
        }
        ends
    }

    /// Updates the lines after a byte was checked.
    pub fn goes_on(&mut self, ended: bool, reply: Option<&Reply>) {
        if matches!(reply, Some(Reply::Report(_))) {
            self.before.clear();
            self.stopped = false;
        }
        if ended && !self.line.is_empty() {
            self.before.push(std::mem::take(&mut self.line));
        }
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.line).trim().to_string()
    }

    /// All lines since the last report.
    fn all(&self) -> impl Iterator<Item = String> {
        self.before.iter().chain([&self.line]).map(|line| String::from_utf8_lossy(line).trim().to_string())
    }
}

/// A check of replies.
pub trait Says {
    /// The port was opened again.
    fn forget(&mut self) {}

    /// Takes the bytes that the dialect sent after the last byte, and whether that byte ended the line.
    fn said(&mut self, _heard: &Heard, _ended: bool, _said: &[u8]) {}

    /// Checks a reply.
    fn is_right(&mut self, heard: &Heard, reply: &Reply);
}

impl<F: FnMut(&Heard, &Reply)> Says for F {
    fn is_right(&mut self, heard: &Heard, reply: &Reply) {
        self(heard, reply);
    }
}

/// GRBL: every reply agrees with its line. The queued and waiting numbers are the difference to the free
/// buffers that two reports at rest in a row stated.
#[derive(Default)]
pub struct GrblCheck {
    /// Free blocks and bytes of the last report at rest.
    last: Option<[u64; 2]>,
    /// Free blocks and bytes that two reports in a row stated, at any time. A new session learns them
    /// again.
    agreed: Vec<[u64; 2]>,
}

impl Says for GrblCheck {
    fn is_right(&mut self, heard: &Heard, reply: &Reply) {
        let text = String::from_utf8_lossy(&heard.line);
        let text = text.as_ref();
        match reply {
            Reply::Accepted | Reply::Armed | Reply::Homed | Reply::SpindleSwitched => {
                assert_eq!(text, "ok", "{reply:?}")
            }
            Reply::Refused { .. } => assert!(text.starts_with("error:"), "{reply:?} from {text:?}"),
            Reply::Alarm { .. } => assert!(text.starts_with("ALARM:"), "{reply:?} from {text:?}"),
            Reply::Report(report) => self.reported(report, text),
            _ => {}
        }
    }
}

impl GrblCheck {
    fn reported(&mut self, report: &Report, text: &str) {
        let rests = text.split(['|', ':', '>']).next() == Some("<Idle");
        assert_eq!(report.mode == Mode::Idle, rests, "{report:?} from {text:?}");
        let said = text.split_once("|Bf:").and_then(|(_, rest)| rest.split(['|', '>']).next());
        let free = said.map(|said| {
            let mut figures = said.split(',').map(|figure| figure.parse::<u64>().expect("it was believed"));
            [figures.next().expect("there is one"), figures.next().expect("there are two")]
        });
        if let Some(free) = free.filter(|_| rests)
            && self.last.replace(free) == Some(free)
            && !self.agreed.contains(&free)
        {
            self.agreed.push(free);
        }
        if let Some((queued, waiting)) = report.queued.map(|queued| queued as u64).zip(report.waiting) {
            let free = free.unwrap_or_else(|| panic!("{report:?} from {text:?}, which states no buffers"));
            let holds = |all: &[u64; 2]| {
                all[0].checked_sub(free[0]) == Some(queued)
                    && all[1].checked_sub(free[1]).is_some_and(|bytes| (bytes > 0) == waiting)
            };
            assert!(self.agreed.iter().any(holds), "{report:?} from {text:?}, of {:?}", self.agreed);
        }
        let Some(at) = report.position else { return };
        let place = text.split_once("|MPos:").and_then(|(_, rest)| two(rest, ','));
        let [x, y] = place.unwrap_or_else(|| panic!("a place from {text:?}"));
        is_there(at.point, [x, y], text);
    }
}

/// The two's complement of the sum of the bytes.
pub fn zaber_sum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte)).wrapping_neg()
}

/// Zaber: facts about the controller.
#[derive(Default)]
pub struct ZaberCheck {
    /// Answers carry a checksum.
    checked: bool,
    /// The number of the line that queries the machine's zero, until the answer.
    asked: Option<u8>,
    /// The machine's zero, microsteps.
    zero: Option<[f64; 2]>,
    /// Both values before this line, if the line answered the query.
    before: Option<(u8, Option<[f64; 2]>)>,
}

impl Says for ZaberCheck {
    fn forget(&mut self) {
        *self = Self::default();
    }

    fn said(&mut self, heard: &Heard, ended: bool, said: &[u8]) {
        self.before = None;
        let text = if ended { heard.text() } else { String::new() };
        let words: Vec<&str> = text.split(' ').take(4).collect();
        if let [device, _, number, status] = words[..]
            && device.starts_with('@')
            && let Some(asked) = self.asked.filter(|asked| number.parse() == Ok(*asked))
        {
            self.before = Some((asked, self.zero));
            self.zero = zaber_counts(&text).filter(|_| status == "OK").or(self.zero);
            self.asked = None;
        }
        // One line is in transit at a time. Another line sent means that this one was answered or given up.
        for line in String::from_utf8_lossy(said).lines() {
            let number = line.split_once(" get limit.max").map(|(head, _)| head.replace("/1 0 ", ""));
            // The dialect queries it once the controller has agreed to checksums.
            self.checked |= number.is_some();
            self.asked = number.and_then(|number| number.parse().ok());
        }
    }

    fn is_right(&mut self, heard: &Heard, reply: &Reply) {
        let (line, text) = (&heard.line, heard.text());
        if matches!(reply, Reply::Garbled(_)) {
            if let Some((asked, zero)) = self.before {
                (self.asked, self.zero) = (self.asked.or(Some(asked)), zero);
            }
            return;
        }
        let Some(colon) = line.iter().rposition(|&byte| byte == b':') else {
            assert!(!self.checked, "{reply:?} from {text:?}, without a checksum");
            return;
        };
        let stated =
            std::str::from_utf8(&line[colon + 1..]).ok().and_then(|sum| u8::from_str_radix(sum, 16).ok());
        assert_eq!(stated, Some(zaber_sum(&line[1..colon])), "{reply:?} from {text:?}");
        if matches!(reply, Reply::Prepared(..)) {
            let zero = self.zero.unwrap_or_else(|| panic!("fit without a travel, at {text:?}"));
            let off = |k: usize| zero[k] / dialect_config().steps_per_mm / TRAVEL_MM[k] - 1.0;
            assert!(off(0).abs().max(off(1).abs()) < 0.020_1, "fit with a travel of {zero:?} microsteps");
        }
        let Reply::Report(report) = reply else { return };
        assert!(report.mode != Mode::Idle || text.contains(" IDLE "), "{report:?} from {text:?}");
        let Some(at) = report.position else { return };
        let counts = zaber_counts(&text).unwrap_or_else(|| panic!("a place from {text:?}"));
        let zero = self.zero.unwrap_or_else(|| panic!("a place without a zero, from {text:?}"));
        let axis = |k: usize| (counts[k] - zero[k]) / dialect_config().steps_per_mm;
        is_there(at.point, [axis(0), axis(1)], &text);
    }
}

/// The two numbers after the warning of `@01 0 07 OK IDLE -- 12345 678:8F`.
fn zaber_counts(text: &str) -> Option<[f64; 2]> {
    let (content, _) = text.rsplit_once(':').unwrap_or((text, ""));
    let data = content.splitn(7, ' ').last()?.trim();
    let mut words = data.split(' ').map(|word| word.parse().ok());
    Some([words.next()??, words.next()??])
}

/// Venus-1: the position is the line's. The machine is at rest if the last number before it is even.
pub fn venus(heard: &Heard, reply: &Reply) {
    let text = heard.text();
    let Reply::Report(report) = reply else { return };
    let lines: Vec<String> = heard.all().collect();
    let status = lines.iter().rev().nth(1).and_then(|status| status.parse::<u64>().ok());
    assert_eq!(status.map(|status| status.is_multiple_of(2)), Some(report.mode == Mode::Idle), "{lines:?}");
    if let Some(at) = report.position {
        let place = two(&text, ' ').unwrap_or_else(|| panic!("a place from {text:?}"));
        is_there(at.point, place, &text);
    }
}

/// A second reading of a description's lines: whether a line states rest, and the position in mm from two
/// numbers.
struct Reading {
    rests: fn(&str) -> Option<bool>,
    place_mm: fn(f64, f64) -> [f64; 2],
    place_in: PlaceIn,
    /// Letters that may follow a number directly.
    letters: &'static str,
}

/// The line that holds the position.
#[derive(Clone, Copy, PartialEq)]
enum PlaceIn {
    /// In the line of the state.
    State,
    /// In a later line.
    Later,
    /// In some other line. Echoes and prompts may be torn into any line.
    Other,
}

/// The checks of the descriptions, in order.
pub const DESCRIBED: [fn(&Heard, &Reply); 4] = [
    |heard, reply| {
        let rests = |line: &str| line.parse::<u32>().ok().map(|status| status == 0 && line == "0");
        let place_mm = |a: f64, b: f64| [a / 1e3 - 400.0, b / 1e3 - 350.0];
        described(heard, reply, &Reading { rests, place_mm, place_in: PlaceIn::Other, letters: "" });
    },
    |heard, reply| {
        let rests = |line: &str| {
            let says = line.contains(|letter: char| letter.is_ascii_alphabetic() || letter == '@');
            says.then(|| line.contains("@@") && !line.contains(['M', 'C', 'S', 'A']))
        };
        described(
            heard,
            reply,
            &Reading { rests, place_mm: |a, b| [a, b], place_in: PlaceIn::Later, letters: "" },
        );
    },
    |heard, reply| {
        let state = |line: &str| Some(line.strip_prefix('<')?.strip_suffix('>')?.trim() == "Idle");
        described(
            heard,
            reply,
            &Reading { rests: state, place_mm: |a, b| [a, b], place_in: PlaceIn::Later, letters: "Y" },
        );
    },
    |heard, reply| {
        let rests =
            |line: &str| numbers(line, "AB").first().map(|status| status % 2.0 == 0.0 && status % 16.0 < 8.0);
        // Its second axis is our x. Its first axis, reversed, is our y.
        let place_mm = |a: f64, b: f64| [(b - 7000.0) / 1250.0, -(a + 2000.0) / 1250.0];
        described(heard, reply, &Reading { rests, place_mm, place_in: PlaceIn::State, letters: "AB" });
    },
];

fn described(heard: &Heard, reply: &Reply, reading: &Reading) {
    let Reply::Report(report) = reply else { return };
    let lines: Vec<String> =
        heard.all().map(|line| line.trim_start_matches(':').trim().to_string()).collect();
    let (last, before) = lines.split_last().expect("it was read from a line");
    let rests = match reading.place_in {
        _ if heard.stopped => Some(lines.iter().any(|line| (reading.rests)(line) == Some(true))),
        PlaceIn::State => (reading.rests)(last),
        PlaceIn::Later => before.iter().rev().find_map(|line| (reading.rests)(line)),
        PlaceIn::Other => Some(lines.iter().any(|line| (reading.rests)(line) == Some(true))),
    };
    assert!(report.mode != Mode::Idle || rests == Some(true), "{report:?} from {lines:?}");
    let Some(at) = report.position else { return };
    let says = |[a, b]: [f64; 2]| off(at.point, (reading.place_mm)(a, b)) < 2e-5;
    let said = lines
        .iter()
        .any(|line| numbers(line, reading.letters).windows(2).any(|pair| says([pair[0], pair[1]])));
    assert!(said, "{report:?} from {lines:?}");
}

/// All numbers of a line. A number that a letter follows does not count, except one of `letters`.
fn numbers(text: &str, letters: &str) -> Vec<f64> {
    let ends = |letter: char| !(letter.is_ascii_digit() || "+-.".contains(letter));
    let goes_on = |letter: char| letter.is_alphabetic() && !letters.contains(letter);
    let parts = text.split_inclusive(ends).filter(|part| !part.ends_with(goes_on));
    parts.filter_map(|part| part.trim_end_matches(ends).parse().ok()).collect()
}

/// The first two numbers.
fn two(text: &str, between: char) -> Option<[f64; 2]> {
    let mut numbers = text.split([between, '|', '>']).filter(|part| !part.is_empty());
    Some([numbers.next()?.trim().parse().ok()?, numbers.next()?.trim().parse().ok()?])
}

/// The position is the line's, in machine coordinates.
fn is_there(at: Point, [x, y]: [f64; 2], text: &str) {
    assert!(off(at, [x, y]) < 2e-5, "{at:?} from {text:?}, not {x} {y}");
}

/// Distance of the position from one in machine coordinates, mm, on the farther axis.
fn off(at: Point, [x, y]: [f64; 2]) -> f64 {
    let machine = at.translated(dialect_config().offset).expect("it came from there");
    (mm(machine.x.units()) - x).abs().max((mm(machine.y.units()) - y).abs())
}
