//! Interleaved timing. The rivals take turns with the same queries, and the medians over the rounds count.

use std::hint::black_box;
use std::time::Instant;

/// An implementation that answers all queries of a run.
pub struct Rival<'a> {
    pub name: &'static str,
    run: Run<'a>,
}

/// A function that answers all queries, and appends the answers to the vector if one is given.
type Run<'a> = Box<dyn FnMut(Option<&mut Vec<f64>>) + 'a>;

impl<'a> Rival<'a> {
    /// A rival with `count` queries. `answer(i)` answers query `i`.
    pub fn new(name: &'static str, count: usize, mut answer: impl FnMut(usize) -> f64 + 'a) -> Self {
        let run = move |answers: Option<&mut Vec<f64>>| match answers {
            Some(answers) => answers.extend((0..count).map(&mut answer)),
            None => {
                for i in 0..count {
                    black_box(answer(i));
                }
            }
        };
        Self { name, run: Box::new(run) }
    }
}

/// The median time of a rival over the rounds, in ns per query, and its answers.
#[derive(Clone, Debug)]
pub struct Timed {
    pub name: &'static str,
    pub ns: f64,
    pub answers: Vec<f64>,
    /// Number of wrong answers. `None` if the answers were not compared.
    pub wrong: Option<usize>,
}

/// Measures the times of all rivals in turn over `rounds` rounds. A first round, which does not count, stores
/// the answers.
pub fn race(rivals: Vec<Rival<'_>>, queries: usize, rounds: usize) -> Vec<Timed> {
    let mut rivals = rivals;
    let mut timed: Vec<(Timed, Vec<f64>)> = Vec::new();
    for rival in &mut rivals {
        let mut answers = Vec::new();
        (rival.run)(Some(&mut answers));
        timed.push((Timed { name: rival.name, ns: 0.0, answers, wrong: None }, Vec::new()));
    }
    for _ in 0..rounds {
        for (rival, (_, times)) in rivals.iter_mut().zip(&mut timed) {
            let begin = Instant::now();
            (rival.run)(None);
            times.push(begin.elapsed().as_nanos() as f64 / queries.max(1) as f64);
        }
    }
    timed.into_iter().map(|(each, mut times)| Timed { ns: median(&mut times), ..each }).collect()
}

/// The median of `values`. Sorts them.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Runs `work`, and returns its duration, s, and its result.
pub fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let begin = Instant::now();
    let made = black_box(work());
    (begin.elapsed().as_secs_f64(), made)
}

/// Resident memory of this process, bytes. `None` if the system does not report it (only Linux does).
pub fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}
