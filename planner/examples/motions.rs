//! Counts the motions of finishing toolpaths, and the causes of the short ones:
//! `cargo run --release -p keepout-planner --example motions -- DRAWING_OR_FOLDER...`.
//!
//! Plans each drawing with tools of 3 mm and 6 mm on both sides. Leaves out combinations that have no plan.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::time::Instant;

use keepout_kernel::curve::sweep;
use keepout_kernel::offset::shortest_arc;
use keepout_kernel::{Curve, Point, UNITS_PER_MM};
use keepout_planner::drawing::read_file;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::profile::{CHORD_ERROR, MachinedSide, ProfileEdge};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{along_mm, point_from_mm, point_mm};

const TOOLS_MM: [f64; 2] = [3.0, 6.0];
const SIDES: [MachinedSide; 2] = [MachinedSide::Outside, MachinedSide::Inside];
/// The program counts the motions shorter than each of these lengths, mm.
const SHORT_MM: [f64; 3] = [0.2, 0.5, 1.0];
/// An edge of the drawing below this length is a short chord, mm.
const CHORD_MM: f64 = 1.0;

/// The cause of a short motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// The motion runs beside a line or arc that replaces a spline or an ellipse.
    Spline,
    /// The motion runs beside a short line of the drawing, or around a corner of one.
    Chord,
    /// The motion is a line that replaces an arc, because the arc's ends are too near for a controller.
    NearEnds,
    /// Another cause.
    Other,
}

/// The counts of one toolpath, or their sums over several.
#[derive(Clone, Default)]
struct Count {
    lines: usize,
    arcs: usize,
    lengths_mm: Vec<f64>,
    shorter: [usize; SHORT_MM.len()],
    by_cause: [usize; 4],
    plans: usize,
    seconds: f64,
}

impl Count {
    fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        self.arcs += other.arcs;
        self.lengths_mm.extend(&other.lengths_mm);
        self.shorter.iter_mut().zip(other.shorter).for_each(|(sum, count)| *sum += count);
        self.by_cause.iter_mut().zip(other.by_cause).for_each(|(sum, count)| *sum += count);
        self.plans += other.plans;
        self.seconds += other.seconds;
    }

    fn print(&mut self, name: &str) {
        self.lengths_mm.sort_by(f64::total_cmp);
        let at = |percent: usize| self.lengths_mm.get(self.lengths_mm.len() * percent / 100).unwrap_or(&0.0);
        let sum: f64 = self.lengths_mm.iter().sum();
        let [p, q, r] = self.shorter;
        let [splines, chords, near, other] = self.by_cause;
        println!(
            "| {name} | {} | {} | {} | {sum:.0} | {:.3} | {:.3} | {:.3} | {p} | {q} | {r} | {splines} \
             | {chords} | {near} | {other} | {:.0} |",
            self.plans,
            self.lines,
            self.arcs,
            at(10),
            at(50),
            at(90),
            self.seconds * 1e3,
        );
    }
}

fn main() {
    let mut files: Vec<PathBuf> =
        std::env::args().skip(1).flat_map(|path| drawings(Path::new(&path))).collect();
    files.sort();
    println!(
        "| drawing | plans | lines | arcs | length, mm | 10 % | 50 % | 90 % | < 0.2 mm | < 0.5 | < 1 \
         | of these: splines | chords | near ends | other | time, ms |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    let mut all = Count::default();
    for file in files {
        let Ok(bytes) = read_file(&file) else { continue };
        let mut count = Count::default();
        for (tool_diameter_mm, side) in TOOLS_MM.into_iter().flat_map(|tool| SIDES.map(|side| (tool, side))) {
            let request = PlanRequest {
                job: PlanParameters { tool_diameter_mm, side, ..PlanParameters::default() },
                ..PlanRequest::default()
            };
            let begin = Instant::now();
            let plan = request.plan("", &bytes, &MachineProfile::simulated(), &mut |_| {});
            if let Ok(plan) = plan {
                count.seconds += begin.elapsed().as_secs_f64();
                count.add(&count_of(&plan));
            }
        }
        if count.plans > 0 {
            count.print(&file.file_name().unwrap_or_default().to_string_lossy());
            all.add(&count);
        }
    }
    all.print("all");
}

/// The drawing, or the drawings in the folder.
fn drawings(path: &Path) -> Vec<PathBuf> {
    let is_drawing = |path: &PathBuf| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("dxf"));
    match std::fs::read_dir(path) {
        Ok(folder) => folder.filter_map(|entry| Some(entry.ok()?.path())).filter(is_drawing).collect(),
        Err(_) => vec![path.to_path_buf()],
    }
}

