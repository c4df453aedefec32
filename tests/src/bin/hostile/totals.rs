//! Sums over the sessions of a run.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use keepout_campaigns::{ShardRecord, mix};
use keepout_tests::hostile::{HostileWorld, Outcome, Spec, Verdict};

/// Sums over the sessions of a run. Threads add to them.
#[derive(Default)]
pub struct Totals {
    /// Sessions.
    pub sessions: AtomicU64,
    /// Drawings.
    pub worlds: AtomicU64,
    /// Sessions that did not reach their end.
    pub broken: AtomicU64,
    millis: AtomicU64,
    /// Of these, with three axes.
    deep_millis: AtomicU64,
    jogs: AtomicU64,
    contour_motions: AtomicU64,
    cancels: AtomicU64,
    rounds: AtomicU64,
    way_m: AtomicU64,
    contours: AtomicU64,
    faults: AtomicU64,
    gouges: AtomicU64,
    jogs_in_stock: AtomicU64,
    recoveries: AtomicU64,
    /// Sum of a digest of each session and its outcome. It does not depend on the order of the sessions.
    fingerprint: AtomicU64,
    ends: Mutex<BTreeMap<String, u64>>,
}

impl Totals {
    /// Adds a session.
    pub fn add(&self, world: &HostileWorld, spec: &Spec, outcome: &Outcome) {
        let deep = world.place.z.is_some();
        let add = |counter: &AtomicU64, value: u64| {
            counter.fetch_add(value, Ordering::Relaxed);
        };
        add(&self.sessions, 1);
        let millis = Duration::from_secs_f64(outcome.seconds).as_millis().try_into().unwrap_or(0);
        add(&self.millis, millis);
        add(&self.deep_millis, if deep { millis } else { 0 });
        add(&self.jogs, outcome.counts.jogs);
        add(&self.contour_motions, outcome.counts.contour_motions);
        add(&self.cancels, outcome.counts.cancels);
        add(&self.rounds, outcome.rounds);
        add(
            &self.way_m,
            Duration::from_secs_f64(outcome.way_mm / 1000.0).as_micros().try_into().unwrap_or(0),
        );
        add(&self.contours, outcome.contoured.try_into().unwrap_or(0));
        add(&self.faults, outcome.faults);
        add(&self.recoveries, outcome.recoveries);
        match outcome.verdict {
            Some(Verdict::Gouge { .. }) => add(&self.gouges, 1),
            Some(Verdict::StockToLeave { .. }) => add(&self.jogs_in_stock, 1),
            None => {}
        }
        add(&self.broken, u64::from(outcome.ended.is_none()));
        let session = [world.seed, spec.seed, millis, outcome.counts.jogs, outcome.rounds];
        add(&self.fingerprint, session.into_iter().fold(0, |digest, value| mix(digest ^ value)));
        let end = outcome
            .fault
            .as_deref()
            .map_or("ended without a fault", |fault| fault.split([':', '.', '(']).next().unwrap_or(fault));
        // Garbage has many forms: count all of it in one row.
        let garbled = end.starts_with("the controller sent");
        let end = if garbled { "the controller sent what is not its language" } else { end };
        let end: String = end.chars().filter(|letter| !letter.is_ascii_digit()).take(60).collect();
        if let Ok(mut ends) = self.ends.lock() {
            *ends.entry(end).or_default() += 1;
        }
    }

    /// Simulated hours.
    pub fn hours(&self) -> f64 {
        Duration::from_millis(self.millis.load(Ordering::Relaxed)).as_secs_f64() / 3600.0
    }

    /// Enters the sums into the results of a shard.
    pub fn enter(&self, record: &mut ShardRecord) {
        for (name, counter) in [
            ("sessions", &self.sessions),
            ("drawings", &self.worlds),
            ("simulated time, ms", &self.millis),
            ("simulated time with three axes, ms", &self.deep_millis),
            ("jogs", &self.jogs),
            ("cancels", &self.cancels),
            ("contour motions", &self.contour_motions),
            ("loops contoured", &self.contours),
            ("travel, µm", &self.way_m),
            ("decisions", &self.rounds),
            ("line faults", &self.faults),
            ("gouges", &self.gouges),
            ("jogs in the stock to leave", &self.jogs_in_stock),
            ("recoveries", &self.recoveries),
            ("fingerprint of the sessions", &self.fingerprint),
        ] {
            record.total(name, counter.load(Ordering::Relaxed));
        }
        if let Ok(ends) = self.ends.lock() {
            ends.iter().for_each(|(end, count)| record.total(&format!("end: {end}"), *count));
        }
    }

    /// Prints how many of the line's faults were followed by a gouge, or by a jog in the stock to leave.
    pub fn print_verdicts(&self) {
        let get = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let (faults, gouges, jogs) = (get(&self.faults), get(&self.gouges), get(&self.jogs_in_stock));
        println!(
            "{faults} altered digits: {gouges} sessions with a gouge, {jogs} with a jog in the stock to leave"
        );
    }

    /// Prints the sums.
    pub fn print(&self) {
        let get = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        println!(
            "{:.1} simulated hours, {:.1} of them with three axes, {} sessions, {} drawings",
            self.hours(),
            Duration::from_millis(get(&self.deep_millis)).as_secs_f64() / 3600.0,
            get(&self.sessions),
            get(&self.worlds)
        );
        println!(
            "{} jogs, {} cancels, {} contour motions, {} loops contoured, {:.1} km travelled",
            get(&self.jogs),
            get(&self.cancels),
            get(&self.contour_motions),
            get(&self.contours),
            Duration::from_micros(get(&self.way_m)).as_secs_f64() / 1000.0
        );
        println!(
            "{} decisions, {} line faults, {} recoveries",
            get(&self.rounds),
            get(&self.faults),
            get(&self.recoveries)
        );
        if let Ok(ends) = self.ends.lock() {
            for (end, count) in ends.iter() {
                println!("  {count:>9}  {end}");
            }
        }
    }
}
