//! Stops: feed hold, cancel, and an immediate stop.

use super::{Block, MEETS, QueuedMotion};

/// The kind of a stop in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// Keep the queued blocks.
    Hold,
    /// Drop the queued blocks.
    Flush,
}

impl QueuedMotion {
    /// Whether a stop is in progress.
    pub fn is_stopping(&self) -> bool {
        self.stop.is_some()
    }

    /// Begins to stop and keeps the queue.
    pub fn hold(&mut self) {
        self.begin_stop(Stop::Hold);
    }

    /// Begins to stop, and drops the queue when the tool stands still.
    pub fn cancel(&mut self) {
        self.begin_stop(Stop::Flush);
    }

    fn begin_stop(&mut self, stop: Stop) {
        self.meets_end = self.brakes_to_end();
        self.unaware = 0.0;
        self.stop = Some(stop);
    }

    /// Whether a stop that begins now ends at the end of the current block.
    pub(super) fn brakes_to_end(&self) -> bool {
        let braking = |block: &Block| self.speed * self.speed / (2.0 * block.acceleration);
        self.speed > 0.0
            && self.blocks.front().is_some_and(|block| (braking(block) - block.left).abs() < MEETS)
    }

    /// Begins to stop as [`QueuedMotion::cancel`] does, but drops the blocks that end within the next
    /// `prepared_s` seconds. The following blocks then start at the current position, so the tool moves
    /// parallel to their lines.
    pub fn cancel_astray(&mut self, prepared_s: f64) {
        let mut prepared = self.speed * prepared_s;
        while self.blocks.len() > 1
            && let Some(first) = self.blocks.front()
            && first.left < prepared
        {
            prepared -= first.left;
            self.blocks.pop_front();
        }
        if let Some(first) = self.blocks.front() {
            let shift = self.position - (first.to - first.unit * first.left);
            for block in &mut self.blocks {
                block.to += shift;
            }
        }
        self.cancel();
    }

    /// Resumes the motion after a hold.
    pub fn resume(&mut self) {
        self.stop = None;
    }

    /// Stops at once, without braking, and drops the queue.
    pub fn kill(&mut self) {
        self.blocks.clear();
        self.speed = 0.0;
        self.stop = None;
        (self.unaware, self.runaway) = (0.0, None);
    }
}
