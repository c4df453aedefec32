//! Nodes of eight boxes, the check of proposed boxes, and packed claims of cells.

use core::ops::ControlFlow;

use alloc::vec;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::cells::{Claim, Packed};
use keepout_kernel::index::check::{BoxProposal, Node};
use keepout_kernel::{CheckedIndex, Edge, Length, Segment};

use crate::lattice::{at, length, near_origin, point};
use crate::{Cases, harnesses};

harnesses! {
    "kernel/src/index/check.rs" {
        nodes_keep_their_boxes:
            "a node gives back the box of each lane", "eight boxes, the last any box, every lane", unwind 12;
        nodes_meet_as_their_boxes_do:
            "a node names a lane exactly when its box meets the window",
            "two boxes of eight and the window any", unwind 12;
        empty_lanes_meet_nothing:
            "a lane without a box meets no window of the lattice", "every window", unwind 12;
        accepted_boxes_hold_their_edges:
            "the check accepts a box only when it holds both edges below it", "any box, two edges at any place",
            unwind 12;
        searches_enter_every_box_that_meets:
            "in an accepted index a search visits both edges if their boxes meet the window",
            "any box, two edges at any place, any window", unwind 12;
        trees_without_a_box_are_refused:
            "no edge stands under an index without boxes, or with one level too many",
            "one edge, up to two levels of up to two nodes", unwind 12;
    }
    "kernel/src/index/cells.rs" {
        claims_survive_packing:
            "a packed claim is read back, or as open when its number does not fit", "every claim", unwind 1;
        packed_claims_differ:
            "two claims that are packed into one number are one claim", "every pair of claims", unwind 1;
    }
    "kernel/src/index/query.rs" {
        queries_find_the_nearest_edge:
            "a query for a point is near exactly when the only edge is near",
            "an edge from (0, 0) to (4, 0), points within ±7, r up to 7", unwind 12;
        queries_add_the_chord_error:
            "a query adds the chord-error bound of an edge to its threshold",
            "a vertical through the middle of that edge, heights up to 60, bounds and r up to 30", unwind 12;
    }
}

fn window(c: &mut impl Cases) -> Window {
    Window::of(point(c)).including(point(c))
}

fn nodes_keep_their_boxes(c: &mut impl Cases) {
    let (fixed, any) = (Window::of(at(1, 2)).including(at(3, 4)), window(c));
    let lane = c.up_to(7);
    let boxes = [0, 1, 2, 3, 4, 5, 6, 7].map(|each: u8| if each == lane { any } else { fixed });
    let node = Node::of(boxes.into_iter());
    assert!(node.window(lane.into()) == Some(any) && node.window(8).is_none());
}

fn nodes_meet_as_their_boxes_do(c: &mut impl Cases) {
    let (one, other, window) = (window(c), window(c), window(c));
    let meeting = Node::of([one, other].into_iter()).meeting(window);
    assert!(meeting == u8::from(one.meets(window)) | u8::from(other.meets(window)) << 1);
}

fn empty_lanes_meet_nothing(c: &mut impl Cases) {
    assert!(Node::of(core::iter::empty()).meeting(window(c)) == 0);
}

fn edge(c: &mut impl Cases) -> Edge {
    Edge { chord: Segment { from: point(c), to: point(c) }, chord_error: Length::ZERO }
}

fn one_box(of: Window) -> BoxProposal {
    BoxProposal { levels: vec![vec![Node::of(core::iter::once(of))]] }
}

fn accepted_boxes_hold_their_edges(c: &mut impl Cases) {
    let (one, other, around) = (edge(c), edge(c), window(c));
    let accepted = CheckedIndex::check(vec![one, other], one_box(around)).is_ok();
    assert!(accepted == (around.contains(one.bounds()) && around.contains(other.bounds())));
}

fn searches_enter_every_box_that_meets(c: &mut impl Cases) {
    let (one, other, around, asked) = (edge(c), edge(c), window(c), window(c));
    let Ok(index) = CheckedIndex::check(vec![one, other], one_box(around)) else { return };
    let mut seen = [false; 2];
    let _ = index.visit(asked, |number, _| {
        if let Some(seen) = seen.get_mut(number) {
            *seen = true;
        }
        ControlFlow::Continue(())
    });
    let [first, second] = seen;
    assert!((first || !one.bounds().meets(asked)) && (second || !other.bounds().meets(asked)));
}

fn trees_without_a_box_are_refused(c: &mut impl Cases) {
    let around = Window::of(at(0, 0)).including(at(4, 0));
    let level = vec![Node::of(core::iter::once(around)); usize::from(c.up_to(2))];
    let levels = match c.up_to(2) {
        0 => vec![],
        1 => vec![level],
        _ => vec![level.clone(), level],
    };
    let fits = matches!(levels.as_slice(), [level] if level.len() == 1);
    let edges = vec![Edge { chord: Segment { from: at(0, 0), to: at(4, 0) }, chord_error: Length::ZERO }];
    assert!(CheckedIndex::check(edges, BoxProposal { levels }).is_ok() == fits);
}

fn claim(c: &mut impl Cases) -> Claim {
    let number = c.int(i32::MIN, i32::MAX).cast_unsigned();
    match c.up_to(4) {
        0 => Claim::Free,
        1 => Claim::Blocked(number),
        2 => Claim::Near(number),
        3 => Claim::Divided(number),
        _ => Claim::Open,
    }
}

/// What a packed claim stands for.
fn kept(claim: Claim) -> Claim {
    match claim {
        Claim::Blocked(number) | Claim::Near(number) | Claim::Divided(number) if number >= u32::MAX >> 2 => {
            Claim::Open
        }
        claim => claim,
    }
}

fn claims_survive_packing(c: &mut impl Cases) {
    let claim = claim(c);
    assert!(Packed::of(claim).claim() == kept(claim));
}

fn packed_claims_differ(c: &mut impl Cases) {
    let (one, other) = (claim(c), claim(c));
    assert!(Packed::of(one) != Packed::of(other) || kept(one) == kept(other));
}

/// An index of the edge from (0, 0) to (4, 0).
fn index_of_one(chord_error: i32) -> CheckedIndex {
    let edge = Edge { chord: Segment { from: at(0, 0), to: at(4, 0) }, chord_error: length(chord_error) };
    CheckedIndex::check(vec![edge], one_box(edge.bounds())).expect("the box is that of the edge")
}

fn queries_find_the_nearest_edge(c: &mut impl Cases) {
    let (p, r) = (near_origin(c, 7), c.int(0, 7));
    let (x, y) = (p.x.units(), p.y.units());
    let aside = if x < 0 { -x } else { (x - 4).max(0) };
    let near = index_of_one(0).near_point(p, length(r)).is_some();
    assert!(near == (aside * aside + y * y <= r * r));
}

fn queries_add_the_chord_error(c: &mut impl Cases) {
    let (y, chord_error, r) = (c.int(0, 60), c.int(0, 30), c.int(0, 30));
    let near = index_of_one(chord_error).near_point(at(2, y), length(r)).is_some();
    assert!(near == (y <= r + chord_error));
}
