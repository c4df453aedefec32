//! GRBL 1.1 and grblHAL: jogs with absolute machine targets, contours in G1/G2/G3, realtime status.
//!
//! Drawing coordinates become machine coordinates by an offset. Targets are written from integers, digit by digit, so
//! nothing is rounded on the way; GRBL itself holds them in 32-bit floats (below 0.03 µm on a 400 mm table).
//!
//! Arcs are written by their radius, to 10 nm, and turn a quarter at most: the arc through the same ends leaves the certified
//! one by less than half the difference of the radii. One that arrives twice is refused (its ends coincide).
//!
//! grblHAL differs where it matters here: a cancel throws away lines it has not read, so that none is sent until the tool rests;
//! a hold does not stop a jog (it is cancelled instead, which both know), its planner
//! has more blocks (they are counted from what it reports at rest), and it says more (fields that are not known are skipped).

use keepout_kernel::{Curve, LatticeError, Point, Turn, Vector};

use super::grbl_inspect::GrblInspector;
use super::lines::{Line, Lines, as_str, plane, push_mm, push_number};
use super::{Dialect, Inspector, Setting};
use crate::link::Abilities;
use crate::supervisor::guard::{Motion, MotionShape};
use crate::supervisor::{Command, Limits, Mode, Reply, Report, Unfit, text};

/// What the dialect is in the middle of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Nothing was sent yet that is answered.
    Silent,
    /// A line was sent that ends whatever the controller may have half of.
    Waking,
    Reading(Settings),
    /// The lines that the controller runs after a reset are read.
    ReadingBlocks(Settings, StartupBlocks),
    /// So many lines that store settings are unanswered.
    Storing(u8, Limits),
    Prepared,
    Homing,
    /// So many lines that set modes are unanswered.
    Arming(u8),
    Ready,
    /// A reset was sent, and a greeting will come.
    Aborting,
}

/// The GRBL 1.1 dialect of one session.
#[derive(Clone, Debug)]
pub struct Grbl {
    setting: Setting,
    hal: bool,
    stage: Stage,
    /// Work coordinate offset, machine coordinates, once reported.
    work_offset: Option<Vector>,
    /// What the list of parameters says of it.
    stated: Stated,
    /// Free blocks at rest.
    blocks: Option<usize>,
    /// Free bytes of the receive buffer at rest.
    bytes: Option<usize>,
    lines: Lines,
}

