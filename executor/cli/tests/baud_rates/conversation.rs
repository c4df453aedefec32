//! The conversation of a session: the bytes that its log recorded, in both directions.

use keepout_executor::session::LoggedEvent;
use keepout_executor::session::log::Log;
use keepout_executor::supervisor::Phase;

use super::job::Case;

/// Numbers of lines that a transcript shows at the beginning and at the end of each part of a session.
const FIRST: usize = 72;
const LAST: usize = 12;

/// The parts of a session, in order, with their lines.
#[derive(Debug)]
pub struct Conversation(Vec<Part>);

#[derive(Debug)]
struct Part {
    /// Name of the part.
    name: String,
    /// `> …` for each sent chunk. `< …` for each received line, or for the beginning of a line that the next
    /// sent chunk interrupts.
    lines: Vec<String>,
}

impl Conversation {
    pub fn of(log: &Log) -> Self {
        let mut parts = vec![Part { name: "start".into(), lines: Vec::new() }];
        let mut received = String::new();
        for entry in &log.entries {
            let part = parts.last_mut().unwrap();
            match &entry.event {
                LoggedEvent::Sent(bytes) => {
                    part.receive(&mut received);
                    part.lines.push(format!("> {}", bytes.escape_ascii()));
                }
                LoggedEvent::Received(bytes) => {
                    for chunk in bytes.split_inclusive(|&byte| byte == b'\n') {
                        received += &chunk.escape_ascii().to_string();
                        if chunk.ends_with(b"\n") {
                            part.receive(&mut received);
                        }
                    }
                }
                LoggedEvent::Phase { phase, .. } if part_of(*phase) != part.name => {
                    parts.push(Part { name: part_of(*phase).into(), lines: Vec::new() });
                }
                _ => {}
            }
        }
        parts.last_mut().unwrap().receive(&mut received);
        Self(parts)
    }

    /// Parses a transcript.
    pub fn parse(text: &str) -> Self {
        let parts = text.split("\n# ").skip(1).map(|part| {
            let mut lines = part.lines().map(str::to_string);
            Part { name: lines.next().unwrap_or_default(), lines: lines.collect() }
        });
        Self(parts.collect())
    }

    /// The transcript: the beginning and the end of each part.
    pub fn text(&self, case: Case, how: &str) -> String {
        let mut text = format!("# {}, {how}\n", case.name());
        for part in &self.0 {
            text += &format!("\n# {}\n", part.name);
            let lines = folded(&part.lines);
            let left_out = lines.len().saturating_sub(FIRST + LAST);
            for (index, line) in lines.iter().enumerate() {
                if index < FIRST || index >= FIRST + left_out {
                    text += &format!("{line}\n");
                } else if index == FIRST {
                    text += &format!("… {left_out} lines …\n");
                }
            }
        }
        text
    }

    /// Checks that two sessions agree in everything that does not depend on the computer's threads: the
    /// parts, the chunks that set the controller up and home it, and the commands of the contour.
    pub fn agrees_with(&self, other: &Self) -> Result<(), String> {
        let parts = |of: &Self| of.0.iter().map(|part| part.name.clone()).collect();
        same("parts", &parts(self), &parts(other))?;
        same("start", &self.start(), &other.start())?;
        let (ours, theirs) = (self.contour(), other.contour());
        if ours.is_empty() { Err("no contour".into()) } else { same("contour", &ours, &theirs) }
    }

    /// Checks that this session agrees with a kept transcript, which leaves lines out.
    pub fn agrees_with_transcript(&self, kept: &Self) -> Result<(), String> {
        let parts = |of: &Self| of.0.iter().map(|part| part.name.clone()).collect();
        same("kept parts", &parts(self), &parts(kept))?;
        same("kept start", &self.start(), &kept.start())?;
        let (mut ours, kept) = (self.contour().into_iter(), kept.contour());
        match kept.iter().find(|command| !ours.any(|ours| ours == **command)) {
            Some(other) => Err(format!("kept contour: the session does not send {other}")),
            None if kept.is_empty() => Err("kept contour: empty".into()),
            None => Ok(()),
        }
    }

    /// The chunks that are sent at the start, each chunk once.
    fn start(&self) -> Vec<String> {
        let mut chunks = Vec::new();
        for chunk in self.0.iter().filter(|part| part.name == "start").flat_map(Part::sent) {
            if !chunks.contains(&chunk) {
                chunks.push(chunk);
            }
        }
        chunks
    }

    /// The chunks that are sent in the contour, without those that are also sent at the start, such as
    /// queries.
    fn contour(&self) -> Vec<String> {
        let start = self.start();
        let contour = self.0.iter().filter(|part| part.name == "contour").flat_map(Part::sent);
        contour.filter(|chunk| !start.contains(chunk)).collect()
    }
}

impl Part {
    /// Adds received text. A line feed that arrives alone, after the next sent chunk, belongs to the line
    /// before.
    fn receive(&mut self, received: &mut String) {
        let received = std::mem::take(received);
        let before = self.lines.iter_mut().rfind(|line| line.starts_with('<'));
        match before {
            Some(line) if received == "\\n" && line.ends_with("\\r") => *line += &received,
            _ if received.is_empty() => {}
            _ => self.lines.push(format!("< {received}")),
        }
    }

    fn sent(&self) -> impl Iterator<Item = String> {
        self.lines.iter().filter_map(|line| line.strip_prefix("> ")).map(unnumbered)
    }
}

/// The chunk without the number and the checksum of a Zaber message. The number counts queries, so it differs
/// between sessions.
fn unnumbered(chunk: &str) -> String {
    if !chunk.starts_with('/') {
        return chunk.into();
    }
    let text = chunk.split(':').next().unwrap_or(chunk);
    let mut words: Vec<&str> = text.split(' ').collect();
    if words.len() > 2 {
        words.remove(2);
    }
    words.join(" ")
}

fn same(what: &str, ours: &Vec<String>, theirs: &Vec<String>) -> Result<(), String> {
    if ours == theirs { Ok(()) } else { Err(format!("{what}: {ours:?} and {theirs:?}")) }
}

fn part_of(phase: Phase) -> &'static str {
    match phase {
        Phase::Starting => "start",
        Phase::Manual | Phase::Sliding | Phase::Retracting => "by hand",
        Phase::Touching => "touched",
        Phase::Contouring | Phase::Holding => "contour",
        Phase::Faulted => "fault",
        Phase::Stopping | Phase::Done => "end",
    }
}

/// Removes repetitions: an exchange of 2 to 8 lines that comes again, word for word, appears once.
fn folded(lines: &[String]) -> Vec<&str> {
    let mut lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    for length in 2..=8 {
        let mut kept: Vec<&str> = Vec::new();
        let mut rest = lines.as_slice();
        while let [first, others @ ..] = rest {
            let again = rest.len() >= length && kept.ends_with(&rest[..length]) && first.starts_with('>');
            if again {
                rest = &rest[length..];
            } else {
                kept.push(first);
                rest = others;
            }
        }
        lines = kept;
    }
    lines
}
