//! Build times of indices, cells and meshes, and the memory of the indices.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::{build, subdivide};
use keepout_kernel::{CheckedIndex, Edge, Point, Ring};
use keepout_planner::mesh::Mesh;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::paths::threshold;
use crate::profiles::{ProfileFamily, edges, mm};
use crate::rivals::{BvhTree, Parry, Rstar, Static, Xy};
use crate::timing::{median, resident, seconds};

/// Build times by name, ms.
pub struct Built {
    pub family: ProfileFamily,
    pub edges: usize,
    pub ms: Vec<(&'static str, f64)>,
    pub notes: Vec<(&'static str, f64)>,
}

type Spade = ConstrainedDelaunayTriangulation<Point2<f64>>;

pub const FRAME: Window = Window::from_corners(-400_000_000, -400_000_000, 400_000_000, 400_000_000);

/// A name, and a build that returns its duration in s.
type Work = (&'static str, Box<dyn FnMut() -> f64>);

/// Builds all structures once per round, and takes the medians.
pub fn run(family: ProfileFamily, count: usize, rounds: usize) -> Built {
    let rings = family.rings(count);
    let chords = edges(&rings);
    let index = build::build(chords.clone()).expect("few edges");
    let mut works = ours(&rings, &chords, &index);
    works.extend(peers(&chords));
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); works.len()];
    for _ in 0..rounds {
        for ((_, work), times) in works.iter_mut().zip(&mut times) {
            times.push(work() * 1e3);
        }
    }
    // The bulk load of spade takes almost a minute on a star outline of a million edges, so it runs once.
    let spade_rounds = if count > 200_000 { 1 } else { rounds };
    let mut spade: Vec<f64> = (0..spade_rounds).map(|_| bulk_load(&rings) * 1e3).collect();
    let named = works.iter().zip(&mut times);
    let mut ms: Vec<(&'static str, f64)> = named.map(|((name, _), times)| (*name, median(times))).collect();
    ms.push(("spade, bulk load", median(&mut spade)));
    let refined = count <= 100_000;
    let mesh = Mesh::build(&index, FRAME, refined).expect("the frame holds the field");
    let cells = subdivide::build(&index, threshold(), None).expect("the field is on the lattice");
    let notes = vec![
        ("points added to the refined mesh", mesh.added() as f64),
        ("bytes of the cells", cells.bytes() as f64),
    ];
    Built { family, edges: chords.len(), ms, notes }
}

fn ours(rings: &[Vec<Point>], chords: &[Edge], index: &CheckedIndex) -> Vec<Work> {
    let (rings, chords, for_cells) = (rings.to_vec(), chords.to_vec(), index.clone());
    let mut works: Vec<Work> = vec![
        (
            "index, checked",
            Box::new(move || {
                let chords = chords.clone();
                seconds(|| build::build(chords)).0
            }),
        ),
        (
            "cells, proposed and checked",
            Box::new(move || seconds(|| subdivide::build(&for_cells, threshold(), None)).0),
        ),
        (
            "rings found simple",
            Box::new(move || {
                let rings = rings.clone();
                seconds(|| rings.into_iter().all(|ring| Ring::new(ring).is_ok())).0
            }),
        ),
    ];
    // The refinement of a million needles takes minutes, because it searches a million far nearest edges.
    let meshes = [("mesh", false), ("mesh, refined", true)];
    for (name, refined) in meshes.into_iter().filter(|(_, refined)| !refined || index.edges().len() < 200_000)
    {
        let index = index.clone();
        works.push((name, Box::new(move || seconds(|| Mesh::build(&index, FRAME, refined)).0)));
    }
    works
}

fn peers(chords: &[Edge]) -> Vec<Work> {
    let segments: Vec<(Xy, Xy)> =
        chords.iter().map(|edge| (mm(edge.chord.from), mm(edge.chord.to))).collect();
    vec![
        ("parry2d", with(&segments, |s| seconds(|| Parry::build(s)).0)),
        ("rstar", with(&segments, |s| seconds(|| Rstar::build(s)).0)),
        ("bvh", with(&segments, |s| seconds(|| BvhTree::build(s)).0)),
        ("static_aabb2d_index", with(&segments, |s| seconds(|| Static::build(s)).0)),
    ]
}

fn with(
    segments: &[(Xy, Xy)],
    mut build: impl FnMut(&[(Xy, Xy)]) -> f64 + 'static,
) -> Box<dyn FnMut() -> f64> {
    let segments = segments.to_vec();
    Box::new(move || build(&segments))
}

fn bulk_load(rings: &[Vec<keepout_kernel::Point>]) -> f64 {
    let mut vertices = Vec::new();
    let mut constraints = Vec::new();
    for ring in rings {
        let first = vertices.len();
        for (k, &point) in ring.iter().enumerate() {
            vertices.push(Point2::new(f64::from(point.x.units()), f64::from(point.y.units())));
            constraints.push([first + k, first + (k + 1) % ring.len()]);
        }
    }
    let (time, made) = seconds(|| Spade::try_bulk_load_cdt(vertices, constraints, |_| {}));
    assert!(made.is_ok_and(|mesh| mesh.num_vertices() > 2));
    time
}

/// Bytes by which this process grows when it builds the named index. Run it in a separate process.
pub fn memory(name: &str, count: usize) -> Option<f64> {
    let rings = ProfileFamily::Maze.rings(count);
    let chords = edges(&rings);
    let segments: Vec<(Xy, Xy)> =
        chords.iter().map(|edge| (mm(edge.chord.from), mm(edge.chord.to))).collect();
    let before = resident()?;
    // The index of the kernel stores its edges, so they count. The peers also store copies of the segments.
    let after = match name {
        "index, checked" => {
            let index = build::build(chords.clone()).ok()?;
            let after = resident()?;
            assert!(!index.edges().is_empty());
            after
        }
        "parry2d" => keep(Parry::build(&segments))?,
        "rstar" => keep(Rstar::build(&segments))?,
        "bvh" => keep(BvhTree::build(&segments))?,
        "static_aabb2d_index" => keep(Static::build(&segments))?,
        _ => return None,
    };
    Some(after - before)
}

fn keep<T>(made: T) -> Option<f64> {
    let after = resident();
    drop(std::hint::black_box(made));
    after
}

/// The index names that [`memory`] accepts.
pub const KEEPERS: [&str; 5] = ["index, checked", "parry2d", "rstar", "bvh", "static_aabb2d_index"];
