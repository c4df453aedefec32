//! Interleaved timing: every rival runs the same queries in turn, round after round; medians are quoted.

use std::time::Instant;

/// Something that answers all queries of a run and adds up its answers, so that none is optimised away.
pub struct Rival<'a> {
    pub name: &'static str,
    pub run: Box<dyn FnMut() -> u64 + 'a>,
}

impl<'a> Rival<'a> {
    pub fn new(name: &'static str, run: impl FnMut() -> u64 + 'a) -> Self {
        Self { name, run: Box::new(run) }
    }
}

/// A rival's median over the rounds, in ns per query, and the sum of its answers.
#[derive(Clone, Debug)]
pub struct Timed {
    pub name: &'static str,
    pub ns: f64,
    pub answers: u64,
}

/// Times all rivals in turn, `rounds` times.
pub fn race(rivals: &mut [Rival<'_>], queries: usize, rounds: usize) -> Vec<Timed> {
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); rivals.len()];
    let mut answers = vec![0; rivals.len()];
    for _ in 0..rounds {
        for (i, rival) in rivals.iter_mut().enumerate() {
            let begin = Instant::now();
            answers[i] = std::hint::black_box((rival.run)());
            times[i].push(begin.elapsed().as_nanos() as f64 / queries as f64);
        }
    }
    let timed = |((rival, times), answers): ((&mut Rival<'_>, &mut Vec<f64>), u64)| Timed {
        name: rival.name,
        ns: median(times),
        answers,
    };
    rivals.iter_mut().zip(&mut times).zip(answers).map(timed).collect()
}

/// The median; sorts its input.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
