//! Compares two searches for link moves: through the mesh, and over a grid.
//! `cargo run --release -p keepout-planner --example routes -- DRAWING_OR_FOLDER...`.
//!
//! Plans each drawing with a tool of 3 mm on both sides. Asks for ways between places beside its loops.

use std::path::{Path, PathBuf};
use std::time::Instant;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{FreePoint, Length, Point};
use keepout_planner::drawing::read_file;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{along_mm, point_from_mm, point_mm};
use keepout_planner::{grid, route};

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
    both: usize,
    only_mesh: usize,
    only_grid: usize,
    lengths: Vec<f64>,
    times: Vec<f64>,
    mesh_s: f64,
    grid_s: f64,
    slowest_s: [f64; 2],
    build_s: f64,
}

fn main() {
    let mut files: Vec<PathBuf> =
        std::env::args().skip(1).flat_map(|path| drawings(Path::new(&path))).collect();
    files.sort();
    println!(
        "| drawing | edges | pairs | straight | both | only mesh | only grid | length ratio 50 % | worst \
         | time ratio 50 % | worst | mesh, ms | grid, ms | slowest mesh, ms | grid | build, ms |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
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
            let mut count = count_of(&plan, &name);
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
        self.both += other.both;
        self.only_mesh += other.only_mesh;
        self.only_grid += other.only_grid;
        self.lengths.extend(other.lengths);
        self.times.extend(other.times);
        self.mesh_s += other.mesh_s;
        self.grid_s += other.grid_s;
        self.slowest_s = [0, 1].map(|k| self.slowest_s[k].max(other.slowest_s[k]));
        self.build_s += other.build_s;
    }

    fn print(&mut self, name: &str, edges: usize) {
        let mut of = |values: fn(&mut Self) -> &mut Vec<f64>| {
            let values = values(self);
            values.sort_by(f64::total_cmp);
            let at =
                |share: usize| values.get((values.len() * share / 100).min(values.len().saturating_sub(1)));
            (at(50).copied().unwrap_or(f64::NAN), at(100).copied().unwrap_or(f64::NAN))
        };
        let ((length, longest), (time, slowest)) =
            (of(|count| &mut count.lengths), of(|count| &mut count.times));
        println!(
            "| {name} | {edges} | {} | {} | {} | {} | {} | {length:.3} | {longest:.3} | {time:.4} \
             | {slowest:.3} | {:.1} | {:.1} | {:.2} | {:.1} | {:.1} |",
            self.pairs,
            self.straight,
            self.both,
            self.only_mesh,
            self.only_grid,
            self.mesh_s * 1e3,
            self.grid_s * 1e3,
            self.slowest_s[0] * 1e3,
            self.slowest_s[1] * 1e3,
            self.build_s * 1e3,
        );
    }
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
                let ((x, y), (dx, dy)) = along_mm(curve, 0.5);
                let at = point_from_mm((x + dy * ASIDE_MM, y - dx * ASIDE_MM)).ok()?;
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
        length += (next.0 - here.0).hypot(next.1 - here.1);
        here = next;
    }
    length
}

fn count_of(plan: &CertifiedPlan, name: &str) -> Count {
    let (low, high) = plan.part_box();
    let within = Window::of(low).including(high).grown(Length::whole_mm(ROOM_MM));
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
            let by_mesh = route::route(plan, from, to.point(), within);
            let mesh_s = begin.elapsed().as_secs_f64();
            let begin = Instant::now();
            let by_grid = grid::route(&plan.part, from, to.point(), within);
            let grid_s = begin.elapsed().as_secs_f64();
            count.mesh_s += mesh_s;
            count.grid_s += grid_s;
            count.slowest_s = [count.slowest_s[0].max(mesh_s), count.slowest_s[1].max(grid_s)];
            match (by_mesh, by_grid) {
                (Some(a), Some(b)) => {
                    count.both += 1;
                    let ratio = length_mm(from.point(), &a) / length_mm(from.point(), &b);
                    if ratio > 1.1 {
                        eprintln!("{name}: {} to {}: {ratio:.3}", from.point(), to.point());
                    }
                    count.lengths.push(ratio);
                    count.times.push(mesh_s / grid_s);
                }
                (Some(_), None) => count.only_mesh += 1,
                (None, Some(_)) => {
                    eprintln!("{name}: {} to {}: only the grid", from.point(), to.point());
                    count.only_grid += 1;
                }
                (None, None) => {}
            }
        }
    }
    count
}
