//! Checks that a step of a controller and of the plant allocates no memory.

use keepout_drives::controllers::kind::Kind;
use keepout_drives::plant::Plant;
use keepout_drives::profile::DriveProfile;
use keepout_drives::reference::ReferenceWindow;
use keepout_studies::koren_lo::comparison::{ModelError, Row};
use keepout_studies::koren_lo::scenario::DriveScenario;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

#[test]
fn controller_steps_allocate_no_memory() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let mut steps = 0;
    for scenario in DriveScenario::built_in().unwrap() {
        let row = Row::new(&scenario, &DriveProfile::load(&scenario.machine).unwrap());
        for kind in Kind::ALL {
            let setting = row.setting(ModelError::crossed(0.05));
            let samples = &row.task.reference;
            let mut blocks = Vec::new();
            // The profiler counts all threads. The test runner may allocate during the first run, but not in
            // every run.
            while blocks.last() != Some(&0) && blocks.len() < 3 {
                let Some(mut controller) = kind.built(&setting) else { break };
                let mut plant = Plant::at_rest(row.task.plant, samples[0].position());
                let before = dhat::HeapStats::get().total_blocks;
                for (now, sample) in samples.iter().enumerate().take(1500) {
                    let command = controller.step(&ReferenceWindow::new(samples, now), plant.measured());
                    plant.step(command, &row.task.load(sample));
                    steps += 1;
                }
                blocks.push(dhat::HeapStats::get().total_blocks - before);
            }
            assert!(
                blocks.last().is_none_or(|blocks| *blocks == 0),
                "{} {kind:?}: {blocks:?}",
                scenario.name
            );
        }
    }
    assert!(steps > 100_000, "{steps}");
}
