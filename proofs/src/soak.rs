//! Differential soaks: they compare answers with the definitions for any number of cases, reproducibly from
//! a seed.

use fastrand::Rng;
use keepout_kernel::exact::arc::{Arc, Turn};
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::predicate::{point_segment, segment_segment, triangle_segment};
use keepout_kernel::exact::swept_arc::SweptArc;
use keepout_kernel::exact::width::Product;
use keepout_kernel::index::build::build;
use keepout_kernel::index::cells::Answer;
use keepout_kernel::index::{CheckedIndex, Edge, subdivide};
use keepout_kernel::{Convex, Point, Segment, Triangle, Vec2};

use crate::families::{Family, at, length};
use crate::oracle::{self, Big, quick};
use crate::properties::{FromPlain, Xy};

fn plain(point: Point) -> Xy {
    (i64::from(point.x.units()), i64::from(point.y.units()))
}

fn big((x, y): Xy) -> Big {
    Big::new(x, y)
}

#[expect(clippy::cast_precision_loss, reason = "coordinates have 30 bits")]
fn float((x, y): Xy) -> quick::Xy {
    (x as f64, y as f64)
}

#[expect(clippy::cast_precision_loss, reason = "thresholds have 31 bits")]
fn units(r: i64) -> f64 {
    r as f64
}

/// The definition of point–segment. It uses floats where their answer is certain.
#[must_use]
pub fn point_within(p: Xy, a: Xy, b: Xy, r: i64) -> bool {
    quick::point_segment_within(float(p), float(a), float(b), units(r))
        .unwrap_or_else(|| oracle::point_segment_within(&big(p), &big(a), &big(b), r))
}

/// The definition of segment–segment, with floats as in [`point_within`].
#[must_use]
pub fn segments_within(a: Xy, b: Xy, c: Xy, d: Xy, r: i64) -> bool {
    quick::segment_segment_within(float(a), float(b), float(c), float(d), units(r))
        .unwrap_or_else(|| oracle::segment_segment_within(&big(a), &big(b), &big(c), &big(d), r))
}

/// The definition of triangle–segment, with floats as in [`point_within`].
#[must_use]
pub fn triangle_within(corners: [Xy; 3], d: Xy, e: Xy, r: i64) -> bool {
    quick::triangle_segment_within(corners.map(float), float(d), float(e), units(r)).unwrap_or_else(|| {
        let [a, b, c] = corners.map(big);
        oracle::triangle_segment_within([&a, &b, &c], &big(d), &big(e), r)
    })
}

/// Runs `cases` random and degenerate predicate cases at product width. One compared answer is one case.
///
/// # Panics
/// At the first difference, with the case.
pub fn predicates(random: &mut Rng, cases: u64) {
    let limit = i64::from(COORD_MAX);
    let mut done = 0;
    while done < cases {
        // Boxes from a few units to the whole lattice. In small ones points coincide.
        let half = 1_i64 << random.u32(2..=29);
        let origin = (random.i64(-(limit - half)..=limit - half), random.i64(-(limit - half)..=limit - half));
        let mut point = || (origin.0 + random.i64(-half..=half), origin.1 + random.i64(-half..=half));
        let [p, a, b, c, d] = [point(), point(), point(), point(), point()];
        let (dx, dy) = ((p.0 - a.0).unsigned_abs(), (p.1 - a.1).unsigned_abs());
        let exact = i64::try_from((u128::from(dx).pow(2) + u128::from(dy).pow(2)).isqrt()).unwrap_or(limit);
        let r = match random.u8(0..8) {
            0 => exact + random.i64(-1..=1),
            1 => (p.1 - a.1).abs() + random.i64(-1..=1),
            _ => random.i64(0..=2 * half),
        }
        .clamp(0, limit);
        let flat = (b.0, a.1);
        let site = Product::site;
        let radius = Product::linear(r);
        for end in [b, flat] {
            let near = !point_segment::<Product>(site(p), site(a), site(end), radius).is_clear();
            assert_eq!(near, point_within(p, a, end, r), "point {p:?} segment {a:?} {end:?} within {r}");
        }
        let near = !segment_segment::<Product>([p, c].map(site), [a, b].map(site), radius).is_clear();
        assert_eq!(near, segments_within(p, c, a, b, r), "segments {p:?} {c:?}, {a:?} {b:?} within {r}");
        let near = !triangle_segment::<Product>([p, c, d].map(site), [a, b].map(site), radius).is_clear();
        assert_eq!(
            near,
            triangle_within([p, c, d], a, b, r),
            "triangle {p:?} {c:?} {d:?}, {a:?} {b:?} within {r}"
        );
        done += 4;
    }
}

