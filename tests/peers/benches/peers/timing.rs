//! Interleaved timing: every rival runs the same queries in turn, round after round; medians are quoted.

use std::hint::black_box;
use std::time::Instant;

/// Something that answers all queries of a run.
pub struct Rival<'a> {
    pub name: &'static str,
    run: Run<'a>,
}

/// Answers all queries, and keeps the answers when told where.
type Run<'a> = Box<dyn FnMut(Option<&mut Vec<f64>>) + 'a>;

impl<'a> Rival<'a> {
    /// Answers query `i` of `count` by `answer(i)`.
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

/// A rival's median over the rounds, in ns per query, and its answers.
#[derive(Clone, Debug)]
pub struct Timed {
    pub name: &'static str,
    pub ns: f64,
    pub answers: Vec<f64>,
    /// How many answers were found to be wrong, where that was looked at.
    pub wrong: Option<usize>,
}

/// Times all rivals in turn, `rounds` times, after one round in which their answers are kept.
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

/// The median; sorts its input.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Seconds that `work` takes, and what it makes.
pub fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let begin = Instant::now();
    let made = black_box(work());
    (begin.elapsed().as_secs_f64(), made)
}

/// Resident memory of this process in bytes, where the system tells (Linux).
pub fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}
