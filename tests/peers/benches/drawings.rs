//! Comparison of import and planning with the peers, in one process on the same files:
//! `KEEPOUT_SHARED=... cargo bench -p keepout-peers --bench drawings`.
//!
//! With `-- --write` the benchmark writes `docs/contributor/planning.md`.
#![allow(clippy::cast_precision_loss, missing_docs)]

use std::fmt::Write as _;
use std::hint::black_box;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cavalier_contours::polyline::{PlineSourceMut, Polyline};
use cavalier_contours::shape_algorithms::{Shape, ShapeOffsetOptions};
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};
use keepout_kernel::curve::sweep;
use keepout_kernel::{Curve, Length, Turn};
use keepout_planner::Mm2;
use keepout_planner::drawing::{EntityFilter, import};
use keepout_planner::finish::{centre_distance, propose};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{Plan, PlanGeometry, PlanParameters, Provenance};
use keepout_planner::profile::{MachinedSide, Profile, free_outlines};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::point_mm;

const ROUNDS: usize = 9;
const RADIUS_MM: f64 = 1.5;
/// Allowed flattening error of peers without arcs, mm.
const FLAT_MM: f64 = 0.001;
/// Time limit of a peer for one file, s.
const PATIENCE_S: f64 = 20.0;

struct File {
    name: String,
    bytes: Vec<u8>,
}

fn main() {
    let write = std::env::args().any(|argument| argument == "--write");
    let mut real = real_files();
    real.sort_by(|a, b| a.name.cmp(&b.name));
    let made = [lines(1_000), lines(100_000), polyline(100_000), splines(2_000)];
    let mut page = format!(
        "# Import and planning compared with the peers\n\n\
         Written by `KEEPOUT_SHARED=... cargo bench -p keepout-peers --bench drawings -- --write`.\n\n\
         The values are medians of {ROUNDS} rounds, in one process on the same data. The readers take\n\
         turns on each file. Machines are noisy, so read the ratios.\n\n"
    );
    imports(&real, &made, &mut page);
    plans(&real, &made, &mut page);
    if write {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/contributor/planning.md");
        match std::fs::write(&path, &page) {
            Ok(()) => println!("docs/contributor/planning.md is written"),
            Err(error) => eprintln!("docs/contributor/planning.md can not be written: {error}"),
        }
    } else {
        println!("{page}");
    }
}

fn real_files() -> Vec<File> {
    let Some(shared) = std::env::var_os("KEEPOUT_SHARED").map(PathBuf::from) else {
        eprintln!("KEEPOUT_SHARED is not set. The benchmark uses its own files only.");
        return Vec::new();
    };
    let Ok(folder) = std::fs::read_dir(shared.join("dxf/dev")) else { return Vec::new() };
    let read = |entry: std::fs::DirEntry| {
        let bytes = std::fs::read(entry.path()).ok()?;
        Some(File { name: entry.file_name().to_string_lossy().into_owned(), bytes })
    };
    folder.filter_map(Result::ok).filter_map(read).collect()
}

