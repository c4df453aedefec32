//! Polling: status queries, their answers, and how long each takes.
//!
//! Implements SR-08.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_guard::{Guard, QueryStamp, Time};

/// Greatest number of queries without an answer.
const QUERIES_MAX: usize = 64;
/// Number of repetitions of an unanswered query within the longest permitted silence.
const QUERIES_IN_SILENCE: u32 = 5;
/// Time between an answer and the next query.
pub(super) const QUERY_PAUSE: Duration = Duration::from_millis(20);
/// The same while the supervisor waits until the tool stops, or until the controller has read a contour
/// motion.
const QUERY_SOON: Duration = Duration::from_millis(10);
/// A repeated answer arrives within the time of this number of bits: 140 bytes.
const ECHO_BITS: u64 = 1400;

/// The state of the polling.
#[derive(Debug)]
pub(super) struct Polling {
    /// Time of the last message from the controller.
    pub(super) heard_at: Time,
    /// Time of the last report of another position, or of no motion.
    pub(super) moved_at: Time,
    /// Queries without an answer, oldest first.
    queries: VecDeque<QueryStamp>,
    /// Send time of the last query. `None` once a report answered it.
    asked_at: Option<Time>,
    /// Send time of the oldest query since the last report.
    waits_since: Option<Time>,
    /// Recent time from the oldest such query to the report.
    patience: Duration,
    /// Time of the last answer.
    answered_at: Time,
    /// Recent time from a query to its answer.
    pub(super) round_trip: Duration,
    /// Time from the last query to its answer.
    last_trip: Duration,
    /// Whether a motion was sent since the last query.
    pub(super) owed: bool,
    /// Start of the time in which the controller is idle with a line unacknowledged.
    unacknowledged_since: Option<Time>,
}

impl Default for Polling {
    fn default() -> Self {
        Self {
            heard_at: Time::ZERO,
            moved_at: Time::ZERO,
            queries: VecDeque::with_capacity(QUERIES_MAX),
            asked_at: None,
            waits_since: None,
            patience: Duration::ZERO,
            answered_at: Time::ZERO,
            round_trip: Duration::from_millis(100),
            last_trip: Duration::ZERO,
            owed: false,
            unacknowledged_since: None,
        }
    }
}

impl Polling {
    /// Number of queries without an answer.
    pub(super) fn open(&self) -> usize {
        self.queries.len()
    }

    /// Whether another query may be sent.
    pub(super) fn has_room(&self) -> bool {
        self.queries.len() < QUERIES_MAX
    }

    /// Takes note of a query that is sent now.
    pub(super) fn ask(&mut self, stamp: QueryStamp, now: Time) {
        self.owed = false;
        self.asked_at = Some(now);
        self.waits_since.get_or_insert(now);
        self.queries.push_back(stamp);
    }

    /// Takes note of a report. Returns the stamp of the query that it answers, if a query is open.
    pub(super) fn answered(&mut self, now: Time, answer_within: Duration) -> Option<QueryStamp> {
        if let Some(asked) = self.asked_at.take() {
            self.last_trip = now.since(asked);
            self.round_trip = smoothed(self.round_trip, self.last_trip);
        }
        if let Some(since) = self.waits_since.take() {
            self.patience = smoothed(self.patience, now.since(since).min(answer_within / 3));
        }
        let stamp = self.queries.pop_front();
        // A report without a query does not put off the next query.
        if stamp.is_some() {
            self.answered_at = now;
        }
        stamp
    }

    /// Takes note of an acknowledged line. The answer to a query that left before this line would have
    /// arrived before the acknowledgement, so older queries are dropped.
    pub(super) fn acknowledged(&mut self, guard: &Guard) {
        self.unacknowledged_since = None;
        self.queries.retain(|stamp| !guard.is_outdated(stamp));
    }

    /// Takes note of whether the controller is idle with a line unacknowledged. Returns the duration of this
    /// state.
    pub(super) fn unacknowledged_for(&mut self, idle: bool, now: Time) -> Duration {
        self.unacknowledged_since = if idle { self.unacknowledged_since.or(Some(now)) } else { None };
        self.unacknowledged_since.map_or(Duration::ZERO, |since| now.since(since))
    }

    /// Time of the next query. `soon`: the supervisor waits for an event that only a report shows.
    pub(super) fn due(&self, answer_within: Duration, baud: u32, soon: bool) -> Time {
        let Some(asked) = self.asked_at else {
            // A repeated answer must not count as the answer to a later query.
            let echo = self.last_trip.min(Duration::from_secs(ECHO_BITS) / baud.max(1));
            let pause = if soon { QUERY_SOON } else { QUERY_PAUSE };
            return self.answered_at.after(pause.max(echo));
        };
        let again = answer_within / QUERIES_IN_SILENCE;
        asked.after(again.max(self.round_trip.max(self.patience) * 2))
    }

    /// Drops the open queries: the session has ended.
    pub(super) fn drop_queries(&mut self) {
        self.queries.clear();
    }

    /// Begins again, as after a message from the controller.
    pub(super) fn restart(&mut self, now: Time) {
        self.queries.clear();
        (self.asked_at, self.waits_since, self.unacknowledged_since) = (None, None, None);
        self.heard_at = now;
    }

    /// Pretends that an answer arrived now.
    #[cfg(test)]
    pub(super) fn answer_now(&mut self, now: Time) {
        (self.heard_at, self.answered_at) = (now, now);
    }
}

/// A recent time: quick to grow, slow to shrink.
fn smoothed(before: Duration, measured: Duration) -> Duration {
    if measured > before { measured } else { (before * 7 + measured) / 8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-08.
    #[test]
    fn a_report_answers_the_oldest_query() {
        let mut guard = keepout_guard::guard_in_open_space().unwrap();
        guard.locate(keepout_kernel::Point::ORIGIN.in_plane()).unwrap();
        let (mut polling, within) = (Polling::default(), Duration::from_secs(10));
        let at = |ms| Time::ZERO.after(Duration::from_millis(ms));
        let stamps = [5, 10, 15].map(|ms| guard.stamp(at(ms)));
        stamps.iter().for_each(|stamp| polling.ask(*stamp, at(5)));
        let answers: Vec<_> = (0..4).map(|k| polling.answered(at(100 + k), within)).collect();
        assert_eq!(answers, [Some(stamps[0]), Some(stamps[1]), Some(stamps[2]), None]);
    }
}
