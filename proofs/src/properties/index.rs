//! The clearance index, its checker and search, cells: they miss no near edge.

use std::ops::ControlFlow;

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::region::Location;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build::{build, propose};
use keepout_kernel::index::cells::{self, Answer, Claim, GROUP, Packed};
use keepout_kernel::index::check::{BoxProposal, Node};
use keepout_kernel::index::{CheckedIndex, subdivide};
use keepout_kernel::{Cells, Convex, Edge, Point, Segment, Triangle};

use super::Xy;
use crate::draw::Draw;
use crate::families::{at, length};
use crate::property::{passed_over, properties};

properties! {
    "index", "kernel/src/index/check.rs, query.rs, cells.rs";
    // Evidence for SR-03.
    accepted_index_overlooks_no_edge |d| {
        let edges = edges(d, 2);
        accepted_index_overlooks_no_edge(&edges, proposal(d, &edges), window(d))
    }
        => "proposed boxes may be arbitrary: if the check accepts them, a search visits every edge whose \
            box meets the window, once and in order";
        every 1 random 60_000;
    disturbed_indices_are_refused_or_overlook_nothing |d| {
        let count = 1 + d.one_of(90);
        let edges = edges(d, count);
        let proposal = disturbed(d, &edges);
        accepted_index_overlooks_no_edge(&edges, proposal, window(d))
    }
        => "a modified tree of one, two or three levels is refused, or a search still misses no edge";
        random 60_000;
    shrunken_boxes_are_refused |d| {
        let count = 1 + d.one_of(300);
        let edges = edges(d, count);
        let which = d.int(0, 1 << 20);
        shrunken_boxes_are_refused(&edges, which, d.int(0, 3))
    }
        => "a box that is one unit too small on one side is refused, on every level";
        random 20_000;
    misshapen_trees_are_refused |d| {
        let count = d.one_of(70);
        let edges = edges(d, count);
        misshapen_trees_are_refused(&edges, d.int(0, 4))
    }
        => "a tree with too many or too few levels or nodes is refused";
        random 5_000;
    boxes_of_a_node_meet_as_windows_do |d| {
        let boxes: Vec<Window> = (0..8).map(|_| window(d)).collect();
        let lanes = d.one_of(9);
        boxes_of_a_node_meet_as_windows_do(&boxes[..lanes], window(d))
    }
        => "a node of eight boxes answers as its boxes do one by one; an empty lane meets no window";
        random 60_000;
    queries_are_those_over_all_edges |d| {
        let count = 1 + d.one_of(60);
        let edges = edges(d, count);
        queries_are_those_over_all_edges(&edges, [d.point(), d.point(), d.point()], d.radius())
    }
        => "queries for point, motion, swept triangle, polygon, box, approached edge and side answer as \
            all edges do, whichever boxes they skip";
        random 30_000;
    few_queries_are_those_over_all_edges |d| {
        let edges = edges(d, 1);
        queries_are_those_over_all_edges(&edges, [d.point(), d.point(), d.point()], d.radius())
    }
        => "the same for every single edge";
        every 1 random 1_000;
    long_motions_skip_only_what_is_beside |d| {
        let count = 1 + d.one_of(60);
        let edges = edges(d, count);
        long_motions_skip_only_what_is_beside(&edges, [d.point(), d.point()], d.radius())
    }
        => "a search along a motion visits every edge within the threshold of it";
        random 30_000;
    claims_survive_packing |d| claims_survive_packing(d.one_of(5), d.int(0, i64::from(u32::MAX)))
        => "a claim packed into 32 bits is read back unchanged, or as open when its number does not fit";
        random 50_000;
    cells_answer_as_the_index |d| {
        let count = 1 + d.one_of(12);
        let edges = edges(d, count);
        cells_answer_as_the_index(&edges, d.radius(), 1 + d.one_of(60), [d.point(), d.point()])
    }
        => "checked cells answer as the index does, for points and motions, or leave the question open";
        random 8_000;
    disturbed_cells_are_refused_or_harmless |d| {
        let count = 1 + d.one_of(8);
        let edges = edges(d, count);
        let disturb = (d.int(0, 1 << 20), d.one_of(8), d.int(0, 40));
        disturbed_cells_are_refused_or_harmless(&edges, d.radius(), disturb, [d.point(), d.point()])
    }
        => "cells with a modified claim, list or covered square are refused, or answer as checked cells \
            do";
        random 60_000;
    what_is_near_lies_in_the_whole |d| {
        let edges = edges(d, 1);
        let rim = d.int(-3, 6);
        what_is_near_lies_in_the_whole(&edges, d.radius(), rim)
    }
        => "cells whose covered square does not hold every point near an edge are refused, so no edge is \
            near outside of it";
        random 20_000;
    walks_cover_their_motion |d| {
        let edges = edges(d, 3);
        walks_cover_their_motion(&edges, d.radius(), 1 + d.one_of(60), [d.point(), d.point()], d.int(0, 64))
    }
        => "the squares that a walk visits along a motion cover all of the motion";
        random 8_000;
}

