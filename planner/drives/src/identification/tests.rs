//! Identification of drives that are known.

use super::*;
use crate::drive::{Drive, DriveMotion};
use crate::plant::{Axis, Friction};

/// The true drive: like one of the built-in simulated machine, in mm.
const DRIVE: Drive = Drive { gain: 0.061, time_constant_s: 0.05 };
const COULOMB: f64 = 250.0;
const DELAY_S: f64 = 0.0014;

/// What is done to a record.
#[derive(Clone, Copy)]
struct Recording {
    /// Step of the positions, mm.
    step_mm: f64,
    /// Standard deviation of the noise, mm.
    noise_mm: f64,
    stiction: f64,
}

const PLAIN: Recording = Recording { step_mm: 0.01, noise_mm: 0.005, stiction: COULOMB };

/// Steps of the command, with their durations: two sizes in both directions.
const STEPS: [[f64; 2]; 7] =
    [[0.0, 0.1], [1500.0, 0.5], [0.0, 0.3], [-3000.0, 0.5], [-800.0, 0.4], [2000.0, 0.5], [0.0, 0.3]];

fn record(steps: &[[f64; 2]], recording: Recording, seed: u64) -> MotionRecord {
    let mut random = fastrand::Rng::with_seed(seed);
    let friction = Friction::Stick { coulomb: COULOMB, stiction: recording.stiction };
    let axis = Axis { friction, ..Axis::ideal(DRIVE) };
    let mut record = MotionRecord::default();
    let mut motion = DriveMotion::default();
    let (mut before, period_s) = (0.0, 0.001);
    let mut at_s = 0.0;
    // A delay of one period and a part of the next.
    let (whole, part_s) = (1, DELAY_S - period_s);
    let mut pending = vec![0.0; whole];
    for &[command, seconds] in steps {
        let until_s = at_s + seconds;
        while at_s < until_s - period_s / 2.0 {
            let noise = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
            let seen = motion.position + noise * recording.noise_mm;
            record.times_s.push(at_s);
            record.commands.push(command);
            record.positions_mm.push((seen / recording.step_mm).round() * recording.step_mm);
            pending.push(command);
            let now = pending.remove(0);
            motion = axis.moved(motion, before, 0.0, part_s);
            motion = axis.moved(motion, now, 0.0, period_s - part_s);
            before = now;
            at_s += period_s;
        }
    }
    record
}

/// 100 records with noise and steps of 10 µm.
#[test]
fn known_drives_are_found_within_five_per_cent() {
    let mut contained = [0; 4];
    for seed in 0..100 {
        let found = identify(&record(&STEPS, PLAIN, seed)).unwrap();
        let truth = [DRIVE.gain, DRIVE.time_constant_s, COULOMB, DELAY_S];
        let estimates = [found.gain, found.time_constant_s, found.coulomb_bits, found.delay_s];
        for (index, (estimate, truth)) in estimates.iter().zip(truth).enumerate() {
            contained[index] += i32::from(estimate.contains(truth));
            let off = (estimate.value / truth - 1.0).abs();
            assert!(index == 3 || off < 0.05, "seed {seed}, {index}: {estimate:?} for {truth}");
        }
        assert!((found.delay_s.value - DELAY_S).abs() < 0.0005, "seed {seed}: {:?}", found.delay_s);
        assert!(found.residual_mm < 0.01, "{}", found.residual_mm);
    }
    println!("intervals that contain the truth, of 100: {contained:?}");
    assert!(contained.iter().all(|count| *count >= 90), "{contained:?}");
}

#[test]
fn static_friction_lies_between_what_held_and_what_moved() {
    let mut steps = vec![[0.0, 0.1]];
    for size in [100.0, 200.0, 300.0, 400.0, 1500.0, -2500.0] {
        steps.extend([[size, 0.4], [0.0, 0.4]]);
    }
    let found = identify(&record(&steps, Recording { stiction: 350.0, ..PLAIN }, 1)).unwrap();
    assert_eq!(found.stiction_bits, Some([300.0, 400.0]));
}

#[test]
fn records_that_tell_nothing_are_refused() {
    let refused = |steps: &[[f64; 2]]| identify(&record(steps, PLAIN, 1)).unwrap_err();
    assert!(matches!(refused(&[[0.0, 1.0]]), IdentificationError::Still { .. }));
    assert!(matches!(refused(&[[1500.0, 1.0]]), IdentificationError::Constant(1500.0)));
    let moving = record(&STEPS, PLAIN, 1);
    let cut = |values: &[f64]| values[250..].to_vec();
    let moving = MotionRecord {
        times_s: cut(&moving.times_s),
        commands: cut(&moving.commands),
        positions_mm: cut(&moving.positions_mm),
    };
    assert_eq!(identify(&moving).unwrap_err(), IdentificationError::Moving);
    // One step in one direction does not tell friction from gain.
    let one = refused(&[[0.0, 0.1], [1500.0, 0.8]]);
    assert!(matches!(one, IdentificationError::Undetermined(_)), "{one}");
    let mut wrong = record(&STEPS, PLAIN, 1);
    // After a while the command has the other sign.
    wrong.commands[1000..].iter_mut().for_each(|command| *command = -*command);
    assert!(matches!(identify(&wrong).unwrap_err(), IdentificationError::NotADrive { .. }));
    let full = record(&STEPS, PLAIN, 1);
    let seldom = |values: &[f64]| values.iter().copied().step_by(20).collect::<Vec<_>>();
    let seldom = MotionRecord {
        times_s: seldom(&full.times_s),
        commands: seldom(&full.commands),
        positions_mm: seldom(&full.positions_mm),
    };
    let coarse = identify(&seldom).unwrap_err();
    assert!(matches!(coarse, IdentificationError::Coarse { .. }), "{coarse}");
}
