//! The interface between the exploration and a model of the controller.

use std::fmt::Debug;
use std::hash::Hash;

use crate::controller::{Happening, MachineModel, MotionModel, Trouble};
use crate::properties::Xyz;
use crate::wire::{HostMessage, Sent};

/// A model of the controller, the link and the tool.
pub trait ControllerModel: Clone + Debug + Eq + Hash {
    /// An event that happens by itself.
    type Event: Copy + Debug;

    /// A controller at rest.
    fn at_rest(tool: Xyz, drive: MotionModel, trouble: Trouble) -> Self;

    /// Position of the tool.
    fn tool(&self) -> Xyz;

    /// Whether the clock may still jump.
    fn may_jump(&self) -> bool;

    /// Counts a jump of the clock.
    fn jump(&mut self);

    /// Puts a message on the link to the controller.
    fn send(&mut self, message: Sent);

    /// Whether a message for the host has arrived.
    fn has_answer(&self) -> bool;

    /// Takes the next message for the host.
    fn next_answer(&mut self) -> Option<HostMessage>;

    /// All targets in the controller and on the link.
    fn all_targets(&self) -> Vec<Xyz>;

    /// Appends all possible events.
    fn events(&self, into: &mut Vec<Self::Event>);

    /// Applies an event, and returns the path of the tool.
    fn apply(&mut self, event: Self::Event) -> Vec<Xyz>;

    /// Lets half of `DRAIN` pass. Returns whether that is possible: no block that has left the planner is overdue, no
    /// line is being parsed, and the tool has come to rest after a stop.
    fn pass_half(&mut self) -> bool;
}

impl ControllerModel for MachineModel {
    type Event = Happening;

    fn at_rest(tool: Xyz, drive: MotionModel, trouble: Trouble) -> Self {
        Self::new(tool, drive, trouble)
    }

    fn tool(&self) -> Xyz {
        self.tool
    }

    fn may_jump(&self) -> bool {
        self.trouble.jumps > 0
    }

    fn jump(&mut self) {
        self.trouble.jumps -= 1;
    }

    fn send(&mut self, message: Sent) {
        self.wire.push_back(message);
    }

    fn has_answer(&self) -> bool {
        !self.answers.is_empty()
    }

    fn next_answer(&mut self) -> Option<HostMessage> {
        self.answers.pop_front()
    }

    fn all_targets(&self) -> Vec<Xyz> {
        self.targets().collect()
    }

    fn events(&self, into: &mut Vec<Happening>) {
        self.moves(into);
    }

    fn apply(&mut self, event: Happening) -> Vec<Xyz> {
        self.happens(event)
    }

    fn pass_half(&mut self) -> bool {
        self.passes()
    }
}
