//! The kernel's structures beside brute force and big integers.

use std::ops::ControlFlow;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_kernel::curve::xy;
use keepout_kernel::exact::convex::Convex;
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::region::Location;
use keepout_kernel::exact::ring::{Piece, RingError};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build::{build, propose};
use keepout_kernel::index::check::{Node, Proposal};
use keepout_kernel::{
    CheckedIndex, Curve, Edge, Length, Mesh, MeshError, Nearest, Point, ProhibitedRegion, Region, Ring,
    Segment, Side,
};
use keepout_proofs::families::{at, length};
use keepout_proofs::oracle::{Big, inside_polygon, never_nearer};
use keepout_proofs::properties::Xy;
use keepout_proofs::soak::{point_within, segments_within, triangle_within};
use keepout_proofs::square::plain;

use crate::import::told;
use crate::offset::bent;
use crate::witness::{places, to_chord};

/// Most corners of a ring, and edges of a soup.
const CORNERS_MAX: usize = 40;

/// Any bytes as edges and questions: index, cells and near list answer as all edges do.
///
/// # Panics
/// When one does not.
pub fn index(bytes: &[u8]) {
    const PROPERTIES: [&str; 6] = [
        "queries_are_those_over_all_edges",
        "long_motions_skip_only_what_is_beside",
        "cells_answer_as_the_index",
        "walks_cover_their_motion",
        "near_lists_answer_as_the_index",
        "probes_answer_as_the_part",
    ];
    keepout_proofs::named_of_bytes(&PROPERTIES, bytes);
}

/// Any bytes as edges and a tree over them that is changed: it is refused, or overlooks nothing.
///
/// # Panics
/// When a tree is believed that overlooks an edge.
pub fn index_check(bytes: &[u8]) {
    const PROPERTIES: [&str; 7] = [
        "accepted_index_overlooks_no_edge",
        "disturbed_indices_are_refused_or_overlook_nothing",
        "shrunken_boxes_are_refused",
        "misshapen_trees_are_refused",
        "boxes_of_a_node_meet_as_windows_do",
        "disturbed_cells_are_refused_or_harmless",
        "what_is_near_lies_in_the_whole",
    ];
    match bytes.split_first() {
        Some((which, rest)) if which % 2 == 0 => keepout_proofs::named_of_bytes(&PROPERTIES, rest),
        Some((_, rest)) => drop(mutated(&mut Unstructured::new(rest))),
        None => {}
    }
}

/// Edges in a tree of up to three levels, of which boxes, nodes and levels are changed.
fn mutated(u: &mut Unstructured<'_>) -> Result<()> {
    let field = Field::arbitrary(u)?;
    let (own, copies) = (u.int_in_range(0..=40_usize)?, u.int_in_range(1..=16_i64)?);
    let mut edges = Vec::new();
    for _ in 0..own {
        let (a, b, slack) = (field.point(u)?, field.point(u)?, length(i64::from(u8::arbitrary(u)?)));
        for k in 0..copies {
            let chord = segment((a.0 + 7 * k, a.1), (b.0, b.1 - 5 * k));
            edges.push(Edge { chord, slack });
        }
    }
    let mut proposal = propose(&edges);
    for _ in 0..u.int_in_range(0..=4_u8)? {
        mutate(&mut proposal, field, u)?;
    }
    match CheckedIndex::check(edges.clone(), proposal) {
        Err(fault) => told(&fault.to_string()),
        Ok(index) => {
            for (number, edge) in edges.iter().enumerate() {
                // All of the edge's box, and what just touches it on each side.
                let whole = edge.bounds();
                let (x0, y0, x1, y1) = whole.corners();
                let rims = [(x0, y0, x0, y1), (x1, y0, x1, y1), (x0, y0, x1, y0), (x0, y1, x1, y1)];
                let rims = rims.map(|(a, b, c, d)| Window::from_corners(a, b, c, d));
                for window in rims.into_iter().chain([whole]) {
                    let mut seen = 0;
                    let _ = index.visit(window, |visited, _| {
                        seen += usize::from(visited == number);
                        ControlFlow::Continue(())
                    });
                    assert_eq!(seen, 1, "edge {number} of {edges:?} in {window:?}");
                }
            }
        }
    }
    Ok(())
}

