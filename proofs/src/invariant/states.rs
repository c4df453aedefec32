//! The states that an exploration has found.

use std::collections::HashSet;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, BuildHasherDefault, Hash, Hasher};

/// The outcome of inserting a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Insertion {
    /// It was there before.
    Before,
    /// It is new.
    New,
    /// It is new, and there is no room for it.
    BeyondLimit,
}

/// The states, as two independent hashes of 64 bits each.
#[derive(Default)]
pub struct StateSet {
    states: HashSet<(u64, u64), BuildHasherDefault<Hashed>>,
    seeds: [RandomState; 2],
    bytes: Bytes,
}

impl StateSet {
    /// Adds the state, unless there are `most` already.
    pub fn insert(&mut self, state: &impl Hash, most: usize) -> Insertion {
        self.bytes.0.clear();
        state.hash(&mut self.bytes);
        let [one, other] = self.seeds.each_ref().map(|seed| seed.hash_one(&self.bytes.0));
        let hashed = (one, other);
        if self.states.len() < most {
            return if self.states.insert(hashed) { Insertion::New } else { Insertion::Before };
        }
        if self.states.contains(&hashed) { Insertion::Before } else { Insertion::BeyondLimit }
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.states.len()
    }
}

/// Collects what a value gives to its hasher. Hashing many bytes at once is much faster than a few at a time.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Hasher for Bytes {
    fn write(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    fn finish(&self) -> u64 {
        unreachable!("the bytes are hashed later")
    }
}

/// Takes a number as it is, because it is a hash already.
#[derive(Default)]
struct Hashed(u64);

impl Hasher for Hashed {
    fn write(&mut self, _: &[u8]) {
        unreachable!("a state is two numbers");
    }

    fn write_u64(&mut self, hash: u64) {
        self.0 = hash;
    }

    fn finish(&self) -> u64 {
        self.0
    }
}