fn edges<D: Draw>(d: &mut D, count: usize) -> Vec<Edge> {
    (0..count)
        .map(|_| {
            let (a, b) = (d.point(), d.point());
            // Mostly short edges, so that searches can skip the far ones.
            let part = [1, 8, 64][if count > 2 { d.one_of(3) } else { 0 }];
            let b = (a.0 + (b.0 - a.0) / part, a.1 + (b.1 - a.1) / part);
            let chord_error = if count > 2 && d.one_of(4) == 0 { d.radius() / 16 } else { 0 };
            Edge { chord: Segment { from: at(a), to: at(b) }, chord_error: length(chord_error) }
        })
        .collect()
}

fn window<D: Draw>(d: &mut D) -> Window {
    Window::of(at(d.point())).including(at(d.point()))
}

/// One node over up to four edges whose first box is drawn.
fn proposal<D: Draw>(d: &mut D, edges: &[Edge]) -> BoxProposal {
    let drawn = window(d);
    let whole = edges.iter().map(Edge::bounds).reduce(Window::union);
    let first = if d.coin() { drawn } else { whole.unwrap_or(drawn) };
    let second = d.coin().then_some(drawn);
    BoxProposal { levels: vec![vec![Node::of([first].into_iter().chain(second))]] }
}

/// Proposed boxes, with one box replaced, or a node or level removed or duplicated.
fn disturbed<D: Draw>(d: &mut D, edges: &[Edge]) -> BoxProposal {
    let mut proposal = propose(edges);
    let level = d.one_of(proposal.levels.len());
    let node = d.one_of(proposal.levels[level].len());
    match d.one_of(6) {
        0 => drop(proposal.levels.remove(level)),
        1 => proposal.levels.insert(level, proposal.levels[level].clone()),
        2 => drop(proposal.levels[level].remove(node)),
        3 => {
            let other = proposal.levels[level][node];
            proposal.levels[level].push(other);
        }
        _ => {
            let lane = d.one_of(8);
            let other = window(d);
            let mut boxes: Vec<Window> = proposal.levels[level][node].windows().collect();
            boxes[lane] = if d.coin() { other } else { Window::from_corners(9, 9, 8, 8) };
            proposal.levels[level][node] = Node::of(boxes.into_iter());
        }
    }
    proposal
}

fn visited(index: &CheckedIndex, window: Window) -> Vec<usize> {
    let mut visited = Vec::new();
    let _ = index.visit(window, |number, edge| {
        assert_eq!(index.edges().get(number), Some(edge), "the number is the edge's");
        visited.push(number);
        ControlFlow::Continue(())
    });
    visited
}

fn accepted_index_overlooks_no_edge(edges: &[Edge], proposal: BoxProposal, window: Window) {
    let Ok(index) = CheckedIndex::check(edges.to_vec(), proposal) else { return };
    assert_eq!(index.edges(), edges);
    let visited = visited(&index, window);
    assert!(visited.windows(2).all(|pair| pair[0] < pair[1]), "once and in order: {visited:?}");
    for (number, edge) in edges.iter().enumerate() {
        let seen = visited.contains(&number);
        assert!(seen || !edge.bounds().meets(window), "{edges:?} {window:?}: the search misses {number}");
    }
}