fn mutate(proposal: &mut Proposal, field: Field, u: &mut Unstructured<'_>) -> Result<()> {
    if proposal.levels.is_empty() {
        proposal.levels.push(vec![Node::of(std::iter::empty())]);
        return Ok(());
    }
    let level = u.choose_index(proposal.levels.len())?;
    let nodes = &mut proposal.levels[level];
    let node = u.choose_index(nodes.len().max(1))?.min(nodes.len().saturating_sub(1));
    match u.int_in_range(0..=9_u8)? {
        0 => drop(proposal.levels.remove(level)),
        1 => proposal.levels.insert(level, proposal.levels[level].clone()),
        2 if !nodes.is_empty() => drop(nodes.remove(node)),
        3 if !nodes.is_empty() => nodes.push(nodes[node]),
        4 if !nodes.is_empty() => nodes.rotate_left(node),
        _ if !nodes.is_empty() => {
            let mut boxes: Vec<Window> = nodes[node].windows().collect();
            let (lane, side) = (u.int_in_range(0..=7_usize)?, u.int_in_range(0..=3_u8)?);
            let by = i32::from(*u.choose(&[1_i16, -1, 2, i16::MAX, i16::MIN])?);
            let (x0, y0, x1, y1) = boxes[lane].corners();
            boxes[lane] = match side {
                0 => Window::from_corners(x0.saturating_add(by), y0, x1, y1),
                1 => Window::from_corners(x0, y0.saturating_add(by), x1, y1),
                2 => Window::from_corners(x0, y0, x1.saturating_add(by), y1),
                _ => Window::of(at(field.point(u)?)),
            };
            nodes[node] = Node::of(boxes.into_iter());
        }
        _ => {}
    }
    Ok(())
}

/// A field of coordinates: half its side, and the grid that they lie on, so that things coincide.
#[derive(Clone, Copy, Debug)]
struct Field {
    half: i64,
    grid: i64,
}

impl<'a> Arbitrary<'a> for Field {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let half = 1_i64 << u.int_in_range(2..=29_u8)?;
        let grid = (1_i64 << u.int_in_range(0..=29_u8)?).min(half);
        Ok(Self { half, grid: if bool::arbitrary(u)? { grid } else { 1 } })
    }
}

impl Field {
    fn point(self, u: &mut Unstructured<'_>) -> Result<Xy> {
        let most = self.half / self.grid;
        let mut coordinate = || -> Result<i64> { Ok(u.int_in_range(-most..=most)? * self.grid) };
        Ok((coordinate()?, coordinate()?))
    }

    /// A point beside some corner, or anywhere.
    fn beside(self, corners: &[Xy], u: &mut Unstructured<'_>) -> Result<Xy> {
        if corners.is_empty() || bool::arbitrary(u)? {
            return self.point(u);
        }
        let (x, y) = *u.choose(corners)?;
        Ok((x + i64::from(i16::arbitrary(u)?), y + i64::from(i8::arbitrary(u)?)))
    }

    fn radius(self, u: &mut Unstructured<'_>) -> Result<i64> {
        let most = if bool::arbitrary(u)? { self.half } else { 64 };
        u.int_in_range(0..=most)
    }

    /// A ring around a centre, or through any points; simple or not.
    fn ring(self, u: &mut Unstructured<'_>) -> Result<Vec<Xy>> {
        let count = u.int_in_range(3..=CORNERS_MAX)?;
        if bool::arbitrary(u)? {
            return (0..count).map(|_| self.point(u)).collect();
        }
        let centre = self.point(u)?;
        (0..count)
            .map(|k| Ok(around(centre, k, count, self.half * i64::from(u.int_in_range(1..=64_u8)?) / 64)))
            .collect()
    }
}

#[expect(clippy::cast_precision_loss, reason = "few corners, and radii of 30 bits")]
fn around((x, y): Xy, k: usize, count: usize, radius: i64) -> Xy {
    let (sine, cosine) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
    let unit = |c: f64| keepout_kernel::curve::nearest_unit(c * radius as f64);
    (x + unit(cosine), y + unit(sine))
}

fn segment(a: Xy, b: Xy) -> Segment {
    Segment { from: at(a), to: at(b) }
}

