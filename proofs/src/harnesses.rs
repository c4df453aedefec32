//! Kani harnesses, for reviewers who have Kani: `cargo kani -p keepout-proofs`.
//!
//! Each states what the exhaustive engine runs concretely, symbolically over the whole `Narrow` lattice (±4 units:
//! multiplication is what defeats bit-blasting). Kani was not available where this was written; the same bodies run
//! as tests.

use crate::properties::{self, Xy};
use keepout_kernel::exact::width::Narrow;

fn point() -> Xy {
    let (x, y): (i8, i8) = (kani::any(), kani::any());
    kani::assume((-4..=4).contains(&x) && (-4..=4).contains(&y));
    (i64::from(x), i64::from(y))
}

fn radius() -> i64 {
    let r: i8 = kani::any();
    kani::assume((0..=8).contains(&r));
    i64::from(r)
}

#[kani::proof]
#[kani::solver(cadical)]
fn orientation_is_the_sign_of_the_area() {
    properties::orientation_is_the_sign_of_the_area::<Narrow>(point(), point(), point());
}

#[kani::proof]
#[kani::solver(cadical)]
fn point_segment_is_exact() {
    properties::point_segment_is_exact::<Narrow>(point(), point(), point(), radius());
}

#[kani::proof]
#[kani::solver(kissat)]
fn segment_segment_is_exact() {
    properties::segment_segment_is_exact::<Narrow>(point(), point(), point(), point(), radius());
}

#[kani::proof]
#[kani::solver(kissat)]
fn triangle_segment_is_exact() {
    let corners = [point(), point(), point()];
    properties::triangle_segment_is_exact::<Narrow>(corners, point(), point(), radius());
}

#[kani::proof]
#[kani::solver(kissat)]
fn receding_never_comes_nearer() {
    properties::receding_never_comes_nearer::<Narrow>(point(), point(), point(), point());
}

#[kani::proof]
#[kani::solver(kissat)]
fn box_segment_is_exact() {
    properties::box_segment_is_exact::<Narrow>(point(), point(), point(), point(), radius());
}
