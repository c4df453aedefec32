//! Nodes of eight boxes, the check of proposed boxes, and packed claims of cells.

use alloc::vec;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::cells::{Claim, Packed};
use keepout_kernel::index::check::{BoxProposal, Node};
use keepout_kernel::{CheckedIndex, Edge, Length, Segment};

use crate::lattice::point;
use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-03.
    "kernel/src/index/check.rs" {
        nodes_meet_as_their_boxes_do:
            "a node names a lane exactly when its box meets the window",
            "two boxes of eight and the window any", unwind 12;
        empty_lanes_meet_nothing:
            "a lane without a box meets no window of the lattice", "every window", unwind 12;
        accepted_boxes_hold_their_edges:
            "the check accepts a box only when it holds both edges below it", "any box, two edges at any place",
            unwind 12;
    }
    "kernel/src/index/cells.rs" {
        claims_survive_packing:
            "a packed claim is read back, or as open when its number does not fit", "every claim", unwind 1;
        packed_claims_differ:
            "two claims that are packed into one number are one claim", "every pair of claims", unwind 1;
    }
}

fn window(c: &mut impl Cases) -> Window {
    Window::of(point(c)).including(point(c))
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
