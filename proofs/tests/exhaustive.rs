//! Every input on a small lattice, at both widths.

use keepout_kernel::exact::width::{Narrow, Product};
use keepout_proofs::properties::{self, Xy};

fn points(half: i64) -> Vec<Xy> {
    (-half..=half).flat_map(|x| (-half..=half).map(move |y| (x, y))).collect()
}

#[test]
fn orientation() {
    let points = points(3);
    for &a in &points {
        for &b in &points {
            for &c in &points {
                properties::orientation_is_the_sign_of_the_area::<Narrow>(a, b, c);
                properties::orientation_is_the_sign_of_the_area::<Product>(a, b, c);
            }
        }
    }
}

#[test]
fn point_segment() {
    let points = points(2);
    for &p in &points {
        for &a in &points {
            for &b in &points {
                for r in 0..=6 {
                    properties::point_segment_is_exact::<Narrow>(p, a, b, r);
                    properties::point_segment_is_exact::<Product>(p, a, b, r);
                }
            }
        }
    }
}

#[test]
fn segment_segment() {
    // 16 points, all quadruples; one point suffices per translation class, so the lattice is 4 × 4.
    let points: Vec<Xy> = (0..4).flat_map(|x| (0..4).map(move |y| (x, y))).collect();
    for &a in &points {
        for &b in &points {
            for &c in &points {
                for &d in &points {
                    for r in 0..=3 {
                        properties::segment_segment_is_exact::<Narrow>(a, b, c, d, r);
                    }
                    properties::segment_segment_is_exact::<Product>(a, b, c, d, 1);
                }
            }
        }
    }
}

#[test]
fn triangle_segment_and_fan() {
    let points = points(1);
    for &a in &points {
        for &b in &points {
            for &c in &points {
                for &d in &points {
                    for &e in &points {
                        for r in 0..=1 {
                            properties::triangle_segment_is_exact::<Narrow>([a, b, c], d, e, r);
                            properties::fan_covers_every_retargeted_motion::<Narrow>(
                                [a, b, c],
                                (1, 2),
                                d,
                                e,
                                r,
                            );
                        }
                    }
                }
            }
        }
    }
}
