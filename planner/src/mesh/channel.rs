//! Channels: sequences of triangles through which a disc can pass, found by A*.
//!
//! A disc passes a side of a triangle when the side is at least as long as its diameter. It passes around
//! a corner when no wall across that corner is nearer than its diameter. Source: D. Demyen and M. Buro,
//! "Efficient Triangulation-Based Pathfinding", AAAI 2006, sections 3 and 4.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Point, Vec2};

use super::{Mesh, NONE, Triangle};

/// Side of a triangle that a channel crosses. In the direction of travel, one end is on the left and one
/// on the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Portal {
    /// The end on the left.
    pub left: Point,
    /// The end on the right.
    pub right: Point,
}

/// Search for the channel of a disc between two points.
pub struct ChannelSearch<'a> {
    mesh: &'a Mesh,
    /// Radius of the disc, lattice units.
    radius: f64,
    within: Window,
    from: (Vec2, usize),
    to: (Vec2, usize),
    /// Sides that the search does not cross, as pairs of their ends.
    refused: HashSet<(u32, u32)>,
}

/// Entry into a triangle: the triangle, and the side.
type Entry = (usize, usize);

/// An entry that the search reached.
struct Reached {
    /// Point of the side at which the proposed path crosses it.
    at: Vec2,
    /// Length of the path so far.
    cost: f64,
    /// The entry before; `None` in the first triangle.
    before: Option<Entry>,
    closed: bool,
}

impl<'a> ChannelSearch<'a> {
    /// A search for discs of `radius` lattice units, whose centre stays in `within`. `None` when the mesh
    /// does not hold both points.
    #[must_use]
    pub fn new(mesh: &'a Mesh, (from, to): (Point, Point), radius: f64, within: Window) -> Option<Self> {
        let mut walk = mesh.walk();
        let from = (Vec2::from(from), walk.locate(mesh, from)?);
        let to = (Vec2::from(to), walk.locate(mesh, to)?);
        Some(Self { mesh, radius, within, from, to, refused: HashSet::new() })
    }

    /// The sides that a short path crosses in order. No side when both points are in one triangle. `None`
    /// when no channel is wide enough.
    #[must_use]
    pub fn channel(&self) -> Option<Vec<Portal>> {
        if self.from.1 == self.to.1 {
            return Some(Vec::new());
        }
        let mut reached: HashMap<Entry, Reached> = HashMap::new();
        let mut open = BinaryHeap::new();
        for side in 0..3 {
            self.cross((self.from.1, side), (self.from.0, 0.0, None), &mut reached, &mut open);
        }
        while let Some((_, entry)) = open.pop() {
            let here = reached.get_mut(&entry)?;
            if std::mem::replace(&mut here.closed, true) {
                continue;
            }
            let (number, entered) = entry;
            if number == self.to.1 {
                return Some(self.portals(entry, &reached));
            }
            let so_far = (here.at, here.cost, Some(entry));
            // Around the corner at the end of the side, then around the corner at its start.
            for (side, pivot) in [((entered + 1) % 3, (entered + 1) % 3), ((entered + 2) % 3, entered)] {
                if self.passes_around(number, pivot) {
                    self.cross((number, side), so_far, &mut reached, &mut open);
                }
            }
        }
        None
    }

    /// Refuses the portal of `channel` that is nearest to `at`, for later calls of
    /// [`ChannelSearch::channel`]. Returns `false` when there is no portal.
    pub fn refuse(&mut self, channel: &[Portal], at: Vec2) -> bool {
        let far = |portal: &Portal| to_segment_2(at, Vec2::from(portal.left), Vec2::from(portal.right));
        let nearest = channel.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        let number = |point| self.mesh.points.iter().position(|&other| other == point);
        let ends = nearest.and_then(|portal| Some((number(portal.left)?, number(portal.right)?)));
        let ends = ends.and_then(|(a, b)| Some((u32::try_from(a).ok()?, u32::try_from(b).ok()?)));
        ends.is_some_and(|(a, b)| self.refused.insert((a.min(b), a.max(b))))
    }

