//! A reference that grows with the points of an interpolator. Its end is not known yet.

use super::Axes;
use super::path::{Foot, PathPiece};
use super::reference::ReferenceSample;

/// The path so far as straight lines, and samples of it.
#[derive(Clone, Debug)]
pub struct Stream {
    samples: Vec<ReferenceSample>,
    /// Smallest number of samples kept. Without it, all are kept.
    keep: Option<usize>,
    from: Axes,
    at: Axes,
    number: usize,
    /// Start of the current piece along the path, pulses.
    begins: f64,
}

/// Largest distance of a point that still lies on the current line, pulses.
const STRAIGHT: f64 = 1e-6;

impl Stream {
    /// A stream that begins with `samples` samples at rest at `position`, pulses. It keeps between `samples`
    /// and twice as many.
    #[must_use]
    pub fn at_rest(position: Axes, samples: usize) -> Self {
        let keep = samples.max(1);
        let samples = Vec::with_capacity(2 * keep);
        let mut stream =
            Self { samples, keep: Some(keep), from: position, at: position, number: 0, begins: 0.0 };
        for _ in 0..keep {
            stream.tick(1.0);
        }
        stream
    }

    /// The same stream, which keeps all samples.
    #[must_use]
    pub fn keeping_all(self) -> Self {
        Self { keep: None, ..self }
    }

    /// Extends the path by a straight line to `point`, pulses.
    pub fn pass(&mut self, point: Axes) {
        let (before, step) = (self.at - self.from, point - self.at);
        if step == Axes::zeros() {
            return;
        }
        let straight = before.perp(&step).abs() <= STRAIGHT * before.norm() && before.dot(&step) >= 0.0;
        if !straight {
            self.begins += before.norm();
            self.from = self.at;
            self.number += 1;
        }
        self.at = point;
        let piece = PathPiece::Line { from: self.from, to: self.at };
        for sample in self.samples.iter_mut().rev().take_while(|sample| sample.number == self.number) {
            sample.piece = piece;
        }
    }

    /// Adds a sample at the current point, `period_s` after the previous sample.
    pub fn tick(&mut self, period_s: f64) {
        if let Some(keep) = self.keep.filter(|keep| self.samples.len() == 2 * keep) {
            self.samples.copy_within(keep.., 0);
            self.samples.truncate(keep);
        }
        if let Some(last) = self.samples.last_mut() {
            last.speed = (self.at - last.foot.point).norm() / period_s;
        }
        let piece = PathPiece::Line { from: self.from, to: self.at };
        let foot = Foot { point: self.at, ..piece.nearest(self.at) };
        let along = self.begins + (self.at - self.from).norm();
        let Self { number, begins, .. } = *self;
        self.samples.push(ReferenceSample { foot, piece, number, begins, along, speed: 0.0 });
    }

    /// The samples, oldest first.
    #[must_use]
    pub fn samples(&self) -> &[ReferenceSample] {
        &self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_moves_form_one_piece_and_corners_begin_another() {
        let mut stream = Stream::at_rest(Axes::zeros(), 8);
        for x in 1..=5 {
            stream.pass(Axes::new(f64::from(x), 0.0));
            stream.tick(0.5);
        }
        stream.pass(Axes::new(6.0, 0.0));
        stream.pass(Axes::new(6.0, 0.5));
        stream.tick(0.5);
        let samples = stream.samples();
        let last = samples[samples.len() - 1];
        let before = samples[samples.len() - 2];
        assert_eq!(before.piece, PathPiece::Line { from: Axes::zeros(), to: Axes::new(6.0, 0.0) });
        assert_eq!(last.piece, PathPiece::Line { from: Axes::new(6.0, 0.0), to: Axes::new(6.0, 0.5) });
        assert_eq!((last.number, before.number), (1, 0));
        assert!((samples[samples.len() - 4].speed - 2.0).abs() < 1e-12);
        // A reversal begins another piece.
        stream.pass(Axes::new(6.0, 0.0));
        stream.tick(0.5);
        assert_eq!(stream.samples().last().unwrap().number, 2);
    }

    #[test]
    fn memory_is_bounded() {
        let mut stream = Stream::at_rest(Axes::zeros(), 8);
        for k in 0..1000_i32 {
            stream.pass(Axes::new(f64::from(k), f64::from(k % 2)));
            stream.tick(0.1);
            assert!((8..=16).contains(&stream.samples().len()));
        }
        assert_eq!(stream.samples.capacity(), 16);
    }
}