fn count_of(plan: &CertifiedPlan) -> Count {
    let edges = edges_by_chord(plan);
    let mut count = Count { plans: 1, ..Count::default() };
    for curve in plan.plan.finish().loops.iter().flat_map(|each| &each.curves) {
        let length_mm = curve.length() / f64::from(UNITS_PER_MM);
        // The executor sends arcs in parts of at most a quarter turn.
        let pieces = match curve {
            Curve::Line(_) => 1,
            Curve::Arc(arc) => (1..4).find(|&n| sweep(arc) <= f64::from(n) * FRAC_PI_2 + 1e-9).unwrap_or(4),
        };
        let piece_mm = length_mm / f64::from(pieces);
        for _ in 0..pieces {
            *(if matches!(curve, Curve::Line(_)) { &mut count.lines } else { &mut count.arcs }) += 1;
            count.lengths_mm.push(piece_mm);
            for (sum, limit_mm) in count.shorter.iter_mut().zip(SHORT_MM) {
                *sum += usize::from(piece_mm < limit_mm);
            }
            if piece_mm < SHORT_MM[2] {
                count.by_cause[cause(plan, &edges, curve) as usize] += 1;
            }
        }
    }
    count
}

/// The profile's edge for each chord of the part.
fn edges_by_chord(plan: &CertifiedPlan) -> HashMap<(Point, Point), ProfileEdge> {
    let edges = plan.plan.profile.loops.iter().flat_map(|each| &each.edges);
    let chords = edges.flat_map(|edge| {
        let points = edge.curve.chord_points(CHORD_ERROR);
        let points = points.unwrap_or_else(|_| vec![edge.curve.from(), edge.curve.to()]);
        let pairs: Vec<_> = points.windows(2).map(|pair| (pair[0], pair[1])).collect();
        pairs.into_iter().flat_map(|(a, b)| [((a, b), *edge), ((b, a), *edge)])
    });
    chords.collect()
}

fn cause(plan: &CertifiedPlan, edges: &HashMap<(Point, Point), ProfileEdge>, curve: &Curve) -> Cause {
    let middle = along_mm(curve, 0.5).0;
    let Ok(at) = point_from_mm(middle) else { return Cause::Other };
    let Some(nearest) = plan.part.index().nearest(at, None) else { return Cause::Other };
    let chord = plan.part.edges()[nearest.edge].chord;
    let edge = edges.get(&(chord.from, chord.to));
    let fitted = edge.is_some_and(|edge| edge.chord_error.units() > 0);
    let (a, b) = (point_mm(chord.from), point_mm(chord.to));
    let foot = middle.nearest_on(a, b);
    let at_corner = foot == a || foot == b;
    let is_line = matches!(curve, Curve::Line(_));
    let beside_line = edge.is_none_or(|edge| matches!(edge.curve, Curve::Line(_)));
    let short_edge = edge.is_some_and(|edge| edge.curve.length() < CHORD_MM * f64::from(UNITS_PER_MM));
    let near = curve.length() <= f64::from(shortest_arc(plan.plan.tool_radius).units());
    match () {
        () if is_line && near && (at_corner || !beside_line) => Cause::NearEnds,
        () if fitted => Cause::Spline,
        () if short_edge && beside_line => Cause::Chord,
        () => Cause::Other,
    }
}
