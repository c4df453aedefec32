//! What can happen next.

use super::{
    PLANNER, PREPARED, RESOLUTION, STRAY, SecondController, SecondEvent, StepState, Trouble, deviations,
};
use crate::wire::Sent;

impl SecondController {
    pub(super) fn events_of_link(&self, into: &mut Vec<SecondEvent>) {
        let Trouble { lost, doubled, swapped, .. } = self.trouble;
        if let Some(first) = self.link.front() {
            // A report that is late shows only beside a later message.
            let late = *first == Sent::Query && self.link.len() == 1 && !self.asked;
            into.extend((!late).then_some(SecondEvent::Arrives));
            into.extend((lost > 0).then_some(SecondEvent::Lost));
            into.extend((doubled > 0).then_some(SecondEvent::ArrivesTwice));
            into.extend((swapped > 0 && self.link.len() > 1).then_some(SecondEvent::Swaps));
            let ignored = *first == Sent::Cancel && self.state == StepState::Moves && self.drive.cancels;
            into.extend(ignored.then_some(SecondEvent::CancelIgnored));
        }
        if !self.answers.is_empty() {
            into.extend((lost > 0).then_some(SecondEvent::AnswerLost));
            into.extend((doubled > 0).then_some(SecondEvent::AnswerTwice));
            into.extend((swapped > 0 && self.answers.len() > 1).then_some(SecondEvent::AnswersSwap));
        }
        if self.asked || self.link.front() == Some(&Sent::Query) {
            let reach = if self.drive.errs { RESOLUTION } else { 0 };
            let count = if self.drive.errs { usize::MAX } else { 1 };
            let errors = deviations(reach, self.drive.climbs).take(count);
            into.extend(errors.map(|(dx, dy, dz)| SecondEvent::Reports(dx, dy, dz)));
            if self.trouble.lies > 0 {
                into.extend((0..self.earlier.len()).map(SecondEvent::Repeats));
            }
        }
    }

    pub(super) fn events_of_program(&self, into: &mut Vec<SecondEvent>) {
        if !self.reads_lines() {
            return;
        }
        if self.parsed.is_none() {
            into.extend((!self.received.is_empty()).then_some(SecondEvent::Reads));
            return;
        }
        into.extend((self.planned.len() < PLANNER).then_some(SecondEvent::Plans));
        into.extend((self.trouble.refused > 0).then_some(SecondEvent::Rejects));
        into.extend(self.flushed.then_some(SecondEvent::Discards));
    }

    /// Whether a line that just arrived comes first. The tool moved before that line arrived, or moves after it is
    /// planned: nobody can tell the difference. A line that waited for room gets no such order.
    fn line_first(&self) -> bool {
        let alone = self.received.len() + usize::from(self.parsed.is_some()) == 1;
        self.reads_lines() && alone && !self.waited && self.planned.len() < PLANNER
    }

    pub(super) fn events_of_motion(&self, into: &mut Vec<SecondEvent>) {
        let moves = matches!(self.state, StepState::Moves | StepState::Cancels | StepState::Brakes);
        let moves = moves && !self.line_first();
        if moves {
            let room = self.prepared.len() < PREPARED;
            into.extend((room && !self.planned.is_empty()).then_some(SecondEvent::Leaves));
            let single: &[Option<u8>] = if self.drive.apart { &[Some(0), Some(1), Some(2)] } else { &[None] };
            for &axis in single {
                let places = self.prepared.front().or(self.planned.front()).map_or(0, |block| block.places);
                let half = places < self.drive.halves && self.next_place(axis, true).is_some();
                into.extend(half.then_some(SecondEvent::DrivesHalf(axis)));
                into.extend(self.next_place(axis, false).map(|_| SecondEvent::DrivesOn(axis)));
            }
        }
        match self.state {
            StepState::Idle => into.extend((!self.planned.is_empty()).then_some(SecondEvent::Starts)),
            StepState::Moves => {
                // A block that was planned at the last moment has not begun.
                let ended =
                    self.prepared.is_empty() && self.planned.front().is_none_or(|next| next.places == 0);
                into.extend(ended.then_some(SecondEvent::Rests));
            }
            StepState::Cancels if self.drive.strays => {
                let all = deviations(STRAY, self.drive.climbs);
                let both = [(1, 1), (1, -1), (-1, 1), (-1, -1)].map(|(x, y)| (x * STRAY, y * STRAY, 0));
                // Only non-interpolated axes leave the path by so much each.
                let all = all.chain(both.into_iter().filter(|_| self.drive.apart));
                into.extend(all.map(|(dx, dy, dz)| SecondEvent::Stops(dx, dy, dz)));
            }
            StepState::Cancels | StepState::Brakes => into.push(SecondEvent::Stops(0, 0, 0)),
            StepState::Held => into.push(SecondEvent::Resumes),
        }
        let holds = self.trouble.holds > 0 && self.reads_lines();
        into.extend(holds.then_some(SecondEvent::Holds));
        into.extend((self.trouble.resets > 0).then_some(SecondEvent::Resets));
    }
}
