//! The operator's devices: gamepad, handwheel and keyboard. A thread of its own reads each device.

mod attended;
#[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "only Linux has input devices"))]
pub mod device;
#[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "only Linux has input devices"))]
mod gamepad;
pub mod handwheel;
mod key;
pub mod keyboard;
pub mod terminal;

pub use attended::{Attended, Endable};
pub use gamepad::Gamepad;
pub use terminal::{Keyboard, TerminalError};

#[cfg(test)]
mod testing {
    use keepout_executor::operator::{Operator, OperatorView};
    use keepout_executor::supervisor::{OperatorInput, Phase};
    use keepout_guard::Time;
    use keepout_planner::{Box2, Mm2};

    /// A view with the tool left of the part.
    pub fn view(phase: Phase) -> OperatorView {
        OperatorView {
            end_mm: None,
            unacknowledged: 0,
            spindle_runs: false,
            position_mm: Some(Mm2::new(-20.0, 10.0)),
            height_mm: None,
            wall_mm: Some(Mm2::new(0.0, 10.0)),
            part_box: Box2 { low: Mm2::ZERO, high: Mm2::new(100.0, 60.0) },
            phase,
            contoured: false,
        }
    }

    /// An operator who gives the listed inputs, one after the other.
    pub struct Scripted(std::vec::IntoIter<OperatorInput>);

    impl Scripted {
        pub fn new(inputs: Vec<OperatorInput>) -> Self {
            Self(inputs.into_iter())
        }
    }

    impl Operator for Scripted {
        fn input(&mut self, _: &OperatorView, _: Time) -> OperatorInput {
            self.0.next().unwrap_or_default()
        }
    }
}
