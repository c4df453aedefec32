//! Every input on a small lattice, at both widths.

use keepout_kernel::exact::predicate::{Site, triangle_segment};
use keepout_kernel::exact::width::{Narrow, Product};
use keepout_kernel::index::build::build;
use keepout_kernel::{Edge, Length, Point, Segment};
use keepout_proofs::oracle::{Big, in_triangle};
use keepout_proofs::properties::{self, FromPlain, Xy};

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
    // All quadruples of 16 points. The answer does not change with a translation, so a lattice of 4 × 4 is
    // enough.
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
fn triangle_segment_and_retargeted_motion() {
    let points = points(1);
    for &a in &points {
        for &b in &points {
            for &c in &points {
                for &d in &points {
                    for &e in &points {
                        for r in 0..=1 {
                            properties::triangle_segment_is_exact::<Narrow>([a, b, c], d, e, r);
                            properties::swept_triangle_covers_every_retargeted_motion::<Narrow>(
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

#[test]
fn retracting() {
    let points: Vec<Xy> = (0..4).flat_map(|x| (0..4).map(move |y| (x, y))).collect();
    for &p in &points {
        for &q in &points {
            for &a in &points {
                for &b in &points {
                    properties::retracting_never_comes_nearer::<Narrow>(p, q, a, b);
                    properties::retracting_never_comes_nearer::<Product>(p, q, a, b);
                }
            }
        }
    }
}

#[test]
fn boxes() {
    let points: Vec<Xy> = (0..4).flat_map(|x| (0..4).map(move |y| (x, y))).collect();
    for &p in &points {
        for &q in points.iter().filter(|q| q.0 >= p.0 && q.1 >= p.1) {
            for &a in &points {
                for &b in &points {
                    for r in 0..=2 {
                        properties::box_segment_is_exact::<Narrow>(p, q, a, b, r);
                    }
                    properties::box_segment_is_exact::<Product>(p, q, a, b, 1);
                }
            }
        }
    }
}

/// All triangles of an 8 × 8 lattice, flat ones too, against all its points and every threshold that can
/// matter: as a filled triangle, and as three edges behind a checked index.
#[test]
fn every_triangle_of_a_lattice_against_every_point_and_threshold() {
    let points: Vec<Xy> = (0..8).flat_map(|x| (0..8).map(move |y| (x, y))).collect();
    let at = |(x, y): Xy| Point::from_units(x, y).unwrap();
    let big = |(x, y): Xy| Big::new(x, y);
    for (i, &a) in points.iter().enumerate() {
        for (j, &b) in points.iter().enumerate().skip(i) {
            for &c in &points[j..] {
                let sides = [(a, b), (b, c), (c, a)];
                let edge =
                    |(p, q)| Edge { chord: Segment { from: at(p), to: at(q) }, chord_error: Length::ZERO };
                let index = build(sides.map(edge).to_vec()).unwrap();
                for &p in &points {
                    // The squared distances of coordinates below 8 are fractions with denominators below 2^7.
                    let nearest = sides
                        .iter()
                        .map(|&(s, t)| distance_2_small(p, s, t))
                        .min_by(|x, y| (x.0 * y.1).cmp(&(y.0 * x.1)))
                        .unwrap();
                    let inside = in_triangle(&big(p), &big(a), &big(b), &big(c));
                    for r in 0..=10 {
                        let near = nearest.0 <= r * r * nearest.1;
                        let threshold = Length::from_units(r).unwrap();
                        assert_eq!(
                            index.near_point(at(p), threshold).is_some(),
                            near,
                            "{a:?} {b:?} {c:?} {p:?} {r}"
                        );
                        let swept = triangle_segment::<Product>(
                            [a, b, c].map(site),
                            [p, p].map(site),
                            Product::linear(r),
                        );
                        assert_eq!(!swept.is_clear(), near || inside, "{a:?} {b:?} {c:?} {p:?} {r}");
                    }
                }
            }
        }
    }
}

fn site((x, y): Xy) -> Site<Product> {
    Product::site((x, y))
}

/// The square of the distance from `p` to the segment as a fraction, in plain integers. Coordinates are
/// below 8.
fn distance_2_small(p: Xy, a: Xy, b: Xy) -> (i64, i64) {
    let (dx, dy, wx, wy) = (b.0 - a.0, b.1 - a.1, p.0 - a.0, p.1 - a.1);
    let length_2 = dx * dx + dy * dy;
    if length_2 == 0 {
        return (wx * wx + wy * wy, 1);
    }
    let t = (wx * dx + wy * dy).clamp(0, length_2);
    let (ox, oy) = (wx * length_2 - dx * t, wy * length_2 - dy * t);
    (ox * ox + oy * oy, length_2 * length_2)
}
