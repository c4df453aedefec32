//! Clearing stock: the time to mill the same stock away by jogging, and the stock that remains near the part.

use std::time::Duration;

use keepout_planner::Mm2;
use keepout_sim::operator::Rounds;
use serde::{Deserialize, Serialize};

use super::attempt::real as number;
use super::invasion::prohibited;
use super::ours::Ours;
use super::paper::Paper;
use super::roughing::DIRECTION_MM_S;
use super::scenario::{MachinedProfile, StudyError};

/// Far stock: distances from the profile, mm. Both systems can clear it.
pub const FAR_MM: (f64, f64) = (8.0, 20.0);
/// Near stock: distances from the profile, mm. Only a system that lets the tool go to the profile can clear
/// it.
pub const NEAR_MM: (f64, f64) = (0.2, 8.0);
/// Distances of the tool's edge from the part in the rounds for the far stock, mm. With a tool of 6 mm the
/// rounds overlap.
const FAR_ROUNDS_MM: [f64; 3] = [15.0, 11.0, 7.4];
/// The same for the near stock. In the last round the operator pushes against the wall.
const NEAR_ROUNDS_MM: [f64; 2] = [3.6, -0.5];
/// Distance at which a place counts as reached, mm.
const REACH_MM: f64 = 1.5;
/// Time without progress after which the operator gives a place up.
const PATIENCE: Duration = Duration::from_secs(3);
/// Side of the squares that represent the stock, mm.
const CELL_MM: f64 = 0.5;

/// Result of a clearing run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cleared {
    /// Duration, s.
    pub seconds: f64,
    /// Cleared share of the far stock.
    pub far: f64,
    /// Area of the far stock, mm².
    pub far_mm2: f64,
    /// Cleared share of the near stock.
    pub near: f64,
    /// Largest depth of the tool in the part, mm.
    pub deepest_mm: f64,
}

impl Cleared {
    /// The mean of several runs. The depth is the largest of all runs.
    #[must_use]
    pub fn mean(runs: &[Self]) -> Self {
        let mean = |of: fn(&Self) -> f64| runs.iter().map(of).sum::<f64>() / real(runs.len().max(1));
        Self {
            seconds: mean(|run| run.seconds),
            far: mean(|run| run.far),
            far_mm2: mean(|run| run.far_mm2),
            near: mean(|run| run.near),
            deepest_mm: runs.iter().map(|run| run.deepest_mm).fold(0.0, f64::max),
        }
    }
}

/// Clears the far stock with the paper's controller.
///
/// # Errors
/// [`StudyError`] if the rounds can not be constructed.
pub fn with_paper(paper: &Paper<'_>, seed: u64) -> Result<Cleared, StudyError> {
    let shape = paper.ground.shape;
    let places = rounds(shape, paper.ground.radius_mm(), &FAR_ROUNDS_MM)?;
    let start = places.first().copied().unwrap_or_default();
    let operator = Rounds::new(places, DIRECTION_MM_S, REACH_MM, PATIENCE);
    let run = paper.session(start, Box::new(operator), seed);
    Ok(cleared(shape, paper.ground.radius_mm(), &run.path, (run.seconds, run.depth_mm)))
}

/// Clears the far stock with Keepout, and the near stock too if `all` is set.
///
/// # Errors
/// [`StudyError`] if the rounds can not be constructed, or the session fails.
pub fn with_ours(
    ours: &Ours<'_>,
    all: bool,
    (seed, latency): (u64, Duration),
) -> Result<Cleared, StudyError> {
    let mut levels = FAR_ROUNDS_MM.to_vec();
    if all {
        levels.extend(NEAR_ROUNDS_MM);
    }
    let places = rounds(ours.shape, ours.radius_mm(), &levels)?;
    let start = places.first().copied().unwrap_or_default();
    let operator = Rounds::new(places, ours.speed_mm_s(), REACH_MM, PATIENCE + latency * 8);
    let run = ours.session(start, Box::new(operator), (seed, latency), None)?;
    Ok(cleared(ours.shape, ours.radius_mm(), &run.path, (run.seconds, run.depth_mm)))
}

/// Places of the tool's centre, round by round. `levels_mm` are the distances of the tool's edge from the
/// profile.
fn rounds(shape: &MachinedProfile, radius_mm: f64, levels_mm: &[f64]) -> Result<Vec<Mm2>, StudyError> {
    let mut places = Vec::new();
    for level in levels_mm {
        let ring = prohibited(&shape.corners, radius_mm + level, shape.side())
            .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })?;
        places.extend(&ring);
        places.extend(ring.first());
    }
    Ok(places)
}

