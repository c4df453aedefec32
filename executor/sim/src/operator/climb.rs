//! The third axis of the models: plunges and rises at random, and the way to a contact start from above.

use keepout_executor::operator::OperatorView;
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_planner::Mm2;

/// Plunges, rises and errands of a model.
#[derive(Clone, Debug, Default)]
pub struct Climb {
    /// Speed along the axis until the given time.
    up: f64,
    until: f64,
    command: Option<OperatorCommand>,
}

/// Height above which the tool crosses on the way to a contact start, and depth of that start, mm.
const CROSS_MM: f64 = 3.0;
const START_MM: f64 = -0.8;
/// Distance of the place beside the part where the tool lowers, mm.
const BESIDE_MM: f64 = 16.0;
/// Distance from that place at which it lowers, mm.
const NEAR_MM: f64 = 8.0;

impl Climb {
    /// The speed along the axis at `t` seconds. The model plunges as often as it rises, and sometimes starts an
    /// errand.
    pub fn step(&mut self, t: f64, random: &mut fastrand::Rng) -> f64 {
        if t >= self.until {
            self.until = t + 0.3 + 1.5 * random.f64();
            self.up = match random.u8(0..8) {
                0..3 => -random.f64().max(0.3),
                3 | 4 => random.f64().max(0.3),
                _ => 0.0,
            };
            self.command = match random.u8(0..24) {
                0 => Some(OperatorCommand::Raise),
                1 => Some(OperatorCommand::Cross { contour: 1 + random.usize(0..5) }),
                _ => None,
            };
        }
        self.up
    }

    /// The command that is due. Until the spindle runs, the model states that it runs, or asks for its start.
    pub fn command(&mut self, spindle_runs: bool) -> Option<OperatorCommand> {
        if !spindle_runs {
            return Some(OperatorCommand::Spindle { runs: true });
        }
        self.command.take()
    }
}

/// The way to a contact start from above: up, to a place beside the part, and down. `None` when the tool is beside
/// the part, below its top.
pub(super) fn to_contact(view: &OperatorView) -> Option<OperatorInput> {
    let (height_mm, position) = (view.height_mm?, view.position_mm?);
    let still = OperatorInput::default();
    let up = |up: f64| Some(OperatorInput { up, ..still });
    let beside = Mm2::new(view.part_box.low.x - BESIDE_MM, view.part_box.middle().y);
    let away = beside - position;
    if view.phase == Phase::Retracting {
        return up(1.0);
    }
    if height_mm <= START_MM / 2.0 && position.x <= view.part_box.low.x {
        return None;
    }
    if away.length() > NEAR_MM {
        if height_mm < CROSS_MM {
            return up(1.0);
        }
        let share = (away.length() / 400.0).clamp(0.05, 0.4);
        return Some(OperatorInput { velocity: away / away.length() * share, ..still });
    }
    up(-((height_mm - START_MM) / 60.0).clamp(0.05, 0.4))
}
