//! The named differences between the two models. `docs/integrator/second-model.md` explains each.

use crate::judge::Differs;
use crate::script::Vocabulary;

/// A difference that the documentation of the firmware decides, or leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NamedDifference {
    /// "G1G2" in one line: the first model answers 21, the second 24. The documentation fits both.
    TwoMotionWords,
    /// A negative feed: the first model answers 22 or 31, the second 4.
    NegativeFeed,
    /// `$J` without `=`: the first model answers 3, the second 16.
    JogWithoutEquals,
    /// A reset at the end of a motion: one model still moves, and raises an alarm.
    ResetAtTheEnd,
    /// A few reports of a short state: the models start and end a motion some milliseconds apart.
    ShortState,
    /// The first model rejects words and forms of G-code that it does not know.
    NotInTheFirstModel,
    /// The first model accepts unknown and unused words of a motion.
    UnusedWords,
    /// The first model answers `$$`, `$#`, `$I` and `$N` in motion, the second rejects them.
    QueriesInMotion,
    /// Both reject the line, with other numbers.
    OtherErrorNumber,
    /// A jog behind a motion of another host: the second model starts that motion later, and still is idle.
    JogWhileIdle,
}

impl NamedDifference {
    /// The name of a difference, and `None` for an unknown one.
    pub fn of(found: &Differs, vocabulary: Vocabulary) -> Option<Self> {
        let (first, second) = match found {
            Differs::States(..) => return Some(Self::ShortState),
            Differs::Answers(_, first, second) => (first.as_str(), second.as_str()),
            _ => return None,
        };
        let resets = [first, second].iter().any(|answer| answer.starts_with("Grbl"));
        let rejects = |answer: &str| answer.starts_with("error:");
        let named = match (first, second) {
            ("error:21", "error:24") => Self::TwoMotionWords,
            ("error:22" | "error:31", "error:4") => Self::NegativeFeed,
            ("error:3", "error:16") => Self::JogWithoutEquals,
            _ if resets && [first, second].contains(&"ALARM:3") => Self::ResetAtTheEnd,
            _ if vocabulary != Vocabulary::OtherHosts => return None,
            ("ok" | "ALARM:2", "error:20" | "error:36") => Self::UnusedWords,
            ("ok", "error:8") => Self::QueriesInMotion,
            ("error:8", "ok") => Self::JogWhileIdle,
            (first, "ok" | "none") if rejects(first) => Self::NotInTheFirstModel,
            (first, second) if rejects(first) && rejects(second) => Self::OtherErrorNumber,
            _ => return None,
        };
        Some(named)
    }
}