/// A wavy outline of `count` separate lines.
fn lines(count: u32) -> File {
    let mut text = String::from("0\nSECTION\n2\nENTITIES\n");
    for k in 0..count {
        let ((x0, y0), (x1, y1)) = (wave(k, count), wave((k + 1) % count, count));
        let _ = write!(
            text,
            "  0\nLINE\n  8\n0\n 10\n{x0:.9}\n 20\n{y0:.9}\n 30\n0.0\n 11\n{x1:.9}\n 21\n{y1:.9}\n 31\n0.0\n"
        );
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    File { name: format!("{count} lines"), bytes: text.into_bytes() }
}

fn polyline(count: u32) -> File {
    let mut text = format!("0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n90\n{count}\n70\n1\n");
    for k in 0..count {
        let (x, y) = wave(k, count);
        let _ = write!(text, " 10\n{x:.9}\n 20\n{y:.9}\n");
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    File { name: format!("one polyline of {count} vertices"), bytes: text.into_bytes() }
}

/// A closed cubic spline with `count` spans.
fn splines(count: u32) -> File {
    let mut text = String::from("0\nSECTION\n2\nENTITIES\n0\nSPLINE\n8\n0\n70\n3\n71\n3\n");
    for k in 0..count + 7 {
        let _ = write!(text, " 40\n{k}.0\n");
    }
    for k in 0..count + 3 {
        let (x, y) = wave(k % count, count);
        let _ = write!(text, " 10\n{x:.9}\n 20\n{y:.9}\n 30\n0.0\n");
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    File { name: format!("one spline of {count} spans"), bytes: text.into_bytes() }
}

fn wave(k: u32, count: u32) -> (f64, f64) {
    let a = std::f64::consts::TAU * f64::from(k) / f64::from(count);
    let r = 150.0 * (0.75 + 0.2 * (5.0 * a).sin() + 0.04 * (37.0 * a).sin());
    (200.0 + r * a.cos(), 175.0 + r * a.sin())
}

fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let begin = Instant::now();
    let made = black_box(work());
    (begin.elapsed().as_secs_f64(), made)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Reads a file with the `dxf` crate. Returns whether it succeeds.
fn by_dxf(bytes: &[u8]) -> bool {
    let load = || dxf::Drawing::load(&mut Cursor::new(bytes)).is_ok();
    std::panic::catch_unwind(load).unwrap_or(false)
}

fn imports(real: &[File], made: &[File], page: &mut String) {
    page.push_str(
        "## Import\n\n\
         Ours reads the file, inserts blocks, rotates planes and splits splines into Bézier curves. The\n\
         `dxf` crate 0.6 only reads the file. The row of the real drawings is the sum over the files that both\n\
         can read.\n\n\
         | file | size | ours, ms | dxf, ms | ratio |\n|---|---|---|---|---|\n",
    );
    let (mut ours_all, mut dxf_all, mut count, mut ratios, mut size) = (0.0, 0.0, 0, Vec::new(), 0);
    for file in real {
        let readable = by_dxf(&file.bytes) && import(&file.bytes, &EntityFilter::default()).is_ok();
        if !readable {
            continue;
        }
        let (ours, peer) = import_times(&file.bytes);
        (ours_all, dxf_all, count) = (ours_all + ours, dxf_all + peer, count + 1);
        size += file.bytes.len();
        ratios.push(peer / ours);
    }
    if count > 0 {
        let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let _ = writeln!(
            page,
            "| {count} real drawings | {:.1} MB | {:.2} | {:.2} | {:.1} (least {least:.1}, median {:.1}) |",
            size as f64 / 1e6,
            ours_all * 1e3,
            dxf_all * 1e3,
            dxf_all / ours_all,
            median(ratios)
        );
    }
    for file in made {
        let (ours, peer) = import_times(&file.bytes);
        let _ = writeln!(
            page,
            "| {} | {:.1} MB | {:.2} | {:.2} | {:.1} |",
            file.name,
            file.bytes.len() as f64 / 1e6,
            ours * 1e3,
            peer * 1e3,
            peer / ours
        );
    }
}

fn import_times(bytes: &[u8]) -> (f64, f64) {
    let (mut ours, mut peer) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        ours.push(
            seconds(|| import(bytes, &EntityFilter::default()).map(|drawing| drawing.curves.len()).ok()).0,
        );
        peer.push(seconds(|| by_dxf(bytes)).0);
    }
    (median(ours), median(peer))
}

/// Planning times of one drawing, s.
struct Planned {
    name: String,
    edges: usize,
    whole: f64,
    proposing: f64,
    cavalier: Option<f64>,
    i_overlay: Option<f64>,
}

fn plans(real: &[File], made: &[File], page: &mut String) {
    let planned: Vec<Planned> = real.iter().chain(made).filter_map(planned).collect();
    let _ = write!(
        page,
        "\n## Planning\n\n\
         A tool of {:.0} mm cuts outside.\n\n\
         - *Ours, total* checks the contours, builds and checks the index, searches the path, and computes\n  \
         both certificates. They also prove that the path follows the splines.\n\
         - *Search* is the search of the path alone.\n\
         - The peers only compute the offset. `cavalier_contours` 0.9 keeps arcs. `i_overlay` 9 gets arcs\n  \
         flattened to 1 µm, and returns lines.\n\
         - A dash means that the peer panicked or took longer than {PATIENCE_S:.0} s.\n\n\
         | drawing | edges | ours total, ms | search, ms | cavalier, ms | i_overlay, ms \
         | cavalier / ours total | cavalier / search |\n\
         |---|---|---|---|---|---|---|---|\n",
        2.0 * RADIUS_MM
    );
    let shown = |value: Option<f64>| value.map_or("–".into(), |value| format!("{:.2}", value * 1e3));
    for each in &planned {
        let ratio = |ours: f64| each.cavalier.map_or("–".into(), |peer| format!("{:.2}", peer / ours));
        let _ = writeln!(
            page,
            "| {} | {} | {:.2} | {:.2} | {} | {} | {} | {} |",
            each.name,
            each.edges,
            each.whole * 1e3,
            each.proposing * 1e3,
            shown(each.cavalier),
            shown(each.i_overlay),
            ratio(each.whole),
            ratio(each.proposing)
        );
    }
    let ratios = |ours: fn(&Planned) -> f64| -> Vec<f64> {
        planned.iter().filter_map(|each| Some(each.cavalier? / ours(each))).collect()
    };
    let against_flat: Vec<f64> =
        planned.iter().filter_map(|each| Some(each.i_overlay? / each.whole)).collect();
    let _ = writeln!(
        page,
        "\nMedians of the ratios: cavalier / ours total {:.2}, cavalier / search {:.2}, \
         i_overlay / ours total {:.2}.",
        median(ratios(|each| each.whole)),
        median(ratios(|each| each.proposing)),
        median(against_flat)
    );
}

fn planned(file: &File) -> Option<Planned> {
    let job = PlanParameters { tool_diameter_mm: 2.0 * RADIUS_MM, ..PlanParameters::default() };
    let request = PlanRequest { job: job.clone(), ..PlanRequest::default() };
    let (_, chained) = request.contours(&file.bytes).ok()?;
    let profile = chained.closed().ok()?.profile;
    let machine = MachineProfile::simulated();
    let make = || {
        let shapes = PlanGeometry { profile: profile.clone(), ..PlanGeometry::default() };
        Plan::make(Provenance::default(), shapes, &job, &machine, &mut |_| {})
    };
    let (first, certified) = seconds(make);
    let certified = certified.ok()?;
    let none = Profile::default();
    let part = profile.part(MachinedSide::Outside, &none).ok()?;
    let rounds = if first > 1.0 { 1 } else { ROUNDS };
    let (mut whole, mut proposing, mut cavalier, mut flat) = (vec![], vec![], vec![], vec![]);
    let shape = Shape::from_plines(plines(&certified.plan.profile, &part));
    let contours = contours(&profile, &part);
    for _ in 0..rounds {
        whole.push(seconds(make).0);
        let seek = || {
            let outlines = free_outlines(&profile, &none, &part);
            propose(&outlines, &part, centre_distance(&profile, &none, certified.finishing), 3.0).is_ok()
        };
        proposing.push(seconds(seek).0);
        let options = ShapeOffsetOptions::default();
        let offset = || std::panic::catch_unwind(|| shape.parallel_offset(-RADIUS_MM, &options)).is_ok();
        if cavalier.last().is_none_or(|&last| last < PATIENCE_S) {
            let (time, good) = seconds(offset);
            cavalier.push(if good { time } else { f64::INFINITY });
        }
        let angle = 2.0 * (1.0 - FLAT_MM / RADIUS_MM).acos();
        let style = OutlineStyle::new(RADIUS_MM).line_join(LineJoin::Round(angle));
        if flat.last().is_none_or(|&last| last < PATIENCE_S) {
            flat.push(seconds(|| contours.outline(&style)).0);
        }
    }
    let known = |values: Vec<f64>| Some(median(values)).filter(|value| *value < PATIENCE_S);
    Some(Planned {
        name: file.name.clone(),
        edges: profile.loops.iter().map(|each| each.edges.len()).sum(),
        whole: median(whole),
        proposing: median(proposing),
        cavalier: known(cavalier),
        i_overlay: known(flat),
    })
}

/// The profile as polylines with bulges. Outer contours are counter-clockwise, holes clockwise.
fn plines(profile: &Profile, part: &keepout_kernel::ProhibitedRegion) -> Vec<Polyline<f64>> {
    let outlines = profile.outlines(part);
    let pline = |outline: &keepout_kernel::offset::Outline| {
        let mut pline = Polyline::new_closed();
        let curves: Vec<Curve> = if outline.free_on_left {
            outline.curves.iter().rev().filter_map(Curve::reversed).collect()
        } else {
            outline.curves.clone()
        };
        for curve in &curves {
            let Mm2 { x, y } = point_mm(curve.from());
            let bulge = match curve {
                Curve::Line(_) => 0.0,
                Curve::Arc(arc) => {
                    (sweep(arc) / 4.0).tan() * if arc.turn() == Turn::CounterClockwise { 1.0 } else { -1.0 }
                }
            };
            pline.add(x, y, bulge);
        }
        pline
    };
    outlines.iter().map(pline).collect()
}

/// The profile as points, flattened to 1 µm. Outer contours are counter-clockwise, holes clockwise.
fn contours(profile: &Profile, part: &keepout_kernel::ProhibitedRegion) -> Vec<Vec<[f64; 2]>> {
    let chord_error = Length::from_units(100).unwrap_or(Length::ZERO);
    let contour = |outline: keepout_kernel::offset::Outline| {
        let corners = |curve: &Curve| {
            let mut points =
                curve.chord_points(chord_error).unwrap_or_else(|_| vec![curve.from(), curve.to()]);
            points.pop();
            points
        };
        let mut points: Vec<[f64; 2]> = outline
            .curves
            .iter()
            .flat_map(corners)
            .map(|point| {
                let Mm2 { x, y } = point_mm(point);
                [x, y]
            })
            .collect();
        if outline.free_on_left {
            points.reverse();
        }
        points
    };
    profile.outlines(part).into_iter().map(contour).collect()
}
