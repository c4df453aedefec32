//! The start of a session: connection, settings, homing and location of the tool. Also the recovery after a
//! fault.
//!
//! Implements SR-11, SR-19.

use keepout_guard::{OnCancel, Time};
use keepout_kernel::UNITS_PER_MM;
use keepout_kernel::curve::round_down;

use super::event::{Command, Mode, Reply, Report};
use super::jog::JogPlanner;
use super::notice::Notice;
use super::state::State;
use super::{Fault, Limits, Supervisor};

impl Supervisor {
    pub(super) fn connected(
        &mut self,
        report: &Report,
        now: Time,
        commands: &mut Vec<Command>,
    ) -> Result<(), Fault> {
        match report.mode {
            Mode::Idle => {}
            Mode::Alarm if self.homes => {}
            Mode::Alarm => return Err(Fault::NotHomed),
            // After a fault, the controller may still run to its last certified target, or someone holds it.
            Mode::Moving | Mode::Slowing => return Ok(()),
            Mode::Held => {
                commands.push(Command::Abort);
                return Ok(());
            }
            mode => return Err(Fault::Unexpected { mode }),
        }
        commands.push(Command::Prepare);
        self.start_step_at = now;
        self.state = State::Preparing;
        Ok(())
    }

    /// Takes the answer to a step of the start, and begins the next step.
    pub(super) fn start_on(&mut self, reply: &Reply, commands: &mut Vec<Command>) {
        match (&self.state, reply) {
            (State::Preparing, Reply::Prepared(limits)) => {
                self.note_of_acceleration(*limits);
                self.limits = self.limits.least(*limits);
                let on_cancel = self.on_cancel();
                self.guard.learn_of_cancels(on_cancel, deceleration(self.least_acceleration_mm_s2()));
                if self.homes {
                    commands.push(Command::Home);
                    self.state = State::Homing;
                } else {
                    commands.push(Command::Arm);
                    self.state = State::Arming;
                }
            }
            (State::Homing, Reply::Homed) => {
                commands.push(Command::Arm);
                self.state = State::Arming;
            }
            (State::Arming, Reply::Armed) => self.state = State::Locating { seen: None },
            _ => {}
        }
    }

    /// The behaviour on a cancel, from the dialect and the machine profile. A measured departure from the
    /// path overrides the dialect. A measurement without a departure proves nothing.
    fn on_cancel(&self) -> OnCancel {
        let stated = self.abilities.on_cancel;
        let controller = self.work.plan.plan.machine.controller.as_ref();
        match controller.and_then(|controller| controller.keeps_path_on_cancel) {
            Some(false) if stated == OnCancel::KeepsPath => OnCancel::MayStray,
            _ => stated,
        }
    }

    /// The least acceleration of the machine's axes, mm/s². The supervisor's limits are those of x and y. For the
    /// third axis the machine profile counts, because no controller with a cancel states its acceleration.
    fn least_acceleration_mm_s2(&self) -> f64 {
        let z = self.work.plan.plan.machine.z.as_ref();
        z.map_or(f64::INFINITY, |z| z.acceleration_mm_s2).min(self.limits.acceleration_mm_s2)
    }

    /// Notes an acceleration above that of the machine profile. The margin holds the contour error at the
    /// profile's acceleration, and drives leave the path farther at a higher one.
    fn note_of_acceleration(&mut self, controller: Limits) {
        let (theirs, ours) = (controller.quicker_mm_s2, self.work.plan.plan.machine.acceleration_mm_s2);
        if theirs.is_finite() && theirs > 1.05 * ours {
            self.note(Notice::Acceleration { theirs, ours });
        }
    }

    pub(super) fn take_place(&mut self, report: &Report) -> Result<(), Fault> {
        let (Mode::Idle, Some(at)) = (report.mode, report.position) else { return Ok(()) };
        if let State::Locating { seen } = &mut self.state
            && !self.abilities.checked
            && seen.replace(at) != Some(at)
        {
            return Ok(());
        }
        self.guard.locate(at).map_err(|refusal| Fault::InsidePart { at: at.point, refusal })?;
        // Only here: a fault before this point may have left homing incomplete.
        self.homes = false;
        self.unrecovered = None;
        self.state = if self.guard.is_inside_jogging_clearance() {
            self.note(Notice::InsideClearance);
            State::Retracting(JogPlanner::default())
        } else {
            State::Manual(JogPlanner::default())
        };
        Ok(())
    }

    // Implements SR-24.
    /// Begins again after a fault. The machine is homed if the controller may have lost its position, or if
    /// homing is incomplete. The operator then commands it twice, because the tool must be raised first.
    pub(super) fn recover(&mut self, now: Time) {
        let State::Faulted { fault, warned } = &mut self.state else { return };
        let homes = self.homes || fault.loses_position();
        if homes && !*warned {
            *warned = true;
            self.note(Notice::RaiseBeforeHoming);
            return;
        }
        self.homes = homes;
        self.unrecovered = Some(*fault);
        self.guard.forget();
        self.operation.rejected = 0;
        self.polling.restart(now);
        self.operation.armed = false;
        self.state = State::Connecting { garbled: None };
    }
}

/// A deceleration in lattice units per s², rounded down. `None` when it is unknown. A lower deceleration makes
/// the stopping distance longer.
fn deceleration(mm_s2: f64) -> Option<u64> {
    let units = mm_s2 * f64::from(UNITS_PER_MM);
    (units >= 1.0 && units.is_finite()).then(|| u64::try_from(round_down(units)).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-11.
    #[test]
    fn deceleration_is_never_above_the_stated_one() {
        for (mm_s2, units) in
            [(0.1, 10_000), (1000.0, 100_000_000), (5368.75, 536_875_000), (1e6, 100_000_000_000)]
        {
            assert_eq!(deceleration(mm_s2), Some(units), "{mm_s2} mm/s²");
        }
        assert_eq!(deceleration(1e-5 / 2.0), None, "less than a unit");
        assert!(deceleration(1e300).is_some_and(|units| units < u64::MAX));
        assert_eq!(deceleration(f64::INFINITY), None);
        assert_eq!(deceleration(f64::NAN), None);
    }
}
