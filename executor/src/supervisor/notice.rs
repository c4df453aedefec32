//! What the supervisor tells the operator while a session runs.

use std::fmt;

use keepout_planner::Mm2;

use super::event::Text;

/// A notice to the operator. A notice that a decision gives while the tool moves holds no memory of its own.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// The controller accelerates harder than the plan's machine.
    Acceleration {
        /// Acceleration of the controller, mm/s².
        theirs: f64,
        /// Acceleration of the plan's machine, mm/s².
        ours: f64,
    },
    /// The tool is inside the jogging clearance.
    InsideClearance,
    /// The machine will be homed, and the tool is down.
    RaiseBeforeHoming,
    /// A raise or a crossing was stopped.
    ErrandStopped,
    /// The session has two axes, and the tool cannot be raised.
    NoRaise,
    /// The session has two axes, and the tool cannot cross above the part.
    NoCrossing,
    /// The plan has no contour with this number.
    UnknownContour(usize),
    /// The contour with this number lies beyond the travel.
    BeyondTravel(usize),
    /// The tool crosses to the contour with this number.
    Crossing(usize),
    /// A contour waits for the statement about the spindle.
    SpindleBeforeContour,
    /// A lowering waits for the statement about the spindle.
    SpindleAboveStock,
    /// The spindle starts after a second command.
    SpindleAsksAgain,
    /// The spindle is switched while the operator steers, and not now.
    SpindleBusy,
    /// The controller switched the spindle.
    Spindle {
        /// Whether it runs.
        runs: bool,
    },
    /// The operator jogged the tool away from the interrupted contour, to this place, mm.
    LedAway(Mm2),
    /// No contour begins, for this reason.
    NoContour(String),
    /// No link move leads to the loop with this name.
    Unreached(String),
    /// So much of the contour is cut again, mm.
    Recut(f64),
    /// The controller states motion, and its position does not change.
    StandsStill,
    /// The controller's own message.
    Controller(Text),
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Acceleration { theirs, ours } => write!(
                f,
                "the controller accelerates at {theirs:.0} mm/s², the plan's machine at {ours:.0} mm/s²: \
                 the margin holds the contour error of the plan's machine only. \
                 Set the controller to {ours:.0} mm/s², or plan with the acceleration of the controller"
            ),
            Self::InsideClearance => {
                f.write_str("the tool is inside the jogging clearance: only retract moves are possible")
            }
            Self::RaiseBeforeHoming => {
                f.write_str("raise the tool, because the machine will be homed. Then recover again.")
            }
            Self::ErrandStopped => f.write_str("stopped: the tool goes no farther by itself"),
            Self::NoRaise => f.write_str("this session has two axes: raise the tool by hand"),
            Self::NoCrossing => {
                f.write_str("this session has two axes: the tool cannot cross above the part")
            }
            Self::UnknownContour(number) => write!(f, "the plan has no contour {number}"),
            Self::BeyondTravel(number) => write!(f, "contour {number} is beyond the machine's travel"),
            Self::Crossing(number) => {
                write!(f, "crossing to contour {number}: up, across, and down to just above the stock")
            }
            Self::SpindleBeforeContour => {
                f.write_str("state whether the spindle runs before a contour begins")
            }
            Self::SpindleAboveStock => f.write_str(
                "the tool is just above the stock: state whether the spindle runs before it goes lower",
            ),
            Self::SpindleAsksAgain => {
                f.write_str("give the command again within 3 s, and the spindle starts: keep your hands off it")
            }
            Self::SpindleBusy => f.write_str(
                "the spindle is switched while you steer the tool: end the contour first, or use the spindle's own \
                 switch",
            ),
            Self::Spindle { runs: true } => f.write_str("the controller started the spindle"),
            Self::Spindle { runs: false } => f.write_str("the controller stopped the spindle"),
            Self::LedAway(Mm2 { x, y }) => write!(
                f,
                "at {x:.3},{y:.3} mm the contour does not go on, because you jogged the tool there: \
                 jog it farther from the part, then resume again"
            ),
            Self::NoContour(reason) => write!(f, "no contour: {reason}"),
            Self::Unreached(name) => {
                write!(f, "no link move outside the jogging clearance leads to {name}: jog the tool to it")
            }
            Self::Recut(mm) => {
                write!(f, "{mm:.2} mm are recut, because the contour enters before the resume point")
            }
            Self::StandsStill => f.write_str(
                "the controller states that it moves, but its position stands still: look at the machine, its drives \
                 and its feed override",
            ),
            Self::Controller(text) => f.write_str(text),
        }
    }
}
