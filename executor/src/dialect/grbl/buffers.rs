//! What reports say of the controller's buffers.

use crate::supervisor::Mode;

/// Free planner blocks and free bytes of the receive buffer, as one report states them.
pub(super) type Free = (usize, usize);

/// How much is free when nothing is queued. One report can be damaged into a valid one, so only two idle reports that agree state
/// it, and a report that states more than all is no evidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Buffers {
    all: Option<Free>,
    last_idle: Option<Free>,
}

impl Buffers {
    /// Blocks that are queued, and whether bytes wait to be read; `None` while that is not known.
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

    #[test]
    fn one_damaged_report_changes_nothing() {
        let mut buffers = Buffers::default();
        assert_eq!(buffers.take(Mode::Idle, (15, 128)), None, "one report is no evidence");
        assert_eq!(buffers.take(Mode::Idle, (15, 128)), Some((0, false)));
        for damaged in [(155, 128), (15, 1289), (150, 1280)] {
            assert_eq!(buffers.take(Mode::Idle, damaged), None);
            assert_eq!(buffers.take(Mode::Idle, (15, 128)), Some((0, false)));
        }
        assert_eq!(buffers.take(Mode::Moving, (12, 100)), Some((3, true)));
        assert_eq!(buffers.take(Mode::Moving, (16, 128)), None);
        // Fewer at rest do not lower it: something may be queued.
        for _ in 0..3 {
            assert_eq!(buffers.take(Mode::Idle, (14, 128)), Some((1, false)));
        }
        for expected in [None, Some((0, false))] {
            assert_eq!(buffers.take(Mode::Idle, (35, 1023)), expected, "it is another controller");
        }
    }
}
