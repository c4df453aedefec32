//! GRBL 1.1: jogs with absolute machine targets, contours in G1/G2/G3, realtime status.
//!
//! Drawing coordinates become machine coordinates by an offset. Targets are written from integers, digit by digit, so
//! nothing is rounded on the way; GRBL itself holds them in 32-bit floats (below 0.03 µm on a 400 mm table).

use std::fmt::Write as _;

use keepout_kernel::{Curve, LatticeError, Point, Turn, Vector};
use keepout_planner::units::point_from_mm;

use crate::supervisor::guard::Motion;
use crate::supervisor::{Command, Mode, Reply, Report};

/// Longest line that GRBL is expected to send.
const LINE_MAX: usize = 256;

/// The GRBL 1.1 dialect of one session.
#[derive(Clone, Debug)]
pub struct Grbl {
    /// Machine coordinates less drawing coordinates.
    offset: Vector,
    /// Work coordinate offset, machine coordinates, once reported.
    work_offset: Vector,
    line: Vec<u8>,
    overlong: bool,
}

impl Grbl {
    /// The dialect for a drawing placed at `offset` on the machine.
    #[must_use]
    pub fn new(offset: Vector) -> Self {
        Self { offset, work_offset: Vector { dx: 0, dy: 0 }, line: Vec::new(), overlong: false }
    }

    /// The bytes of a command.
    ///
    /// # Errors
    /// [`LatticeError`] when a target leaves the lattice in machine coordinates.
    pub fn encode(&self, command: &Command) -> Result<Vec<u8>, LatticeError> {
        Ok(match command {
            Command::Query => b"?".to_vec(),
            Command::Cancel => vec![0x85],
            Command::Hold => b"!".to_vec(),
            Command::Reset => vec![0x18],
            Command::Wake => b"\n".to_vec(),
            Command::ReadSettings => b"$$\n".to_vec(),
            Command::SetArcTolerance { mm } => format!("$12={mm:.5}\n").into_bytes(),
            Command::ReportBlocks => b"$10=3\n".to_vec(),
            // A change of work coordinates makes the next report carry their offset.
            Command::SetModes => b"G21G90G94G17G40G49G80G55\nG54\n".to_vec(),
            Command::Home => b"$H\n".to_vec(),
            Command::Move(certified) => self.motion(certified.motion())?.into_bytes(),
        })
    }

    fn motion(&self, motion: &Motion) -> Result<String, LatticeError> {
        match motion {
            Motion::Jog { to, feed_mm_min } => {
                let to = to.translated(self.offset)?;
                Ok(format!(
                    "$J=G53G90G21{}F{feed_mm_min}\n",
                    words(&[('X', to.x.units()), ('Y', to.y.units())])
                ))
            }
            Motion::Contour { curve, feed_mm_min } => {
                let to = self.work(curve.to())?;
                let (code, centre) = match curve {
                    Curve::Line(_) => ("G1", String::new()),
                    Curve::Arc(arc) => {
                        let ij = arc.centre().minus(arc.from());
                        let code = if arc.turn() == Turn::Left { "G3" } else { "G2" };
                        (code, words(&[('I', ij.dx), ('J', ij.dy)]))
                    }
                };
                Ok(format!(
                    "{code}{}{centre}F{feed_mm_min}\n",
                    words(&[('X', to.x.units()), ('Y', to.y.units())])
                ))
            }
        }
    }

    fn work(&self, point: Point) -> Result<Point, LatticeError> {
        let back = Vector { dx: -self.work_offset.dx, dy: -self.work_offset.dy };
        point.translated(self.offset)?.translated(back)
    }

    /// The replies completed by `bytes`. Total: any bytes give some replies, never a panic, and no line is kept longer
    /// than 256 bytes.
    pub fn decode(&mut self, bytes: &[u8]) -> Vec<Reply> {
        let mut replies = Vec::new();
        for &byte in bytes {
            match byte {
                b'\n' => replies.extend(self.end_of_line()),
                b'\r' => {}
                _ if self.line.len() < LINE_MAX => self.line.push(byte),
                _ => self.overlong = true,
            }
        }
        replies
    }

    fn end_of_line(&mut self) -> Option<Reply> {
        let bytes = std::mem::take(&mut self.line);
        let overlong = std::mem::take(&mut self.overlong);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if overlong || !bytes.iter().all(|byte| (0x20..0x7f).contains(byte)) {
            return Some(Reply::Garbled(text));
        }
        if text.is_empty() { None } else { Some(self.reply(&text)) }
    }

    fn reply(&mut self, text: &str) -> Reply {
        let garbled = || Reply::Garbled(text.to_string());
        let number = |rest: &str| rest.trim().parse::<u16>().ok();
        if text == "ok" {
            Reply::Ok
        } else if let Some(rest) = text.strip_prefix("error:") {
            number(rest).map_or_else(garbled, Reply::Error)
        } else if let Some(rest) = text.strip_prefix("ALARM:") {
            number(rest).map_or_else(garbled, Reply::Alarm)
        } else if let Some(inner) = text.strip_prefix('<').and_then(|rest| rest.strip_suffix('>')) {
            self.report(inner).map_or_else(garbled, Reply::Report)
        } else if let Some((number, value)) = text.strip_prefix('$').and_then(|rest| rest.split_once('=')) {
            match (number.parse(), value.split_whitespace().next().unwrap_or("").parse()) {
                (Ok(number), Ok(value)) => Reply::Setting(number, value),
                _ if number.starts_with('N') => Reply::Message(text.into()),
                _ => garbled(),
            }
        } else if text.starts_with("Grbl ") || text.starts_with("GrblHAL ") {
            Reply::Greeting(text.into())
        } else if text.starts_with('[') && text.ends_with(']') || text.starts_with('>') {
            Reply::Message(text.into())
        } else {
            garbled()
        }
    }

