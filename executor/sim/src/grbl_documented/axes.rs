//! Places of three axes, in whole steps and in millimetres.

use keepout_kernel::curve::round_down;
use keepout_planner::Mm3;

/// One figure for each of x, y and z: millimetres, mm/s or a direction.
pub(super) type Triple = [f64; 3];

/// A place in whole steps from the machine's zero.
pub(super) type StepPlace = [i32; 3];

/// The three figures of a place, mm.
pub(super) const fn triple(Mm3 { x, y, z }: Mm3) -> Triple {
    [x, y, z]
}

/// A figure for each axis from a function of the axis.
pub(super) fn each(figure: impl Fn(usize) -> f64) -> Triple {
    [figure(0), figure(1), figure(2)]
}

/// The length of a vector.
pub(super) fn length(of: Triple) -> f64 {
    of.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// The nearest whole number of steps.
pub(super) fn whole_steps(value: f64) -> i32 {
    let nearest = round_down(value.clamp(f64::from(i32::MIN), f64::from(i32::MAX)) + 0.5);
    i32::try_from(nearest).unwrap_or(i32::MAX)
}

/// A place in millimetres as whole steps.
pub(super) fn to_steps(place_mm: Triple, steps_per_mm: Triple) -> StepPlace {
    [0, 1, 2].map(|axis| whole_steps(place_mm[axis] * steps_per_mm[axis]))
}

/// A place in steps as millimetres.
pub(super) fn to_mm(place: StepPlace, steps_per_mm: Triple) -> Triple {
    each(|axis| f64::from(place[axis]) / steps_per_mm[axis])
}
