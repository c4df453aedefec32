//! Pictures of the time of a query over the number of edges.

use std::fmt::Write as _;

use crate::page::{Measured, is_ours};
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
    let mut svg = axes(&title);
    curves(&mut svg, &results);
    svg.push_str("</svg>\n");
    svg
}

fn axes(title: &str) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"60\" y=\"22\" font-size=\"15\">{title}</text>\n"
    );
    for decade in 2..=6 {
        let at = across(10_usize.pow(decade));
        let (low, high) = (up(1.0), up(4e4));
        let _ = writeln!(
            svg,
            "<line x1=\"{at:.0}\" y1=\"{low:.0}\" x2=\"{at:.0}\" y2=\"{high:.0}\" stroke=\"#ddd\"/>"
        );
        let below = HEIGHT - 30.0;
        let _ =
            writeln!(svg, "<text x=\"{at:.0}\" y=\"{below:.0}\" text-anchor=\"middle\">10^{decade}</text>");
    }
    for decade in 0..=4 {
        let ns = 10_f64.powi(decade);
        let (at, end) = (up(ns), WIDTH - 190.0);
        let _ =
            writeln!(svg, "<line x1=\"60\" y1=\"{at:.0}\" x2=\"{end:.0}\" y2=\"{at:.0}\" stroke=\"#ddd\"/>");
        let _ = writeln!(svg, "<text x=\"52\" y=\"{:.0}\" text-anchor=\"end\">{ns:.0}</text>", at + 4.0);
    }
    let (x, y) = (WIDTH / 2.0 - 90.0, HEIGHT - 10.0);
    let _ = writeln!(svg, "<text x=\"{x:.0}\" y=\"{y:.0}\" text-anchor=\"middle\">edges</text>");
    svg
}

fn curves(svg: &mut String, results: &[&queries::Result]) {
    let mut names: Vec<&str> = Vec::new();
    for each in results.iter().flat_map(|result| &result.timed) {
        if !names.contains(&each.name) && !each.name.starts_with("geo") {
            names.push(each.name);
        }
    }
    let mut labels: Vec<(f64, usize)> = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let of = |result: &queries::Result| {
            result.timed.iter().find(|each| each.name == *name).map(|each| each.ns)
        };
        let points: Vec<(f64, f64)> =
            results.iter().filter_map(|result| Some((across(result.edges), up(of(result)?)))).collect();
        let path: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let path = path.join(" ");
        let (width, dash) = if is_ours(name) { (2.5, "") } else { (1.3, " stroke-dasharray=\"5 3\"") };
        let _ = writeln!(
            svg,
            "<polyline points=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>"
        );
        if let Some(last) = points.last() {
            labels.push((last.1, k));
        }
    }
    // Place the labels at the ends of the curves, without overlap.
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = f64::NEG_INFINITY;
    for (at, k) in labels {
        below = at.max(below + 15.0);
        let (x, colour) = (WIDTH - 182.0, COLOURS[k % COLOURS.len()]);
        let _ = writeln!(svg, "<text x=\"{x:.0}\" y=\"{below:.0}\" fill=\"{colour}\">{}</text>", names[k]);
    }
}
