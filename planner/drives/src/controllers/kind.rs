//! The kinds of controllers and their names.

use serde::{Deserialize, Serialize};

use super::adaptive::Adaptive;
use super::contouring::{self, Contouring};
use super::cross_coupling::{CrossCoupling, ErrorEstimate};
use super::drive_feedforward::DriveFeedforward;
use super::exact_inverse::ExactInverse;
use super::inverse_filter::InverseFilter;
use super::matching::Matching;
use super::optimal::linear_quadratic;
use super::optimal_cross_coupling::OptimalCrossCoupling;
use super::pid::{self, Pid, Structure};
use super::pid_zero_phase::PidZeroPhase;
use super::predictive::{self, Predictive};
use super::proportional::Proportional;
use super::repetitive::Repetitive;
use super::selection::Environment;
use super::state_feedback::StateFeedback;
use super::zero_phase::ZeroPhase;
use super::{Belief, Controller};
use crate::gains::{Design, Gains};
use crate::plant::MOST_DELAY;

/// A kind of controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "names() describes each kind")]
pub enum Kind {
    P,
    Pid,
    PidB,
    PidC,
    PidD,
    PidCorners,
    PidZpetc,
    StateFeedback,
    ExactInverse,
    #[serde(rename = "drive-ff")]
    DriveFeedforward,
    Zpetc,
    Ikf,
    Ccc,
    #[serde(rename = "ccc-ff")]
    CccFeedforward,
    CccExact,
    Lq,
    OptimalCcc,
    Gpc,
    AdaptiveZpetc,
    Matching,
    Repetitive,
    Selection,
    Contouring,
}

/// The parameters of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The model of the drives.
    pub belief: Belief,
    /// Gains of the paper's controllers.
    pub gains: Gains,
    /// The conditions for the selection of section 8.
    pub environment: Environment,
    /// Samples per round, if the path repeats.
    pub round: Option<usize>,
}

impl Kind {
    /// All kinds, in the paper's order.
    pub const ALL: [Self; 23] = [
        Self::P,
        Self::Pid,
        Self::PidB,
        Self::PidC,
        Self::PidD,
        Self::PidCorners,
        Self::PidZpetc,
        Self::StateFeedback,
        Self::ExactInverse,
        Self::DriveFeedforward,
        Self::Zpetc,
        Self::Ikf,
        Self::Ccc,
        Self::CccFeedforward,
        Self::CccExact,
        Self::Lq,
        Self::OptimalCcc,
        Self::Gpc,
        Self::AdaptiveZpetc,
        Self::Matching,
        Self::Repetitive,
        Self::Selection,
        Self::Contouring,
    ];