impl Grbl {
    /// The dialect for a drawing placed on the machine.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        Self {
            setting,
            hal: false,
            stage: Stage::Silent,
            work_offset: None,
            stated: Stated::default(),
            blocks: None,
            bytes: None,
            lines: Lines::default(),
        }
    }

    /// The same for grblHAL.
    #[must_use]
    pub fn hal(setting: Setting) -> Self {
        Self { hal: true, ..Self::new(setting) }
    }

    fn motion(&self, motion: &Motion, out: &mut Vec<u8>) -> Result<(), LatticeError> {
        let feed = match motion {
            Motion::Jog { to, feed_mm_min } => {
                let to = to.translated(self.setting.offset)?;
                out.extend(b"$J=G53G90G21");
                words(out, &[(b'X', to.x.units()), (b'Y', to.y.units())]);
                feed_mm_min
            }
            Motion::Contour { curve, feed_mm_min } => {
                let to = self.work(curve.to())?;
                out.extend(match curve {
                    Curve::Line(_) => b"G1",
                    Curve::Arc(arc) if arc.turn() == Turn::Left => b"G3",
                    Curve::Arc(_) => b"G2",
                });
                words(out, &[(b'X', to.x.units()), (b'Y', to.y.units())]);
                // By its radius: given by its centre, an arc that arrives twice would be a full circle somewhere else.
                if let Curve::Arc(arc) = curve {
                    words(out, &[(b'R', arc.radius().units())]);
                }
                feed_mm_min
            }
        };
        out.push(b'F');
        push_number(out, u64::from(*feed));
        out.push(b'\n');
        Ok(())
    }

    fn work(&self, point: Point) -> Result<Point, LatticeError> {
        let offset = self.work_offset.unwrap_or(Vector { dx: 0, dy: 0 });
        point.translated(self.setting.offset)?.translated(Vector { dx: -offset.dx, dy: -offset.dy })
    }

    fn reply(&mut self, line: &str, out: &mut Vec<u8>) -> Option<Reply> {
        let garbled = Some(Reply::Garbled(text(line)));
        let number = |rest: &str| rest.trim().parse::<u16>().ok();
        if line == "ok" {
            self.answered(out)
        } else if let Some(rest) = line.strip_prefix("error:") {
            number(rest).map_or(garbled, |code| self.refused(code, out))
        } else if let Some(rest) = line.strip_prefix("ALARM:") {
            number(rest).map_or(garbled, |code| Some(Reply::Alarm { code, meaning: alarm_text(code) }))
        } else if let Some(inner) = line.strip_prefix('<').and_then(|rest| rest.strip_suffix('>')) {
            self.report(inner).or(garbled)
        } else if let Some((name, value)) = line.strip_prefix('$').and_then(|rest| rest.split_once('=')) {
            match (name.parse::<u16>(), value.split_whitespace().next().unwrap_or("").parse::<f64>()) {
                (Ok(number), Ok(value)) => {
                    if let Stage::Reading(settings) = &mut self.stage {
                        settings.take(number, value);
                    }
                    None
                }
                // grblHAL has settings that are no numbers.
                (Ok(_), Err(_)) if matches!(self.stage, Stage::Reading(_)) => None,
                _ if name.starts_with('N') => {
                    if let Stage::ReadingBlocks(_, blocks) = &mut self.stage {
                        blocks.take(name, value);
                        return None;
                    }
                    Some(Reply::Message(text(line)))
                }
                _ => garbled,
            }
        } else if line.starts_with("Grbl ") || line.starts_with("GrblHAL ") {
            self.greeted()
        } else if line.starts_with("[HLP:") && self.stage == Stage::Waking {
            None
        } else if let Some(inner) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'))
            && matches!(self.stage, Stage::Arming(_))
        {
            self.stated.take(inner);
            None
        } else if line.starts_with('[') && line.ends_with(']') || line.starts_with('>') {
            Some(Reply::Message(text(line)))
        } else {
            garbled
        }
    }

    fn greeted(&mut self) -> Option<Reply> {
        match self.stage {
            Stage::Silent => None,
            Stage::Aborting => {
                self.stage = Stage::Silent;
                None
            }
            _ => Some(Reply::Restarted),
        }
    }

    /// The oldest line is accepted.
    fn answered(&mut self, out: &mut Vec<u8>) -> Option<Reply> {
        match self.stage {
            Stage::Silent | Stage::Aborting => None,
            Stage::Waking => {
                self.read_settings(out);
                None
            }
            Stage::Reading(settings) => match settings.check(self.setting.steps_per_mm) {
                Ok(()) => {
                    out.extend(b"$N\n");
                    self.stage = Stage::ReadingBlocks(settings, StartupBlocks::default());
                    None
                }
                Err(unfit) => Some(Reply::Unfit(unfit)),
            },
            Stage::ReadingBlocks(settings, blocks) => self.store(&settings, blocks, out),
            Stage::Storing(open @ 2.., limits) => {
                self.stage = Stage::Storing(open - 1, limits);
                None
            }
            Stage::Storing(_, limits) => self.prepared(limits),
            Stage::Homing => {
                self.stage = Stage::Prepared;
                Some(Reply::Homed)
            }
            Stage::Arming(open @ 2..) => {
                self.stage = Stage::Arming(open - 1);
                None
            }
            Stage::Arming(_) => {
                self.stage = Stage::Ready;
                Some(Reply::Armed)
            }
            Stage::Prepared | Stage::Ready => Some(Reply::Accepted),
        }
    }

    fn refused(&mut self, code: u16, out: &mut Vec<u8>) -> Option<Reply> {
        /// Not idle: a jog stream that ran dry leaves GRBL in Run for a moment.
        const NOT_IDLE: u16 = 8;
        match self.stage {
            Stage::Silent | Stage::Aborting => None,
            Stage::Waking => {
                self.read_settings(out);
                None
            }
            _ => Some(Reply::Refused { code, meaning: error_text(code), transient: code == NOT_IDLE }),
        }
    }

    fn read_settings(&mut self, out: &mut Vec<u8>) {
        out.extend(b"$$\n");
        self.stage = Stage::Reading(Settings::default());
    }

    /// Sets what the session relies on where the controller has it otherwise.
    fn store(&mut self, settings: &Settings, blocks: StartupBlocks, out: &mut Vec<u8>) -> Option<Reply> {
        let mut open = 0;
        match blocks.needed() {
            Ok(None) => {}
            Ok(Some(line)) => {
                out.extend(line);
                open += 1;
            }
            Err(unfit) => return Some(Reply::Unfit(unfit)),
        }
        if !settings.reports_blocks() {
            out.extend(b"$10=3\n");
            open += 1;
        }
        let mm = self.setting.arc_tolerance_mm;
        if !settings.follows_arcs(mm) {
            out.extend(format!("$12={mm:.5}\n").bytes());
            open += 1;
        }
        let limits = settings.limits();
        self.stage = Stage::Storing(open, limits);
        if open == 0 { self.prepared(limits) } else { None }
    }

    fn prepared(&mut self, limits: Limits) -> Option<Reply> {
        self.stage = Stage::Prepared;
        Some(Reply::Prepared(limits))
    }

    fn report(&mut self, inner: &str) -> Option<Reply> {
        let mut fields = inner.split('|');
        let mode = mode(fields.next()?)?;
        let (mut position, mut buffers) = (None, None);
        for field in fields {
            let (name, value) = field.split_once(':')?;
            match name {
                "MPos" => position = Some(plane(value)?),
                "Bf" => {
                    let (blocks, bytes) = value.split_once(',')?;
                    buffers = Some((blocks.parse::<usize>().ok()?, bytes.parse::<usize>().ok()?));
                }
                "WCO" if self.displaced(plane(value)?) => return Some(Reply::Displaced),
                _ => {}
            }
        }
        if let (Mode::Idle, Some((blocks, bytes))) = (mode, buffers) {
            self.blocks = self.blocks.max(Some(blocks));
            self.bytes = self.bytes.max(Some(bytes));
        }
        let queued = self.blocks.zip(buffers).map(|(all, (free, _))| all.saturating_sub(free));
        let waiting = self.bytes.zip(buffers).map(|(all, (_, free))| free < all);
        let back = Vector { dx: -self.setting.offset.dx, dy: -self.setting.offset.dy };
        let position = match position {
            Some(position) => Some(position.translated(back).ok()?),
            None => None,
        };
        let agreed = self.work_offset.is_some() && self.work_offset == self.stated.sum();
        // A report without its buffers is no evidence of anything.
        let position = position.filter(|_| agreed && waiting.is_some() || self.stage != Stage::Ready);
        Some(Reply::Report(Report { mode, position, queued, waiting }))
    }

    /// Takes the work offset; whether it changed while it was relied on.
    fn displaced(&mut self, offset: Point) -> bool {
        let offset = offset.minus(Point::ORIGIN);
        let before = self.work_offset.replace(offset);
        self.stage == Stage::Ready && before.is_some_and(|before| before != offset)
    }
}

