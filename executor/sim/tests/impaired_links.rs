//! Controllers of each dialect behind impaired lines, which lose, duplicate, swap, delay and damage chunks:
//! the session may stop, but the tool must not enter the part.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::session::{Going, NoEventLog, VirtualClock};
use keepout_executor::supervisor::{Abilities, PreparedPlan};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PassParameters;
use keepout_planner::request::PlanRequest;
use keepout_sim::faults::{ByteDamage, Faults, Rates};
use keepout_sim::session::{Scene, SimRun};
use keepout_sim::{Disturbance, PositioningError, SimMachine, SimSettings, VirtualPort, operator, speaking};

fn prepared_plan() -> PreparedPlan {
    let bytes = include_bytes!("../../cli/drawings/bracket.dxf");
    let mut request = PlanRequest::default();
    request.job.passes = vec![PassParameters { stock_to_leave_mm: 0.05, feed_mm_min: Some(3000) }];
    PreparedPlan::new(request.plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap())
}

/// The number of motions certified before the session ended.
fn run(work: &PreparedPlan, language: &str, seed: u64) -> u64 {
    let mut random = fastrand::Rng::with_seed(seed);
    let machine = MachineProfile::simulated();
    let run = SimRun { dialect: DialectName::named(language).unwrap(), seed, ..SimRun::default() };
    let mut scene = Scene::of(work.clone(), &run).unwrap();
    scene.setup.options.home = false;
    let settings = SimSettings::of(machine.clone(), Mm2::new(-1.0, -1.0).at_height(0.0));
    // From one fault in a hundred chunks to one in ten thousand.
    let often = 10.0_f64.powf(-2.0 * random.f64());
    let abilities = run.dialect.dialect(scene.setup.config).abilities();
    let (to_controller, to_host) = rates(abilities, often, seed);
    let positioning_error = PositioningError::wandering(machine.repeatability_mm, machine.steps_per_mm, seed);
    let latency = Duration::from_millis(random.u64(0..40));
    let machine = SimMachine::new(speaking(&run.dialect, settings), 115_200, latency, positioning_error)
        .hurt(Faults::new(to_controller, seed), Faults::new(to_host, seed + 1000));
    let mut monitor = scene.monitor();
    let operator = operator::named(["wall", "random", "reversal"][random.usize(0..3)], 8.0, seed).unwrap();
    let mut session = scene.setup.session(VirtualPort { machine }, operator, Box::new(NoEventLog));
    let mut samples = Vec::new();
    let disturbed = Time::from_micros(random.u64(0..60_000_000));
    let disturbance = if random.bool() { Disturbance::Reset } else { Disturbance::Alarm };
    let mut over = false;
    let mut clock = VirtualClock::default();
    let ended = session.run(&mut clock, Duration::from_secs(60), |session, now| {
        if now > disturbed && !over {
            over = true;
            session.port().unwrap().machine.disturb(disturbance, now);
        }
        session.port().unwrap().machine.take_samples(&mut samples);
        samples.drain(..).for_each(|sample| monitor.watch(&sample));
        Going::On
    });
    ended.unwrap();
    // The motion under way ends.
    let until = Time::from_micros(80_000_000);
    session.drain(until);
    session.port().unwrap().machine.take_samples(&mut samples);
    samples.drain(..).for_each(|sample| monitor.watch(&sample));
    assert!(monitor.deepest().is_none(), "{language} {seed}: {:?}", monitor.deepest());
    let counts = session.supervisor().counts();
    counts.jogs + counts.contour_motions
}

/// The fault rates toward the controller and toward the host.
fn rates(abilities: Abilities, often: f64, seed: u64) -> (Rates, Rates) {
    // Assumed (docs/safety/assumptions.md): where the session queues contours and counts their
    // acknowledgements, no line both duplicates and also loses or swaps chunks. Where an arc is given by its
    // centre, no arc arrives twice.
    let duplicates = abilities.checked || !abilities.queues || seed.is_multiple_of(2);
    let loses = abilities.checked || !abilities.queues || !duplicates;
    let arrives_twice = duplicates && (abilities.checked || !abilities.arcs);
    let to_host = Rates {
        lie: 0.0,
        delay: 0.01 * often,
        delay_max: Duration::from_millis(800),
        loss: if loses { 0.003 * often } else { 0.0 },
        doubling: if duplicates { 0.005 * often } else { 0.0 },
        swap: if loses { 0.003 * often } else { 0.0 },
        damage: 0.000_3 * often,
        noise: 0.001 * often,
        // Only a checksum detects a byte that became another byte of the dialect.
        kind: if abilities.checked { ByteDamage::Any } else { ByteDamage::Detectable },
    };
    let to_controller = Rates { doubling: if arrives_twice { to_host.doubling } else { 0.0 }, ..to_host };
    (to_controller, to_host)
}

#[test]
fn tool_never_enters_the_part_on_an_impaired_link() {
    let work = prepared_plan();
    let file = |name: &str| format!("{}/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let described = [
        "../dialects/nsk-style",
        "../dialects/tango",
        "tests/described/ok-style",
        "tests/described/one-answer",
    ];
    let languages = ["zaber", "venus"].map(String::from).into_iter().chain(described.map(file));
    for language in languages {
        let motions: u64 = (0..60).map(|seed| run(&work, &language, seed)).sum();
        println!("{language}: {motions} motions");
        assert!(motions > 300, "{language}: only {motions} certified motions");
    }
}
