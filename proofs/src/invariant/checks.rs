//! What is checked in each state.

use keepout_guard::Interpolation;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Levels, Segment};

use super::{Node, World};
use crate::controller::{RESOLUTION, Trouble};
use crate::families::{at, length};
use crate::model::ControllerModel;
use crate::properties::{Xy, Xyz};
use crate::square::{MANUAL, approaches, certified, height, off_box, off_hull, place, plain};

impl<M: ControllerModel> Node<M> {
    /// The condition that the tool's path to this state violates.
    pub(super) fn fault_of_path(&self, world: &World, levels: &Levels, way: &[Xyz]) -> Option<String> {
        for pair in way.windows(2) {
            let [from, to] = [place(pair[0]), place(pair[1])];
            let part = levels.at(from.height.min(to.height));
            let motion = Segment { from: from.point, to: to.point };
            if self.inside {
                if approaches(part, plain(from.point), plain(to.point)) {
                    return Some(format!("a retract move comes nearer to the part: {pair:?}"));
                }
            } else if !part.motion_clear(motion, length(world.kept())).is_clear() || part.holds(to.point) {
                return Some(format!("the tool comes too near the part: {pair:?}"));
            }
        }
        None
    }

    /// The condition that this state violates. It depends on nothing but the state, which [`Key`](super::Key) holds.
    pub(super) fn fault(&self, world: &World, levels: &Levels) -> Option<String> {
        if self.ended && world.trouble == Trouble::default() {
            return Some("the session ended in a world without faults".into());
        }
        if self.guard.contour_progress().is_some() {
            return self.off_the_contour();
        }
        self.off_the_set(world, levels)
    }

    /// Whether the set is clear, and holds the tool and every target.
    fn off_the_set(&self, world: &World, levels: &Levels) -> Option<String> {
        let set: Vec<Xy> = self.guard.in_flight().map(plain).collect();
        let lowest = i64::from(self.guard.lowest()?.units());
        let stray = i64::from(self.guard.stray().units());
        let part = levels.at(height(lowest - stray).lowered(self.guard.rules().heights.margin));
        if !self.inside && !certified(part, &set, world.drive.apart, stray) {
            return Some(format!("the set is not clear: {set:?} at {lowest}"));
        }
        let outside = |p: Xy| if world.drive.apart { off_box(&set, p) } else { off_hull(&set, p) };
        let (x, y, z) = self.plant.tool();
        let (tool, part) = (at((x, y)), levels.at(height(z)));
        let open = part.motion_clear(Segment { from: tool, to: tool }, length(MANUAL + 2 * RESOLUTION));
        let off = match world.drive.errs {
            false => 1,
            true if self.guard.in_position() && open.is_clear() => RESOLUTION,
            true => world.off() + 1,
        };
        if outside((x, y)) > off + stray {
            return Some(format!("the tool at {:?} is outside the set {set:?}", self.plant.tool()));
        }
        let below = if world.drive.errs { RESOLUTION } else { 0 };
        if z < lowest - below - stray {
            return Some(format!("the tool at height {z} is below the lowest height {lowest}"));
        }
        let other = self.plant.all_targets().into_iter().find(|&(x, y, z)| outside((x, y)) > 0 || z < lowest);
        other.map(|to| format!("the target {to:?} is outside the set {set:?} at {lowest}"))
    }

    fn off_the_contour(&self) -> Option<String> {
        let (x, y, z) = self.plant.tool();
        let (point, z) = (at((x, y)), height(z));
        let on = self.guard.contour_left().iter().any(|motion| {
            let line = Segment { from: motion.curve.from(), to: motion.curve.to() };
            let beside = !line.near_point(point, length(RESOLUTION)).is_clear();
            let boxed = self.guard.rules().contours == Interpolation::Independent
                && Window::of(line.from).including(line.to).holds(point);
            let [low, high] = [motion.lowest(), motion.heights[0].max(motion.heights[1])];
            let between = (low.lowered(length(RESOLUTION))..=high.raised(length(RESOLUTION))).contains(&z);
            (beside || boxed) && between
        });
        (!on).then(|| format!("the tool at {:?} is not on the contour", self.plant.tool()))
    }
}
