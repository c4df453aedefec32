//! The rules of the house that Cargo cannot express.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod folders;
mod lines;
mod messages;
mod names;
mod source;
mod trusted;

use source::{Offender, judge, sources};

/// A room of the executor, and the rooms that it may not name.
const ARROWS: [(&str, &[&str]); 4] = [
    ("executor/src/supervisor", &["dialect", "session", "operator"]),
    ("executor/src/operator", &["dialect", "session"]),
    ("executor/src/dialect", &["session", "operator"]),
    ("kernel/src/exact", &["index", "clear", "clip", "curve", "offset", "simplify"]),
];

#[test]
fn arrows_between_rooms_run_one_way() {
    let mut offenders = Vec::new();
    for (place, forbidden) in ARROWS {
        for (file, text) in sources(place) {
            for (number, line) in text.lines().enumerate() {
                let named = forbidden.iter().filter(|room| line.contains(&format!("crate::{room}")));
                offenders
                    .extend(named.map(|room| Offender::at(&file, number + 1, format_args!("names {room}"))));
            }
        }
    }
    judge("Arrows between rooms run one way", &offenders, &[]);
}

/// Seeds are part of the record: they must give the same numbers in every version.
#[test]
fn seeds_give_the_same_numbers_as_ever() {
    let mut random = fastrand::Rng::with_seed(20_261_125);
    let mut order: Vec<u8> = (0..8).collect();
    let numbers =
        (random.u64(..), random.f64().to_bits(), random.usize(0..1000), random.i64(-5..5), random.bool());
    random.shuffle(&mut order);
    assert_eq!(
        (numbers, order),
        ((3_864_322_368_815_853_088, 4_604_169_150_310_717_304, 451, -2, true), vec![6, 2, 0, 3, 5, 4, 7, 1])
    );
}
