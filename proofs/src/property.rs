//! A property, and the engines that run it.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use crate::draw::{Bytes, Chance, Every};

/// The seed of all random runs.
pub const SEED: u64 = 20_261_122;

/// The bound of an engine, and the run of one case.
pub type CaseEngine<B, S> = (B, fn(&mut S));

/// A property of the trusted core: an asserting function, and the engines that run it.
#[derive(Clone, Copy, Debug)]
pub struct Property {
    /// The topic.
    pub group: &'static str,
    /// The function's name.
    pub name: &'static str,
    /// The claim, as the assurance table shows it.
    pub claim: &'static str,
    /// The code under test.
    pub source: &'static str,
    /// Every case of a small lattice: the lattice's side, and the run of one case.
    pub every: Option<CaseEngine<i64, Every>>,
    /// Random cases over the full range: their number, and the run of one case.
    pub random: Option<CaseEngine<u64, Chance>>,
    /// Runs the case that the bytes encode.
    pub bytes: fn(&mut Bytes),
}

/// The extent of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ran {
    /// Cases drawn.
    pub cases: u64,
    /// Cases that met the property's premise. The other cases prove nothing.
    pub asked: u64,
    /// The largest magnitude that was drawn.
    pub reach: i64,
}

/// The outcome of a run.
#[derive(Clone, Copy, Debug)]
pub struct PropertyOutcome {
    /// The extent of the run, or `None` when the property failed.
    pub ran: Option<Ran>,
    /// The time that the run took.
    pub time: Duration,
}

thread_local! {
    /// Whether the case that runs does not meet its property's premise.
    static PASSED_OVER: Cell<bool> = const { Cell::new(false) };
}

/// Marks the case that runs as one that does not meet its property's premise.
pub fn passed_over() {
    PASSED_OVER.set(true);
}

/// Runs one case, and returns whether it met its property's premise.
fn met_premise<S>(run: fn(&mut S), source: &mut S) -> bool {
    PASSED_OVER.set(false);
    run(source);
    !PASSED_OVER.get()
}

/// At least one in four cases must meet the premise, or 400 cases in all. A run with fewer shows little.
const ASKED: (u64, u64) = (4, 400);

impl Property {
    /// Runs every case of the small lattice; `None` when the property has no such engine.
    ///
    /// # Panics
    /// When the property does not hold.
    #[must_use]
    pub fn run_every(&self) -> Option<Ran> {
        let (side, run) = self.every?;
        let mut every = Every::of(side);
        let mut ran = Ran { cases: 0, asked: 0, reach: side };
        loop {
            ran.asked += u64::from(met_premise(run, &mut every));
            ran.cases += 1;
            if !every.advance() {
                return Some(ran);
            }
        }
    }

    /// Runs the random cases; `None` when the property has no such engine.
    ///
    /// # Panics
    /// When the property does not hold.
    #[must_use]
    pub fn run_random(&self) -> Option<Ran> {
        self.run_some(1)
    }

    /// Runs one in `share` of the random cases.
    fn run_some(&self, share: u64) -> Option<Ran> {
        let (cases, run) = self.random?;
        let cases = cases / share;
        let mut chance = Chance::of(SEED);
        let mut asked = 0;
        for _ in 0..cases {
            chance.advance();
            asked += u64::from(met_premise(run, &mut chance));
        }
        Some(Ran { cases, asked, reach: chance.reach() })
    }

    /// Runs the engines that need no other tool: every case, and random cases.
    ///
    /// # Panics
    /// When the property does not hold, has neither engine, or too few cases met its premise.
    pub fn check(&self) {
        let (every, random) = (self.run_every(), self.run_random());
        assert!(every.is_some() || random.is_some(), "{} lacks an engine that runs here", self.name);
        for ran in [every, random].into_iter().flatten() {
            let Ran { cases, asked, .. } = ran;
            let enough = asked * ASKED.0 >= cases || asked >= ASKED.1;
            assert!(enough, "{}: {asked} of {cases} cases met its premise", self.name);
        }
    }

    /// Runs a tenth of the random cases. This finds gross faults.
    ///
    /// # Panics
    /// When the property does not hold.
    #[must_use]
    pub fn run_quick(&self) -> Option<Ran> {
        self.run_some(10)
    }

    /// Runs an engine and returns the outcome. A panic counts as a failure.
    #[must_use]
    pub fn observed(&self, engine: fn(&Self) -> Option<Ran>) -> Option<PropertyOutcome> {
        let begin = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| engine(self)));
        let time = begin.elapsed();
        match outcome {
            Ok(ran) => ran.map(|ran| PropertyOutcome { ran: Some(ran), time }),
            Err(_) => Some(PropertyOutcome { ran: None, time }),
        }
    }
}

/// Lists properties: name, drawing of the inputs, claim, and engines with their bounds. Each entry becomes
/// a [`Property`].
macro_rules! properties {
    (
        $group:literal, $source:literal;
        $( $name:ident |$d:ident| $call:expr => $claim:literal;
            $(every $side:literal)? $(random $cases:literal)?; )+
    ) => {
        /// The properties of this file.
        pub const ALL: &[crate::property::Property] = &[ $( crate::property::Property {
            group: $group,
            name: stringify!($name),
            claim: $claim,
            source: $source,
            every: crate::property::first(&[$((
                $side,
                crate::property::drawn!($d, $call, crate::draw::Every) as fn(&mut crate::draw::Every)
            ))?]),
            random: crate::property::first(&[$((
                $cases,
                crate::property::drawn!($d, $call, crate::draw::Chance) as fn(&mut crate::draw::Chance)
            ))?]),
            bytes: crate::property::drawn!($d, $call, crate::draw::Bytes),
        } ),+ ];
    };
}

/// The function that draws the inputs from one source and runs the property.
macro_rules! drawn {
    ($d:ident, $call:expr, $source:ty) => {{
        fn run<D: crate::draw::Draw>($d: &mut D) {
            $call
        }
        run::<$source>
    }};
}

/// The element of a slice of at most one element.
pub(crate) const fn first<T: Copy>(of: &[T]) -> Option<T> {
    match of {
        [one, ..] => Some(*one),
        [] => None,
    }
}

pub(crate) use drawn;
pub(crate) use properties;
