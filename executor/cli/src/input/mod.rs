//! The operator's devices: gamepad, handwheel and keyboard, each read by a thread of its own.

mod attended;
pub mod device;
mod gamepad;
pub mod handwheel;
pub mod keyboard;
mod stick;
pub mod terminal;

pub use attended::{Attended, Endable};
pub use gamepad::Gamepad;
pub use stick::{Stick, StickError, StickSettings};
pub use terminal::{Keyboard, TerminalError};

#[cfg(test)]
mod testing {
    use keepout_executor::operator::{Operator, OperatorView};
    use keepout_executor::supervisor::{OperatorInput, Phase};
    use keepout_guard::Time;

    /// What an operator sees in the middle of nowhere.
    pub fn view(phase: Phase) -> OperatorView {
        OperatorView {
            end_mm: None,
            unacknowledged: 0,
            position_mm: Some((-20.0, 10.0)),
            wall_mm: Some((0.0, 10.0)),
            part_box_mm: (0.0, 0.0, 100.0, 60.0),
            phase,
            contoured: false,
        }
    }

    /// An operator who inputs what it was told, one after the other.
    pub struct Told(std::vec::IntoIter<OperatorInput>);

    impl Told {
        pub fn new(inputs: Vec<OperatorInput>) -> Self {
            Self(inputs.into_iter())
        }
    }

    impl Operator for Told {
        fn input(&mut self, _: &OperatorView, _: Time) -> OperatorInput {
            self.0.next().unwrap_or_default()
        }
    }
}
