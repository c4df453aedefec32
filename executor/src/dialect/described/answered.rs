//! The handling of answers: states, positions, and the steps that follow them.
//!
//! Implements SR-12, SR-18, SR-19.

use std::sync::Arc;

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{Place, UNITS_PER_MM};
use keepout_planner::Mm3;

use super::axes::Values;
use super::heard::{Asked, For, Heard};
use super::{Accepted, Described, NEAR_STEPS};
use crate::supervisor::{Limits, Mode, Reply, Report, Unfit, text};

impl Described {
    /// Ends the oldest exchange with its answer.
    pub(super) fn over(&mut self, heard: Option<Heard>, out: &mut Vec<u8>) -> Option<Reply> {
        if let (Some(Asked::Say(For::Nothing)), Some(Heard::Error { .. })) = (self.exchanges.open(), heard) {
            // The supervisor learns that the whole motion is rejected, so its other lines must not follow.
            self.exchanges.withdraw(|asked| matches!(asked, Asked::Say(purpose) if *purpose != For::Stop));
        }
        // The position query follows the state query directly: a waiting line would move the tool between the
        // two.
        if let (Some(Asked::Status(purpose)), Some(Heard::Status(_, None))) = (self.exchanges.open(), heard) {
            self.ask_position(purpose, out);
        }
        let asked = self.exchanges.close(out)?;
        match (asked, heard) {
            (_, Some(Heard::Error { code, transient })) => {
                // The supervisor can repeat only a rejected motion, and only where the answer shows which
                // line was rejected.
                let motion = matches!(asked, Asked::Say(For::Nothing | For::Jog));
                let transient = transient && motion && self.description.accepted != Accepted::Query;
                Some(Reply::Refused { code, meaning: "", transient })
            }
            (Asked::Say(purpose), None | Some(Heard::Accepted)) => self.acknowledged(purpose, out),
            (Asked::Status(purpose), Some(Heard::Status(mode, place))) => {
                self.seen(purpose, mode, place, out)
            }
            (Asked::Position(purpose), Some(Heard::Position(place))) => self.placed(purpose, place, out),
            _ => Some(Reply::Garbled(text("an exchange without its answer"))),
        }
    }

    /// Continues after the answer to the last line of a purpose.
    fn acknowledged(&mut self, purpose: For, out: &mut Vec<u8>) -> Option<Reply> {
        match purpose {
            For::Nothing | For::Stop | For::Query => None,
            For::Preparing => Some(Reply::Prepared(Limits::UNLIMITED)),
            For::Unfit => Some(Reply::Unfit(Unfit {
                name: "units.counts_per_mm",
                value: self.description.coordinate.scale.per_mm_f64(),
                needed: "at least the steps_per_mm of the plan's machine profile",
            })),
            For::Homing(_) => {
                self.ask_status(purpose, out);
                None
            }
            For::Arming => Some(Reply::Armed),
            For::Contour if !self.description.queues => {
                self.ask_status(For::Contour, out);
                None
            }
            For::Jog | For::Contour => Some(Reply::Accepted),
        }
    }

    /// Sends the next homing line when the tool rests after the previous one.
    pub(super) fn home(&mut self, done: u8, out: &mut Vec<u8>) -> Option<Reply> {
        let description = Arc::clone(&self.description);
        match description.home.get(usize::from(done)) {
            Some(line) => {
                let purpose = For::Homing(done.saturating_add(1));
                self.say(std::slice::from_ref(line), &Values::default(), purpose, out);
                None
            }
            None if done == 0 => {
                self.say(&[], &Values::default(), For::Homing(1), out);
                None
            }
            None => Some(Reply::Homed),
        }
    }

    /// Continues after an answer with a state.
    fn seen(&mut self, purpose: For, mode: Mode, place: Option<Mm3>, out: &mut Vec<u8>) -> Option<Reply> {
        match (purpose, mode) {
            (For::Contour, _) if self.description.queues => Some(Reply::Accepted),
            (For::Query | For::Contour, _) => {
                self.mode = mode;
                place.and_then(|place| self.placed(purpose, place, out))
            }
            (For::Homing(done), Mode::Idle) => self.home(done, out),
            (For::Homing(_), Mode::Alarm) => Some(Reply::Alarm { code: 0, meaning: "homing failed" }),
            _ => self.acknowledged(purpose, out),
        }
    }

    /// Continues after an answer with a position, which follows the state.
    fn placed(&mut self, purpose: For, place: Mm3, out: &mut Vec<u8>) -> Option<Reply> {
        let at = self.description.place(place);
        if purpose == For::Contour {
            return self.arrived(at, out);
        }
        let position = at.and_then(|at| self.setting.in_drawing(at).ok());
        match position {
            Some(_) => Some(Reply::Report(Report { mode: self.mode, position, queued: None, waiting: None })),
            None => Some(Reply::Garbled(text("a position off the lattice"))),
        }
    }

    /// Accepts a contour motion when the tool rests at its end. If the controller skipped the motion, the
    /// next one would begin elsewhere.
    fn arrived(&mut self, at: Option<Place>, out: &mut Vec<u8>) -> Option<Reply> {
        if self.mode == Mode::Moving {
            self.ask_status(For::Contour, out);
            return None;
        }
        let most = |steps_per_mm: f64| NEAR_STEPS * f64::from(UNITS_PER_MM) / steps_per_mm;
        let near = at.is_some_and(|at| {
            let off = at.point.minus(self.target.point);
            let below = (i64::from(at.height.units()) - i64::from(self.target.height.units())).abs();
            let near_height = self.setting.z.is_none_or(|z| below <= nearest_unit(most(z.steps_per_mm)));
            f64::from(off.dx.abs().max(off.dy.abs())) <= most(self.setting.steps_per_mm) && near_height
        });
        let meaning = "a motion of the contour was not executed";
        Some(match (self.mode, near) {
            (Mode::Idle, true) => Reply::Accepted,
            (Mode::Alarm, _) => Reply::Alarm { code: 0, meaning },
            _ => Reply::Refused { code: 0, meaning, transient: false },
        })
    }
}
