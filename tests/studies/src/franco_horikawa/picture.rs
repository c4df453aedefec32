//! The pictures of the study: roughing paths like Fig. 8, and success over tolerance.

use std::cmp::Ordering;

use keepout_planner::Mm2;
use keepout_planner::report::chart::sheet;
use keepout_planner::report::element::{Element, Lines, background, circle, path, points, polyline, text};
use keepout_planner::report::{RunDrawing, Trace, TraceKind, svg};

use super::attempt::Attempt;
use super::ours::Ours;
use super::paper_picture::{self, DrawnAttempt};
use super::results::{PaperRow, Results, our_attempts, paper_attempts};
use super::roughing;
use super::scenario::{Reported, Scenarios, StudyError};

/// Number of attempts in a picture.
const DRAWN: u64 = 24;
/// Smallest distance of two drawn points of a path, mm.
const APART_MM: f64 = 0.25;
/// Width of the chart.
const WIDTH: f64 = 560.0;
/// Height of the chart.
const HEIGHT: f64 = 300.0;
/// Margin of the chart.
const MARGIN: f64 = 46.0;
/// Largest tolerance in the chart, mm.
const WIDEST_MM: f64 = 5.5;
const SLOW: &str = "#2c6fd1";
const QUICK: &str = "#d97a00";
const OURS: &str = "#0b7a3b";

/// The file name of a picture, and its SVG text.
pub type Picture = (String, String);

/// Draws roughing paths at every profile, with the paper's controller and with Keepout.
///
/// # Errors
/// [`StudyError`] if an attempt can not run.
pub fn paths(scenarios: &Scenarios, seed: u64) -> Result<Vec<Picture>, StudyError> {
    let mut pictures = Vec::new();
    for (number, shape) in scenarios.profile.iter().enumerate() {
        let reported = scenarios.row.iter().enumerate().filter(|(_, row)| row.profile == shape.name);
        let ours = Ours::new(shape, scenarios.tool_diameter_mm, scenarios.ours_mm_s[0])?;
        let plan = &ours.work.plan;
        // Take the largest tolerance that the paper reports for the profile, at the slower feed.
        let order = |row: &Reported| (-row.tolerance_mm, row.feed_mm_s);
        let widest = reported.min_by(|a, b| order(a.1).partial_cmp(&order(b.1)).unwrap_or(Ordering::Equal));
        if let Some((row, reported)) = widest {
            let tried = paper_attempts(scenarios, row, (DRAWN, seed))?;
            let drawn: Vec<DrawnAttempt> = tried
                .iter()
                .map(|attempt| DrawnAttempt { points_mm: thin(attempt), invades: attempt.depth_mm > 0.0 })
                .collect();
            let picture = paper_picture::svg(shape, reported, scenarios.tool_diameter_mm, &drawn)?;
            pictures.push((format!("{}-paper.svg", shape.name), picture));
        }
        let speed = scenarios.ours_mm_s[0];
        let tried = our_attempts(scenarios, (number, speed), (DRAWN, seed))?;
        let title = format!("{}: Keepout, V = {speed} mm/s, T = {:.3} mm", shape.title, ours.tolerance_mm());
        let mut traces = traces(&tried);
        traces.push(Trace { kind: TraceKind::Contour, points_mm: ours.contour(seed)? });
        pictures.push((format!("{}-ours.svg", shape.name), svg(plan, &title, &run_of(&traces))));
    }
    Ok(pictures)
}

/// Draws a roughing pass all round each profile of Fig. 8, with the paper's controller and with Keepout, and the path
/// of finishing.
///
/// # Errors
/// [`StudyError`] if a pass can not run.
pub fn passes(scenarios: &Scenarios, seed: u64) -> Result<Vec<Picture>, StudyError> {
    let (mut pictures, speed) = (Vec::new(), scenarios.ours_mm_s[0]);
    for shape in scenarios.of_fig_8() {
        let (pass, run) = roughing::with_paper(scenarios, shape, speed, seed)?;
        let picture = paper_picture::pass_svg(shape, &pass, scenarios.tool_diameter_mm, &thin(&run))?;
        pictures.push((format!("{}-pass-paper.svg", shape.name), picture));
        let (pass, run) = roughing::with_ours(scenarios, shape, speed, seed)?;
        let ours = Ours::new(shape, scenarios.tool_diameter_mm, speed)?;
        let title = format!("Keepout all round, V = {speed} mm/s, T = {:.3} mm", pass.tolerance_mm);
        let rough = Trace { kind: TraceKind::Manual, points_mm: thin(&run) };
        let finishing = Trace { kind: TraceKind::Contour, points_mm: ours.contour(seed)? };
        let traces = [rough, finishing];
        pictures
            .push((format!("{}-pass-ours.svg", shape.name), svg(&ours.work.plan, &title, &run_of(&traces))));
    }
    Ok(pictures)
}

