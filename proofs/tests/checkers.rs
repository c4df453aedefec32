//! The checkers on wrong arrays: an array is rejected or harmless, and no checker panics.

use fastrand::Rng;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::cells::{self, Answer, Cells, Claim, GROUP, Packed};
use keepout_kernel::index::check::{CheckedIndex, Node};
use keepout_kernel::index::{build, subdivide};
use keepout_kernel::{Edge, Length, Point, Segment};
use keepout_proofs::families::{Family, ProfileCase, at, length};

fn profile(random: &mut Rng) -> ProfileCase {
    let family = Family::ALL[random.usize(..Family::ALL.len())];
    let mut profile = family.profile(random);
    if random.bool() {
        // Enough edges for several levels.
        while profile.edges.len() < 700 {
            profile.edges.extend(Family::Scattered.profile(random).edges);
        }
    }
    profile
}

fn near(edges: &[Edge], point: Point, r: Length) -> bool {
    edges.iter().any(|edge| !edge.near_point(point, r).is_clear())
}

/// The node with one box moved, grown, shrunk or emptied.
fn disturb(node: &Node, random: &mut Rng) -> Node {
    let mut windows: Vec<Window> = node.windows().collect();
    let lane = random.usize(..windows.len());
    let (x0, y0, x1, y1) = windows[lane].corners();
    let by = if random.bool() { 1 } else { random.i32(-5_000..5_000) };
    windows[lane] = match random.u8(0..6) {
        0 => Window::from_corners(x0.saturating_add(by), y0, x1, y1),
        1 => Window::from_corners(x0, y0.saturating_add(by), x1, y1),
        2 => Window::from_corners(x0, y0, x1.saturating_sub(by), y1),
        3 => Window::from_corners(x0, y0, x1, y1.saturating_sub(by)),
        4 => Window::from_corners(1, 1, 0, 0),
        _ => Window::from_corners(i32::MIN, i32::MIN, i32::MAX, i32::MAX),
    };
    Node::of(windows.into_iter())
}

#[test]
fn wrong_boxes_are_rejected_or_harmless() {
    let mut random = Rng::with_seed(23);
    let mut rejected = 0;
    for _ in 0..2_000 {
        let profile = profile(&mut random);
        let mut proposal = build::propose(&profile.edges);
        let level = random.usize(..proposal.levels.len());
        let nodes = &mut proposal.levels[level];
        match random.u8(0..8) {
            0 => drop(nodes.pop()),
            1 => nodes.push(nodes[0]),
            2 => drop(proposal.levels.pop()),
            3 => proposal.levels.push(vec![Node::of([Window::from_corners(-9, -9, 9, 9)].into_iter())]),
            4 => nodes.reverse(),
            _ => {
                let at = random.usize(..nodes.len());
                nodes[at] = disturb(&nodes[at], &mut random);
            }
        }
        let Ok(index) = CheckedIndex::check(profile.edges.clone(), proposal) else {
            rejected += 1;
            continue;
        };
        for _ in 0..20 {
            let point = at(profile.query(&mut random));
            let r = length(profile.threshold);
            assert_eq!(index.near_point(point, r).is_some(), near(&profile.edges, point, r));
        }
    }
    assert!(rejected > 1_000, "{rejected} of 2000");
}

fn disturb_cells(proposal: &mut cells::CellProposal, random: &mut Rng) {
    let at = random.usize(..proposal.claims.len());
    let number = match proposal.claims[at].claim() {
        Claim::Blocked(n) | Claim::Near(n) | Claim::Divided(n) => n,
        Claim::Free | Claim::Open => 0,
    };
    let other = random.u32(..).checked_shr(random.u32(0..32)).unwrap_or(0);
    match random.u8(0..12) {
        0 => proposal.claims[at] = Packed::of(Claim::Free),
        1 => proposal.claims[at] = Packed::of(Claim::Blocked(other)),
        2 => proposal.claims[at] = Packed::of(Claim::Near(other)),
        3 => proposal.claims[at] = Packed::of(Claim::Divided(other)),
        4 => proposal.claims[at] = Packed::of(Claim::Near(number)),
        5 => proposal.claims.truncate(at),
        6 => proposal.claims.extend([Packed::of(Claim::Open); GROUP]),
        7 => proposal.origin.0 = proposal.origin.0.saturating_add(random.i32(-3_000..3_000)),
        8 => proposal.log_2 = random.u32(0..40),
        9 if !proposal.lists.is_empty() => {
            let at = random.usize(..proposal.lists.len());
            proposal.lists[at] = proposal.lists[at].wrapping_add(1);
        }
        10 if !proposal.lists.is_empty() => drop(proposal.lists.remove(random.usize(..proposal.lists.len()))),
        _ => proposal.lists.push(0),
    }
}

#[test]
fn wrong_cells_are_rejected_or_harmless() {
    let mut random = Rng::with_seed(29);
    let mut rejected = 0;
    for _ in 0..2_000 {
        let profile = profile(&mut random);
        let index = build::build(profile.edges.clone()).unwrap();
        let r = length(profile.threshold);
        let Some(mut proposal) = subdivide::propose(&index, r, random.usize(1..40)) else { continue };
        disturb_cells(&mut proposal, &mut random);
        let Ok(cells) = Cells::check(&index, proposal) else {
            rejected += 1;
            continue;
        };
        for _ in 0..20 {
            let (p, q) = (at(profile.query(&mut random)), at(profile.query(&mut random)));
            match cells.point(&index, p) {
                Answer::Unknown => {}
                answer => assert_eq!(answer != Answer::Clear, near(&profile.edges, p, r)),
            }
            let motion = Segment { from: p, to: q };
            match cells.motion(&index, motion) {
                Answer::Unknown => {}
                answer => {
                    let truth = profile.edges.iter().any(|edge| !edge.near_motion(motion, r).is_clear());
                    assert_eq!(answer != Answer::Clear, truth);
                }
            }
        }
    }
    assert!(rejected > 800, "{rejected} of 2000");
}
