//! The checkers on wrong arrays: an array is rejected or harmless, and no checker panics.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use fastrand::Rng;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::cells::{self, Answer, Cells, Claim, GROUP, Packed};
use keepout_kernel::index::check::{BoxProposal, CheckedIndex, IndexFault, Node};
use keepout_kernel::index::{CellFault, build, subdivide};
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

#[test]
fn box_one_unit_too_small_is_rejected_on_every_side_and_level() {
    let edges: Vec<Edge> = (0..300)
        .map(|k| {
            let corner = |d| Point::from_units(k * 10, (k * k) % 97 + d).unwrap();
            Edge { chord: Segment { from: corner(0), to: corner(9) }, chord_error: Length::small(3) }
        })
        .collect();
    let right = build::propose(&edges);
    assert!(CheckedIndex::check(edges.clone(), right.clone()).is_ok());
    assert_eq!(right.levels.len(), 3);
    for level in 0..right.levels.len() {
        for side in 0..4 {
            let mut wrong = right.clone();
            let node = wrong.levels[level][0];
            let mut windows: Vec<Window> = node.windows().collect();
            let (x0, y0, x1, y1) = windows[1].corners();
            let d = |k| i32::from(side == k);
            windows[1] = Window::from_corners(x0 + d(0), y0 + d(1), x1 - d(2), y1 - d(3));
            wrong.levels[level][0] = Node::of(windows.into_iter());
            let fault = CheckedIndex::check(edges.clone(), wrong).unwrap_err();
            assert_eq!(fault, IndexFault::Box { level, index: 1 });
        }
    }
    for (levels, fault) in [
        (vec![], IndexFault::Levels { count: 0 }),
        (right.levels[..2].to_vec(), IndexFault::Levels { count: 2 }),
        ([&right.levels[..], &right.levels[2..]].concat(), IndexFault::Levels { count: 4 }),
        (right.levels[1..].to_vec(), IndexFault::Nodes { level: 0, count: 2 }),
    ] {
        assert_eq!(CheckedIndex::check(edges.clone(), BoxProposal { levels }).unwrap_err(), fault);
    }
    assert!(
        CheckedIndex::check(vec![], BoxProposal::default())
            .unwrap()
            .near_point(Point::ORIGIN, length(9))
            .is_none()
    );
}

