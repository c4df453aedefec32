//! A cable to a simulated machine that can be pulled and plugged in again.

use std::cell::RefCell;
use std::rc::Rc;

use keepout_executor::session::Sample;
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::supervisor::PreparedPlan;
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_sim::session::{Scene, SimRun};
use keepout_sim::{PositioningError, SimMachine, SimSettings, speaking};

/// The machine at the end of a cable that can be pulled and plugged in again.
#[derive(Clone)]
pub struct Cable(pub Rc<RefCell<SimMachine>>);

impl Cable {
    pub fn to(work: &PreparedPlan, run: &SimRun, scene: &Scene) -> Self {
        let start = point_on_machine(work, scene);
        let sim = SimSettings {
            work_offset_mm: Mm2::new(-3.0, -4.0).at_height(0.0),
            ..SimSettings::of(run.machine.clone(), start.at_height(0.0))
        };
        let positioning_error = PositioningError::wandering(0.0, run.machine.steps_per_mm, 1);
        let machine = SimMachine::new(speaking(&run.dialect, sim), run.baud, run.latency, positioning_error);
        Self(Rc::new(RefCell::new(machine)))
    }

    pub fn samples(&self, now: Time) -> Vec<Sample> {
        let mut samples = Vec::new();
        self.0.borrow_mut().advance(now);
        self.0.borrow_mut().take_samples(&mut samples);
        samples
    }
}

fn point_on_machine(work: &PreparedPlan, scene: &Scene) -> Mm2 {
    let start = keepout_executor::session::start_inside(&work.plan).unwrap();
    keepout_planner::units::point_mm(start.translated(scene.offset()).unwrap())
}

impl Port for Cable {
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError> {
        let mut machine = self.0.borrow_mut();
        machine.host_writes(bytes, now);
        if machine.is_connected() { Ok(()) } else { Err(unplugged()) }
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        let mut machine = self.0.borrow_mut();
        machine.advance(now);
        machine.host_reads(into, now);
        if machine.is_connected() { Ok(()) } else { Err(unplugged()) }
    }

    fn next_event(&self) -> Time {
        self.0.borrow().next_event()
    }
}

pub fn unplugged() -> PortError {
    PortError::Lost { name: "test".into(), reason: "unplugged".into() }
}