fn shrunken_boxes_are_refused(edges: &[Edge], which: i64, side: i64) {
    let mut proposal = propose(edges);
    assert!(CheckedIndex::check(edges.to_vec(), proposal.clone()).is_ok());
    let pick = |count: usize, of: i64| usize::try_from(of).unwrap_or(0) % count;
    let level = pick(proposal.levels.len(), which);
    let node = pick(proposal.levels[level].len(), which / 3);
    let mut boxes: Vec<Window> = proposal.levels[level][node].windows().collect();
    let full = boxes.iter().filter(|window| !window.is_empty()).count();
    let lane = pick(full, which / 7);
    let (x0, y0, x1, y1) = boxes[lane].corners();
    boxes[lane] = match side {
        0 => Window::from_corners(x0 + 1, y0, x1, y1),
        1 => Window::from_corners(x0, y0 + 1, x1, y1),
        2 => Window::from_corners(x0, y0, x1 - 1, y1),
        _ => Window::from_corners(x0, y0, x1, y1 - 1),
    };
    proposal.levels[level][node] = Node::of(boxes.into_iter());
    assert!(
        CheckedIndex::check(edges.to_vec(), proposal).is_err(),
        "level {level}, node {node}, lane {lane}"
    );
}

fn misshapen_trees_are_refused(edges: &[Edge], way: i64) {
    let mut proposal = propose(edges);
    let whole = Window::from_corners(-(1 << 29), -(1 << 29), 1 << 29, 1 << 29);
    let all = Node::of([whole; 8].into_iter());
    match way {
        0 => proposal.levels.push(vec![all]),
        1 if !proposal.levels.is_empty() => drop(proposal.levels.pop()),
        2 if !proposal.levels.is_empty() => proposal.levels[0].push(all),
        3 if !proposal.levels.is_empty() => drop(proposal.levels[0].pop()),
        4 if !proposal.levels.is_empty() => proposal.levels.last_mut().expect("one at least").push(all),
        _ => return,
    }
    assert!(CheckedIndex::check(edges.to_vec(), proposal).is_err(), "{} edges, {way}", edges.len());
}

fn boxes_of_a_node_meet_as_windows_do(boxes: &[Window], window: Window) {
    let node = Node::of(boxes.iter().copied());
    let mask = node.meeting(window);
    for lane in 0..8_usize {
        let meets = boxes.get(lane).is_some_and(|each| each.meets(window));
        assert_eq!(mask >> lane & 1 == 1, meets, "{boxes:?} {window:?}: lane {lane}");
        let of = node.window(u32::try_from(lane).unwrap_or(0)).expect("eight lanes");
        assert!(boxes.get(lane).map_or(of.is_empty(), |each| *each == of));
    }
    assert_eq!(node.window(8), None);
}

fn queries_are_those_over_all_edges(edges: &[Edge], [p, q, s]: [Xy; 3], r: i64) {
    let index = build(edges.to_vec()).expect("few edges");
    let (a, b, c, t) = (at(p), at(q), at(s), length(r));
    // The index finds an edge whose chord-error bound takes the threshold off the lattice only near the
    // edge's box.
    if edges.iter().any(|edge| t.plus(edge.chord_error).is_err()) {
        return passed_over();
    }
    let any = |near: &dyn Fn(&Edge) -> bool| edges.iter().any(near);
    let case = format!("{edges:?} {p:?} {q:?} {s:?} {r}");
    let (motion, swept) = (Segment { from: a, to: b }, Triangle { corners: [a, b, c] });
    let window = Window::of(a).including(b);
    assert_eq!(
        index.near_point(a, t).is_some(),
        any(&|edge| !edge.near_point(a, t).is_clear()),
        "point {case}"
    );
    assert_eq!(
        index.near_motion(motion, t).is_some(),
        any(&|edge| !edge.near_motion(motion, t).is_clear()),
        "motion {case}"
    );
    let turned = [a, c, b];
    let polygon =
        Convex::check(&swept.corners).or_else(|| Convex::check(&turned)).expect("one way it turns left");
    assert_eq!(
        index.near_convex(polygon, t).is_some(),
        any(&|edge| !edge.near_convex(polygon, t).is_clear()),
        "polygon {case}"
    );
    assert_eq!(
        index.near_triangle(swept, t).is_some(),
        any(&|edge| !edge.near_triangle(swept, t).is_clear()),
        "swept triangle {case}"
    );
    assert_eq!(
        index.near_box(window, t).is_some(),
        any(&|edge| !edge.near_box(window, t).is_clear()),
        "box {case}"
    );
    let approached =
        any(&|edge| !motion.retracts_from(edge.chord) && !edge.near_motion(motion, t).is_clear());
    assert_eq!(index.approached(motion, t).is_some(), approached, "approached {case}");
    if let Some(edge) = index.near_point(a, t) {
        assert!(!edge.near_point(a, t).is_clear(), "the edge that is named is near: {case}");
    }
    assert_eq!(index.locate(a), location(edges, a), "side {case}");
}

