//! The conversation of a short session in every language, word for word: homing, a few jogs, rest.
//!
//! What comes again word for word (a tool that rests, asked where it is) is written once.
//!
//! `KEEPOUT_WRITE_TRANSCRIPTS=1` writes the files anew; look at the difference before it is kept.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use keepout_executor::link::dialect::Language;
use keepout_executor::operator;
use keepout_executor::session::{Going, Record, SimRun, Tape, TapeError, run_simulated};
use keepout_executor::supervisor::Workpiece;
use keepout_executor::time::Time;
use keepout_planner::machine::MachineProfile;
use keepout_planner::order::Order;

/// What was said, one line for each turn: `>` to the controller, `<` from it.
#[derive(Default)]
struct Conversation {
    text: String,
    from_host: Option<bool>,
}

impl Conversation {
    fn say(&mut self, from_host: bool, bytes: &[u8]) {
        if self.from_host != Some(from_host) {
            self.text += if self.from_host.is_none() { "" } else { "\n" };
            self.text += if from_host { "> " } else { "< " };
            self.from_host = Some(from_host);
        }
        self.text += &bytes.escape_ascii().to_string();
    }
}

struct Recorder(Arc<Mutex<Conversation>>);

impl Tape for Recorder {
    fn take(&mut self, _: Time, record: &Record<'_>) -> Result<(), TapeError> {
        match record {
            Record::Sent(bytes) => self.0.lock().unwrap().say(true, bytes),
            Record::Received(bytes) => self.0.lock().unwrap().say(false, bytes),
            _ => {}
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), TapeError> {
        Ok(())
    }
}

fn conversation(language: &str) -> String {
    let bytes = include_bytes!("../drawings/bracket.dxf");
    let plan = Order::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap();
    let run = SimRun {
        language: Language::named(language).unwrap(),
        limit: Duration::from_millis(2500),
        ..SimRun::default()
    };
    let operator = operator::named("wall", 60.0, 1).unwrap();
    let conversation = Arc::new(Mutex::new(Conversation::default()));
    let tape = Box::new(Recorder(Arc::clone(&conversation)));
    let result =
        run_simulated(Workpiece::new(plan), &run, operator, tape, |_| {}, &mut |_, _, _| Going::On).unwrap();
    assert_eq!((result.facts.fault, result.facts.deepest_mm), (None, Some(0.0)));
    assert!(result.facts.counts.jogs > 0, "nothing was moved");
    let text = std::mem::take(&mut conversation.lock().unwrap().text);
    folded(&text)
}

/// A turn and its answer that come again word for word are written once.
fn folded(text: &str) -> String {
    let mut turns: Vec<&str> = text.lines().collect();
    for length in [2, 4] {
        let mut kept: Vec<&str> = Vec::new();
        for turn in turns.chunks(length) {
            if kept.len() < length || kept[kept.len() - length..] != *turn {
                kept.extend(turn);
            }
        }
        turns = kept;
    }
    turns.join("\n") + "\n"
}

fn compare(name: &str, language: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/transcripts").join(format!("{name}.txt"));
    let said = conversation(language);
    if std::env::var_os("KEEPOUT_WRITE_TRANSCRIPTS").is_some() {
        std::fs::write(&path, &said).unwrap();
        return;
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    let lines = said.lines().zip(kept.lines()).enumerate();
    for (number, (said, kept)) in lines {
        assert_eq!(said, kept, "{name}.txt line {}", number + 1);
    }
    assert_eq!(said.lines().count(), kept.lines().count(), "{name}.txt");
}

#[test]
fn built_in_languages() {
    for name in Language::NAMES {
        compare(name, name);
    }
}

#[test]
fn described_languages() {
    for name in ["nsk-style", "tango"] {
        compare(name, &format!("{}/dialects/{name}.toml", env!("CARGO_MANIFEST_DIR")));
    }
}
