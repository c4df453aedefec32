//! Counts the link moves that the search through the mesh finds, and measures their length and time:
//! `cargo run --release -p keepout-planner --example routes -- DRAWING_OR_FOLDER...`.
//!
//! Plans each drawing with a tool of 3 mm on both sides. Asks for ways between places beside its loops, and
//! states their length as a share of the straight distance. No way may exist: a narrow place can part the
//! free space at the jogging clearance.

use std::path::{Path, PathBuf};
use std::time::Instant;

use keepout_kernel::{FreePoint, Length, Point};
use keepout_planner::Mm2;
use keepout_planner::drawing::read_file;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_planner::route::route;
use keepout_planner::units::{along_mm, point_from_mm, point_mm};

const TOOL_MM: f64 = 3.0;
/// Travel around the box of the part, mm.
const ROOM_MM: u8 = 20;
/// Places beside the loops that are paired, at most.
const PLACES: usize = 9;
/// Distance of a place from the finishing toolpath, mm.
const ASIDE_MM: f64 = 0.25;

#[derive(Default)]
struct Count {
    pairs: usize,
    straight: usize,
    found: usize,
    lengths: Vec<f64>,
    times_s: Vec<f64>,
    build_s: f64,
}

fn main() {
    let mut files: Vec<PathBuf> =
        std::env::args().skip(1).flat_map(|path| drawings(Path::new(&path))).collect();
    files.sort();
    println!(
        "| drawing | edges | pairs | straight | found | length share 50 % | worst | time 50 %, ms | worst \
         | mesh, ms |\n|---|---|---|---|---|---|---|---|---|---|"
    );
    let mut all = Count::default();
    for file in files {
        let Ok(bytes) = read_file(&file) else { continue };
        for side in [MachinedSide::Outside, MachinedSide::Inside] {
            let job = PlanParameters { tool_diameter_mm: TOOL_MM, side, ..PlanParameters::default() };
            let request = PlanRequest { job, ..PlanRequest::default() };
            let Ok(plan) = request.plan("", &bytes, &MachineProfile::simulated(), &mut |_| {}) else {
                continue;
            };
            let name = format!("{} {side:?}", file.file_name().unwrap_or_default().to_string_lossy());
            let mut count = count_of(&plan);
            if count.pairs > count.straight {
                count.print(&name, plan.part.edges().len());
                all.add(count);
            }
        }
    }
    all.print("all", 0);
}

impl Count {
    fn add(&mut self, other: Self) {
        self.pairs += other.pairs;
        self.straight += other.straight;
        self.found += other.found;
        self.lengths.extend(other.lengths);
        self.times_s.extend(other.times_s);
        self.build_s += other.build_s;
    }

    fn print(&mut self, name: &str, edges: usize) {
        let (Mm2 { x: length, y: longest }, Mm2 { x: time_s, y: slowest_s }) =
            (spread(&mut self.lengths), spread(&mut self.times_s));
        println!(
            "| {name} | {edges} | {} | {} | {} | {length:.3} | {longest:.3} | {:.3} | {:.3} | {:.1} |",
            self.pairs,
            self.straight,
            self.found,
            time_s * 1e3,
            slowest_s * 1e3,
            self.build_s * 1e3,
        );
    }
}

/// The median and the largest value.
fn spread(values: &mut [f64]) -> Mm2 {
    values.sort_by(f64::total_cmp);
    let median = values.get(values.len() / 2).copied().unwrap_or(f64::NAN);
    Mm2::new(median, values.last().copied().unwrap_or(f64::NAN))
}

/// The drawing, or the drawings in the folder.
fn drawings(path: &Path) -> Vec<PathBuf> {
    let is_drawing = |path: &PathBuf| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("dxf"));
    match std::fs::read_dir(path) {
        Ok(folder) => folder.filter_map(|entry| Some(entry.ok()?.path())).filter(is_drawing).collect(),
        Err(_) => vec![path.to_path_buf()],
    }
}

/// Places beside the loops, outside the jogging clearance.
fn places(plan: &CertifiedPlan) -> Vec<(FreePoint, usize)> {
    let loops = &plan.plan.finish().loops;
    let mut found = Vec::new();
    for (number, each) in loops.iter().enumerate().step_by(loops.len().div_ceil(PLACES)) {
        // Two places on each loop, where it has them.
        for first in [0, each.curves.len() / 2] {
            let place = each.curves.iter().cycle().skip(first).take(each.curves.len()).find_map(|curve| {
                let (Mm2 { x, y }, Mm2 { x: dx, y: dy }) = along_mm(curve, 0.5);
                let at = point_from_mm(Mm2::new(x + dy * ASIDE_MM, y - dx * ASIDE_MM)).ok()?;
                plan.part.free_point(at, plan.roughing).ok()
            });
            found.extend(place.map(|place| (place, loops[number].component)));
        }
    }
    found
}

fn length_mm(from: Point, path: &[Point]) -> f64 {
    let mut here = point_mm(from);
    let mut length = 0.0;
    for &point in path {
        let next = point_mm(point);
        length += here.distance(next);
        here = next;
    }
    length
}

fn count_of(plan: &CertifiedPlan) -> Count {
    let within = plan.part.region().bounds().grown(Length::whole_mm(ROOM_MM));
    let places = places(plan);
    let mut count = Count::default();
    let begin = Instant::now();
    let _ = plan.mesh();
    count.build_s = begin.elapsed().as_secs_f64();
    for (k, &(from, component)) in places.iter().enumerate() {
        for &(to, other) in &places[k + 1..] {
            if component != other {
                continue;
            }
            count.pairs += 1;
            if plan.part.motion(from, to.point()).is_ok() {
                count.straight += 1;
                continue;
            }
            let begin = Instant::now();
            let found = route(plan, from, to.point(), within);
            count.times_s.push(begin.elapsed().as_secs_f64());
            if let Some(path) = found {
                count.found += 1;
                let straight_mm = length_mm(from.point(), &[to.point()]);
                count.lengths.push(length_mm(from.point(), &path) / straight_mm);
            }
        }
    }
    count
}