/// The location of the point, by the number of edges that cross the ray from it to the right.
fn location(edges: &[Edge], a: Point) -> Location {
    if edges.iter().any(|edge| !edge.chord.near_point(a, length(0)).is_clear()) {
        return Location::Boundary;
    }
    let crossed = edges.iter().filter(|edge| {
        let (from, to) = (edge.chord.from, edge.chord.to);
        let side = keepout_kernel::exact::segment::orientation(from, to, a);
        let up = from.y <= a.y && to.y > a.y && side == keepout_kernel::exact::predicate::Orientation::Left;
        let down =
            to.y <= a.y && from.y > a.y && side == keepout_kernel::exact::predicate::Orientation::Right;
        up || down
    });
    if crossed.count() % 2 == 1 { Location::Inside } else { Location::Outside }
}

fn long_motions_skip_only_what_is_beside(edges: &[Edge], [p, q]: [Xy; 2], r: i64) {
    let index = build(edges.to_vec()).expect("few edges");
    let (motion, t) = (Segment { from: at(p), to: at(q) }, length(r));
    let mut seen = vec![false; edges.len()];
    let _ = index.along(motion, t, |number, _| {
        seen[number] = true;
        ControlFlow::Continue(())
    });
    for (edge, seen) in edges.iter().zip(seen) {
        let near = t.plus(edge.chord_error).is_ok() && !edge.near_motion(motion, t).is_clear();
        assert!(seen || !near, "{edge:?} {motion:?} {r}");
    }
}

fn claims_survive_packing(kind: usize, number: i64) {
    let number = u32::try_from(number).unwrap_or(u32::MAX);
    let claim =
        [Claim::Free, Claim::Open, Claim::Blocked(number), Claim::Near(number), Claim::Divided(number)][kind];
    let fits = kind < 2 || number < (1 << 30) - 1;
    assert_eq!(Packed::of(claim).claim(), if fits { claim } else { Claim::Open }, "{claim:?}");
}

fn cells_answer_as_the_index(edges: &[Edge], r: i64, groups: usize, [p, q]: [Xy; 2]) {
    let index = build(edges.to_vec()).expect("few edges");
    let t = length(r);
    let Ok(cells) = subdivide::build(&index, t, Some(groups)) else { return passed_over() };
    let motion = Segment { from: at(p), to: at(q) };
    for (answer, near) in [
        (cells.point(&index, at(p)), index.near_point(at(p), t).is_some()),
        (cells.motion(&index, motion), index.near_motion(motion, t).is_some()),
    ] {
        assert!(
            answer == Answer::Unknown || (answer != Answer::Clear) == near,
            "{edges:?} {r} {p:?} {q:?} {answer:?}"
        );
    }
}

/// The covered square begins `rim` units below and left of the points that lie the threshold below and left
/// of the edge. All its claims are open.
fn what_is_near_lies_in_the_whole(edges: &[Edge], r: i64, rim: i64) {
    let index = build(edges.to_vec()).expect("one edge");
    let (x0, y0, x1, y1) = edges[0].bounds().corners();
    let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(i64::from);
    let side = (x1 - x0).max(y1 - y0) + 2 * r + 20;
    let log_2 = 64 - side.leading_zeros();
    let (Ok(x), Ok(y)) = (i32::try_from(x0 - r - rim), i32::try_from(y0 - r - rim)) else {
        return passed_over();
    };
    let claims = vec![Packed::of(Claim::Open); GROUP];
    let proposal =
        cells::CellProposal { threshold: length(r), origin: (x, y), log_2, claims, lists: Vec::new() };
    let Ok(cells) = Cells::check(&index, proposal) else {
        // The check requires one spare unit on each side, and a square on the lattice.
        let room = i64::from(COORD_MAX) - (1 << log_2.min(40)) - r - 10;
        assert!(rim < 1 || x0.abs().max(y0.abs()) >= room, "{edges:?} {r} {rim}");
        return;
    };
    for (px, py) in [(x0 - r, y0), (x0, y0 - r), (x1, y0 - r), (x0 - r, y1)] {
        let Ok(p) = Point::from_units(px, py) else { continue };
        let near = index.near_point(p, length(r)).is_some();
        assert!(!near || cells.point(&index, p) != Answer::Clear, "{edges:?} {r} {rim} {p:?}");
    }
}