/// Any bytes as a part and motions beside it: point, motion, fan and clip are what big integers say over all edges.
///
/// # Panics
/// When one is not.
pub fn clear(bytes: &[u8]) {
    let _ = clear_of(&mut Unstructured::new(bytes));
}

fn clear_of(u: &mut Unstructured<'_>) -> Result<()> {
    let field = Field::arbitrary(u)?;
    let corners = field.ring(u)?;
    let side = if bool::arbitrary(u)? { Side::Outside } else { Side::Inside };
    let mut polygons = vec![corners.iter().copied().map(clamped).collect::<Vec<Xy>>()];
    if bool::arbitrary(u)? {
        polygons.push(field.ring(u)?.into_iter().map(clamped).collect());
    }
    let plain = |polygon: Vec<Xy>| polygon.into_iter().map(|p| (p, 0)).collect();
    let mut drawn = Drawn { outlines: polygons.into_iter().map(plain).collect(), zones: Vec::new(), side };
    let Some(mut part) = drawn.part() else { return Ok(()) };
    let threshold = field.radius(u)?;
    if bool::arbitrary(u)? {
        let _ = part.prepare(length(threshold));
    }
    let truth = Truth::of(&drawn);
    let mut asked = Vec::new();
    for _ in 0..u.int_in_range(1..=4_u8)? {
        let places =
            [field.beside(&corners, u)?, field.beside(&corners, u)?, field.beside(&corners, u)?].map(clamped);
        ask(&part, &truth, places, threshold);
        asked.push(places);
    }
    // The same once more among zones, and where curves may leave their chords.
    for (_, slack) in drawn.outlines.iter_mut().flatten() {
        *slack = slack_of(u)?;
    }
    for _ in 0..u.int_in_range(0..=2_u8)? {
        let zone = field.ring(u)?.into_iter().map(clamped);
        drawn.zones.push(zone.map(|p| Ok((p, slack_of(u)?))).collect::<Result<_>>()?);
    }
    let Some(mut part) = drawn.part() else { return Ok(()) };
    let threshold = threshold.min(i64::from(COORD_MAX) - SLACK_MAX);
    if bool::arbitrary(u)? {
        let _ = part.prepare(length(threshold));
    }
    let truth = Truth::of(&drawn);
    for places in asked {
        ask(&part, &truth, places, threshold);
        let more = More {
            corner: clamped(field.beside(&corners, u)?),
            higher: threshold + i64::from(u16::arbitrary(u)?),
            bulge: f64::from(i8::arbitrary(u)?) / 100.0,
        };
        ask_more(&part, &truth, places, threshold, &more);
        ask_coarse(&part, &truth, places, threshold, (more.higher - threshold) / 64);
    }
    Ok(())
}

/// Most that a curve leaves its chord by, lattice units.
const SLACK_MAX: i64 = 1 << 17;

fn slack_of(u: &mut Unstructured<'_>) -> Result<i64> {
    Ok(match u.int_in_range(0..=3_u8)? {
        0 => i64::from(u16::arbitrary(u)?),
        1 => i64::from(u8::arbitrary(u)?),
        _ => 0,
    })
}

/// Onto the lattice, as [`at`] does.
fn clamped(p: Xy) -> Xy {
    plain(at(p))
}

/// Corners, each with what the curve may leave the edge by that begins there.
type Loop = Vec<(Xy, i64)>;

/// A part as it was drawn, not as the kernel keeps it.
struct Drawn {
    outlines: Vec<Loop>,
    zones: Vec<Loop>,
    side: Side,
}

impl Drawn {
    /// The kernel's; a drawing that is none has an error with a text.
    fn part(&self) -> Option<ProhibitedRegion> {
        let rings =
            |loops: &[Loop]| match loops.iter().map(ring_of).collect::<std::result::Result<Vec<_>, _>>() {
                Ok(rings) => Some(rings),
                Err(error) => {
                    told(&error.to_string());
                    None
                }
            };
        let region = match Region::new(rings(&self.outlines)?) {
            Ok(region) => region,
            Err(error) => {
                told(&error.to_string());
                return None;
            }
        };
        ProhibitedRegion::with_zones(region, self.side, rings(&self.zones)?).ok()
    }
}

