//! The cost of predicates that are generic over the integer widths:
//! `cargo bench -p keepout-peers --bench generic`.
//!
//! Each generic predicate competes with the same predicate written for `i32`, `i64` and `i128`, in the same
//! process on the same data. With `-- --write` the benchmark writes the table to
//! `docs/contributor/generic.md`.
#![allow(
    missing_docs,
    clippy::arithmetic_side_effects,
    clippy::cast_precision_loss,
    reason = "a benchmark; `exact/width.rs` asserts the widths"
)]

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;

use keepout_kernel::exact::predicate::{self, Orientation, Site};
use keepout_kernel::exact::width::Product;
use timing::{Rival, race};

#[path = "peers/timing.rs"]
#[expect(dead_code, reason = "the benchmark `peers` uses the other functions")]
mod timing;

const CASES: usize = 4_096;
const ROUNDS: usize = 401;
/// Queries in a round: eight per case.
const QUERIES: usize = 8 * CASES;

/// Five points and a threshold: the arguments of the largest predicate.
#[derive(Clone, Copy)]
struct Case {
    points: [(i32, i32); 5],
    r: i32,
}

fn site((x, y): (i32, i32)) -> Site<Product> {
    Site { x, y }
}

/// The predicates without the trait, written for one width only.
mod plain {
    type Xy = (i32, i32);

    #[inline(always)]
    fn cross(o: Xy, a: Xy, b: Xy) -> i64 {
        i64::from(a.0 - o.0) * i64::from(b.1 - o.1) - i64::from(a.1 - o.1) * i64::from(b.0 - o.0)
    }

    #[inline(always)]
    fn dot(o: Xy, a: Xy, b: Xy) -> i64 {
        i64::from(a.0 - o.0) * i64::from(b.0 - o.0) + i64::from(a.1 - o.1) * i64::from(b.1 - o.1)
    }

    #[inline(always)]
    fn square(r: i32) -> i64 {
        i64::from(r) * i64::from(r)
    }

    #[inline(always)]
    pub fn orientation(a: Xy, b: Xy, c: Xy) -> i64 {
        cross(a, b, c).signum()
    }

    #[inline(always)]
    pub fn point_segment(p: Xy, a: Xy, b: Xy, r: i32) -> bool {
        let (along, length_2) = (dot(a, p, b), dot(a, b, b));
        if along <= 0 {
            return dot(p, a, a) <= square(r);
        }
        if along >= length_2 {
            return dot(p, b, b) <= square(r);
        }
        let off = i128::from(cross(a, b, p));
        off * off <= i128::from(square(r)) * i128::from(length_2)
    }

    #[inline(always)]
    fn beyond(a: Xy, b: Xy, points: [Xy; 2], r: i32) -> bool {
        let [first, second] = points.map(|p| cross(a, b, p));
        if first >= 0 || second >= 0 {
            return false;
        }
        let off = i128::from(first.max(second));
        off * off > i128::from(square(r)) * i128::from(dot(a, b, b))
    }

    #[inline(always)]
    fn crosses_properly(a: Xy, b: Xy, c: Xy, d: Xy) -> bool {
        orientation(a, b, c) * orientation(a, b, d) < 0 && orientation(c, d, a) * orientation(c, d, b) < 0
    }

    #[inline(always)]
    pub fn segment_segment(a: Xy, b: Xy, c: Xy, d: Xy, r: i32) -> bool {
        if beyond(a, b, [c, d], r)
            || beyond(b, a, [c, d], r)
            || beyond(c, d, [a, b], r)
            || beyond(d, c, [a, b], r)
        {
            return false;
        }
        point_segment(c, a, b, r)
            || point_segment(d, a, b, r)
            || point_segment(a, c, d, r)
            || point_segment(b, c, d, r)
            || crosses_properly(a, b, c, d)
    }

    #[inline(always)]
    pub fn triangle_segment([a, b, c]: [Xy; 3], [d, e]: [Xy; 2], r: i32) -> bool {
        let inside = || {
            let side = orientation(a, b, d);
            side != 0 && side == orientation(b, c, d) && side == orientation(c, a, d)
        };
        segment_segment(a, b, d, e, r)
            || segment_segment(b, c, d, e, r)
            || segment_segment(c, a, d, e, r)
            || inside()
    }
}