impl Dialect for Grbl {
    fn abilities(&self) -> Abilities {
        Abilities {
            shape: MotionShape::Line,
            contours: MotionShape::Line,
            arcs: true,
            queues: true,
            cancels: true,
            flushes: self.hal,
            holds: true,
            checked: false,
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), LatticeError> {
        match command {
            Command::Query => out.push(b'?'),
            Command::Cancel => out.push(0x85),
            Command::Hold => out.push(b'!'),
            Command::Continue => out.push(b'~'),
            Command::Abort => {
                out.push(0x18);
                self.stage = Stage::Aborting;
            }
            // Half a line may be left from before the cable was pulled; a mere line end would have the controller drive to
            // half a target. With a `$` behind it every line is refused, and alone it is answered with a help text.
            Command::Prepare => {
                out.extend(b"$\n");
                self.stage = Stage::Waking;
            }
            // A change of work coordinates makes the next report carry their offset; the list of parameters must agree.
            Command::Arm => {
                out.extend(b"G21G90G94G17G40G49G80G55\nG54\n$#\n");
                self.work_offset = None;
                self.stated = Stated::default();
                self.stage = Stage::Arming(3);
            }
            Command::Home => {
                out.extend(b"$H\n");
                self.stage = Stage::Homing;
            }
            Command::Move(certified) => {
                let first = out.len();
                self.motion(certified.motion(), out).inspect_err(|_| out.truncate(first))?;
            }
        }
        Ok(())
    }

    fn decode(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply> {
        match self.lines.take(byte)? {
            Line::Garbled(line) => Some(Reply::Garbled(line)),
            Line::Text(line) => self.reply(as_str(&line), out),
        }
    }

    fn reset(&mut self) {
        self.stage = Stage::Silent;
        self.lines.clear();
    }

    fn inspector(&self) -> Option<Box<dyn Inspector>> {
        Some(Box::new(GrblInspector::default()))
    }
}

fn mode(state: &str) -> Option<Mode> {
    Some(match state.split_once(':').unwrap_or((state, "")) {
        ("Idle", _) => Mode::Idle,
        ("Jog" | "Run", _) => Mode::Moving,
        ("Hold", "1") => Mode::Slowing,
        ("Hold", _) => Mode::Held,
        ("Home", _) => Mode::Homing,
        ("Alarm", _) => Mode::Alarm,
        ("Door" | "Check" | "Sleep" | "Tool", _) => Mode::Other,
        _ => return None,
    })
}

/// `X1.5Y-0.00001`: words in mm.
fn words(out: &mut Vec<u8>, values: &[(u8, i32)]) {
    for &(letter, units) in values {
        out.push(letter);
        push_mm(out, units);
    }
}

fn error_text(code: u16) -> &'static str {
    match code {
        1..=3 => "a damaged line",
        8 => "not idle",
        9 => "locked by an alarm",
        11 | 14 => "a line too long",
        15 => "beyond the machine's travel",
        20..=25 | 33..=35 => "not valid G-code",
        _ => "",
    }
}

fn alarm_text(code: u16) -> &'static str {
    match code {
        1 => "limit switch",
        2 => "beyond the machine's travel",
        3 => "reset while moving, position lost",
        6..=9 => "homing failed",
        _ => "",
    }
}

