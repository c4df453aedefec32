//! The tables of the study.

use super::attempt::Tally;
use super::results::{OurRow, PaperRow, Results};

/// A length as text, mm.
fn mm(value: f64) -> String {
    if value < 1.0 { format!("{value:.3}") } else { format!("{value:.2}") }
}

fn maybe(value: Option<f64>) -> String {
    value.map_or("-".into(), mm)
}

/// A share as text, per cent.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}

fn row<const N: usize>(cells: [String; N]) -> Vec<String> {
    cells.into()
}

fn named<const N: usize>(names: [&str; N]) -> Vec<String> {
    names.map(String::from).into()
}

fn fastest(tally: &Tally) -> String {
    tally.fastest_mm_s.map_or("-".into(), |fastest| format!("{fastest:.0}"))
}

/// Cells for the columns [`COUNTED`].
fn counted(tally: &Tally) -> Vec<String> {
    row([
        tally.attempts.to_string(),
        tally.successes.to_string(),
        percent(tally.success()),
        maybe(tally.mean_mm),
        maybe(tally.worst_mm),
        mm(tally.deepest_mm),
        format!("{:.1}", tally.seconds),
    ])
}

const COUNTED: [&str; 7] =
    ["attempts", "successes", "success %", "mean under-cutting mm", "worst mm", "deepest mm", "mean time s"];

/// Column of the highest speed of the tool.
const FASTEST: &str = "fastest mm/s";

impl Results {
    /// Table of the clearing runs.
    #[must_use]
    pub fn clearing_table(&self) -> Vec<Vec<String>> {
        let names = named([
            "profile",
            "system",
            "V mm/s",
            "T mm",
            "cleared to",
            "time s",
            "far stock (8 to 20 mm) cleared %",
            "far stock cleared mm²/s",
            "near stock (0.2 to 8 mm) cleared %",
            "deepest mm",
        ]);
        let rows = self.clearing.iter().map(|each| {
            row([
                each.profile.clone(),
                each.system.clone(),
                each.speed_mm_s.to_string(),
                mm(each.tolerance_mm),
                if each.all { "the wall".into() } else { "8 mm".into() },
                format!("{:.0}", each.found.seconds),
                percent(each.found.far),
                format!("{:.1}", each.found.far * each.found.far_mm2 / each.found.seconds),
                percent(each.found.near),
                mm(each.found.deepest_mm),
            ])
        });
        std::iter::once(names).chain(rows).collect()
    }

    /// Table of the finishing passes.
    #[must_use]
    pub fn finishing_table(&self) -> Vec<Vec<String>> {
        let names = named([
            "profile",
            "controller",
            "stock mm",
            "passes",
            "first pass max µm",
            "contour error RMS µm",
            "max µm",
        ]);
        let rows = self.finishing.iter().map(|each| {
            row([
                each.profile.clone(),
                each.controller.clone(),
                mm(each.stock_mm),
                each.passes.to_string(),
                each.first_max_mm.map_or("-".into(), |max| format!("{:.1}", 1000.0 * max)),
                format!("{:.2}", 1000.0 * each.rms_mm),
                format!("{:.1}", 1000.0 * each.max_mm),
            ])
        });
        std::iter::once(names).chain(rows).collect()
    }

    /// Table of the one-dimensional system.
    #[must_use]
    pub fn handwheel_table(&self) -> Vec<Vec<String>> {
        let mut names = named(["system", "wheel mm/s", "T mm", "released"]);
        names.extend(COUNTED.map(String::from));
        let rows = self.handwheel.iter().map(|each| {
            let mut cells = row([
                each.system.clone(),
                each.speed_mm_s.to_string(),
                mm(each.tolerance_mm),
                each.released.to_string(),
            ]);
            cells.extend(counted(&each.found));
            cells
        });
        std::iter::once(names).chain(rows).collect()
    }

    /// Table of the roughing passes.
    #[must_use]
    pub fn roughing_table(&self) -> Vec<Vec<String>> {
        let names = named([
            "profile",
            "system",
            "V mm/s",
            "T mm",
            "approaches",
            "invasions",
            "deepest mm",
            "stock left, mean mm",
            "most mm",
            "time s",
        ]);
        let rows = self.roughing.iter().map(|each| {
            row([
                each.profile.clone(),
                each.system.clone(),
                each.speed_mm_s.to_string(),
                mm(each.tolerance_mm),
                each.approaches.to_string(),
                each.invasions.to_string(),
                mm(each.deepest_mm),
                mm(each.left_mm),
                mm(each.most_left_mm),
                format!("{:.0}", each.seconds),
            ])
        });
        std::iter::once(names).chain(rows).collect()
    }

    /// Table of the one-dimensional system with a gradual brake.
    #[must_use]
    pub fn brake_table(&self) -> Vec<Vec<String>> {
        let mut names = named(["hand mm/s", "band mm", "round ms", "released"]);
        names.extend(COUNTED.map(String::from));
        let rows = self.brake.iter().map(|each| {
            let mut cells = row([
                each.speed_mm_s.to_string(),
                each.band_mm.to_string(),
                format!("{:.0}", 1000.0 * each.round_s),
                each.released.to_string(),
            ]);
            cells.extend(counted(&each.found));
            cells
        });
        std::iter::once(names).chain(rows).collect()
    }

