//! The page and the picture that a shop keeps with the part. They show the facts that the log proves, and the
//! timeline.

use std::time::Duration;

use keepout_guard::Time;
use keepout_kernel::{Height, Point, Segment};
use keepout_planner::job::Progress;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::report::html::JobPage;
use keepout_planner::report::{RunDrawing, Spot, SpotKind, Trace, TraceKind, svg};
use keepout_planner::sha256::hex;
use keepout_planner::units::{height_from_mm, mm, point_from_mm, point_mm};

use super::log::Header;
use super::outcome::contour_rows;
use super::replay::{PhaseTimes, Replay, TimelineEntry};
use super::report::{count_rows, part_rows, section_of_run, stock_rows, traces};
use crate::session::{Sample, SampleKind};

/// The picture of a run from its log, with contact starts and stops. It shows jogging from one reported
/// position to the next, and the contour as sent.
#[must_use]
pub fn picture_of_log(header: &Header, replay: &Replay) -> String {
    let timeline = &replay.timeline;
    let spot = |(_, happening, at): &(Time, TimelineEntry, Option<Point>)| {
        let kind = match happening {
            TimelineEntry::Touched => SpotKind::ProbePoint,
            TimelineEntry::Held | TimelineEntry::Fault(_) => SpotKind::Stop,
            _ => return None,
        };
        Some(Spot { kind, at_mm: point_mm((*at)?) })
    };
    let spots: Vec<Spot> = timeline.happenings.iter().filter_map(spot).collect();
    let plan = replay.supervisor.plan();
    let mut drawn = traces_by_hand(plan, &timeline.samples);
    let contours = timeline.contours.iter().cloned();
    drawn.extend(contours.map(|points_mm| Trace { kind: TraceKind::Contour, points_mm }));
    // The picture shows the tool at the end of the last trace.
    drawn.extend(
        timeline
            .samples
            .last()
            .map(|last| Trace { kind: TraceKind::Manual, points_mm: vec![last.position_mm.plane()] }),
    );
    let title = format!("{}, {}: jogging as reported, contour as sent", header.drawing, header.began);
    let progress = replay.supervisor.progress();
    svg(plan, &title, &RunDrawing { traces: &drawn, spots: &spots, progress: Some(&progress) })
}

/// The jogging traces, from one reported position to the next. If the straight line between two positions
/// would cut the part, the tool took another path, and the picture leaves the line out.
fn traces_by_hand(plan: &CertifiedPlan, samples: &[Sample]) -> Vec<Trace> {
    let clear = |a: &Sample, b: &Sample| {
        let (Ok(from), Ok(to)) = (point_from_mm(a.position_mm.plane()), point_from_mm(b.position_mm.plane()))
        else {
            return false;
        };
        // In a session with two axes the height is zero, and this is the part.
        let lowest = height_from_mm(a.position_mm.z.min(b.position_mm.z)).unwrap_or(Height::LOWEST);
        plan.levels.at(lowest).edges_clear(Segment { from, to }, plan.plan.tool_radius).is_ok()
    };
    let by_hand = |pair: &[Sample]| pair.iter().all(|sample| sample.kind == SampleKind::Jog);
    let stretches = samples.chunk_by(|a, b| by_hand(&[*a, *b]) && clear(a, b));
    stretches.flat_map(traces).filter(|trace| trace.kind == TraceKind::Manual).collect()
}

/// The page: title block, picture, contours, then the proof with timeline and plan. `head`: the title block's rows.
/// `file` names the log.
#[must_use]
pub fn page_of_log(
    header: &Header,
    replay: &Replay,
    head: &[(String, String)],
    file: &str,
    checksum: u32,
) -> String {
    let plan = replay.supervisor.plan();
    let outcome = replay.outcome();
    let mut facts = part_rows(plan);
    facts.extend(time_rows(header, replay));
    let mut proof = job_rows(header, plan);
    proof.extend(run_rows(replay));
    // A session that goes on from an earlier one does not know what that one removed.
    if header.progress == Progress::default() {
        proof.extend(stock_rows(plan, &replay.timeline.samples));
    }
    proof.extend(proof_rows(replay, file, checksum));
    JobPage {
        title: format!("{}, {}", header.drawing, header.began),
        outcome: outcome.to_string(),
        is_complete: outcome.is_complete(),
        head: head.to_vec(),
        facts,
        contours: contour_rows(plan, &replay.supervisor.progress()),
        picture: picture_of_log(header, replay),
        section: section_of_run(plan, &header.drawing, &replay.timeline.samples),
        proof,
        timeline: happenings(replay).collect(),
        plan: plan.summary(),
    }
    .html()
}