/// The offsets that make up that of work coordinates, as the list of parameters states them: a report that was damaged on the
/// way would send a contour elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Stated {
    g54: Option<Vector>,
    g92: Option<Vector>,
}

impl Stated {
    fn take(&mut self, line: &str) {
        let Some((name, value)) = line.split_once(':') else { return };
        let offset = plane(value).map(|point| point.minus(Point::ORIGIN));
        match name {
            "G54" => self.g54 = offset,
            "G92" => self.g92 = offset,
            _ => {}
        }
    }

    fn sum(&self) -> Option<Vector> {
        let (a, b) = (self.g54?, self.g92?);
        Some(Vector { dx: a.dx.checked_add(b.dx)?, dy: a.dy.checked_add(b.dy)? })
    }
}

/// What the controller runs after a reset. One of the two lines must cancel the motion mode: a jog whose beginning a reset
/// swallowed is a line of axis words, and would be run as a rapid motion in work coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct StartupBlocks {
    /// Whether each is there, and empty.
    free: [bool; 2],
    cancels_motion: bool,
}

impl StartupBlocks {
    fn take(&mut self, name: &str, value: &str) {
        let value = value.trim();
        self.cancels_motion |= value.eq_ignore_ascii_case("G80");
        if let Some(free) = name.strip_prefix('N').and_then(|n| self.free.get_mut(n.parse::<usize>().ok()?)) {
            *free = value.is_empty();
        }
    }

