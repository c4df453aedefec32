//! Cells: what the checker accepts, and the walk along a motion.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use fastrand::Rng;
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::cells::{self, Answer, Cells, Claim, GROUP, Packed};
use keepout_kernel::index::check::CheckedIndex;
use keepout_kernel::index::{CellFault, build};
use keepout_kernel::{Edge, Length, Point, Segment};

fn at((x, y): (i64, i64)) -> Point {
    Point::from_units(x, y).unwrap()
}

fn length(units: i64) -> Length {
    Length::from_units(units).unwrap()
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
    let largest = length(i64::from(COORD_MAX));
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
                let answer = cells.motion(&index, motion);
                assert!(
                    answer != Answer::Unknown && (answer != Answer::Clear) == near,
                    "{motion:?} {answer:?}"
                );
                asked += 1;
            }
        }
    }
    assert_eq!(asked, 12 * 81 * 81);
}

/// Squares lie in the whole only, and nothing beyond it is near.
#[test]
fn no_square_lies_outside_of_the_whole() {
    let edge = Edge { chord: Segment { from: at((-9, 3)), to: at((8, -5)) }, chord_error: Length::ZERO };
    let index = build::build(vec![edge]).unwrap();
    let cells = random_cells(&index, length(4), &mut Rng::with_seed(3));
    for (x, y) in [(-33, 0), (32, 0), (0, -33), (0, 32), (32, 32), (-33, 31), (1 << 29, -(1 << 29))] {
        assert!(cells.square_at(x, y).is_none(), "{x} {y}");
        assert_eq!(cells.point(&index, at((x.into(), y.into()))), Answer::Clear);
    }
    for outside in [(33, 30), (30, 40), (30, -33), (-60, 30)] {
        let motion = Segment { from: at((30, 30)), to: at(outside) };
        assert_eq!(cells.motion(&index, motion), Answer::Unknown, "{outside:?}");
    }
    for (x, y) in [(-32, -32), (31, 31), (-32, 31), (31, -32)] {
        let square = cells.square_at(x, y).unwrap();
        let side = 1 << square.log_2;
        let holds = |c: i32, low: i32| (low..low + side).contains(&c);
        assert!(holds(x, square.low.0) && holds(y, square.low.1), "{square:?}");
    }
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