fn ring_of(each: &Loop) -> std::result::Result<Ring, RingError> {
    let pieces =
        edges_of(each).map(|((a, b), slack)| Piece::Line { segment: segment(a, b), slack: length(slack) });
    Ring::from_pieces(&pieces.collect::<Vec<_>>())
}

fn edges_of(each: &Loop) -> impl Iterator<Item = ((Xy, Xy), i64)> + '_ {
    each.iter().zip(each.iter().cycle().skip(1)).map(|(&(a, slack), &(b, _))| ((a, b), slack))
}

/// What big integers say of it.
#[derive(Debug)]
struct Truth {
    walls: Vec<((Xy, Xy), i64)>,
    polygons: Vec<Vec<Big>>,
    zones: Vec<Vec<Big>>,
    side: Side,
}

impl Truth {
    fn of(drawn: &Drawn) -> Self {
        let places = |each: &Loop| each.iter().map(|&((x, y), _)| Big::new(x, y)).collect();
        Self {
            walls: drawn.outlines.iter().chain(&drawn.zones).flat_map(edges_of).collect(),
            polygons: drawn.outlines.iter().map(places).collect(),
            zones: drawn.zones.iter().map(places).collect(),
            side: drawn.side,
        }
    }

    /// Whether a point that is on no wall is where the tool may be.
    fn is_free(&self, (x, y): Xy) -> bool {
        let at = Big::new(x, y);
        let around = |polygon: &&Vec<Big>| inside_polygon(&at, polygon) == Some(true);
        let within = self.polygons.iter().filter(around).count() % 2 == 1;
        within == (self.side == Side::Inside) && !self.zones.iter().any(|zone| around(&zone))
    }

    fn near_point(&self, p: Xy, r: i64) -> bool {
        self.walls.iter().any(|&((a, b), slack)| point_within(p, a, b, r + slack))
    }

    fn near_motion(&self, p: Xy, q: Xy, r: i64) -> bool {
        self.walls.iter().any(|&((a, b), slack)| segments_within(p, q, a, b, r + slack))
    }

    fn near_fan(&self, corners: [Xy; 3], r: i64) -> bool {
        self.walls.iter().any(|&((a, b), slack)| triangle_within(corners, a, b, r + slack))
    }

    /// Whether the motion comes within `r` of a wall that it also comes nearer to than it began.
    fn approaches(&self, p: Xy, q: Xy, r: i64) -> bool {
        let big = |(x, y): Xy| Big::new(x, y);
        self.walls.iter().any(|&((a, b), slack)| {
            segments_within(p, q, a, b, r + slack) && !never_nearer(&big(p), &big(q), &big(a), &big(b))
        })
    }
}

fn ask(part: &ProhibitedRegion, truth: &Truth, [p, q, s]: [Xy; 3], r: i64) {
    let case = || format!("{p:?} {q:?} {s:?} within {r} of {truth:?}");
    let t = length(r);
    assert_eq!(part.point_clear(at(p), t).is_clear(), !truth.near_point(p, r), "point {}", case());
    assert_eq!(
        part.motion_clear(segment(p, q), t).is_clear(),
        !truth.near_motion(p, q, r),
        "motion {}",
        case()
    );
    let start = part.free_point(at(p), t);
    let is_free = !truth.near_point(p, r) && truth.is_free(p);
    assert_eq!(start.is_ok(), is_free, "free point {}", case());
    let Ok(start) = start else { return };
    let motion = part.motion(start, at(q));
    assert_eq!(motion.is_ok(), !truth.near_motion(p, q, r), "motion from a free point {}", case());
    if let Ok(end) = motion {
        let fan = part.fan(start, end, at(s)).is_ok();
        assert_eq!(fan, !truth.near_fan([p, q, s], r), "fan {}", case());
    }
    let clipped = plain(part.clip(start, at(q)).point());
    assert!(!truth.near_motion(p, clipped, r), "clipped at {clipped:?}, {}", case());
    let whole = truth.near_motion(p, q, r) || clipped == q;
    assert!(whole, "clipped at {clipped:?} although clear, {}", case());
    if let Some(clearance) = part.clearance(at(p)) {
        let c = i64::from(clearance.units());
        assert!(!truth.near_point(p, c), "clearance {c}, {}", case());
    }
}