    /// Enters the triangle across a side, when the disc passes that side.
    fn cross(
        &self,
        (number, side): (usize, usize),
        (at, cost, before): (Vec2, f64, Option<Entry>),
        reached: &mut HashMap<Entry, Reached>,
        open: &mut BinaryHeap<(Reverse<i64>, Entry)>,
    ) {
        let Triangle { corners, across, walls, .. } = self.mesh.triangles[number];
        let (a, b) = (corners[side], corners[(side + 1) % 3]);
        if walls[side] != NONE || across[side] == NONE || self.refused.contains(&(a.min(b), a.max(b))) {
            return;
        }
        let Some(next) = self.crossing(self.mesh.corner(a), self.mesh.corner(b), at) else { return };
        let beyond = self.mesh.triangles[across[side] as usize];
        let Some(entered) = (0..3).find(|&k| beyond.corners[k] == b) else { return };
        let entry = (across[side] as usize, entered);
        let cost = cost + at.distance(next);
        if reached.get(&entry).is_some_and(|known| known.closed || known.cost <= cost) {
            return;
        }
        reached.insert(entry, Reached { at: next, cost, before, closed: false });
        open.push((Reverse(nearest_unit(cost + next.distance(self.to.0))), entry));
    }

    /// The point of the side `a b`, as far as the disc's centre can be there, on the shortest way from
    /// `at` to the goal.
    fn crossing(&self, a: Vec2, b: Vec2, at: Vec2) -> Option<Vec2> {
        let length = a.distance(b);
        if length < 2.0 * self.radius {
            return None;
        }
        let along = (b - a) / length;
        let (mut low, mut high) = (self.radius, length - self.radius);
        let (x0, y0, x1, y1) = self.within.corners();
        for (start, slope, least, most) in [(a.x, along.x, x0, x1), (a.y, along.y, y0, y1)] {
            let (least, most) = (f64::from(least) - start, f64::from(most) - start);
            if slope == 0.0 {
                if least > 0.0 || most < 0.0 {
                    return None;
                }
                continue;
            }
            let (p, q) = (least / slope, most / slope);
            (low, high) = (low.max(p.min(q)), high.min(p.max(q)));
        }
        if low > high {
            return None;
        }
        let share = |p: Vec2| (p - a).dot(along);
        let aside = |p: Vec2| along.cross(p - a).abs();
        // The goal, reflected to the other side where needed, is straight ahead there.
        let (near, far) = (aside(at), aside(self.to.0));
        let straight = (share(at) * far + share(self.to.0) * near) / (near + far).max(f64::MIN_POSITIVE);
        let t = straight.clamp(low, high);
        Some(a + along * t)
    }

    /// Whether the disc passes between the corner and all that is across it.
    fn passes_around(&self, number: usize, corner: usize) -> bool {
        let pivot = self.mesh.corner(self.mesh.triangles[number].corners[corner]);
        let mut stack = vec![(number, (corner + 1) % 3)];
        while let Some((number, side)) = stack.pop() {
            let Triangle { corners, across, walls, .. } = self.mesh.triangles[number];
            let (a, b) = (self.mesh.corner(corners[side]), self.mesh.corner(corners[(side + 1) % 3]));
            let along = b - a;
            let obtuse = (pivot - a).dot(along) <= 0.0 || (pivot - b).dot(along) >= 0.0;
            let aside = (pivot - a).cross(along).abs() / along.length();
            if obtuse || aside >= 2.0 * self.radius {
                continue;
            }
            if walls[side] != NONE || across[side] == NONE {
                return false;
            }
            let beyond = &self.mesh.triangles[across[side] as usize];
            let entered = (0..3).find(|&k| beyond.corners[k] == corners[(side + 1) % 3]).unwrap_or(0);
            stack.extend([1, 2].map(|k| (across[side] as usize, (entered + k) % 3)));
        }
        true
    }

    fn portals(&self, last: Entry, reached: &HashMap<Entry, Reached>) -> Vec<Portal> {
        let mut portals = Vec::new();
        let mut next = Some(last);
        while let Some((number, side)) = next {
            // Seen from the triangle that it leads into, a side runs from left to right.
            let ends = self.mesh.side(number, side);
            portals.push(Portal { left: ends.from, right: ends.to });
            next = reached.get(&(number, side)).and_then(|here| here.before);
        }
        portals.reverse();
        portals
    }
}

impl Mesh {
    pub(super) fn corner(&self, number: u32) -> Vec2 {
        Vec2::from(self.points[number as usize])
    }
}

fn to_segment_2(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let off = p - p.nearest_on(a, b);
    off.dot(off)
}
