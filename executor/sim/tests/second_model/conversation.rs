//! One conversation with a controller, byte by byte, without a line between.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_executor::session::Sample;
use keepout_guard::Time;
use keepout_planner::Mm3;
use keepout_sim::SimulatedController;

/// Time of a byte at 115200 baud.
const BYTE: Duration = Duration::from_micros(87);

/// A controller, and what it has said and done.
pub struct DirectConversation {
    controller: Box<dyn SimulatedController>,
    now: Time,
    bytes: Vec<u8>,
    /// Lengths of the lines without an answer.
    open: VecDeque<usize>,
    /// Received lines with their times.
    pub lines: Vec<(Time, String)>,
    /// The true positions.
    pub samples: Vec<Sample>,
}

impl DirectConversation {
    pub fn with(controller: Box<dyn SimulatedController>) -> Self {
        let mut begun = Self {
            controller,
            now: Time::ZERO,
            bytes: Vec::new(),
            open: VecDeque::new(),
            lines: Vec::new(),
            samples: Vec::new(),
        };
        begun.wait(Duration::from_millis(10));
        begun
    }

    /// Lets time pass.
    pub fn wait(&mut self, span: Duration) {
        let end = self.now.after(span);
        loop {
            let next = self.controller.next_event();
            if next > end {
                break;
            }
            self.now = self.now.max(next);
            self.controller.advance(self.now);
            self.collect();
            if self.controller.next_event() <= next {
                self.now = self.now.after(Duration::from_micros(1)).min(end);
                if self.now >= end {
                    break;
                }
            }
        }
        self.now = end;
        self.controller.advance(end);
        self.collect();
    }

    /// Sends a line.
    pub fn send_line(&mut self, line: &str) {
        self.open.push_back(line.len() + 1);
        self.send(format!("{line}\n").as_bytes());
    }

    /// Sends a real-time character.
    pub fn send_byte(&mut self, byte: u8) {
        if byte == 0x18 {
            self.open.clear();
        }
        self.send(&[byte]);
    }

    /// Sends bytes at 115200 baud.
    fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.wait(BYTE);
            self.controller.receive(byte);
            self.collect();
        }
    }

    fn collect(&mut self) {
        self.controller.transmit(&mut self.bytes);
        self.controller.take_samples(&mut self.samples);
        while let Some(end) = self.bytes.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.bytes.drain(..=end).collect();
            let line = String::from_utf8_lossy(&line).trim().to_owned();
            if is_answer(&line) {
                self.open.pop_front();
            }
            if !line.is_empty() {
                self.lines.push((self.now, line));
            }
        }
    }

    /// Waits until the lines without an answer have at most this many bytes. Returns whether it came to that.
    pub fn await_open(&mut self, most: usize, within: Duration) -> bool {
        let end = self.now.after(within);
        while self.open.iter().sum::<usize>() > most {
            if self.now >= end {
                return false;
            }
            let next = self.controller.next_event().min(end).max(self.now.after(BYTE));
            self.wait(next.since(self.now));
        }
        true
    }

    /// Asks until two reports in a row state the same rest. Returns the state and the position, and an empty state
    /// without rest in time.
    pub fn rest(&mut self) -> (String, [f64; 3]) {
        let mut last = None;
        for _ in 0..3000 {
            let known = self.lines.len();
            self.send(b"?");
            self.wait(Duration::from_millis(40));
            let report = self.lines[known..].iter().rev().find_map(|(_, line)| ReportStart::of(line));
            let Some(report) = report else { return ("silent".into(), [0.0; 3]) };
            let rests =
                ["Idle", "Alarm", "Hold:0", "Check", "Door:0", "Sleep"].contains(&report.state.as_str());
            let now = Some((report.state.clone(), report.place));
            if rests && last == now {
                return (report.state, report.place);
            }
            last = now;
        }
        (String::new(), [0.0; 3])
    }

    /// The path: the corners of the motion.
    pub fn path(&self) -> Vec<Mm3> {
        let mut path: Vec<Mm3> = Vec::new();
        for sample in &self.samples {
            if path.last() != Some(&sample.position_mm) {
                path.push(sample.position_mm);
            }
        }
        path
    }
}

/// Whether a line answers a line of the host.
pub fn is_answer(line: &str) -> bool {
    line == "ok" || line.starts_with("error:")
}

/// The start of a status report.
pub struct ReportStart {
    pub state: String,
    pub place: [f64; 3],
}

impl ReportStart {
    pub fn of(line: &str) -> Option<Self> {
        let mut fields = line.strip_prefix('<')?.strip_suffix('>')?.split('|');
        let state = fields.next()?.to_owned();
        let numbers = fields.next()?.split_once(':')?.1;
        let mut place = [0.0; 3];
        for (into, number) in place.iter_mut().zip(numbers.split(',')) {
            *into = number.parse().ok()?;
        }
        Some(Self { state, place })
    }
}