/// A row of a table.
pub(super) fn row(name: &str, value: impl Into<String>) -> (String, String) {
    (name.into(), value.into())
}

/// The rows about plan and machine.
fn job_rows(header: &Header, plan: &CertifiedPlan) -> Vec<(String, String)> {
    let budget = &plan.plan.budget;
    vec![
        row("drawing SHA-256", hex(&plan.plan.provenance.hash)),
        row("plan SHA-256", &header.plan),
        row("margin M", format!("{:.5} mm", budget.total().map_or(f64::NAN, |m| mm(m.units())))),
        row("dialect", &header.dialect),
        row(
            "drawing's origin on the machine",
            format!("({:.3}, {:.3}) mm", mm(header.offset.dx), mm(header.offset.dy)),
        ),
        row("operator", &header.operator),
    ]
}

/// The rows about feed, machine and times.
fn time_rows(header: &Header, replay: &Replay) -> Vec<(String, String)> {
    let PhaseTimes { starting, by_hand, touching, contouring, held, stopped } = replay.timeline.spent;
    let earlier = header.progress.finished.len();
    let mut rows = vec![
        row("feed", format!("{} mm/min", header.feed_mm_min)),
        row("machine", &header.setting),
        row("began", &header.began),
        row("jogging", span(by_hand)),
        row("contouring", span(contouring)),
        row("other time", span(starting + touching + held + stopped)),
    ];
    if earlier > 0 {
        rows.push(row(
            "earlier sessions",
            format!(
                "{earlier} finishing loops were cut before. Times and counts are of the last session alone."
            ),
        ));
    }
    rows
}

/// The rows about the run: approach, commands.
fn run_rows(replay: &Replay) -> Vec<(String, String)> {
    let closest = replay.timeline.closest_mm().map_or("no position was reported".into(), |(mm, at)| {
        format!("{mm:.4} mm at {}, of the positions that the controller reported", clock(at))
    });
    let mut rows = vec![
        row("time span", format!("{} after it began", clock(replay.counted.ended))),
        row("closest approach of tool and part", closest),
    ];
    rows.extend(count_rows(&replay.supervisor.counts()));
    rows
}

/// The rows about the proof behind this page.
fn proof_rows(replay: &Replay, file: &str, checksum: u32) -> Vec<(String, String)> {
    let counted = &replay.counted;
    vec![
        row("log", file),
        row("log checksum", format!("{checksum:08x} over all lines, each checked with the one before")),
        row(
            "certified again for this page",
            format!(
                "{} sent chunks match byte by byte, {} certificates hold by themselves",
                counted.commands, counted.certificates
            ),
        ),
    ]
}

/// The rows of the timeline: time, entry, position.
fn happenings(replay: &Replay) -> impl Iterator<Item = [String; 3]> {
    replay.timeline.happenings.iter().map(|(at, happening, place)| {
        let what = match happening {
            TimelineEntry::Touched => "contour requested".into(),
            TimelineEntry::Contouring => "contouring".into(),
            TimelineEntry::Held => "feed hold".into(),
            TimelineEntry::Finished(number) => {
                format!("{} is cut", replay.supervisor.plan().loop_name(*number))
            }
            TimelineEntry::Told(notice) => format!("note: {notice}"),
            TimelineEntry::Fault(fault) => format!("stopped: {fault}"),
            TimelineEntry::Recovered => "recovered: the session begins again with the controller".into(),
            TimelineEntry::Ended => "the session ended".into(),
        };
        [clock(*at), what, place.map_or(String::new(), |at| at.to_string())]
    })
}

/// Minutes and seconds since the session began.
fn clock(at: Time) -> String {
    span(Duration::from_micros(at.micros()))
}

fn span(span: Duration) -> String {
    let (minutes, seconds) = (span.as_secs() / 60, span.as_secs() % 60);
    let millis = span.subsec_millis();
    if minutes == 0 {
        format!("{seconds}.{millis:03} s")
    } else {
        format!("{minutes} min {seconds:02}.{millis:03} s")
    }
}
