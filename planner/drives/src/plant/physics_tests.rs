//! Pre-sliding friction and resonance.

use super::axis::Acting;
use super::*;

const DRIVE: Drive = Drive { gain: 10.0, time_constant_s: 0.045 };
const COULOMB: f64 = 100.0;
const STICTION: f64 = 130.0;
/// The distance that the Coulomb friction gives, pulses.
const GIVES: f64 = 2.0;
/// Speed of the Stribeck curve, pulses/s.
const STRIBECK: f64 = 100.0;

fn sliding() -> Axis {
    Axis {
        friction: Friction::Stick { coulomb: COULOMB, stiction: STICTION },
        presliding: Some(Presliding::of(DRIVE, COULOMB, GIVES, STRIBECK)),
        ..Axis::ideal(DRIVE)
    }
}

fn on_spring(drive: Drive, frequency_hz: f64, damping: f64, table_share: f64) -> Axis {
    let angular = frequency_hz * std::f64::consts::TAU;
    Axis { resonance: Some(Resonance { angular, damping, table_share }), ..Axis::ideal(drive) }
}

fn under(command: f64) -> Acting {
    Acting { command, force: 0.0, reference_velocity: 0.0 }
}

/// The positions after each period of 1 ms under commands.
fn positions(axis: &Axis, commands: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut motion = AxisMotion::default();
    let after = |command: f64| {
        motion = axis.after(motion, &under(command), 0.001);
        motion.table.position
    };
    commands.into_iter().map(after).collect()
}

/// The equations of the paper, by the classic Runge-Kutta method in steps of 1 µs.
fn by_runge_kutta(commands: &[f64]) -> Vec<f64> {
    let stiffness = COULOMB / GIVES;
    let damping = (stiffness * DRIVE.time_constant_s / DRIVE.gain).sqrt();
    let rate = |[_, v, z]: [f64; 3], command: f64| {
        let level = COULOMB + (STICTION - COULOMB) * (-(v / STRIBECK).powi(2)).exp();
        let growth = v - stiffness * v.abs() / level * z;
        let force = stiffness * z + damping * growth;
        [v, (DRIVE.gain * (command - force) - v) / DRIVE.time_constant_s, growth]
    };
    let plus = |state: [f64; 3], by: [f64; 3], share: f64| std::array::from_fn(|i| state[i] + by[i] * share);
    let (mut state, step) = ([0.0; 3], 1e-6);
    let mut found = Vec::new();
    for &command in commands {
        for _ in 0..1000 {
            let one = rate(state, command);
            let two = rate(plus(state, one, step / 2.0), command);
            let three = rate(plus(state, two, step / 2.0), command);
            let four = rate(plus(state, three, step), command);
            state = std::array::from_fn(|i| {
                state[i] + step / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i])
            });
        }
        found.push(state[0]);
    }
    found
}

#[test]
fn presliding_follows_its_equations() {
    // Below the friction, above it, back, through a reversal, and to rest.
    let phases = [(40, 90.0), (60, 240.0), (40, 60.0), (80, -260.0), (60, -90.0), (40, 0.0)];
    let commands: Vec<f64> =
        phases.iter().flat_map(|&(count, bits)| std::iter::repeat_n(bits, count)).collect();
    let [ours, theirs] = [positions(&sliding(), commands.iter().copied()), by_runge_kutta(&commands)];
    let largest = theirs.iter().fold(0.0_f64, |most, position| most.max(position.abs()));
    for (ours, theirs) in ours.iter().zip(&theirs) {
        assert!((ours - theirs).abs() < 2e-4 * largest, "{ours} {theirs} of {largest}");
    }
}

/// Below the friction the axis gives like a spring. After the command ends, it keeps a part of the way (the hysteresis
/// of pre-sliding, Canudas de Wit et al. 1995, section III).
#[test]
fn axis_gives_before_it_slides_and_keeps_a_part() {
    let found = positions(&sliding(), std::iter::repeat_n(50.0, 300).chain(std::iter::repeat_n(0.0, 300)));
    let given = found[299];
    // A spring without the bristles' slip would give 1 pulse.
    assert!(given > 1.0 && given < 1.5, "{given}");
    let kept = found[599];
    assert!(kept > 0.05 && kept < 0.5 * given, "{kept}");
    let rigid = Axis { presliding: None, ..sliding() };
    assert_eq!(positions(&rigid, [50.0; 300])[299], 0.0);
}