fn run_of(traces: &[Trace]) -> RunDrawing<'_> {
    RunDrawing { traces, ..RunDrawing::default() }
}

fn traces(attempts: &[Attempt]) -> Vec<Trace> {
    attempts.iter().map(|attempt| Trace { kind: TraceKind::Manual, points_mm: thin(attempt) }).collect()
}

/// The path of an attempt without the points that are too close to be seen.
fn thin(attempt: &Attempt) -> Vec<Mm2> {
    let mut points_mm: Vec<Mm2> = Vec::new();
    for (number, &at) in attempt.path.iter().enumerate() {
        let far = |last: &Mm2| at.distance(*last) >= APART_MM;
        if number + 1 == attempt.path.len() || points_mm.last().is_none_or(far) {
            points_mm.push(at);
        }
    }
    points_mm
}

/// Draws the success over the tolerance on the external triangle: reported, simulated, and with Keepout.
#[must_use]
pub fn chart(results: &Results) -> String {
    let x = |tolerance: f64| MARGIN + (WIDTH - 2.0 * MARGIN) * tolerance / WIDEST_MM;
    let y = |share: f64| HEIGHT - MARGIN - (HEIGHT - 2.0 * MARGIN) * share;
    let mut body = Lines::default();
    body.draw(&[background("#fff")]);
    let title = "Attempts without invasion, external triangle, over tolerance T in mm";
    body.draw(&[text((MARGIN, 18.0), 0, title).set("font-size", 13)]);
    for tenth in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let grid = path(format_args!("M{:.1} {:.1}H{:.1}", x(0.0), y(tenth), x(WIDEST_MM)));
        let share = text((x(0.0) - 6.0, y(tenth) + 4.0), 1, format_args!("{:.0} %", 100.0 * tenth));
        body.draw(&[grid.set("stroke", "#ddd"), share.set("text-anchor", "end")]);
    }
    for tolerance in 0..=5_u8 {
        body.draw(&[text((x(tolerance.into()), y(0.0) + 16.0), 1, tolerance).set("text-anchor", "middle")]);
    }
    let place = |tolerance: f64, share: f64| (x(tolerance), y(share));
    for (feed, colour) in [(12.0, SLOW), (18.0, QUICK)] {
        let of_triangle = |row: &&PaperRow| row.reported.table == "2 (a)" && row.reported.feed_mm_s == feed;
        let rows: Vec<&PaperRow> = results.paper.iter().filter(of_triangle).collect();
        curve(&mut body, &rows, colour, place);
    }
    let ours = results.ours.first().map_or(0.0, |row| row.tolerance_mm);
    let mark = Element::new("rect").fixed("x", x(ours) - 4.5, 1);
    let mark = mark.fixed("y", y(results.ours_together().success()) - 4.5, 1);
    let fastest = results.driven.iter().filter_map(|row| row.found.fastest_mm_s).fold(0.0, f64::max);
    let named = format_args!("Keepout, T = {ours:.3} mm, 12 to {fastest:.0} mm/s (the fastest reached)");
    let named = text((x(ours) + 10.0, y(1.0) - 8.0), 1, named);
    body.draw(&[mark.set("width", 9).set("height", 9).fill(OURS), named.fill(OURS)]);
    let slow = text((x(2.6), y(0.2)), 1, "12 mm/s: line found, dots reported");
    body.draw(&[slow.fill(SLOW)]);
    body.draw(&[text((x(2.6), y(0.2) + 15.0), 1, "18 mm/s. Full dots: fitted. Bars: 95 %").fill(QUICK)]);
    sheet((WIDTH, HEIGHT), 11, &body)
}

/// Draws the success at a feed: a line for our simulation, dots for the paper.
fn curve(body: &mut Lines, rows: &[&PaperRow], colour: &str, place: impl Fn(f64, f64) -> (f64, f64)) {
    let found = points(rows.iter().map(|row| place(row.reported.tolerance_mm, row.found.success())), 1);
    body.draw(&[polyline(found.trim_end()).outline(colour, 2)]);
    for row in rows {
        let fill = if row.reported.calibrates { colour } else { "#fff" };
        // The two feeds stand beside each other.
        let tolerance_mm = row.reported.tolerance_mm + if colour == SLOW { -0.04 } else { 0.04 };
        let bar = row.reported.interval().map(|share| place(tolerance_mm, share));
        body.draw(&[polyline(points(bar.into_iter(), 1).trim_end()).outline(colour, 1)]);
        let at = place(tolerance_mm, row.reported.success());
        body.draw(&[circle(at, 1, 4).fill(fill).stroke(colour, 1.5)]);
    }
}