/// A predicate over cases. It is not inlined, so both forms have the same call overhead.
type Predicate = fn(&Case) -> bool;

const RACES: [(&str, Predicate, Predicate); 4] = [
    (
        "`orientation`",
        |case| {
            let [a, b, c, ..] = case.points.map(site);
            predicate::orientation::<Product>(a, b, c) == Orientation::Left
        },
        |case| {
            let [a, b, c, ..] = case.points;
            plain::orientation(a, b, c) > 0
        },
    ),
    (
        "`point_segment`",
        |case| {
            let [a, b, c, ..] = case.points.map(site);
            !predicate::point_segment::<Product>(a, b, c, case.r).is_clear()
        },
        |case| {
            let [a, b, c, ..] = case.points;
            plain::point_segment(a, b, c, case.r)
        },
    ),
    (
        "`segment_segment`",
        |case| {
            let [a, b, c, d, _] = case.points.map(site);
            !predicate::segment_segment::<Product>([a, b], [c, d], case.r).is_clear()
        },
        |case| {
            let [a, b, c, d, _] = case.points;
            plain::segment_segment(a, b, c, d, case.r)
        },
    ),
    (
        "`triangle_segment`",
        |case| {
            let [a, b, c, d, e] = case.points.map(site);
            !predicate::triangle_segment::<Product>([a, b, c], [d, e], case.r).is_clear()
        },
        |case| {
            let [a, b, c, d, e] = case.points;
            plain::triangle_segment([a, b, c], [d, e], case.r)
        },
    ),
];

/// Groups of points within `reach` of a random place on the lattice, with random thresholds: some reach, some
/// do not.
fn cases(reach: i32) -> Vec<Case> {
    let mut random = fastrand::Rng::with_seed(2026);
    let corner = (1 << 29) - reach;
    let mut case = || {
        let origin = (random.i32(-corner..=corner), random.i32(-corner..=corner));
        let mut point = || (origin.0 + random.i32(-reach..=reach), origin.1 + random.i32(-reach..=reach));
        Case { points: std::array::from_fn(|_| point()), r: random.i32(0..=reach / 2) }
    };
    (0..CASES).map(|_| case()).collect()
}

fn main() {
    let mut page = String::from(
        "# Generic predicates compared with predicates for one width\n\n\
         Written by `cargo bench -p keepout-peers --bench generic -- --write`.\n\n\
         The values are medians over rounds. Both forms take turns, in one process on the same cases. The\n\
         benchmark calls both forms through a pointer, so each value includes a call.\n\n\
         | predicate | points within | generic, ns | one width, ns | generic / one width |\n\
         |---|---|---|---|---|\n",
    );
    for reach in [1 << 10, 1 << 20, 1 << 28] {
        let cases = cases(reach);
        for (name, generic, single) in RACES {
            let cases = &cases;
            let rival = |name, form: Predicate| {
                let form = black_box(form);
                Rival::new(name, QUERIES, move |i| f64::from(u8::from(form(&cases[i % CASES]))))
            };
            let timed = race(vec![rival("generic", generic), rival("one width", single)], QUERIES, ROUNDS);
            let [ours, theirs] = &timed[..] else { unreachable!("two rivals") };
            assert_eq!(ours.answers, theirs.answers, "the two forms of {name} disagree");
            let (ours, theirs) = (ours.ns, theirs.ns);
            let ratio = ours / theirs;
            writeln!(page, "| {name} | {reach} units | {ours:.2} | {theirs:.2} | {ratio:.2} |")
                .expect("a string");
        }
    }
    print!("{page}");
    if std::env::args().any(|argument| argument == "--write") {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/contributor/generic.md");
        let part = path.with_extension("part");
        match std::fs::write(&part, page).and_then(|()| std::fs::rename(part, &path)) {
            Ok(()) => println!("\n{} is written", path.display()),
            Err(error) => eprintln!("{}: {error}", path.display()),
        }
    }
}
