//! The largest disc that fits into the free space between walls.

use std::collections::BinaryHeap;

use keepout_kernel::curve::{nearest_point, nearest_unit};
use keepout_kernel::{Length, Point, ProhibitedRegion, Vec2};

use super::{Mesh, NONE};
use crate::units::mm;

/// A disc in free space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Disc {
    /// Its centre.
    pub centre: Point,
    /// Its radius: a certified clearance of the centre.
    pub radius: Length,
}

/// The search ends when no disc can be larger by more than this share.
const SHARE: f64 = 0.001;
/// The search ends at this difference too, lattice units (1 µm).
const LEAST: f64 = 100.0;
/// Largest number of places at which the search looks.
const PLACES_MAX: usize = 100_000;
/// First step of the climb, as a share of the radius.
const CLIMB: f64 = 0.1;

impl Mesh {
    /// The largest disc that touches no edge, with its centre on the free side of `part`. With `around`
    /// its centre lies in the same connected component between walls. The mesh must be that of
    /// [`Mesh::of`]. `None` without such a disc, or where walls do not bound the free space.
    ///
    /// The kernel certifies the radius. It is the largest up to a share of 0.001.
    #[must_use]
    pub fn largest_disc(&self, part: &ProhibitedRegion, around: Option<Point>) -> Option<Disc> {
        let component = match around {
            Some(point) => Some(self.triangles[self.walk().locate(self, point)?].component),
            None => None,
        };
        let mut search = Search { part, best: (0.0, None), hint: None };
        let mut whole = Vec::new();
        for triangle in &self.triangles {
            if component.is_some_and(|number| triangle.component != number) {
                continue;
            }
            let corners = triangle.corners.map(|number| self.corner(number));
            let at_frame = triangle.corners.iter().any(|&number| self.ends[number as usize] == NONE);
            if at_frame && search.is_free(middle(corners)) {
                return None;
            }
            if !at_frame {
                whole.push((circumradius(corners), corners));
            }
        }
        search.triangles(whole);
        search.climb();
        let centre = nearest_point(search.best.1?).ok().filter(|&centre| !part.holds(centre))?;
        Some(Disc { centre, radius: part.clearance(centre)? })
    }
}

/// Diameter of the largest tool that fits somewhere beside the part with `more_mm` between the tool and
/// the part, mm. It is rounded down to 0.01 mm. `None` where any tool fits, or no tool.
#[must_use]
pub fn largest_tool_mm(part: &ProhibitedRegion, more_mm: f64) -> Option<f64> {
    let disc = Mesh::of(part).ok()?.largest_disc(part, None)?;
    let diameter_mm = 2.0 * (mm(disc.radius.units()) - more_mm);
    Some((diameter_mm * 100.0).floor() / 100.0).filter(|largest_mm| *largest_mm > 0.0)
}

/// Branch and bound over triangles.
struct Search<'a> {
    part: &'a ProhibitedRegion,
    /// Radius and centre of the largest disc so far.
    best: (f64, Option<Vec2>),
    hint: Option<usize>,
}

impl Search<'_> {
    /// Searches triangles, each with a bound on the radius of the discs whose centre it holds.
    ///
    /// The clearance changes by at most the distance between two places. So the clearance in the middle
    /// of a triangle gives a bound for the whole triangle.
    fn triangles(&mut self, mut whole: Vec<(f64, [Vec2; 3])>) {
        whole.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Parts of triangles, with the number of their corners in `parts`.
        let (mut open, mut parts) = (BinaryHeap::new(), Vec::new());
        for _ in 0..PLACES_MAX {
            let enough = self.best.0 + LEAST.max(self.best.0 * SHARE);
            let divided = open.peek().map_or(0.0, |&(bound, _)| to_units(bound));
            let (bound, corners) = match whole.last() {
                Some(&(bound, corners)) if bound >= divided => {
                    whole.pop();
                    if bound > enough && !self.is_free(middle(corners)) {
                        continue;
                    }
                    (bound, corners)
                }
                _ => match open.pop() {
                    Some((bound, number)) => (to_units(bound), parts[number]),
                    None => return,
                },
            };
            if bound <= enough {
                return;
            }
            let centre = middle(corners);
            let clearance = self.look(centre);
            let bound = corners.iter().map(|&corner| centre.distance(corner)).fold(0.0, f64::max) + clearance;
            let [a, b, c] = longest_first(corners);
            let between = a.midpoint(b);
            for part in [[a, between, c], [between, b, c]] {
                open.push((nearest_unit(bound), parts.len()));
                parts.push(part);
            }
        }
    }

    /// Climbs from the best place, in smaller and smaller steps.
    fn climb(&mut self) {
        let mut step = self.best.0 * CLIMB;
        while let (before, Some(best)) = self.best {
            for (dx, dy) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
                self.look(best + Vec2::new(f64::from(dx), f64::from(dy)) * step);
            }
            if self.best.0 <= before {
                step *= 0.5;
            }
            if step < 1.0 {
                return;
            }
        }
    }

    /// The clearance at a place. Keeps the place when it is the best on the free side.
    fn look(&mut self, place: Vec2) -> f64 {
        let Ok(at) = nearest_point(place) else { return 0.0 };
        let Some(nearest) = self.part.index().nearest(at, self.hint) else { return 0.0 };
        self.hint = Some(nearest.edge);
        if nearest.distance() > self.best.0 && !self.part.holds(at) {
            self.best = (nearest.distance(), Some(place));
        }
        nearest.distance()
    }

    fn is_free(&self, place: Vec2) -> bool {
        nearest_point(place).is_ok_and(|at| !self.part.holds(at))
    }
}

fn to_units(bound: i64) -> f64 {
    i32::try_from(bound).map_or(f64::INFINITY, f64::from)
}

fn middle([a, b, c]: [Vec2; 3]) -> Vec2 {
    (a + b + c) / 3.0
}

/// Radius of the circle through the corners. It bounds the radius of every disc that holds no corner and
/// has its centre in the triangle.
fn circumradius([a, b, c]: [Vec2; 3]) -> f64 {
    let double_area = (b - a).cross(c - a).abs();
    a.distance(b) * b.distance(c) * c.distance(a) / (2.0 * double_area)
}

/// The corners in an order with the longest side first.
fn longest_first([a, b, c]: [Vec2; 3]) -> [Vec2; 3] {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if a.distance(b) >= longest {
        [a, b, c]
    } else if b.distance(c) >= longest {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
