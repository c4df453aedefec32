//! The first two of many segments that meet where they should not.

use alloc::vec::Vec;

use super::segment::{Segment, Window};

/// Segments in a block, and blocks under one box.
const BLOCK: usize = 8;

/// The first pair `i < j`, in the order of a divide-and-conquer walk, of which `meet` says that it meets, among the pairs
/// whose boxes do.
///
/// Boxes over blocks of consecutive segments, and over blocks of those, are made here; two blocks whose boxes do not
/// meet hold no pair that does. Near-linear when consecutive segments lie near each other.
pub fn first_contact(edges: &[Segment], meet: impl Fn(usize, usize) -> bool) -> Option<(usize, usize)> {
    let mut levels: Vec<Vec<Window>> = Vec::new();
    let mut below: Vec<Window> = edges.iter().map(|edge| edge.bounds()).collect();
    while below.len() > 1 {
        let above = below.chunks(BLOCK).filter_map(|run| run.iter().copied().reduce(Window::union)).collect();
        levels.push(below);
        below = above;
    }
    let search = Search { levels, meet };
    search.within(search.levels.len(), 0)
}

struct Search<F> {
    /// Boxes of single segments, of blocks, of blocks of blocks; without the one box over everything.
    levels: Vec<Vec<Window>>,
    meet: F,
}

impl<F: Fn(usize, usize) -> bool> Search<F> {
    /// The numbers of what is under box `index` of the level above `level`, with their boxes.
    fn under(&self, level: usize, index: usize) -> impl Iterator<Item = (usize, Window)> + '_ {
        let windows = self.levels.get(level).map_or(&[][..], Vec::as_slice);
        let first = index.saturating_mul(BLOCK);
        windows.iter().copied().enumerate().skip(first).take(BLOCK)
    }

    /// A pair of segments both under box `index`, `height` levels above the segments.
    fn within(&self, height: usize, index: usize) -> Option<(usize, usize)> {
        let level = height.checked_sub(1)?;
        let found = self.under(level, index).find_map(|(i, _)| self.within(level, i));
        found.or_else(|| {
            self.under(level, index).find_map(|(i, window)| {
                let later = self.under(level, index).filter(|&(j, other)| j > i && window.meets(other));
                later.map(|(j, _)| self.between(level, i, j)).find_map(|pair| pair)
            })
        })
    }

    /// A pair of segments, one under each of two different boxes that meet.
    fn between(&self, height: usize, i: usize, j: usize) -> Option<(usize, usize)> {
        let Some(level) = height.checked_sub(1) else {
            return (self.meet)(i, j).then_some((i, j));
        };
        let across = self.levels.get(height).and_then(|windows| windows.get(j)).copied();
        self.under(level, i).filter(|&(_, one)| across.is_none_or(|across| one.meets(across))).find_map(
            |(a, one)| {
                let meeting = self.under(level, j).filter(|&(_, other)| one.meets(other));
                meeting.map(|(b, _)| self.between(level, a, b)).find_map(|pair| pair)
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::lattice::Point;

    /// Every pair whose boxes meet is asked, as all pairs would be.
    #[test]
    fn no_meeting_pair_is_missed() {
        for seed in 0..300_u64 {
            let mut random = fastrand::Rng::with_seed(seed);
            let count = random.usize(0..200);
            let mut at = || Point::from_units(random.i64(-300..300), random.i64(-300..300)).unwrap();
            let edges: Vec<Segment> = (0..count)
                .map(|_| {
                    let from = at();
                    let (x, y) = (i64::from(from.x.units()), i64::from(from.y.units()));
                    Segment { from, to: Point::from_units(x + (y % 7), y + (x % 5)).unwrap() }
                })
                .collect();
            let meet = |i: usize, j: usize| edges[i].touches(edges[j]);
            let brute = (0..count).any(|i| (i + 1..count).any(|j| meet(i, j)));
            let found = first_contact(&edges, meet);
            assert_eq!(found.is_some(), brute, "seed {seed}");
            assert!(found.is_none_or(|(i, j)| i < j && meet(i, j)));
        }
    }
}
