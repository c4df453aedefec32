//! The part of the path between tool and reference, and the point of it that is nearest to the tool.

use crate::Axes;
use crate::path::{Foot, PathPiece};
use crate::reference::ReferenceSample;

/// Largest number of pieces between tool and reference. When a tool is farther behind, the oldest of these
/// pieces counts.
const MOST_PIECES: usize = 256;

/// The last pieces that the reference came to, and the one with the point nearest to the tool.
///
/// The search for that point only goes forward: a path that comes back is another cut. It passes on to the
/// next piece as soon as that is as near, so a tool that lags behind finds its place between reference and
/// tool, and not at the end of a piece.
#[derive(Clone, Debug)]
pub struct PassedPieces {
    /// A ring. The piece with the count `n` is at `n % MOST_PIECES`.
    pieces: Box<[PassedPiece; MOST_PIECES]>,
    /// Number of pieces so far.
    count: usize,
    /// The count of the piece with the tool's nearest point.
    on: usize,
    /// Number of the newest piece along the path.
    newest: usize,
}

#[derive(Clone, Copy, Debug)]
struct PassedPiece {
    piece: PathPiece,
    /// Whether it begins at a corner.
    turns: bool,
}

/// The point of the path that is nearest to the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolFoot {
    /// The point.
    pub foot: Foot,
    /// Whether a corner lies between it and the reference.
    pub before_corner: bool,
}

impl Default for PassedPieces {
    fn default() -> Self {
        let none = PathPiece::Line { from: Axes::zeros(), to: Axes::zeros() };
        let pieces = Box::new([PassedPiece { piece: none, turns: false }; MOST_PIECES]);
        Self { pieces, count: 0, on: 0, newest: 0 }
    }
}

impl PassedPieces {
    /// The nearest point to `tool`, pulses, between the one of the last call and the piece of `reference`. Call it
    /// once for each sample.
    pub fn foot(&mut self, reference: &ReferenceSample, tool: Axes) -> ToolFoot {
        self.reach(reference);
        let distance_2 = |foot: &Foot| (foot.point - tool).norm_squared();
        let mut best = self.at(self.on).piece.nearest(tool);
        while self.on + 1 < self.count {
            let next = self.at(self.on + 1).piece.nearest(tool);
            if distance_2(&next) > distance_2(&best) {
                break;
            }
            (best, self.on) = (next, self.on + 1);
        }
        let before_corner = (self.on + 1..self.count).any(|count| self.at(count).turns);
        ToolFoot { foot: best, before_corner }
    }

    /// Appends the piece of `reference`, if it is new. Pieces shorter than a sample's step, which no sample is on,
    /// become a straight line.
    fn reach(&mut self, reference: &ReferenceSample) {
        let piece = reference.piece;
        if self.count == 0 {
            self.append(piece, false);
        } else if self.newest == reference.number {
            // The last line of a path that is still being made becomes longer.
            self.pieces[(self.count - 1) % MOST_PIECES].piece = piece;
        } else {
            let before = self.at(self.count - 1).piece;
            let (end, start) = (before.at(before.length()).point, piece.at(0.0).point);
            let skipped = PathPiece::Line { from: end, to: start };
            if self.newest + 1 < reference.number && skipped.length() > 0.0 {
                self.append(skipped, before.turns_to(&skipped));
            }
            let before = self.at(self.count - 1).piece;
            self.append(piece, before.turns_to(&piece));
        }
        self.newest = reference.number;
    }

    fn append(&mut self, piece: PathPiece, turns: bool) {
        self.pieces[self.count % MOST_PIECES] = PassedPiece { piece, turns };
        self.count += 1;
        self.on = self.on.max(self.count.saturating_sub(MOST_PIECES));
    }

    fn at(&self, count: usize) -> PassedPiece {
        self.pieces[count % MOST_PIECES]
    }
}