    /// The line that is still to be stored, if any.
    fn needed(self) -> Result<Option<&'static [u8]>, Unfit> {
        match (self.cancels_motion, self.free) {
            (true, _) => Ok(None),
            // The last to be run has the last word.
            (false, [_, true]) => Ok(Some(b"$N1=G80\n")),
            (false, [true, _]) => Ok(Some(b"$N0=G80\n")),
            (false, _) => {
                let needed = "G80, or empty: after a reset the rest of a line must not be run as a motion";
                Err(Unfit { name: "$N1", value: f64::NAN, needed })
            }
        }
    }
}

/// Controller settings that safety and steering rest on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Settings {
    report_mask: Option<f64>,
    arc_tolerance_mm: Option<f64>,
    inches: Option<f64>,
    homing: Option<f64>,
    steps_per_mm: [Option<f64>; 2],
    max_rate_mm_min: [Option<f64>; 2],
    acceleration_mm_s2: [Option<f64>; 2],
}

impl Settings {
    fn take(&mut self, number: u16, value: f64) {
        match number {
            10 => self.report_mask = Some(value),
            12 => self.arc_tolerance_mm = Some(value),
            13 => self.inches = Some(value),
            22 => self.homing = Some(value),
            100 | 101 => self.steps_per_mm[usize::from(number - 100)] = Some(value),
            110 | 111 => self.max_rate_mm_min[usize::from(number - 110)] = Some(value),
            120 | 121 => self.acceleration_mm_s2[usize::from(number - 120)] = Some(value),
            _ => {}
        }
    }

    fn check(&self, steps_per_mm: f64) -> Result<(), Unfit> {
        let unfit = |name, value, needed| Unfit { name, value, needed };
        let missing = |name| unfit(name, f64::NAN, "reported by the controller");
        let homing = self.homing.ok_or(missing("$22"))?;
        if homing < 1.0 {
            return Err(unfit("$22", homing, "1: without homing the position is not known"));
        }
        let inches = self.inches.ok_or(missing("$13"))?;
        if inches.abs() > 0.0 {
            return Err(unfit("$13", inches, "0: positions are read in mm"));
        }
        for (name, value) in [("$100", self.steps_per_mm[0]), ("$101", self.steps_per_mm[1])] {
            let value = value.ok_or(missing(name))?;
            if value.is_nan() || value < steps_per_mm * 0.999 {
                let needed = "at least the steps per mm that the plan's margin was made for";
                return Err(unfit(name, value, needed));
            }
        }
        Ok(())
    }

    /// Whether reports carry machine positions (bit 0) and planner blocks (bit 1).
    fn reports_blocks(&self) -> bool {
        self.report_mask.is_some_and(|mask| mask.rem_euclid(4.0) >= 3.0)
    }

    /// Whether the arc tolerance is provably no more than `mm`: it is reported with three decimals.
    fn follows_arcs(&self, mm: f64) -> bool {
        self.arc_tolerance_mm.is_some_and(|reported| reported >= 0.001 && reported + 0.0005 <= mm)
    }