    fn report(&mut self, inner: &str) -> Option<Report> {
        let mut fields = inner.split('|');
        let state = fields.next()?;
        let mode = match state.split(':').next()? {
            "Idle" => Mode::Idle,
            "Jog" | "Run" => Mode::Moving,
            "Hold" => Mode::Held,
            "Home" => Mode::Homing,
            "Alarm" => Mode::Alarm,
            "Door" | "Check" | "Sleep" | "Tool" => Mode::Other,
            _ => return None,
        };
        let (mut position, mut work_offset) = (None, None);
        let mut free_blocks = None;
        for field in fields {
            let (name, value) = field.split_once(':')?;
            match name {
                "MPos" => position = Some(plane(value)?),
                "Bf" => free_blocks = Some(value.split(',').next()?.parse().ok()?),
                "WCO" => work_offset = Some(plane(value)?),
                _ => {}
            }
        }
        let back = Vector { dx: -self.offset.dx, dy: -self.offset.dy };
        if let Some(offset) = work_offset {
            self.work_offset = offset.minus(Point::ORIGIN);
        }
        let position = match position {
            Some(position) => Some(Point::translated(position, back).ok()?),
            None => None,
        };
        Some(Report { mode, position, work_offset, free_blocks })
    }
}

/// The first two of a list of mm values.
fn plane(value: &str) -> Option<Point> {
    let mut values = value.split(',').map(|number| number.parse::<f64>().ok());
    point_from_mm((values.next()??, values.next()??)).ok()
}

/// `X1.5Y-0.00001`: words in mm, exact, with as few digits as it takes.
fn words(values: &[(char, i32)]) -> String {
    let mut text = String::new();
    for &(letter, units) in values {
        let sign = if units < 0 { "-" } else { "" };
        let magnitude = units.unsigned_abs();
        let (whole, fraction) = (magnitude / 100_000, magnitude % 100_000);
        let _ = write!(text, "{letter}{sign}{whole}");
        if fraction != 0 {
            let digits = format!("{fraction:05}");
            let _ = write!(text, ".{}", digits.trim_end_matches('0'));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dialect() -> Grbl {
        Grbl::new(Vector { dx: -20_000_000, dy: 500 })
    }

    #[test]
    fn words_are_exact_and_short() {
        assert_eq!(words(&[('X', 150_000), ('Y', -1)]), "X1.5Y-0.00001");
        assert_eq!(words(&[('X', 0), ('Y', -12_345_600)]), "X0Y-123.456");
    }

    #[test]
    fn report_is_read_in_drawing_coordinates() {
        let mut grbl = dialect();
        let replies = grbl
            .decode(b"<Jog|MPos:-150.000,20.005,0.000|Bf:14,128|FS:600,0|WCO:1.000,2.000,0.000>\r\nok\r\n");
        let position = Point::from_units(5_000_000, 2_000_000).unwrap();
        let work_offset = Some(Point::from_units(100_000, 200_000).unwrap());
        let report =
            Report { mode: Mode::Moving, position: Some(position), work_offset, free_blocks: Some(14) };
        assert_eq!(replies, [Reply::Report(report), Reply::Ok]);
        assert_eq!(grbl.work_offset, Vector { dx: 100_000, dy: 200_000 });
    }

    #[test]
    fn replies_of_the_real_firmware() {
        let mut grbl = dialect();
        let text = "Grbl 1.1h ['$' for help]\r\n$10=1\r\n$130=400.000 (x max travel)\r\nerror:15\r\nALARM:2\r\n[MSG:Reset to continue]\r\n";
        assert_eq!(
            grbl.decode(text.as_bytes()),
            [
                Reply::Greeting("Grbl 1.1h ['$' for help]".into()),
                Reply::Setting(10, 1.0),
                Reply::Setting(130, 400.0),
                Reply::Error(15),
                Reply::Alarm(2),
                Reply::Message("[MSG:Reset to continue]".into()),
            ]
        );
    }

    #[test]
    fn decode_is_total() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut grbl = dialect();
        for _ in 0..20_000 {
            let alphabet = b"<>|:,.-+0123456789MPosBfWCOIdleJogokerror\r\n\n$=[]\xff\x00";
            let bytes: Vec<u8> =
                (0..random.usize(0..40)).map(|_| alphabet[random.usize(0..alphabet.len())]).collect();
            grbl.decode(&bytes);
            assert!(grbl.line.len() <= LINE_MAX);
        }
        grbl.decode(b"\n");
        assert_eq!(grbl.decode(&[b'x'; 5000]).len(), 0);
        assert!(matches!(grbl.decode(b"\n")[..], [Reply::Garbled(_)]));
    }
}