/// Runs `cases` queries over indices and cells of all families. One answer compared with all edges is one
/// case.
///
/// # Panics
/// At the first difference, with the family and the case.
pub fn queries(random: &mut Rng, cases: u64) {
    let mut done = 0;
    while done < cases {
        for family in Family::ALL {
            done += family_queries(family, random);
        }
    }
}

/// Queries a random profile of the family a few hundred times. Returns the number of compared answers.
///
/// # Panics
/// At the first difference.
pub fn family_queries(family: Family, random: &mut Rng) -> u64 {
    let profile = family.profile(random);
    let index = build(profile.edges.clone()).expect("few edges");
    let cells = subdivide::build(&index, length(profile.threshold), Some(random.usize(0..300))).ok();
    let mut done = 0;
    for _ in 0..40 {
        let (p, q, s) = (profile.query(random), profile.query(random), profile.query(random));
        let step = |c: i64, d: i64| c + (d - c) / 64;
        let near_by = (step(p.0, q.0), step(p.1, q.1));
        for r in [profile.threshold, random.i64(0..=2 * profile.threshold.min(i64::from(COORD_MAX) / 2))] {
            let context = format!("{family:?} {p:?} {q:?} {s:?} within {r}");
            let ask = Ask { index: &index, r };
            done += ask.compare(p, q, s, near_by, &context);
        }
        if let Some(cells) = &cells {
            let r = profile.threshold;
            let near = near_point(&index, p, r);
            let context = format!("cells, {family:?} {p:?} {q:?} within {r}");
            match cells.point(&index, at(p)) {
                Answer::Unknown => {}
                answer => assert_eq!(answer != Answer::Clear, near, "{context}"),
            }
            for to in [q, near_by] {
                match cells.motion(&index, Segment { from: at(p), to: at(to) }) {
                    Answer::Unknown => {}
                    answer => assert_eq!(answer != Answer::Clear, near_motion(&index, p, to, r), "{context}"),
                }
            }
            done += 3;
        }
    }
    done
}

fn brute(index: &CheckedIndex, r: i64, within: impl Fn(Xy, Xy, i64) -> bool) -> bool {
    index.edges().iter().any(|edge: &Edge| {
        let reach = r + i64::from(edge.chord_error.units());
        // A threshold beyond the lattice blocks everything.
        reach > i64::from(COORD_MAX) || within(plain(edge.chord.from), plain(edge.chord.to), reach)
    })
}

fn near_point(index: &CheckedIndex, p: Xy, r: i64) -> bool {
    brute(index, r, |a, b, r| point_within(p, a, b, r))
}

fn near_motion(index: &CheckedIndex, p: Xy, q: Xy, r: i64) -> bool {
    brute(index, r, |a, b, r| segments_within(p, q, a, b, r))
}

struct Ask<'a> {
    index: &'a CheckedIndex,
    r: i64,
}

impl Ask<'_> {
    fn compare(&self, p: Xy, q: Xy, s: Xy, near_by: Xy, context: &str) -> u64 {
        let (index, r, threshold) = (self.index, self.r, length(self.r));
        // The index finds an edge whose chord-error bound takes the threshold beyond the lattice only near
        // the edge's box.
        let whole =
            index.edges().iter().all(|edge| r + i64::from(edge.chord_error.units()) <= i64::from(COORD_MAX));
        if !whole {
            return 0;
        }
        let near = near_point(index, p, r);
        assert_eq!(index.near_point(at(p), threshold).is_some(), near, "point, {context}");
        for to in [q, near_by] {
            let motion = Segment { from: at(p), to: at(to) };
            assert_eq!(
                index.near_motion(motion, threshold).is_some(),
                near_motion(index, p, to, r),
                "motion, {context}"
            );
            let approached = index.edges().iter().any(|edge| {
                let (a, b) = (plain(edge.chord.from), plain(edge.chord.to));
                segments_within(p, to, a, b, r + i64::from(edge.chord_error.units()))
                    && !quick::never_nearer(float(p), float(to), float(a), float(b))
                        .unwrap_or_else(|| oracle::never_nearer(&big(p), &big(to), &big(a), &big(b)))
            });
            assert_eq!(index.approached(motion, threshold).is_some(), approached, "retracting, {context}");
        }
        let swept = Triangle { corners: [at(p), at(q), at(s)] };
        let near_triangle = brute(index, r, |a, b, r| triangle_within([p, q, s], a, b, r));
        assert_eq!(
            index.near_triangle(swept, threshold).is_some(),
            near_triangle,
            "swept triangle, {context}"
        );
        let mut corners = swept.corners;
        if Convex::check(&corners).is_none() {
            corners.swap(1, 2);
        }
        let polygon = Convex::check(&corners).expect("one way round a triangle turns left");
        assert_eq!(index.near_convex(polygon, threshold).is_some(), near_triangle, "polygon, {context}");
        let quadrangle = [at(p), at(q), at(s), at(near_by)];
        for order in [[0, 1, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2], [0, 3, 2, 1], [0, 3, 1, 2], [0, 2, 3, 1]] {
            let corners = order.map(|k| quadrangle[k]);
            let Some(polygon) = Convex::check(&corners) else { continue };
            let [a, b, c, d] = corners.map(plain);
            let near = brute(index, r, |e, f, r| {
                triangle_within([a, b, c], e, f, r) || triangle_within([a, c, d], e, f, r)
            });
            assert_eq!(index.near_convex(polygon, threshold).is_some(), near, "polygon, {context}");
        }
        if let Some(clearance) = index.clearance(at(p)) {
            let c = i64::from(clearance.units());
            assert!(!near_point(index, p, c), "clearance {c}, {context}");
            // Clearance ends at the largest length.
            let tight = c >= i64::from(COORD_MAX) - 3 || near_point(index, p, c + 3);
            assert!(tight, "clearance {c} is not tight, {context}");
        } else {
            assert!(near_point(index, p, 0), "no clearance, {context}");
        }
        9
    }
}

