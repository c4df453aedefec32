//! The flexible selection of section 8 and Fig. 23: the controller for a contour, a feed, a model and an
//! amplifier.

use super::kind::Kind;
use crate::drive::Drive;
use crate::plant::Friction;
use crate::profile::DriveProfile;
use crate::run::Task;

/// The conditions for the choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Largest deviation of the drives from the model, as a share.
    pub model_error: f64,
    /// Fastest change of the path's direction on its curves, rad/s.
    pub turning: f64,
    /// Whether the path has corners.
    pub corners: bool,
    /// Whether friction or a cutting force acts on the axes.
    pub disturbed: bool,
    /// Whether the axes agree within the model error or 1 %.
    pub matched: bool,
    /// Whether the inverse of a drive exceeds the amplifier's limit at the step to the feed.
    pub saturates: bool,
}

/// Largest model error for feedforward. Alone it helps only "when the modeling error is less than 0.5%". With
/// cross-coupling 1 % is acceptable.
const WELL_KNOWN: f64 = 0.01;
/// Change of direction from which a curve counts as fast, rad/s: 0.4 m/min on the paper's circle.
const QUICK: f64 = 1.0 / 3.0;

impl Environment {
    /// The conditions of a task. Its drives deviate from the model by at most the share `model_error`.
    #[must_use]
    pub fn of(task: &Task, model_error: f64) -> Self {
        let pieces = task.path.pieces();
        let turning =
            pieces.iter().map(|piece| piece.at(0.0).curvature.abs() * task.feed).fold(0.0, f64::max);
        let [x, y] = task.plant.drives();
        let alike = |a: f64, b: f64| (a - b).abs() <= model_error.max(0.01) * a.max(b);
        let jump =
            |drive: Drive| task.feed / drive.gain / -(-task.plant.period_s / drive.time_constant_s).exp_m1();
        Self {
            model_error,
            turning,
            corners: pieces.windows(2).any(|pair| pair[0].turns_to(&pair[1])),
            disturbed: task.cutting.is_some()
                || task.plant.axes.iter().any(|axis| axis.friction != Friction::None),
            matched: alike(x.gain, y.gain) && alike(x.time_constant_s, y.time_constant_s),
            saturates: task.plant.limit.is_some_and(|limit| jump(x).max(jump(y)) > limit),
        }
    }

    /// The conditions of a machine in jog mode. The path is unknown, so all conditions are the worst.
    #[must_use]
    pub fn of_hand(profile: &DriveProfile) -> Self {
        let model_error = profile.uncertainty.largest();
        Self {
            model_error,
            turning: f64::INFINITY,
            corners: true,
            disturbed: true,
            matched: false,
            saturates: true,
        }
    }

    /// The choice, by the rules of section 8:
    ///
    /// 1. P "only when cutting a contour on a machine with small friction, small cutting loads, small
    ///    mismatch in axial parameters, and conventional feedrates";
    /// 2. IKF for a path with corners that saturates the amplifier, if the model is accurate and no load acts
    ///    (Fig. 18);
    /// 3. cross-coupling with feedforward for corners and fast curves, if the model is accurate and the
    ///    amplifier does not saturate (Fig. 23);
    /// 4. cross-coupling "under any condition".
    #[must_use]
    pub fn choice(&self) -> Kind {
        let well_known = self.model_error <= WELL_KNOWN;
        let bends = self.corners || self.turning >= QUICK;
        if !self.disturbed && self.matched && !bends {
            Kind::P
        } else if well_known && self.corners && self.saturates && !self.disturbed {
            Kind::Ikf
        } else if well_known && bends && !self.saturates {
            Kind::CccFeedforward
        } else {
            Kind::Ccc
        }
    }
}