fn cleared(
    shape: &MachinedProfile,
    radius_mm: f64,
    path: &[Mm2],
    (seconds, deepest_mm): (f64, f64),
) -> Cleared {
    let stock = Stock::of(shape, radius_mm, path);
    Cleared {
        seconds,
        far: stock.share(FAR_MM),
        far_mm2: stock.area_mm2(FAR_MM),
        near: stock.share(NEAR_MM),
        deepest_mm,
    }
}

/// Squares of stock: the distance of each from the profile, and whether the tool covered its centre.
struct Stock {
    squares: Vec<(f64, bool)>,
}

impl Stock {
    fn of(shape: &MachinedProfile, radius_mm: f64, path: &[Mm2]) -> Self {
        let around = shape.bounds().grown(FAR_MM.1 + CELL_MM);
        let (left, low) = (around.low.x, around.low.y);
        let (columns, rows) = (index(around.size().x / CELL_MM), index(around.size().y / CELL_MM));
        let middle = |column: usize, row: usize| {
            Mm2::new(left + (real(column) + 0.5) * CELL_MM, low + (real(row) + 0.5) * CELL_MM)
        };
        let mut gone = vec![false; columns * rows];
        for at in strides(path) {
            let span = |c: f64, from: f64, most: usize| {
                let first = index((c - radius_mm - from) / CELL_MM);
                first..(index((c + radius_mm - from) / CELL_MM) + 1).min(most)
            };
            for column in span(at.x, left, columns) {
                for row in span(at.y, low, rows) {
                    gone[column * rows + row] |= at.distance(middle(column, row)) <= radius_mm;
                }
            }
        }
        let squares = (0..columns * rows)
            .map(|number| (shape.clearance(middle(number / rows, number % rows)), gone[number]))
            .collect();
        Self { squares }
    }

    /// Area of the stock between these distances from the profile, mm².
    fn area_mm2(&self, (from, to): (f64, f64)) -> f64 {
        let between = self.squares.iter().filter(|(far, _)| (from..to).contains(far));
        real(between.count()) * CELL_MM * CELL_MM
    }

    /// Cleared share of the stock between these distances from the profile. It includes sharp inside corners,
    /// which the tool can not reach.
    fn share(&self, (from, to): (f64, f64)) -> f64 {
        let between = self.squares.iter().filter(|(far, _)| (from..to).contains(far));
        let (all, gone) =
            between.fold((0_usize, 0_usize), |(all, gone), square| (all + 1, gone + usize::from(square.1)));
        if all == 0 { 0.0 } else { real(gone) / real(all) }
    }
}

/// The path with intermediate points. Neighbours are at most half a square apart.
fn strides(path: &[Mm2]) -> impl Iterator<Item = Mm2> + '_ {
    path.windows(2).flat_map(|pair| {
        let (from, to) = (pair[0], pair[1]);
        let count = index((from.distance(to) / (CELL_MM / 2.0)).ceil()).max(1);
        (0..count).map(move |number| {
            let share = real(number) / real(count);
            from + (to - from) * share
        })
    })
}

fn real(count: usize) -> f64 {
    number(count as u64)
}

/// `value` as a count. Negative values give zero.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the size of a table")]
fn index(value: f64) -> usize {
    value.clamp(0.0, 1e6) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tool that moves along one side of the bar clears the stock of that side only.
    #[test]
    fn stock_is_cleared_where_the_tool_was() {
        let bar = MachinedProfile::bar();
        let (radius_mm, side) = (3.0, [(-3.0, 0.0), (-3.0, 60.0)].map(Mm2::from));
        let stock = Stock::of(&bar, radius_mm, &side);
        // The bar is 40 by 60 mm. One long side has 60 of 200 mm of the stock up to 3 mm, without the
        // corners.
        let share = stock.share((0.0, 3.0));
        assert!((0.28..0.34).contains(&share), "{share}");
        assert_eq!(stock.share((8.0, 20.0)), 0.0);
        let around = [(-3.0, -3.0), (43.0, -3.0), (43.0, 63.0), (-3.0, 63.0), (-3.0, -3.0)].map(Mm2::from);
        assert!(Stock::of(&bar, radius_mm, &around).share((0.3, 5.5)) > 0.97);
        assert_eq!(Stock::of(&bar, radius_mm, &[]).share((0.3, 5.5)), 0.0);
    }

    #[test]
    fn rounds_have_the_given_distance_from_the_part() {
        let bar = MachinedProfile::bar();
        let places = rounds(&bar, 3.0, &[10.0]).unwrap();
        assert_eq!(places.len(), 5);
        assert!(
            places.iter().all(|at| (bar.clearance(*at) - 13.0 * f64::sqrt(2.0)).abs() < 1e-9),
            "{places:?}"
        );
    }
}
