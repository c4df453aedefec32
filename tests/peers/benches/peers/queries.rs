//! The queries clear, clip and nearest, compared with the peers.

use keepout_kernel::{CheckedIndex, FreePoint, Point, ProhibitedRegion, Region, Ring, Segment, Side};
use keepout_planner::mesh::Mesh;

use crate::paths::{PathKind, RADIUS_MM, STEP_MM, threshold};
use crate::profiles::{ProfileFamily, edges, mm};
use crate::rivals::{BvhTree, Geo, Parry, Parry32, Rstar, Segments, Static, Xy};
use crate::timing::{Rival, Timed, race};

/// Kind of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    Point,
    Motion,
    Clip,
    SweptTriangle,
    Nearest,
}

impl QueryKind {
    pub const ALL: [Self; 5] = [Self::Point, Self::Motion, Self::Clip, Self::SweptTriangle, Self::Nearest];

    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "clear(point)",
            Self::Motion => "clear(motion)",
            Self::Clip => "clip",
            Self::SweptTriangle => "clear(swept triangle)",
            Self::Nearest => "nearest",
        }
    }
}

/// Result of one race.
pub struct Result {
    pub question: QueryKind,
    pub family: ProfileFamily,
    pub edges: usize,
    pub motion: PathKind,
    pub timed: Vec<Timed>,
}

/// Runs all queries on one profile, and appends the results.
pub fn run(family: ProfileFamily, count: usize, rounds: usize, results: &mut Vec<Result>) {
    let rings = family.rings(count);
    let segments: Vec<(Xy, Xy)> =
        edges(&rings).iter().map(|edge| (mm(edge.chord.from), mm(edge.chord.to))).collect();
    let simple = rings.iter().map(|ring| Ring::new(ring.clone()).expect("profiles are simple")).collect();
    let region = Region::new(simple).expect("rings do not touch");
    let plain = ProhibitedRegion::new(region, Side::Outside).expect("few edges");
    let mut part = plain.clone();
    part.prepare(threshold()).expect("the field is on the lattice");
    let peers = Peers::build(&segments);
    let queries = if segments.len() > 200_000 { 800 } else { 4_000 };
    for motion in PathKind::ALL {
        let points = motion.points(part.index(), family.field(count), queries);
        let mut push = |question, timed| {
            results.push(Result { question, family, edges: segments.len(), motion, timed });
        };
        push(QueryKind::Point, points_race(&part, &plain, &peers, &points, rounds));
        push(QueryKind::Nearest, nearest_race(part.index(), &peers, &points, rounds));
        let ends = points.iter().zip(points.iter().skip(1));
        let free = ends.filter_map(|(&p, &q)| Some((part.free_point(p, threshold()).ok()?, q)));
        let moves: Vec<(FreePoint, Point)> = free.take(queries / 2).collect();
        if moves.len() >= 20 {
            push(QueryKind::Motion, motions_race(&part, &plain, &peers, &moves, rounds));
            push(QueryKind::Clip, clips_race(&part, &plain, &peers, &moves, rounds));
            push(QueryKind::SweptTriangle, triangles_race(&part, &moves, rounds));
        }
    }
}

struct Peers {
    parry: Parry,
    parry32: Parry32,
    rstar: Rstar,
    bvh: BvhTree,
    index: Static,
    geo: Option<Geo>,
    count: usize,
}

impl Peers {
    fn build(segments: &Segments) -> Self {
        Self {
            parry: Parry::build(segments),
            parry32: Parry32::build(segments),
            rstar: Rstar::build(segments),
            bvh: BvhTree::build(segments),
            index: Static::build(segments),
            geo: (segments.len() <= 1_100).then(|| Geo::build(segments)),
            count: segments.len(),
        }
    }
}