/// Compares `cases` swept arcs with chords. A chord reported clear must be clear of curves along both sides
/// of the ring, at 201 angles. A chord that keeps 16 units more than `t`, besides half a sampling step,
/// must be reported clear.
///
/// # Panics
/// At the first difference.
#[expect(clippy::cast_precision_loss, reason = "coordinates have 30 bits")]
pub fn arcs(random: &mut Rng, cases: u64) {
    for _ in 0..cases {
        let rho = 1_i64 << random.u32(7..=22);
        let rho = random.i64(rho..=2 * rho);
        let (start, sweep) = (random.f64() * 7.0, 0.02 + random.f64() * 6.2);
        let turn = if random.bool() { Turn::CounterClockwise } else { Turn::Clockwise };
        let signed = if turn == Turn::CounterClockwise { sweep } else { -sweep };
        let on = |phi: f64, r: f64| (r * phi.cos(), r * phi.sin());
        let lattice =
            |(x, y): (f64, f64)| keepout_kernel::curve::nearest_point(Vec2::new(x, y)).expect("small");
        let (from, to) = (lattice(on(start, rho as f64)), lattice(on(start + signed, rho as f64)));
        let Ok(arc) = Arc::new(from, to, Point::ORIGIN, turn) else { continue };
        let Some(swept) = SweptArc::of(&arc) else { continue };
        let reach = 2 * rho;
        let mut point = || (random.i64(-reach..=reach), random.i64(-reach..=reach));
        let (mut a, b) = (point(), point());
        match random.u8(0..6) {
            0 => a = (0, 0),
            1 => a = (random.i64(-3..=3), random.i64(-3..=3)),
            2 => a = plain(from),
            _ => {}
        }
        let t = if random.bool() { rho - random.i64(1..=60) } else { random.i64(0..=2 * rho) };
        let t = t.clamp(0, i64::from(COORD_MAX));
        let mut least = f64::INFINITY;
        let rho_true = i64::from(arc.radius().units()) as f64;
        let (first, last) = (angle(from), angle(to));
        let turned = (if turn == Turn::CounterClockwise { last - first } else { first - last })
            .rem_euclid(std::f64::consts::TAU);
        for k in 0..=200 {
            let phi = first
                + turned * f64::from(k) / 200.0 * if turn == Turn::CounterClockwise { 1.0 } else { -1.0 };
            for r in [rho_true - 1.0, rho_true + 2.0] {
                least = least.min(quick::point_segment(on(phi, r), float(a), float(b)));
            }
        }
        let clear = swept.near_chord(Segment { from: at(a), to: at(b) }, length(t)).is_clear();
        let case = format!("{arc:?}, chord {a:?} {b:?}, t {t}: sampled distance {least}");
        assert!(!clear || least > units(t) - 1e-6, "reported clear, but is near: {case}");
        let step = rho_true * turned / 200.0;
        assert!(clear || least - step / 2.0 < units(t) + 16.0, "clear, but reported near: {case}");
    }
}

fn angle(point: Point) -> f64 {
    let (x, y) = float(plain(point));
    y.atan2(x)
}
