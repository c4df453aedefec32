//! What an event changes.

use super::{
    HostMessage, QueuedBlock, RECEIVE, REMEMBERED, SecondController, SecondEvent, Sent, StatusReport,
    StepState, Xyz, along, middle, off,
};

impl SecondController {
    pub(super) fn says_report(&mut self, report: StatusReport) {
        if self.asked {
            self.asked = false;
        } else {
            self.link.pop_front();
        }
        if self.trouble.lies > 0 {
            self.earlier.push_back(report);
            if self.earlier.len() > REMEMBERED {
                self.earlier.pop_front();
            }
        } else {
            self.earlier.clear();
        }
        self.answers.push_back(HostMessage::Report(report));
    }

    fn arrives(&mut self, message: Sent) {
        match message {
            Sent::Query => self.asked = true,
            Sent::Cancel => self.cancel(),
            Sent::Line(to) if self.received.len() < RECEIVE => {
                let line = self.torn.take().map_or(to, |head| (head.0, to.1, to.2));
                self.received.push_back(line);
            }
            Sent::Line(to) => self.torn = Some(to),
        }
    }

    fn cancel(&mut self) {
        if self.state != StepState::Moves || !self.drive.cancels {
            return;
        }
        self.state = StepState::Cancels;
        if self.drive.flushes {
            self.received.clear();
            self.torn = None;
            self.flushed = self.parsed.is_some();
        }
    }

    pub(super) fn plans(&mut self) {
        let Some(to) = self.parsed.take() else { return };
        (self.flushed, self.waited) = (false, false);
        if to != self.end() {
            self.planned.push_back(QueuedBlock { to, halves: 0, places: 0 });
            // Jogs start at once, programmed motions wait for a start.
            if self.drive.cancels && self.state == StepState::Idle {
                self.state = StepState::Moves;
            }
        }
        self.answers.push_back(HostMessage::Accepted);
    }

    /// Drives along the first prepared block, and returns the path.
    pub(super) fn drives(&mut self, to: Xyz) -> Vec<Xyz> {
        let way = vec![self.tool, to];
        self.tool = to;
        if self.prepared.front().is_some_and(|block| block.to == to) {
            self.prepared.pop_front();
        }
        way
    }

    /// The place on the way along the present block. The tool drives along a block that still is in the planner,
    /// and reaches its end only after it has left.
    pub(super) fn next_place(&self, axis: Option<u8>, half: bool) -> Option<Xyz> {
        let block = self.prepared.front().or(self.planned.front().filter(|_| half))?;
        let to = along(self.tool, block.to, axis);
        let place = if half { along(self.tool, middle(self.tool, block.to), axis) } else { to };
        (place != self.tool && (!half || place != to)).then_some(place)
    }

    pub(super) fn stops(&mut self, deviation: (i64, i64, i64)) -> Vec<Xyz> {
        let way = vec![self.tool, off(self.tool, deviation)];
        self.tool = off(self.tool, deviation);
        if self.state == StepState::Cancels {
            self.planned.clear();
            self.prepared.clear();
            self.state = StepState::Idle;
        } else {
            self.state = StepState::Held;
        }
        way
    }

    pub(super) fn apply_to_link(&mut self, event: SecondEvent) {
        match event {
            SecondEvent::Arrives => {
                if let Some(message) = self.link.pop_front() {
                    self.arrives(message);
                }
            }
            SecondEvent::ArrivesTwice => {
                self.trouble.doubled -= 1;
                if let Some(&message) = self.link.front() {
                    self.arrives(message);
                }
            }
            SecondEvent::Lost => {
                self.trouble.lost -= 1;
                self.link.pop_front();
            }
            SecondEvent::Swaps => {
                self.trouble.swapped -= 1;
                self.link.swap(0, 1);
            }
            SecondEvent::AnswerLost => {
                self.trouble.lost -= 1;
                self.answers.pop_front();
            }
            SecondEvent::AnswersSwap => {
                self.trouble.swapped -= 1;
                self.answers.swap(0, 1);
            }
            SecondEvent::AnswerTwice => {
                self.trouble.doubled -= 1;
                if let Some(&copy) = self.answers.front() {
                    self.answers.push_front(match copy {
                        HostMessage::Report(report) => {
                            HostMessage::Report(StatusReport { doubled: true, ..report })
                        }
                        other => other,
                    });
                }
            }
            _ => _ = self.link.pop_front(),
        }
    }
}