fn points_race(
    part: &ProhibitedRegion,
    plain: &ProhibitedRegion,
    peers: &Peers,
    points: &[Point],
    rounds: usize,
) -> Vec<Timed> {
    let at: Vec<Xy> = points.iter().map(|&point| mm(point)).collect();
    let (n, r, t) = (points.len(), RADIUS_MM, threshold());
    let yes = |clear: bool| f64::from(u8::from(clear));
    let rivals = vec![
        Rival::new("cells", n, |i| yes(part.point_clear(points[i], t).is_clear())),
        Rival::new("index alone", n, |i| yes(plain.point_clear(points[i], t).is_clear())),
        Rival::new("parry2d bounded", n, |i| yes(peers.parry.nearest_within(at[i], r).is_none())),
        Rival::new("parry2d intersection", n, |i| yes(!peers.parry.meets_ball(at[i], r))),
        Rival::new("rstar", n, |i| yes(peers.rstar.is_clear(at[i], r))),
        Rival::new("static_aabb2d_index", n, |i| yes(peers.index.is_clear(at[i], r))),
    ];
    differing(race(rivals, n, rounds))
}

fn nearest_race(index: &CheckedIndex, peers: &Peers, points: &[Point], rounds: usize) -> Vec<Timed> {
    let at: Vec<Xy> = points.iter().map(|&point| mm(point)).collect();
    let n = points.len();
    let mut hint = None;
    let in_mm = |nearest: Option<keepout_kernel::Nearest>| {
        nearest.map_or(f64::NAN, |nearest| nearest.distance() / 1e5)
    };
    let mut last: Option<(Xy, f64)> = None;
    let frame = keepout_kernel::exact::segment::Window::from_corners(
        -400_000_000,
        -400_000_000,
        400_000_000,
        400_000_000,
    );
    let meshes = [false, true].map(|refined| {
        let small = peers.count <= 200_000;
        small.then(|| Mesh::build(index, frame, refined).expect("the frame is larger than the field"))
    });
    let mut rivals = vec![
        Rival::new("index, hint", n, |i| {
            let nearest = index.nearest(points[i], hint);
            hint = nearest.map(|nearest| nearest.edge);
            in_mm(nearest)
        }),
        Rival::new("parry2d", n, |i| peers.parry.nearest(at[i])),
        Rival::new("parry2d bounded", n, |i| {
            // The last distance plus the distance moved since then bounds the next distance.
            let bound =
                last.map_or(f64::MAX, |((x, y), d)| d + (x - at[i].0).hypot(y - at[i].1) + STEP_MM / 1e6);
            let found = peers.parry.nearest_within(at[i], bound).unwrap_or(f64::NAN);
            last = Some((at[i], found));
            found
        }),
        Rival::new("rstar", n, |i| peers.rstar.nearest(at[i])),
        Rival::new("bvh", n, |i| peers.bvh.nearest(at[i])),
    ];
    let names = ["mesh", "mesh, refined"];
    for (mesh, name) in meshes.iter().zip(names) {
        if let Some(mesh) = mesh {
            let mut walk = mesh.walk();
            rivals.push(Rival::new(name, n, move |i| in_mm(walk.nearest(mesh, index, points[i]))));
        }
    }
    if let Some(geo) = &peers.geo {
        rivals.push(Rival::new("geo, all segments", n, |i| geo.nearest(at[i])));
    }
    race(rivals, n, rounds)
}

fn ends_mm(moves: &[(FreePoint, Point)]) -> Vec<(Xy, Xy)> {
    moves.iter().map(|&(p, q)| (mm(p.point()), mm(q))).collect()
}

