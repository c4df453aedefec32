//! What was said in a session, as its log has it.

use keepout_executor::session::LoggedEvent;
use keepout_executor::session::log::Log;
use keepout_executor::supervisor::Phase;

use super::job::Case;

/// Lines that are written out at the beginning and at the end of each part of a session.
const FIRST: usize = 44;
const LAST: usize = 12;

/// A session's parts, in order, with what was said in each.
#[derive(Debug)]
pub struct Conversation(Vec<Part>);

#[derive(Debug)]
struct Part {
    /// What went on.
    name: String,
    /// `> …` for each piece that was sent, `< …` for each line that was received, or for as much of it as came before the next
    /// piece was sent.
    lines: Vec<String>,
}

impl Conversation {
    pub fn of(log: &Log) -> Self {
        let mut parts = vec![Part { name: "start".into(), lines: Vec::new() }];
        let mut heard = String::new();
        for entry in &log.entries {
            let part = parts.last_mut().unwrap();
            match &entry.event {
                LoggedEvent::Sent(bytes) => {
                    part.hear(&mut heard);
                    part.lines.push(format!("> {}", bytes.escape_ascii()));
                }
                LoggedEvent::Received(bytes) => {
                    for piece in bytes.split_inclusive(|&byte| byte == b'\n') {
                        heard += &piece.escape_ascii().to_string();
                        if piece.ends_with(b"\n") {
                            part.hear(&mut heard);
                        }
                    }
                }
                LoggedEvent::Phase { phase, .. } if part_of(*phase) != part.name => {
                    parts.push(Part { name: part_of(*phase).into(), lines: Vec::new() });
                }
                _ => {}
            }
        }
        parts.last_mut().unwrap().hear(&mut heard);
        Self(parts)
    }

    /// Reads a transcript.
    pub fn parse(text: &str) -> Self {
        let parts = text.split("\n# ").skip(1).map(|part| {
            let mut lines = part.lines().map(str::to_string);
            Part { name: lines.next().unwrap_or_default(), lines: lines.collect() }
        });
        Self(parts.collect())
    }

    /// The transcript: of each part the beginning and the end.
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

    /// Whether it is the same session as another, as far as that does not depend on how the threads of this computer took
    /// turns: its parts, what is sent to set the controller up and home it, and the commands of the contour.
    pub fn agrees_with(&self, other: &Self) -> Result<(), String> {
        let parts = |of: &Self| of.0.iter().map(|part| part.name.clone()).collect();
        same("parts", &parts(self), &parts(other))?;
        same("start", &self.start(), &other.start())?;
        let (ours, theirs) = (self.contour(), other.contour());
        if ours.is_empty() { Err("no contour".into()) } else { same("contour", &ours, &theirs) }
    }

    /// Whether a transcript with lines left out is of such a session.
    pub fn is_told_by(&self, kept: &Self) -> Result<(), String> {
        let parts = |of: &Self| of.0.iter().map(|part| part.name.clone()).collect();
        same("kept parts", &parts(self), &parts(kept))?;
        same("kept start", &self.start(), &kept.start())?;
        let (mut ours, kept) = (self.contour().into_iter(), kept.contour());
        match kept.iter().find(|command| !ours.any(|ours| ours == **command)) {
            Some(other) => Err(format!("kept contour: {other} is not sent")),
            None if kept.is_empty() => Err("kept contour: nothing".into()),
            None => Ok(()),
        }
    }

    /// What is sent while it starts, each piece once.
    fn start(&self) -> Vec<String> {
        let mut pieces = Vec::new();
        for piece in self.0.iter().filter(|part| part.name == "start").flat_map(Part::sent) {
            if !pieces.contains(&piece) {
                pieces.push(piece);
            }
        }
        pieces
    }

    /// What is sent in the contour, but for what is asked at the start, too.
    fn contour(&self) -> Vec<String> {
        let start = self.start();
        let contour = self.0.iter().filter(|part| part.name == "contour").flat_map(Part::sent);
        contour.filter(|piece| !start.contains(piece)).collect()
    }
}

impl Part {
    /// A line feed that comes by itself, after the next question, belongs to the line before.
    fn hear(&mut self, heard: &mut String) {
        let heard = std::mem::take(heard);
        let before = self.lines.iter_mut().rfind(|line| line.starts_with('<'));
        match before {
            Some(line) if heard == "\\n" && line.ends_with("\\r") => *line += &heard,
            _ if heard.is_empty() => {}
            _ => self.lines.push(format!("< {heard}")),
        }
    }

    fn sent(&self) -> impl Iterator<Item = String> {
        self.lines.iter().filter_map(|line| line.strip_prefix("> ")).map(unnumbered)
    }
}

/// Without the number and the checksum that Zaber's messages carry: they count questions.
fn unnumbered(piece: &str) -> String {
    if !piece.starts_with('/') {
        return piece.into();
    }
    let text = piece.split(':').next().unwrap_or(piece);
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
        Phase::Manual | Phase::Sliding | Phase::Escaping => "by hand",
        Phase::Touching => "touched",
        Phase::Contouring | Phase::Holding => "contour",
        Phase::Faulted => "fault",
        Phase::Stopping | Phase::Done => "end",
    }
}

/// One or two questions that come again with the same answers, word for word, are written once.
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