/// What else is asked.
#[derive(Debug)]
struct More {
    /// One more corner of a polygon.
    corner: Xy,
    /// The threshold that a way out is asked at.
    higher: i64,
    /// Of an arc.
    bulge: f64,
}

/// Filled polygons, ways out and arcs from a free point.
fn ask_more(part: &ProhibitedRegion, truth: &Truth, [p, q, s]: [Xy; 3], r: i64, more: &More) {
    let case = || format!("{p:?} {q:?} {s:?} within {r}, {more:?} of {truth:?}");
    let holds = part.holds(at(p));
    let on_wall = truth.walls.iter().any(|&((a, b), _)| point_within(p, a, b, 0));
    assert_eq!(holds, on_wall || !truth.is_free(p), "holds {}", case());
    let Ok(start) = part.free_point(at(p), length(r)) else { return };
    let o = more.corner;
    for corners in [vec![p, q], vec![p, q, s], vec![p, s, q], vec![p, q, s, o], vec![p, o, s, q]] {
        let points: Vec<Point> = corners.iter().map(|&corner| at(corner)).collect();
        let Some(polygon) = Convex::check(&points) else { continue };
        // Fans from its first corner are all of it.
        let fans = corners[1..].windows(2).map(|pair| [p, pair[0], pair[1]]);
        let near = truth.near_motion(p, corners[1], r) || fans.into_iter().any(|fan| truth.near_fan(fan, r));
        let end = part.polygon(start, polygon, at(q));
        assert_eq!(end.is_ok(), !near, "polygon {corners:?}, {}", case());
    }
    let way_out = part.recedes(start, at(q), length(more.higher));
    assert_eq!(way_out.is_ok(), !truth.approaches(p, q, more.higher), "way out {}", case());
    let Some(curve) = bent(at(p), at(q), more.bulge) else { return };
    let Curve::Arc(arc) = &curve else { return };
    if part.arc(start, arc).is_ok() {
        for place in places(&curve) {
            for &((a, b), slack) in &truth.walls {
                let (left, needed) = (to_chord(place, (xy(at(a)), xy(at(b)))), length(r + slack));
                // An arc's ends are on its circle to a unit or two.
                assert!(left > f64::from(needed.units()) - 3.0, "{arc:?} comes to {left}, {}", case());
            }
        }
    }
}

/// What is free of the part with fewer edges is free of the part.
fn ask_coarse(part: &ProhibitedRegion, truth: &Truth, [p, q, s]: [Xy; 3], r: i64, tolerance: i64) {
    let case = || format!("{p:?} {q:?} {s:?} within {r} of {truth:?}, coarse by {tolerance}");
    let coarse = part.coarsened(length(tolerance)).expect("fewer edges");
    let Ok(start) = coarse.free_point(at(p), length(r)) else { return };
    assert!(!truth.near_point(p, r) && truth.is_free(p), "free point {}", case());
    let Ok(end) = coarse.motion(start, at(q)) else { return };
    assert!(!truth.near_motion(p, q, r), "motion {}", case());
    let fan = coarse.fan(start, end, at(s));
    assert!(fan.is_err() || !truth.near_fan([p, q, s], r), "fan {}", case());
}

/// Any bytes as edges: a mesh that finds what is nearest, and what lies where, as brute force does; or one that is not
/// confirmed.
///
/// # Panics
/// When a wrong answer is confirmed, or a mesh with all edges gives one.
pub fn mesh(bytes: &[u8]) {
    let _ = mesh_of(&mut Unstructured::new(bytes));
}