/// Friction that gives by very little is sticking friction.
#[test]
fn stiff_presliding_is_sticking_friction() {
    let presliding = Some(Presliding::of(DRIVE, COULOMB, 0.002, 1.0));
    let stiff = Axis { presliding, ..sliding() };
    let commands = || [200.0; 100].into_iter().chain([-200.0; 100]);
    let [stiff, stick] =
        [stiff, Axis { presliding: None, ..sliding() }].map(|axis| positions(&axis, commands()));
    for (stiff, stick) in stiff.iter().zip(&stick) {
        assert!((stiff - stick).abs() < 0.05, "{stiff} {stick}");
    }
}

/// A table on a held motor swings at its frequency, and each swing is smaller by the logarithmic decrement.
#[test]
fn table_swings_at_its_frequency() {
    let held = Axis {
        friction: Friction::Stick { coulomb: 1e9, stiction: 1e9 },
        ..on_spring(DRIVE, 40.0, 0.05, 0.4)
    };
    let mut motion =
        AxisMotion { table: DriveMotion { position: 1.0, velocity: 0.0 }, ..AxisMotion::default() };
    let (mut peaks, mut at_s, mut before) = (Vec::new(), 0.0, [1.0, 1.0]);
    while peaks.len() < 3 {
        motion = held.after(motion, &under(0.0), 2e-5);
        at_s += 2e-5;
        let now = motion.table.position;
        if before[1] > before[0] && before[1] > now {
            peaks.push((at_s, before[1]));
        }
        before = [before[1], now];
    }
    let damped_hz = 40.0 * (1.0_f64 - 0.05 * 0.05).sqrt();
    assert!(((peaks[2].0 - peaks[0].0) * damped_hz / 2.0 - 1.0).abs() < 0.002, "{peaks:?}");
    let decrement = (peaks[0].1 / peaks[2].1).ln() / 2.0;
    let stated = std::f64::consts::TAU * 0.05 / (1.0_f64 - 0.05 * 0.05).sqrt();
    assert!((decrement / stated - 1.0).abs() < 0.01, "{decrement} {stated}");
}

/// With a free motor, motor and table swing against each other, faster by `1/√(1 − share)`.
#[test]
fn free_motor_raises_the_frequency() {
    let free = on_spring(Drive { gain: 1.0, time_constant_s: 1e6 }, 40.0, 0.001, 0.4);
    let table = DriveMotion { position: 1.0, velocity: 0.0 };
    let mut motion = AxisMotion { table, ..AxisMotion::default() };
    let (mut crossings, mut at_s, mut before) = (Vec::new(), 0.0, 1.0);
    while crossings.len() < 11 {
        motion = free.after(motion, &under(0.0), 2e-5);
        at_s += 2e-5;
        let now = motion.table.position - motion.motor.position;
        if (now < 0.0) != (before < 0.0) {
            crossings.push(at_s);
        }
        before = now;
    }
    let found_hz = 5.0 / (crossings[10] - crossings[0]);
    assert!((found_hz / (40.0 / 0.6_f64.sqrt()) - 1.0).abs() < 0.002, "{found_hz}");
    // Momentum is kept: nothing from outside acts on the two.
    let momentum = 0.6 * motion.motor.velocity + 0.4 * motion.table.velocity;
    assert!(momentum.abs() < 1e-3 * motion.table.velocity.abs().max(1.0), "{momentum}");
}

/// A table on a very stiff spring moves as a rigid one does, also under a cutting force, with friction and play.
#[test]
fn stiff_spring_is_rigid() {
    let stiff = on_spring(DRIVE, 1500.0, 0.7, 0.3);
    let rigid = Axis::ideal(DRIVE);
    let commands = || [50.0; 100].into_iter().chain([-50.0; 100]);
    let [soft, hard] = [stiff, rigid].map(|axis| positions(&axis, commands()));
    for (soft, hard) in soft.iter().zip(&hard) {
        assert!((soft - hard).abs() < 0.02, "{soft} {hard}");
    }
    let pushed = |axis: &Axis| {
        let acting = Acting { command: 20.0, force: 15.0, reference_velocity: 0.0 };
        (0..500).fold(AxisMotion::default(), |motion, _| axis.after(motion, &acting, 0.001)).table.position
    };
    assert!((pushed(&stiff) / pushed(&rigid) - 1.0).abs() < 0.01, "{} {}", pushed(&stiff), pushed(&rigid));
    let loose = Axis { backlash: 0.5, ..stiff };
    let gap = positions(&stiff, [50.0; 200])[199] - positions(&loose, [50.0; 200])[199];
    assert!((gap - 0.25).abs() < 0.1, "{gap}");
}