fn motions_race(
    part: &ProhibitedRegion,
    plain: &ProhibitedRegion,
    peers: &Peers,
    moves: &[(FreePoint, Point)],
    rounds: usize,
) -> Vec<Timed> {
    let at = ends_mm(moves);
    let (n, r) = (moves.len(), RADIUS_MM);
    let yes = |clear: bool| f64::from(u8::from(clear));
    let rivals = vec![
        Rival::new("cells", n, |i| yes(part.motion(moves[i].0, moves[i].1).is_ok())),
        Rival::new("index alone", n, |i| yes(plain.motion(moves[i].0, moves[i].1).is_ok())),
        Rival::new("parry2d intersection", n, |i| yes(!peers.parry.meets_capsule(at[i], r))),
        Rival::new("static_aabb2d_index", n, |i| yes(peers.index.motion_is_clear(at[i], r))),
    ];
    differing(race(rivals, n, rounds))
}

fn clips_race(
    part: &ProhibitedRegion,
    plain: &ProhibitedRegion,
    peers: &Peers,
    moves: &[(FreePoint, Point)],
    rounds: usize,
) -> Vec<Timed> {
    let at = ends_mm(moves);
    let (n, r) = (moves.len(), RADIUS_MM);
    let x = |end: FreePoint| f64::from(end.point().x.units());
    let mut rivals = vec![
        Rival::new("cells", n, |i| x(part.clip(moves[i].0, moves[i].1))),
        Rival::new("index alone", n, |i| x(plain.clip(moves[i].0, moves[i].1))),
    ];
    if peers.count <= 200_000 {
        rivals.push(Rival::new("parry2d f64 cast", n, |i| peers.parry.cast(at[i], r)));
        rivals.push(Rival::new("parry2d f32 cast", n, |i| peers.parry32.cast(at[i], r)));
    }
    let mut timed = race(rivals, n, rounds);
    for cast in timed.iter_mut().filter(|each| each.name.contains("cast")) {
        // Count the ends that the exact query rejects: there the cast lets the disc into the part.
        let rejected = |(&(from, to), t): (&(FreePoint, Point), &f64)| {
            let ((ax, ay), (bx, by)) = (mm(from.point()), mm(to));
            let end = crate::profiles::at(ax + (bx - ax) * t, ay + (by - ay) * t);
            !part.motion_clear(Segment { from: from.point(), to: end }, lowered()).is_clear()
        };
        cast.wrong = Some(moves.iter().zip(&cast.answers).filter(|&each| rejected(each)).count());
    }
    timed
}

/// The threshold less 0.1 µm. The rounding of a peer does not count as an error.
fn lowered() -> keepout_kernel::Length {
    keepout_kernel::Length::from_units(i64::from(threshold().units()) - 10).expect("a length")
}

fn triangles_race(part: &ProhibitedRegion, moves: &[(FreePoint, Point)], rounds: usize) -> Vec<Timed> {
    // The triangle of the start and end of one motion and the next target. It covers a change of target
    // during the motion.
    let triangles: Vec<(FreePoint, FreePoint, Point)> = moves
        .iter()
        .zip(moves.iter().skip(1))
        .filter_map(|(&(a, b), &(_, to))| Some((a, part.motion(a, b).ok()?, to)))
        .filter(|(a, _, to)| {
            let d = to.minus(a.point());
            f64::from(d.dx).hypot(f64::from(d.dy)) < 1e8
        })
        .collect();
    let n = triangles.len();
    let yes = |clear: bool| f64::from(u8::from(clear));
    let segments = |i: usize| Segment { from: triangles[i].0.point(), to: triangles[i].2 };
    let rivals = vec![
        Rival::new("swept triangle", n, |i| {
            let (from, to, target) = triangles[i];
            yes(part.swept_triangle(from, to, target).is_ok())
        }),
        Rival::new("its motion alone", n, |i| yes(part.motion_clear(segments(i), threshold()).is_clear())),
    ];
    race(rivals, n, rounds)
}

/// Counts the answers that differ from those of the first rival, which is ours.
fn differing(mut timed: Vec<Timed>) -> Vec<Timed> {
    let truth = timed.first().map(|first| first.answers.clone()).unwrap_or_default();
    for each in &mut timed {
        each.wrong = Some(each.answers.iter().zip(&truth).filter(|(a, b)| a != b).count());
    }
    timed
}