fn mesh_of(u: &mut Unstructured<'_>) -> Result<()> {
    let field = Field::arbitrary(u)?;
    let soup = bool::arbitrary(u)?;
    let (edges, corners) = if soup { soup_of(field, u)? } else { rings_of(field, u)? };
    let Ok(index) = build(edges) else { return Ok(()) };
    let half_frame = 2 * field.half + 1 + i64::from(u16::arbitrary(u)?);
    let half_frame = half_frame.min(i64::from(COORD_MAX));
    let frame = i32::try_from(half_frame).unwrap_or(i32::MAX);
    let frame = Window::from_corners(-frame, -frame, frame, frame);
    let mesh = match Mesh::build(&index, frame, bool::arbitrary(u)?) {
        Ok(mesh) => mesh,
        Err(MeshError::Frame) => {
            let ends = index.edges().iter().flat_map(|edge| [plain(edge.chord.from), plain(edge.chord.to)]);
            let most = ends.map(|(x, y)| x.abs().max(y.abs())).max().unwrap_or(0);
            assert!(most >= half_frame, "a frame of {half_frame} is refused for {most}");
            return Ok(());
        }
        Err(error) => panic!("{error}: {:?}", index.edges()),
    };
    let mut walk = mesh.walk();
    for _ in 0..u.int_in_range(1..=8_u8)? {
        let p = at(field.beside(&corners, u)?);
        let Some(nearest) = walk.nearest(&mesh, &index, p) else {
            assert!(!frame.holds(p), "nothing is nearest to {p:?} of {:?}", index.edges());
            continue;
        };
        let truth = brute(&index, p);
        let right = (nearest.distance() - truth).abs() <= 1e-3 + truth * 1e-9;
        let case = format!("{p:?}: {nearest:?}, {truth} in {:?}", index.edges());
        assert!(
            right || !index.confirms(p, nearest) || (nearest.distance() - truth).abs() < 2.5,
            "confirmed {case}"
        );
        assert!(right || mesh.left_out() > 0, "{case}");
        refuses_others(&index, p, nearest, truth, u)?;
        if !soup && mesh.left_out() == 0 && frame.holds(p) && index.locate(p) != Location::Boundary {
            // What is outside of all rings is one piece with the frame's corner.
            let outside = walk.component(&mesh, p) == Some(0);
            assert!(!outside || index.locate(p) == Location::Outside, "{case}");
        }
    }
    Ok(())
}

/// An answer that is off by more than rounding is not confirmed.
fn refuses_others(
    index: &CheckedIndex,
    p: Point,
    nearest: Nearest,
    truth: f64,
    u: &mut Unstructured<'_>,
) -> Result<()> {
    let edge = usize::from(u8::arbitrary(u)?);
    let factor = 1.0 + f64::from(i8::arbitrary(u)?) / 64.0;
    let other = Nearest { edge, distance_2: nearest.distance_2 * factor };
    let off = |edge: &Edge| (to_edge(edge, p) - other.distance()).abs();
    let wrong =
        (other.distance() - truth).abs() > 2.5 || index.edges().get(edge).is_none_or(|edge| off(edge) > 2.5);
    assert!(!wrong || !index.confirms(p, other), "{other:?} at {p:?}, truth {truth}");
    Ok(())
}

fn soup_of(field: Field, u: &mut Unstructured<'_>) -> Result<(Vec<Edge>, Vec<Xy>)> {
    let count = u.int_in_range(1..=CORNERS_MAX)?;
    let mut corners: Vec<Xy> = Vec::new();
    let mut edges = Vec::new();
    for _ in 0..count {
        // Ends are shared now and then.
        let a =
            if corners.is_empty() || bool::arbitrary(u)? { field.point(u)? } else { *u.choose(&corners)? };
        let b = field.point(u)?;
        corners.extend([a, b]);
        edges.push(Edge { chord: segment(a, b), slack: Length::ZERO });
    }
    Ok((edges, corners))
}

fn rings_of(field: Field, u: &mut Unstructured<'_>) -> Result<(Vec<Edge>, Vec<Xy>)> {
    let (mut edges, mut corners) = (Vec::new(), Vec::new());
    for _ in 0..u.int_in_range(1..=2_u8)? {
        let ring = field.ring(u)?;
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        edges.extend(ends.map(|(&a, &b)| Edge { chord: segment(a, b), slack: Length::ZERO }));
        corners.extend(ring);
    }
    Ok((edges, corners))
}

fn to_edge(edge: &Edge, p: Point) -> f64 {
    let (a, b, p) = (xy(edge.chord.from), xy(edge.chord.to), xy(p));
    let (d, w) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
    let share = ((w.0 * d.0 + w.1 * d.1) / (d.0 * d.0 + d.1 * d.1).max(1.0)).clamp(0.0, 1.0);
    (w.0 - share * d.0).hypot(w.1 - share * d.1)
}

fn brute(index: &CheckedIndex, p: Point) -> f64 {
    index.edges().iter().map(|edge| to_edge(edge, p)).fold(f64::INFINITY, f64::min)
}
