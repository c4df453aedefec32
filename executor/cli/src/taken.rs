//! The places that an operator takes while the place of the part is unknown.

use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase, Supervisor};
use keepout_guard::Time;
use keepout_kernel::Place;
use keepout_planner::Mm3;
use keepout_planner::units::{mm, point_mm};

/// Distance of the end of travel above height zero of the session's plan, mm.
pub const SAFE_MM: f64 = 1.0;
/// Longest time from the take key until the rest of the tool is confirmed.
const SETTLES_WITHIN: Duration = Duration::from_millis(500);

/// The places taken so far, machine coordinates, mm.
#[derive(Clone, Debug, Default)]
pub struct TakenPlaces {
    pub taken: Vec<Mm3>,
    /// A place that is not taken yet, because its rest is not confirmed, and the time of its key.
    asked: Option<(Mm3, Time)>,
}

/// What a moment of the session came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TakeOutcome {
    Nothing,
    /// A place was taken.
    Taken(Mm3),
    /// Why none was taken.
    Refused(&'static str),
}

impl TakenPlaces {
    /// Takes the place of the tool when it rests. `key`: the operator asks for it now.
    pub fn watch(&mut self, supervisor: &Supervisor, key: bool, now: Time) -> TakeOutcome {
        let position = on_machine(supervisor);
        if key {
            match position.filter(|_| is_ready(supervisor)) {
                Some(at) => self.asked = Some((at, now)),
                None => {
                    return TakeOutcome::Refused(
                        "not taken: the session is not ready. Take again when it is.",
                    );
                }
            }
        }
        let Some((at, asked)) = self.asked else { return TakeOutcome::Nothing };
        if position != Some(at) || now.since(asked) >= SETTLES_WITHIN {
            self.asked = None;
            return TakeOutcome::Refused(
                "not taken: the machine moves. Let it come to rest, and take again.",
            );
        }
        if !rests(supervisor) {
            return TakeOutcome::Nothing;
        }
        self.asked = None;
        self.taken.push(at);
        TakeOutcome::Taken(at)
    }
}

fn is_ready(supervisor: &Supervisor) -> bool {
    matches!(supervisor.phase(), Phase::Manual | Phase::Sliding)
}

/// Whether the tool rests at a confirmed place.
pub fn rests(supervisor: &Supervisor) -> bool {
    is_ready(supervisor) && supervisor.is_at_rest() && supervisor.guard().in_position()
}

/// The machine's own position, mm.
pub fn on_machine(supervisor: &Supervisor) -> Option<Mm3> {
    let zero_mm = if supervisor.height_mm().is_some() { -SAFE_MM } else { 0.0 };
    let in_machine = |place: Place| point_mm(place.point).at_height(mm(place.height.units()) + zero_mm);
    supervisor.position().map(in_machine)
}

/// An operator who states first that the spindle stands.
pub struct SpindleStands<O> {
    operator: O,
    stated: bool,
}

impl<O: Operator> SpindleStands<O> {
    /// `climbs`: whether the session has a third axis, and needs the statement.
    pub fn new(operator: O, climbs: bool) -> Self {
        Self { operator, stated: !climbs }
    }
}

impl<O: Operator> Operator for SpindleStands<O> {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        self.operator.input(view, now)
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        if !std::mem::replace(&mut self.stated, true) {
            return Some(OperatorCommand::Spindle { runs: false });
        }
        self.operator.command()
    }

    fn every(&self) -> Duration {
        self.operator.every()
    }
}
