//! Pictures of the time of a query over the number of edges.

use keepout_planner::report::chart::sheet;
use keepout_planner::report::element::{Lines, background, line, points, polyline, text};

use crate::page::{Measured, distinct, is_ours};
use crate::paths::PathKind;
use crate::profiles::ProfileFamily;
use crate::queries::{self, QueryKind};

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
const COLOURS: [&str; 10] = [
    "#0b6e4f", "#1f77b4", "#d1495b", "#edae49", "#66408e", "#555555", "#00a6a6", "#a0522d", "#7f9c2a",
    "#e377c2",
];

fn across(edges: usize) -> f64 {
    60.0 + ((edges as f64).log10() - 1.9) / 4.2 * (WIDTH - 260.0)
}

fn up(ns: f64) -> f64 {
    HEIGHT - 50.0 - (ns.max(1.0).log10() / 4.6) * (HEIGHT - 90.0)
}

/// Draws ns per query over the number of edges, both logarithmic.
pub fn growth(measured: &Measured, question: QueryKind, family: ProfileFamily, motion: PathKind) -> String {
    let chosen =
        |each: &&queries::Result| each.question == question && each.family == family && each.motion == motion;
    let results: Vec<&queries::Result> = measured.queries.iter().filter(chosen).collect();
    let title = format!("{}, {} path over {}: ns per query", question.name(), motion.name(), family.name());
    let mut body = Lines::default();
    body.draw(&[background("white")]);
    body.draw(&[text((60.0, 22.0), 0, title).set("font-size", 15)]);
    axes(&mut body);
    curves(&mut body, &results);
    sheet((WIDTH, HEIGHT), 12, &body)
}

fn axes(body: &mut Lines) {
    for decade in 2..=6 {
        let at = across(10_usize.pow(decade));
        body.draw(&[line((at, up(1.0)), (at, up(4e4)), 0).set("stroke", "#ddd")]);
        body.draw(&[text((at, HEIGHT - 30.0), 0, format_args!("10^{decade}")).set("text-anchor", "middle")]);
    }
    for decade in 0..=4 {
        let ns = 10_f64.powi(decade);
        body.draw(&[line((60.0, up(ns)), (WIDTH - 190.0, up(ns)), 0).set("stroke", "#ddd")]);
        body.draw(&[text((52.0, up(ns) + 4.0), 0, ns).set("text-anchor", "end")]);
    }
    body.draw(&[text((WIDTH / 2.0 - 90.0, HEIGHT - 10.0), 0, "edges").set("text-anchor", "middle")]);
}

fn curves(body: &mut Lines, results: &[&queries::Result]) {
    let timed = results.iter().flat_map(|result| &result.timed).map(|each| each.name);
    let names = distinct(timed.filter(|name| !name.starts_with("geo")));
    let mut labels: Vec<(f64, usize)> = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let of = |result: &queries::Result| {
            result.timed.iter().find(|each| each.name == *name).map(|each| each.ns)
        };
        let places: Vec<(f64, f64)> =
            results.iter().filter_map(|result| Some((across(result.edges), up(of(result)?)))).collect();
        let curve = points(places.iter().copied(), 1);
        let curve = polyline(curve.trim_end());
        body.draw(&[if is_ours(name) {
            curve.outline(colour, 2.5)
        } else {
            curve.outline(colour, 1.3).set("stroke-dasharray", "5 3")
        }]);
        if let Some(last) = places.last() {
            labels.push((last.1, k));
        }
    }
    // Place the labels at the ends of the curves, without overlap.
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = f64::NEG_INFINITY;
    for (at, k) in labels {
        below = at.max(below + 15.0);
        body.draw(&[text((WIDTH - 182.0, below), 0, names[k]).fill(COLOURS[k % COLOURS.len()])]);
    }
}
