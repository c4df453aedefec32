//! False statements. A model checker that does not refute each of them is not to be believed.

use keepout_kernel::Coord;
use keepout_kernel::exact::lattice::COORD_MAX;

use crate::Cases;
#[cfg(not(target_arch = "wasm32"))]
use crate::{Inputs, ModelHarness};

/// The canaries.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) const ALL: &[ModelHarness] = &[
    canary("no_coordinate_is_the_largest", "every i64", no_coordinate_is_the_largest),
    canary("no_loop_ends_at_its_end", "two rounds", no_loop_ends_at_its_end),
    canary("no_sum_overflows", "every pair of i32", no_sum_overflows),
];

#[cfg(not(target_arch = "wasm32"))]
const fn canary(name: &'static str, bounds: &'static str, run: fn(&mut Inputs)) -> ModelHarness {
    ModelHarness {
        name,
        claim: "a false statement",
        file: "proofs/harnesses/src/canaries.rs",
        bounds,
        unwind: 4,
        run,
    }
}

/// One number of 2^64 refutes it.
fn no_coordinate_is_the_largest(c: &mut impl Cases) {
    assert!(Coord::from_units(c.wide()).is_ok_and(|coord| coord.units() != COORD_MAX) || c.coin());
}

/// The path that leaves the loop at its end refutes it. CBMC 6.6 loses this path in the plain translation.
#[inline(never)]
fn no_loop_ends_at_its_end(c: &mut impl Cases) {
    let mut round = 0;
    loop {
        if round == 2 {
            return;
        }
        round += 1;
        if c.int(0, 9) > 4 {
            break;
        }
    }
    assert!(round > 2);
}

/// The harnesses are compiled with overflow checks.
fn no_sum_overflows(c: &mut impl Cases) {
    let (one, other) = (c.int(i32::MIN, i32::MAX), c.int(i32::MIN, i32::MAX));
    assert!(one + other == one.wrapping_add(other));
}

#[cfg(target_arch = "wasm32")]
#[expect(unsafe_code, reason = "the model checker finds harnesses by name")]
mod exports {
    use crate::wasm::AllInputs;

    #[unsafe(no_mangle)]
    extern "C" fn no_coordinate_is_the_largest() {
        super::no_coordinate_is_the_largest(&mut AllInputs);
    }

    #[unsafe(no_mangle)]
    extern "C" fn no_loop_ends_at_its_end() {
        super::no_loop_ends_at_its_end(&mut AllInputs);
    }

    #[unsafe(no_mangle)]
    extern "C" fn no_sum_overflows() {
        super::no_sum_overflows(&mut AllInputs);
    }
}
