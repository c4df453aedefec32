//! Meaning of the buttons and axes of a device.

use keepout_executor::supervisor::OperatorCommand;

/// Action of a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Enables the stick while the operator holds it.
    DeadMan,
    /// Arms or disarms the cycle at each press.
    Arm,
    /// Gives an operator command.
    OperatorCommand(OperatorCommand),
    /// Moves the third axis while the operator holds it, upward or downward, if the stick is enabled.
    Lift(Lift),
    /// Selects the next axis for the handwheel.
    WheelAxis,
    /// Selects the next step size of the handwheel.
    WheelStep,
}

/// A direction of the third axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lift {
    /// Upward.
    Up,
    /// Downward.
    Down,
}

/// Axes, dials and buttons by their evdev codes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mapping {
    /// The stick's axes, x and y.
    pub axes: (u16, u16),
    /// Relative axes that are handwheels.
    pub wheels: Vec<u16>,
    /// Buttons.
    pub buttons: Vec<(u16, Action)>,
}

/// `ABS_X` and `ABS_Y`: the left stick of a gamepad, the stick of a joystick.
const STICK: (u16, u16) = (0x00, 0x01);
/// `REL_DIAL`, and `REL_WHEEL`.
const WHEELS: [u16; 2] = [0x07, 0x08];

/// The table of buttons. A device has only the buttons of its kind.
///
/// | gamepad | joystick | pulse generator | does |
/// |---|---|---|---|
/// | left or right shoulder | trigger | | dead-man |
/// | start | top | fifth button | cycle armed, on or off |
/// | east (B, ○) | thumb | third | pause (feed hold) |
/// | south (A, ×) | second thumb | fourth | resume (cycle start) |
/// | north (Y, △) | second top | | recover |
/// | lower left, lower right shoulder | third, fourth (base) | | down, up |
/// | west (X, □) | | | raise to the safe height |
/// | mode (the logo) | seventh (base) | | quit |
/// | select, left stick pressed | | first, second | next axis, next step of the handwheel |
const BUTTONS: [(u16, Action); 25] = [
    (0x136, Action::DeadMan),                                      // BTN_TL
    (0x137, Action::DeadMan),                                      // BTN_TR
    (0x13b, Action::Arm),                                          // BTN_START
    (0x131, Action::OperatorCommand(OperatorCommand::FeedHold)),   // BTN_EAST
    (0x130, Action::OperatorCommand(OperatorCommand::CycleStart)), // BTN_SOUTH
    (0x133, Action::OperatorCommand(OperatorCommand::Recover)),    // BTN_NORTH
    (0x134, Action::OperatorCommand(OperatorCommand::Raise)),      // BTN_WEST
    (0x138, Action::Lift(Lift::Down)),                             // BTN_TL2
    (0x139, Action::Lift(Lift::Up)),                               // BTN_TR2
    (0x13c, Action::OperatorCommand(OperatorCommand::Stop)),       // BTN_MODE
    (0x13a, Action::WheelAxis),                                    // BTN_SELECT
    (0x13d, Action::WheelStep),                                    // BTN_THUMBL
    (0x120, Action::DeadMan),                                      // BTN_TRIGGER
    (0x123, Action::Arm),                                          // BTN_TOP
    (0x121, Action::OperatorCommand(OperatorCommand::FeedHold)),   // BTN_THUMB
    (0x122, Action::OperatorCommand(OperatorCommand::CycleStart)), // BTN_THUMB2
    (0x124, Action::OperatorCommand(OperatorCommand::Recover)),    // BTN_TOP2
    (0x126, Action::OperatorCommand(OperatorCommand::Stop)),       // BTN_BASE
    (0x128, Action::Lift(Lift::Down)),                             // BTN_BASE3
    (0x129, Action::Lift(Lift::Up)),                               // BTN_BASE4
    (0x100, Action::WheelAxis),                                    // BTN_0
    (0x101, Action::WheelStep),                                    // BTN_1
    (0x102, Action::OperatorCommand(OperatorCommand::FeedHold)),   // BTN_2
    (0x103, Action::OperatorCommand(OperatorCommand::CycleStart)), // BTN_3
    (0x104, Action::Arm),                                          // BTN_4
];

impl Default for Mapping {
    fn default() -> Self {
        Self { axes: STICK, wheels: WHEELS.to_vec(), buttons: BUTTONS.to_vec() }
    }
}

impl Mapping {
    /// The action of a button, if it has one.
    #[must_use]
    pub fn action(&self, code: u16) -> Option<Action> {
        self.buttons.iter().find(|button| button.0 == code).map(|button| button.1)
    }

    /// The buttons with an action.
    pub fn with(&self, action: Action) -> impl Iterator<Item = u16> + '_ {
        self.buttons.iter().filter(move |button| button.1 == action).map(|button| button.0)
    }
}