#[test]
fn claims_survive_packing_and_numbers_that_do_not_fit_are_open() {
    let largest = (1 << 30) - 2;
    for number in [0, 1, 77, largest] {
        for claim in
            [Claim::Free, Claim::Open, Claim::Blocked(number), Claim::Near(number), Claim::Divided(number)]
        {
            assert_eq!(Packed::of(claim).claim(), claim);
        }
    }
    for number in [largest + 1, largest + 2, u32::MAX] {
        for claim in [Claim::Blocked(number), Claim::Near(number), Claim::Divided(number)] {
            assert_eq!(Packed::of(claim).claim(), Claim::Open);
        }
    }
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

#[test]
fn covered_square_must_exceed_all_near_points_by_a_unit() {
    let edge = Edge {
        chord: Segment { from: Point::from_units(0, 0).unwrap(), to: Point::from_units(50, 30).unwrap() },
        chord_error: Length::small(2),
    };
    let index = build::build(vec![edge]).unwrap();
    // Near points lie from −2 − 10 to 52 + 10 in x. With the spare units the square must be 76 wide.
    let whole = |x: i32, y: i32, log_2| cells::CellProposal {
        threshold: Length::small(10),
        origin: (x, y),
        log_2,
        claims: vec![Packed::of(Claim::Open); GROUP],
        lists: vec![],
    };
    assert!(Cells::check(&index, whole(-13, -13, 7)).is_ok());
    for (x, y, log_2) in [
        (-12, -13, 7),
        (-13, -12, 7),
        (-66, -13, 7),
        (-13, -86, 7),
        (-13, -13, 6),
        (-13, -13, 1),
        (-13, -13, 31),
    ] {
        let fault = Cells::check(&index, whole(x, y, log_2)).unwrap_err();
        assert_eq!(fault, CellFault::Whole, "{x} {y} {log_2}");
    }
    assert!(Cells::check(&index, whole(-65, -85, 7)).is_ok());
}

#[test]
fn lists_must_be_complete_and_leave_nothing_over() {
    let edge = |x: i64| Edge {
        chord: Segment { from: Point::from_units(x, 0).unwrap(), to: Point::from_units(x, 9).unwrap() },
        chord_error: Length::ZERO,
    };
    let index = build::build(vec![edge(0), edge(20)]).unwrap();
    // One group covers everything. Its squares are 64 wide, and the one that holds both edges has the list.
    let with = |claims: usize, lists: Vec<u32>| {
        let mut all = vec![Packed::of(Claim::Open); claims];
        all[GROUP / 2 + 2] = Packed::of(Claim::Near(0));
        cells::CellProposal {
            threshold: Length::small(3),
            origin: (-128, -128),
            log_2: 8,
            claims: all,
            lists,
        }
    };
    let check = |proposal| Cells::check(&index, proposal).map(|_| ());
    assert_eq!(check(with(GROUP, vec![2, 0, 1])), Ok(()));
    let faulty =
        |lists| matches!(check(with(GROUP, lists)), Err(CellFault::Claim { claim: Claim::Near(0), .. }));
    assert!(faulty(vec![1, 0]) && faulty(vec![1, 1]) && faulty(vec![0]), "an edge is missing");
    assert!(faulty(vec![2, 1, 0]), "not ascending");
    assert!(faulty(vec![3, 0, 1, 2]), "an edge that is not there");
    assert_eq!(
        check(with(GROUP, vec![2, 0, 1, 0])),
        Err(CellFault::PlanRequest { at: 3 }),
        "a list left over"
    );
    assert_eq!(
        check(with(2 * GROUP, vec![2, 0, 1])),
        Err(CellFault::PlanRequest { at: 3 }),
        "a group left over"
    );
    assert_eq!(
        check(with(GROUP, vec![9, 0, 1])),
        Err(CellFault::PlanRequest { at: 0 }),
        "a list beyond the end"
    );
    let largest = length(i64::from(keepout_kernel::exact::lattice::COORD_MAX));
    let whole = cells::CellProposal {
        threshold: largest,
        origin: (-(1 << 29), -(1 << 29)),
        log_2: 30,
        ..with(GROUP, vec![])
    };
    assert_eq!(check(whole.clone()), Err(CellFault::Whole), "a threshold that no length exceeds");
    // The same holds where the square would just hold the boxes grown by the threshold.
    let dot = Edge { chord: Segment { from: Point::ORIGIN, to: Point::ORIGIN }, chord_error: Length::ZERO };
    let dot = build::build(vec![dot]).unwrap();
    assert_eq!(Cells::check(&dot, whole).map(|_| ()), Err(CellFault::Whole));
}

/// Every motion between the points of a small field, over squares of several sizes. Each walk ends, also
/// through corners and along borders, and answers as the index does.
#[test]
fn every_walk_over_a_small_field_ends_with_the_right_answer() {
    let mut random = Rng::with_seed(47);
    let mut asked = 0_u64;
    for _ in 0..12 {
        let edge = |random: &mut Rng| {
            let mut c = || random.i64(-14..=14);
            let (a, b) = ((c(), c()), (c(), c()));
            Edge { chord: Segment { from: at(a), to: at(b) }, chord_error: Length::ZERO }
        };
        let index = build::build((0..3).map(|_| edge(&mut random)).collect()).unwrap();
        let threshold = length(random.i64(0..=5));
        // Squares are divided at random. Their claims, free or near, are right.
        let cells = random_cells(&index, threshold, &mut random);
        let points: Vec<Point> = (0..81).map(|k| at((4 * (k % 9) - 16, 4 * (k / 9) - 16))).collect();
        for &p in &points {
            for &q in &points {
                let motion = Segment { from: p, to: q };
                let near = index.near_motion(motion, threshold).is_some();
                match cells.motion(&index, motion) {
                    Answer::Unknown => {}
                    answer => assert_eq!(answer != Answer::Clear, near, "{motion:?}"),
                }
                asked += 1;
            }
        }
    }
    assert_eq!(asked, 12 * 81 * 81);
}

/// Cells over −32 … 32. Their squares, down to the smallest, are divided with a chance of one in three.
fn random_cells(index: &CheckedIndex, threshold: Length, random: &mut Rng) -> Cells {
    struct Toss<'a>(&'a CheckedIndex, Length, Vec<Packed>, Vec<u32>);
    fn group(toss: &mut Toss<'_>, low: (i32, i32), log_2: u32, random: &mut Rng) -> u32 {
        let first = toss.2.len();
        toss.2.extend([Packed::of(Claim::Open); GROUP]);
        let part = log_2 - cells::DIVIDE;
        for lane in 0..GROUP {
            let (column, row) = (i32::try_from(lane % 4).unwrap(), i32::try_from(lane / 4).unwrap());
            let low = (low.0 + (column << part), low.1 + (row << part));
            let square = Window::from_corners(low.0, low.1, low.0 + (1 << part), low.1 + (1 << part));
            let near: Vec<u32> = (0_u32..)
                .zip(toss.0.edges())
                .filter(|(_, edge)| !edge.near_box(square, toss.1).is_clear())
                .map(|(number, _)| number)
                .collect();
            let claim = if part >= cells::DIVIDE && random.u8(0..3) == 0 {
                Claim::Divided(group(toss, low, part, random))
            } else if near.is_empty() {
                Claim::Free
            } else {
                let list = u32::try_from(toss.3.len()).unwrap();
                toss.3.push(u32::try_from(near.len()).unwrap());
                toss.3.extend(near);
                Claim::Near(list)
            };
            toss.2[first + lane] = Packed::of(claim);
        }
        u32::try_from(first / GROUP).unwrap()
    }
    let mut toss = Toss(index, threshold, Vec::new(), Vec::new());
    group(&mut toss, (-32, -32), 6, random);
    let proposal =
        cells::CellProposal { threshold, origin: (-32, -32), log_2: 6, claims: toss.2, lists: toss.3 };
    Cells::check(index, proposal).unwrap()
}