    /// Statistics of all attempts with Keepout.
    #[must_use]
    pub fn ours_together(&self) -> Tally {
        let tallies: Vec<Tally> = self.ours.iter().chain(&self.driven).map(|row| row.found).collect();
        Tally::together(&tallies)
    }

    /// Table of Keepout by profile and speed, over all delays of the line.
    #[must_use]
    pub fn ours_by_speed(&self) -> Vec<Vec<String>> {
        let mut names = named(["profile", "V mm/s", "T mm"]);
        names.extend(COUNTED.map(String::from));
        names.push(FASTEST.into());
        let mut table = vec![names];
        for rows in self.ours.chunk_by(|a, b| a.profile == b.profile && a.speed_mm_s == b.speed_mm_s) {
            let mut cells =
                row([rows[0].profile.clone(), rows[0].speed_mm_s.to_string(), mm(rows[0].tolerance_mm)]);
            let tallies: Vec<Tally> = rows.iter().map(|row| row.found).collect();
            let together = Tally::together(&tallies);
            cells.extend(counted(&together));
            cells.push(fastest(&together));
            table.push(cells);
        }
        table
    }

    /// Table of Keepout by delay of the line, over all profiles and speeds.
    #[must_use]
    pub fn ours_by_latency(&self) -> Vec<Vec<String>> {
        let mut latencies: Vec<u64> = self.ours.iter().map(|row| row.latency_ms).collect();
        latencies.sort_unstable();
        latencies.dedup();
        let mut names = named(["delay each way ms"]);
        names.extend(COUNTED.map(String::from));
        let mut table = vec![names];
        for latency in latencies {
            let rows = self.ours.iter().filter(|row| row.latency_ms == latency);
            let tallies: Vec<Tally> = rows.map(|row| row.found).collect();
            let mut cells = vec![latency.to_string()];
            cells.extend(counted(&Tally::together(&tallies)));
            table.push(cells);
        }
        table
    }
}

/// Table of the rows of Keepout.
#[must_use]
pub fn ours_table(rows: &[OurRow]) -> Vec<Vec<String>> {
    let mut names = named(["profile", "V mm/s", "delay each way ms", "T mm"]);
    names.extend(COUNTED.map(String::from));
    names.push(FASTEST.into());
    let rows = rows.iter().map(|each| {
        let mut cells = row([
            each.profile.clone(),
            each.speed_mm_s.to_string(),
            each.latency_ms.to_string(),
            mm(each.tolerance_mm),
        ]);
        cells.extend(counted(&each.found));
        cells.push(fastest(&each.found));
        cells
    });
    std::iter::once(names).chain(rows).collect()
}

/// Table of the rows of Tables 2 and 3: the reported values and ours.
#[must_use]
pub fn paper_table(rows: &[PaperRow]) -> Vec<Vec<String>> {
    let mut names = named([
        "table",
        "profile",
        "V mm/s",
        "T mm",
        "fitted",
        "reported successes",
        "reported %",
        "reported mm",
    ]);
    names.extend(COUNTED.map(String::from));
    names.extend(
        ["false alarms", "success error, percentage points", "under-cutting error mm", "within chance"]
            .map(String::from),
    );
    let rows = rows.iter().map(|each| {
        let PaperRow { reported, found } = each;
        let mut cells = row([
            reported.table.clone(),
            reported.profile.clone(),
            reported.feed_mm_s.to_string(),
            reported.tolerance_mm.to_string(),
            if reported.calibrates { "yes".into() } else { "no".into() },
            format!("{}/{}", reported.successes, reported.attempts),
            percent(reported.success()),
            maybe(reported.under_cutting_mm),
        ]);
        cells.extend(counted(found));
        cells.push(found.false_alarms.to_string());
        let signed = |value: f64, digits: usize| format!("{value:+.digits$}");
        cells.push(signed(each.success_error(), 1));
        cells.push(each.under_cutting_error().map_or("-".into(), |error| signed(error, 2)));
        cells.push(if each.is_within_chance() { "yes".into() } else { "no".into() });
        cells
    });
    std::iter::once(names).chain(rows).collect()
}

impl PaperRow {
    /// Difference between our success and the reported success, percentage points.
    #[must_use]
    pub fn success_error(&self) -> f64 {
        100.0 * (self.found.success() - self.reported.success())
    }

    /// Difference between our mean under-cutting and the reported one, mm. `None` if one of them is missing.
    #[must_use]
    pub fn under_cutting_error(&self) -> Option<f64> {
        Some(self.found.mean_mm? - self.reported.under_cutting_mm?)
    }

    /// Whether the reported number of successes agrees with our success as the true share.
    #[must_use]
    pub fn is_within_chance(&self) -> bool {
        self.reported.is_within_chance(self.found.success())
    }
}