    /// The short name and the title.
    #[must_use]
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::P => ("p", "P"),
            Self::Pid => ("pid", "PID"),
            Self::PidB => ("pid-b", "PID, D of the position (Fig. 4b)"),
            Self::PidC => ("pid-c", "I-PD (Fig. 4c)"),
            Self::PidD => ("pid-d", "P around PI (Fig. 4d)"),
            Self::PidCorners => ("pid-corners", "PID, I off at corners"),
            Self::PidZpetc => ("pid-zpetc", "PID with ZPETC"),
            Self::StateFeedback => ("state-feedback", "state feedback with I"),
            Self::ExactInverse => ("exact-inverse", "P with exact inverse (Fig. 5a)"),
            Self::DriveFeedforward => ("drive-ff", "P with drive feedforward (Fig. 5b)"),
            Self::Zpetc => ("zpetc", "ZPETC"),
            Self::Ikf => ("ikf", "IKF"),
            Self::Ccc => ("ccc", "CCC"),
            Self::CccFeedforward => ("ccc-ff", "CCC with drive feedforward (Fig. 23)"),
            Self::CccExact => ("ccc-exact", "CCC with the exact contour error"),
            Self::Lq => ("lq", "optimal (LQ)"),
            Self::OptimalCcc => ("optimal-ccc", "optimal CCC"),
            Self::Gpc => ("gpc", "GPC"),
            Self::AdaptiveZpetc => ("adaptive-zpetc", "adaptive ZPETC"),
            Self::Matching => ("matching", "adaptive matching"),
            Self::Repetitive => ("repetitive", "repetitive P"),
            Self::Selection => ("selection", "flexible selection (section 8)"),
            Self::Contouring => ("contouring", "contouring MPC with observer"),
        }
    }

    /// Number of samples that the controller looks ahead.
    #[must_use]
    pub fn preview(self) -> usize {
        match self {
            Self::Contouring => contouring::HORIZON + MOST_DELAY,
            Self::Gpc => predictive::HORIZON,
            Self::PidCorners => pid::MOST_AHEAD,
            // Zero-phase inverses look two samples ahead.
            _ => 2,
        }
    }

    /// The kind with this short name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.names().0 == name)
    }

    /// A controller of this kind, at rest. `None` if it does not exist for this setting.
    ///
    /// A repetitive controller needs a path that repeats. An optimal controller needs an optimum.
    #[must_use]
    pub fn built(self, setting: &Setting) -> Option<Box<dyn Controller>> {
        let Setting { belief, gains: Gains { proportional, pid, cross_coupling, design }, .. } = *setting;
        let Design { quickness, index, contour, predictive_effort, contouring } = design;
        let period_s = belief.period_s;
        let in_structure = |structure| Box::new(Pid::new(structure, pid, period_s));
        let coupled = |estimate| CrossCoupling::new(&belief, proportional, cross_coupling, estimate);
        Some(match self {
            Self::P => Box::new(Proportional { gain: proportional }),
            Self::Pid => in_structure(Structure::OnError),
            Self::PidB => in_structure(Structure::DerivativeOnPosition),
            Self::PidC => in_structure(Structure::IntegralOnError),
            // The derivative gain is the gain of its speed loop, so it must not be zero.
            Self::PidD if pid.derivative == 0.0 => return None,
            Self::PidD => in_structure(Structure::Cascade),
            Self::PidCorners => {
                Box::new(Pid::new(Structure::OnError, pid, period_s).without_integral_at_corners(&belief))
            }
            Self::PidZpetc => Box::new(PidZeroPhase::new(&belief, pid)),
            Self::StateFeedback => Box::new(StateFeedback::new(&belief, quickness)),
            Self::ExactInverse => Box::new(ExactInverse::new(&belief, proportional)),
            Self::DriveFeedforward => Box::new(DriveFeedforward::new(&belief, proportional)),
            Self::Zpetc => Box::new(ZeroPhase::new(&belief, proportional)),
            Self::Ikf => Box::new(InverseFilter::new(&belief, proportional)),
            Self::Ccc => Box::new(coupled(ErrorEstimate::Modelled)),
            Self::CccFeedforward => Box::new(coupled(ErrorEstimate::Modelled).with_feedforward(&belief)),
            Self::CccExact => Box::new(coupled(ErrorEstimate::Exact)),
            Self::Lq => Box::new(linear_quadratic(&belief, index)?),
            Self::OptimalCcc => Box::new(OptimalCrossCoupling::new(&belief, index, contour)?),
            Self::Gpc => Box::new(Predictive::new(&belief, predictive_effort)?),
            Self::AdaptiveZpetc => Box::new(Adaptive::new(&belief, proportional)),
            Self::Matching => Box::new(Matching::new(&belief, proportional)),
            Self::Repetitive => Box::new(Repetitive::new(&belief, proportional, setting.round?)),
            // The choice is one of the kinds above, never Selection itself.
            Self::Selection => return setting.environment.choice().built(setting),
            Self::Contouring => Box::new(Contouring::new(&belief, contouring)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_name_each_kind_as_commands_do() {
        #[derive(Deserialize)]
        struct Named {
            kind: Kind,
        }
        for kind in Kind::ALL {
            let text = format!("kind = \"{}\"", kind.names().0);
            assert_eq!(toml::from_str::<Named>(&text).unwrap().kind, kind);
            assert_eq!(Kind::named(kind.names().0), Some(kind));
        }
    }
}
