//! The controller's buffers, from its status reports.
//!
//! Implements SR-18.

use crate::supervisor::Mode;

/// Free planner blocks and free bytes of the receive buffer, from one report.
pub(super) type Free = (usize, usize);

/// The capacity of the buffers: the free space when nothing is queued. Damage can turn one report into
/// another valid one. So only two idle reports that agree set the capacity, and a report with more free space
/// than the capacity is ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Buffers {
    all: Option<Free>,
    last_idle: Option<Free>,
}

impl Buffers {
    /// The number of queued blocks, and whether received bytes wait for the controller. `None` while the
    /// capacity is unknown.
    pub(super) fn take(&mut self, mode: Mode, free: Free) -> Option<(usize, bool)> {
        if mode == Mode::Idle {
            let holds = |all: Free| free.0 >= all.0 && free.1 >= all.1;
            if self.last_idle == Some(free) && self.all.is_none_or(holds) {
                self.all = Some(free);
            }
            self.last_idle = Some(free);
        }
        let all = self.all?;
        let queued = all.0.checked_sub(free.0)?;
        let waiting = all.1.checked_sub(free.1)?;
        Some((queued, waiting > 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-18.
    #[test]
    fn one_damaged_report_changes_nothing() {
        let mut buffers = Buffers::default();
        assert_eq!(buffers.take(Mode::Idle, (15, 128)), None, "one report is not enough");
        assert_eq!(buffers.take(Mode::Idle, (15, 128)), Some((0, false)));
        for damaged in [(155, 128), (15, 1289), (150, 1280)] {
            assert_eq!(buffers.take(Mode::Idle, damaged), None);
            assert_eq!(buffers.take(Mode::Idle, (15, 128)), Some((0, false)));
        }
        assert_eq!(buffers.take(Mode::Moving, (12, 100)), Some((3, true)));
        assert_eq!(buffers.take(Mode::Moving, (16, 128)), None);
        // Less free space at rest does not lower the capacity: a line may be queued.
        for _ in 0..3 {
            assert_eq!(buffers.take(Mode::Idle, (14, 128)), Some((1, false)));
        }
        for expected in [None, Some((0, false))] {
            assert_eq!(
                buffers.take(Mode::Idle, (35, 1023)),
                expected,
                "another controller needs two reports"
            );
        }
    }
}
