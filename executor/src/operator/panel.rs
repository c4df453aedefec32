//! The panel of an operator's device: notices, and one status line.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most notices that the panel keeps. It drops the oldest one first.
const NOTICES_MAX: usize = 32;

/// The panel, shared by the operator, the threads that read its devices, and the view. A lock lasts for one
/// copy at most.
#[derive(Clone, Debug, Default)]
pub struct Panel(Arc<Mutex<Lines>>);

#[derive(Debug, Default)]
struct Lines {
    notices: VecDeque<String>,
    /// Notices since the beginning, the dropped ones included.
    count: usize,
    status: String,
    help: bool,
    taken: usize,
}

impl Panel {
    /// Adds a notice. A repetition of the last notice is ignored.
    pub fn say(&self, notice: impl Into<String>) {
        let (mut lines, notice) = (self.lines(), notice.into());
        if lines.notices.back() == Some(&notice) {
            return;
        }
        if lines.notices.len() >= NOTICES_MAX {
            lines.notices.pop_front();
        }
        lines.notices.push_back(notice);
        lines.count += 1;
    }

    /// Sets the status line of the device, such as its step size.
    pub fn set_status(&self, status: &str) {
        let mut lines = self.lines();
        if lines.status != status {
            lines.status = status.into();
        }
    }

    /// Counts a place that the operator takes.
    pub fn take(&self, count: usize) {
        self.lines().taken += count;
    }

    /// Number of places that the operator took.
    #[must_use]
    pub fn taken(&self) -> usize {
        self.lines().taken
    }

    /// Shows or hides the help.
    pub fn set_help(&self, help: bool) {
        self.lines().help = help;
    }

    /// Whether the operator requests the help.
    #[must_use]
    pub fn help(&self) -> bool {
        self.lines().help
    }

    /// The status line of the device.
    #[must_use]
    pub fn status(&self) -> String {
        self.lines().status.clone()
    }

    /// The last notices, oldest first.
    #[must_use]
    pub fn notices(&self) -> Vec<String> {
        self.lines().notices.iter().cloned().collect()
    }

    /// The kept notices after the first `known`, and the count of all notices.
    #[must_use]
    pub fn since(&self, known: usize) -> (Vec<String>, usize) {
        let lines = self.lines();
        let new = lines.count.saturating_sub(known).min(lines.notices.len());
        (lines.notices.range(lines.notices.len() - new..).cloned().collect(), lines.count)
    }

    fn lines(&self) -> MutexGuard<'_, Lines> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notices_are_bounded_and_not_repeated() {
        let panel = Panel::default();
        for _ in 0..3 {
            panel.say("unplugged");
        }
        assert_eq!(panel.notices(), ["unplugged"]);
        for number in 0..100 {
            panel.say(number.to_string());
        }
        assert_eq!(panel.notices().len(), NOTICES_MAX);
        assert_eq!(panel.since(99), (vec!["98".into(), "99".into()], 101));
        assert_eq!(panel.since(0).0.len(), NOTICES_MAX);
        assert_eq!(panel.since(500).0.len(), 0);
        assert_eq!(panel.notices().last().map(String::as_str), Some("99"));
    }
}
