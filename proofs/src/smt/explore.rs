//! Runs a predicate once for each path through it.
//!
//! The predicate runs on symbolic numbers. When it compares two of them, the explorer chooses the answer
//! and records it as a condition of the path. It repeats the run until it has given every answer. On one
//! path, the answer to a comparison never contradicts an earlier one about the same two numbers.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::{BTreeSet, HashMap};

use super::fact::{Fact, all, any, at_most, equal, less, not};
use super::term::Term;

/// One path through a predicate.
#[derive(Clone, Debug)]
pub struct PredicatePath<T> {
    /// The comparisons and answers on the path.
    pub conditions: Vec<Fact>,
    /// The predicate's answer.
    pub outcome: T,
}

/// A predicate that can be closed where it is part of another: the explorer chooses its answer, and its
/// code does not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// `point_segment`.
    PointSegment,
    /// `crosses_properly`.
    CrossesProperly,
    /// `segment_segment`.
    SegmentSegment,
    /// `strictly_inside`.
    StrictlyInside,
    /// `box_point`.
    BoxPoint,
    /// `beyond`.
    Beyond,
    /// `convex_holds`.
    ConvexHolds,
}

/// Orderings that are still possible, as bits.
type Possible = u8;
const LESS: Possible = 1;
const EQUAL: Possible = 2;
const GREATER: Possible = 4;

#[derive(Default)]
struct Explorer {
    running: bool,
    parts: BTreeSet<Part>,
    /// For each decision so far, the chosen option and the number of options.
    choices: Vec<(usize, usize)>,
    next: usize,
    possible: HashMap<(Term, Term), Possible>,
    answers: HashMap<String, bool>,
    conditions: Vec<Fact>,
}

thread_local! {
    static EXPLORER: RefCell<Explorer> = RefCell::default();
}

/// Runs `predicate` along every path. Each pair `(a, b)` of `ordered` satisfies a ≤ b. The predicates in
/// `parts` are closed.
pub fn explore<T>(
    ordered: &[(Term, Term)],
    parts: &[Part],
    predicate: impl Fn() -> T,
) -> Vec<PredicatePath<T>> {
    let mut paths = Vec::new();
    let mut choices = Vec::new();
    loop {
        EXPLORER.with_borrow_mut(|explorer| {
            *explorer = Explorer { running: true, choices, ..Explorer::default() };
            explorer.parts.extend(parts);
            for &(a, b) in ordered {
                explorer.narrow(a, b, LESS | EQUAL);
            }
        });
        let outcome = predicate();
        let explorer = EXPLORER.take();
        let ordered = ordered.iter().map(|&(a, b)| at_most(a, b));
        paths.push(PredicatePath { conditions: ordered.chain(explorer.conditions).collect(), outcome });
        choices = explorer.choices;
        while choices.last().is_some_and(|&(taken, count)| taken + 1 == count) {
            choices.pop();
        }
        match choices.last_mut() {
            Some((taken, _)) => *taken += 1,
            None => return paths,
        }
    }
}

impl Explorer {
    fn choose(&mut self, count: usize) -> usize {
        assert!(self.running, "a symbolic number is compared outside of `explore`");
        if self.next == self.choices.len() {
            self.choices.push((0, count));
        }
        let (taken, before) = self.choices[self.next];
        assert_eq!(count, before, "a predicate took another path under the same answers");
        self.next += 1;
        taken
    }

    fn possible(&self, a: Term, b: Term) -> Possible {
        if a == b { EQUAL } else { self.possible.get(&(a, b)).copied().unwrap_or(LESS | EQUAL | GREATER) }
    }

    fn narrow(&mut self, a: Term, b: Term, to: Possible) {
        let swapped = (to & EQUAL) | (to & LESS) << 2 | (to & GREATER) >> 2;
        self.possible.insert((a, b), to);
        self.possible.insert((b, a), swapped);
    }

    /// Chooses one of the groups of orderings, and returns its index.
    fn decide(&mut self, a: Term, b: Term, groups: &[Possible]) -> usize {
        let known = self.possible(a, b);
        let open: Vec<usize> = (0..groups.len()).filter(|&i| groups[i] & known != 0).collect();
        if let &[only] = open.as_slice() {
            return only;
        }
        let taken = open[self.choose(open.len())];
        let now = groups[taken] & known;
        self.narrow(a, b, now);
        self.conditions.push(comparison(a, b, now));
        taken
    }

    fn ask(&mut self, name: &str) -> bool {
        if let Some(&answer) = self.answers.get(name) {
            return answer;
        }
        let answer = self.choose(2) == 1;
        self.answers.insert(name.to_owned(), answer);
        let fact = Fact::Answer(name.to_owned());
        self.conditions.push(if answer { fact } else { not(fact) });
        answer
    }
}

fn comparison(a: Term, b: Term, possible: Possible) -> Fact {
    match possible {
        LESS => less(a, b),
        EQUAL => equal(a, b),
        GREATER => less(b, a),
        3 => at_most(a, b),
        6 => at_most(b, a),
        _ => not(equal(a, b)),
    }
}

/// The ordering of `a` and `b`. The path branches here.
pub fn order(a: Term, b: Term) -> Ordering {
    let groups = [LESS, EQUAL, GREATER];
    let taken = EXPLORER.with_borrow_mut(|explorer| explorer.decide(a, b, &groups));
    [Ordering::Less, Ordering::Equal, Ordering::Greater][taken]
}

/// Whether `a < b`. The path branches here.
pub fn is_less(a: Term, b: Term) -> bool {
    EXPLORER.with_borrow_mut(|explorer| explorer.decide(a, b, &[LESS, EQUAL | GREATER])) == 0
}

/// Whether a part is closed.
pub fn is_closed(part: Part) -> bool {
    EXPLORER.with_borrow(|explorer| explorer.parts.contains(&part))
}

/// The answer of a closed part. The path branches here.
pub fn ask(part: Part, arguments: &[Term]) -> bool {
    let name = answer_name(part, arguments);
    EXPLORER.with_borrow_mut(|explorer| explorer.ask(&name))
}

/// The answer of a closed part as a fact: "near", or "yes".
#[must_use]
pub fn answer(part: Part, arguments: &[Term]) -> Fact {
    Fact::Answer(answer_name(part, arguments))
}

fn answer_name(part: Part, arguments: &[Term]) -> String {
    let numbers: Vec<String> = arguments.iter().map(|term| term.number().to_string()).collect();
    format!("{part:?}({})", numbers.join(","))
}

/// The fact that the run took a path with this outcome.
pub fn outcome_is<T: PartialEq>(paths: &[PredicatePath<T>], outcome: &T) -> Fact {
    any(paths.iter().filter(|path| path.outcome == *outcome).map(|path| all(path.conditions.clone())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_is_run_once() {
        let (a, b, c) = (Term::fresh("a"), Term::fresh("b"), Term::fresh("c"));
        let paths = explore(&[], &[], || (order(a, b), is_less(b, c)));
        assert_eq!(paths.len(), 6);
        let known = explore(&[(a, b)], &[], || (order(a, b), order(b, a)));
        assert_eq!(known.len(), 2, "the second comparison follows from the first");
        assert!(known.iter().all(|path| path.outcome.0 == path.outcome.1.reverse()));
        assert_eq!(explore(&[], &[], || order(a, a)).len(), 1);
    }

    #[test]
    fn closed_parts_answer_the_same_on_a_path() {
        let a = Term::fresh("a");
        let ask = || ask(Part::PointSegment, &[a]);
        assert_eq!(explore(&[], &[Part::PointSegment], || (ask(), ask())).len(), 2);
    }
}