fn disturbed_cells_are_refused_or_harmless(
    edges: &[Edge],
    r: i64,
    disturb: (i64, usize, i64),
    [p, q]: [Xy; 2],
) {
    let index = build(edges.to_vec()).expect("few edges");
    let t = length(r);
    let Some(mut proposal) = subdivide::propose(&index, t, 6) else { return passed_over() };
    let (which, way, number) = disturb;
    let pick = |count: usize| usize::try_from(which).unwrap_or(0) % count.max(1);
    let (at_claim, at_list) = (pick(proposal.claims.len()), pick(proposal.lists.len()));
    let other = u32::try_from(number).unwrap_or(0);
    match way {
        0 | 1 => proposal.claims[at_claim] = Packed::of(Claim::Free),
        2 => proposal.claims[at_claim] = Packed::of(Claim::Blocked(other % 8)),
        3 => proposal.claims[at_claim] = Packed::of(Claim::Near(other)),
        4 if !proposal.lists.is_empty() => proposal.lists[at_list] = other % 9,
        5 => {
            // Moves the covered square off the near points.
            let side = 1_i32 << proposal.log_2.min(29);
            proposal.origin.0 =
                proposal.origin.0.saturating_add(side / 4 * i32::try_from(number % 5).unwrap_or(0));
        }
        6 if !proposal.lists.is_empty() => {
            // Removes one edge: the list's length and its last number.
            let count = proposal.lists[0];
            if count > 0 && proposal.lists.len() > usize::try_from(count).unwrap_or(0) {
                proposal.lists.remove(usize::try_from(count).unwrap_or(0));
                proposal.lists[0] = count - 1;
            }
        }
        _ => proposal.log_2 = proposal.log_2.saturating_sub(2),
    }
    let Ok(cells) = Cells::check(&index, proposal) else { return };
    let motion = Segment { from: at(p), to: at(q) };
    // Also a vertex, and a point at the threshold from it.
    let (x, y) = (edges[0].chord.from.x.units(), edges[0].chord.from.y.units());
    let beside = at((i64::from(x) + r, i64::from(y)));
    let points = [at(p), edges[0].chord.from, beside];
    for (answer, near) in points
        .map(|p| (cells.point(&index, p), index.near_point(p, t).is_some()))
        .into_iter()
        .chain([(cells.motion(&index, motion), index.near_motion(motion, t).is_some())])
    {
        assert!(
            answer == Answer::Unknown || (answer != Answer::Clear) == near,
            "{edges:?} {r} {disturb:?} {p:?} {q:?}"
        );
    }
}

fn walks_cover_their_motion(edges: &[Edge], r: i64, groups: usize, [p, q]: [Xy; 2], share: i64) {
    let index = build(edges.to_vec()).expect("few edges");
    let Ok(cells) = subdivide::build(&index, length(r), Some(groups)) else { return passed_over() };
    let motion = Segment { from: at(p), to: at(q) };
    // The point at `share` 64ths of the motion, times 64, lies in some closed square that the walk visits.
    let place = |from: i64, to: i64| from * 64 + (to - from) * share;
    let (x, y) = (place(p.0, q.0), place(p.1, q.1));
    let (mut covered, mut first, mut last) = (false, None, None);
    let walked = cells.walk(motion, |square| {
        let (low, side) = (square.low, 1_i64 << square.log_2);
        let within = |c: i64, low: i32| (i64::from(low) * 64..=(i64::from(low) + side) * 64).contains(&c);
        let holds = |x: i64, y: i64| within(x, low.0) && within(y, low.1);
        covered |= holds(x, y);
        first = first.or(Some(holds(p.0 * 64, p.1 * 64)));
        last = Some(holds(q.0 * 64, q.1 * 64));
        ControlFlow::Continue(())
    });
    if walked.is_some() {
        assert!(covered && first == Some(true) && last == Some(true), "{motion:?} {share} {edges:?} {r}");
    }
}
