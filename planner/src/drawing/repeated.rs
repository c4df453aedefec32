//! Drops curves and contours that repeat others exactly.

use std::collections::{HashMap, HashSet};

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{Point, Turn, Vec2};

use super::Repair;
use super::chain::{Bend, Piece, remove};

/// The identity of a curve: its ends and its bend, equal for both directions of travel.
type Key = ((Point, Point), Vec<i64>);

fn key_of(piece: &Piece) -> Key {
    let forwards = piece.from < piece.to;
    let ends = if forwards { (piece.from, piece.to) } else { (piece.to, piece.from) };
    let bend = match &piece.bend {
        Bend::Straight => Vec::new(),
        // The same arc drawn in the other direction has the opposite turn.
        Bend::Round(Vec2 { x, y }, turn, _) => {
            vec![nearest_unit(*x), nearest_unit(*y), i64::from((*turn == Turn::CounterClockwise) == forwards)]
        }
        Bend::Free(curve) => {
            let units = |(p, &w): (&Point, &u64)| {
                [i64::from(p.x.units()), i64::from(p.y.units()), i64::try_from(w).unwrap_or(i64::MAX)]
            };
            let mut control: Vec<[i64; 3]> = curve.control().iter().zip(curve.weights()).map(units).collect();
            if !forwards {
                control.reverse();
            }
            control.into_iter().flatten().collect()
        }
    };
    (ends, bend)
}

/// Drops entities that are closed contours and repeat another such contour, and all other pieces that repeat
/// a piece of another entity. A contour of one entity is dropped whole or not at all.
pub(super) fn drop_duplicates(pieces: &mut Vec<Piece>, repairs: &mut Vec<Repair>) {
    let keys: Vec<Key> = pieces.iter().map(key_of).collect();
    let mut doubled: HashSet<usize> = HashSet::new();
    let mut contours: HashSet<Vec<&Key>> = HashSet::new();
    let mut seen: HashMap<&Key, u32> = HashMap::new();
    let mut end = 0;
    for group in pieces.chunk_by(|a, b| a.origin == b.origin && a.whole == b.whole) {
        let range = end..end + group.len();
        end = range.end;
        if !group[0].whole {
            continue;
        }
        let mut contour: Vec<&Key> = keys[range.clone()].iter().collect();
        contour.sort();
        if contours.insert(contour) {
            keys[range].iter().for_each(|key| _ = seen.insert(key, group[0].origin));
        } else {
            doubled.extend(range);
        }
    }
    for (i, piece) in pieces.iter().enumerate().filter(|(_, piece)| !piece.whole) {
        if *seen.entry(&keys[i]).or_insert(piece.origin) != piece.origin {
            doubled.insert(i);
        }
    }
    let mut dropped: Vec<usize> = doubled.iter().copied().collect();
    dropped.sort_unstable();
    for i in dropped {
        repairs.push(Repair::DuplicateDropped { at: pieces[i].from, length_mm: pieces[i].length_mm() });
    }
    if !doubled.is_empty() {
        remove(pieces, &doubled);
    }
}