    fn limits(&self) -> Limits {
        let least = |values: [Option<f64>; 2], scale: f64| {
            let known = values.into_iter().flatten().filter(|value| *value > 0.0);
            known.map(|value| value * scale).fold(f64::INFINITY, f64::min)
        };
        Limits {
            speed_mm_s: least(self.max_rate_mm_min, 1.0 / 60.0),
            acceleration_mm_s2: least(self.acceleration_mm_s2, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dialect() -> Grbl {
        let offset = Vector { dx: -20_000_000, dy: 500 };
        Grbl::new(Setting { offset, steps_per_mm: 400.0, arc_tolerance_mm: 0.0005 })
    }

    fn hear(grbl: &mut Grbl, text: &[u8]) -> (Vec<Reply>, Vec<u8>) {
        let mut out = Vec::new();
        (text.iter().filter_map(|&byte| grbl.decode(byte, &mut out)).collect(), out)
    }

    fn ready() -> Grbl {
        let mut grbl = dialect();
        grbl.stage = Stage::Ready;
        grbl
    }

    #[test]
    fn report_is_read_in_drawing_coordinates() {
        let mut grbl = dialect();
        grbl.stage = Stage::Arming(1);
        hear(&mut grbl, b"[G54:1.000,1.500,0.000]\r\n[G92:0.000,0.500,0.000]\r\nok\r\n");
        let idle = b"<Idle|MPos:0.000,0.000,0.000|Bf:15,128|WCO:1.000,2.000,0.000>\r\n";
        hear(&mut grbl, idle);
        let (replies, _) = hear(&mut grbl, b"<Jog|MPos:-150.000,20.005,0.000|Bf:14,100|FS:600,0>\r\nok\r\n");
        let position = Some(Point::from_units(5_000_000, 2_000_000).unwrap());
        let report = Report { mode: Mode::Moving, position, queued: Some(1), waiting: Some(true) };
        assert_eq!(replies, [Reply::Report(report), Reply::Accepted]);
        assert_eq!(grbl.work_offset, Some(Vector { dx: 100_000, dy: 200_000 }));
        let (replies, _) = hear(&mut grbl, b"<Idle|MPos:0.000,0.000,0.000|WCO:1.001,2.000,0.000>\r\n");
        assert_eq!(replies, [Reply::Displaced]);
    }

    #[test]
    fn replies_of_the_real_firmware() {
        let mut grbl = ready();
        let text = "error:15\r\nALARM:2\r\n[MSG:Reset to continue]\r\nGrbl 1.1h ['$' for help]\r\n<Hold:1|MPos:0,0,0>\r\n";
        let (replies, _) = hear(&mut grbl, text.as_bytes());
        assert!(
            matches!(
                replies[..],
                [
                    Reply::Refused { code: 15, transient: false, .. },
                    Reply::Alarm { code: 2, .. },
                    Reply::Message(_),
                    Reply::Restarted,
                    Reply::Report(Report { mode: Mode::Slowing, position: None, .. }),
                ]
            ),
            "{replies:?}"
        );
    }

    #[test]
    fn settings_are_read_checked_and_set() {
        let mut grbl = dialect();
        let mut out = Vec::new();
        grbl.encode(&Command::Prepare, &mut out).unwrap();
        assert_eq!(out, b"$\n");
        assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$$\n".to_vec()));
        let listed = b"$10=1\r\n$12=0.002\r\n$13=0\r\n$22=1\r\n$74=name\r\n$100=400.000\r\n$101=400.000 (y)\r\n$110=6000\r\n$111=3000\r\n$120=100\r\n$121=90\r\n";
        assert_eq!(hear(&mut grbl, listed), (vec![], vec![]));
        assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$N\n".to_vec()));
        let (replies, sent) = hear(&mut grbl, b"$N0=G54\r\n$N1=\r\nok\r\n");
        assert_eq!((replies, sent), (vec![], b"$N1=G80\n$10=3\n$12=0.00050\n".to_vec()));
        let limits = Limits { speed_mm_s: 50.0, acceleration_mm_s2: 90.0 };
        assert_eq!(hear(&mut grbl, b"ok\r\nok\r\nok\r\n").0, [Reply::Prepared(limits)]);
        let mut unfit = dialect();
        unfit.stage = Stage::Reading(Settings::default());
        assert!(matches!(hear(&mut unfit, b"ok\r\n").0[..], [Reply::Unfit(_)]));
    }

    #[test]
    fn decode_is_total() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut grbl = dialect();
        for round in 0..20_000 {
            if round % 100 == 0 {
                let commands = [Command::Prepare, Command::Arm, Command::Home, Command::Abort];
                let _ = grbl.encode(&commands[random.usize(0..4)], &mut Vec::new());
            }
            let alphabet = b"<>|:,.-+0123456789MPosBfWCOIdleJogokerror\r\n\n$=[]\xff\x00";
            let bytes: Vec<u8> =
                (0..random.usize(0..40)).map(|_| alphabet[random.usize(0..alphabet.len())]).collect();
            hear(&mut grbl, &bytes);
        }
    }
}
