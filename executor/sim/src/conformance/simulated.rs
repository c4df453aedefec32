//! Scenarios at a simulated controller, in virtual time.

use std::time::Duration;

use keepout_executor::session::VirtualClock;
use keepout_planner::Mm2;

use super::error::RecordError;
use super::record::{Bench, ScenarioRecorder};
use super::recording::Recording;
use super::scenario::Scenario;
use super::start::{Setup, Start};
use crate::{PositioningError, Quirks, SimMachine, SimSettings, SimulatedController, VirtualPort, speaking};

/// The simulated machine.
#[derive(Clone, Debug)]
pub struct SimulatedBench {
    /// The set-up of the recording.
    pub setup: Setup,
    /// The tool's start, machine coordinates.
    pub at: Mm2,
    /// Baud rate of the line.
    pub baud: u32,
    /// Optional behaviour of the controller.
    pub quirks: Quirks,
}

/// Delay of the line each way, as with a USB adapter.
const DELAY: Duration = Duration::from_millis(1);
/// Longest time to store a setting.
const STORES_WITHIN: Duration = Duration::from_secs(1);

/// Plays the scenarios at the simulated controller of the set-up's dialect.
///
/// # Errors
/// [`RecordError`] as at a port.
pub fn simulate(setting: &SimulatedBench, scenarios: &[Scenario]) -> Result<Recording, RecordError> {
    simulate_with(|settings| speaking(&setting.setup.language, settings), setting, scenarios)
}

/// Plays the scenarios at the controller that `build` makes from the settings.
///
/// # Errors
/// [`RecordError`] as at a port.
pub fn simulate_with(
    build: impl FnOnce(SimSettings) -> Box<dyn SimulatedController>,
    setting: &SimulatedBench,
    scenarios: &[Scenario],
) -> Result<Recording, RecordError> {
    let machine = setting.setup.machine.clone();
    let setup = Setup { start: Start::Standing, ..setting.setup.clone() };
    let positioning_error = PositioningError::wandering(0.0, machine.steps_per_mm, 1);
    let settings = SimSettings {
        quirks: setting.quirks.clone(),
        ..SimSettings::of(machine, Mm2::new(setting.at.x, setting.at.y).at_height(0.0))
    };
    let mut port =
        VirtualPort { machine: SimMachine::new(build(settings), setting.baud, DELAY, positioning_error) };
    let mut clock = VirtualClock::default();
    let bench = Bench {
        port: &mut port,
        clock: &mut clock,
        tool: |port: &mut VirtualPort, into| port.machine.take_samples(into),
    };
    let mut recorder = ScenarioRecorder::begin(bench, setup)?;
    recorder.ask("$10=3", STORES_WITHIN)?;
    scenarios.iter().try_for_each(|scenario| recorder.play(scenario))?;
    Ok(recorder.finish())
}
