//! Random inputs over the full lattice, with thresholds at and near the exact distance.
#![expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "shapes are drawn in f64 and rounded; `robust` takes f64, which holds 30 bits exactly"
)]

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::width::Product;
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Triangle, Vec2};
use keepout_proofs::oracle::{Big, inside_polygon, segment_segment_within, triangle_segment_within};
use keepout_proofs::properties::{self, Xy};
use proptest::prelude::*;

const LIMIT: i64 = COORD_MAX as i64;

/// Coordinates: anywhere, at the extremes, near the origin.
fn coordinate() -> impl Strategy<Value = i64> {
    prop_oneof![-LIMIT..=LIMIT, Just(LIMIT), Just(-LIMIT), -50_i64..=50, LIMIT - 50..=LIMIT]
}

fn point() -> impl Strategy<Value = Xy> {
    (coordinate(), coordinate())
}

/// A threshold at, just below or just above the distance of two points, or any other.
fn threshold(p: Xy, q: Xy, pick: i64, any: i64) -> i64 {
    let (dx, dy) = (i128::from(p.0 - q.0), i128::from(p.1 - q.1));
    let distance = i64::try_from((dx * dx + dy * dy).isqrt()).expect("below 2^31");
    let near = distance + pick - 1;
    if pick < 4 && (0..=LIMIT).contains(&near) { near } else { any }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn orientation(a in point(), b in point(), c in point()) {
        properties::orientation_is_the_sign_of_the_area::<Product>(a, b, c);
        let coord = |(x, y): Xy| robust::Coord { x: x as f64, y: y as f64 };
        let exact = robust::orient2d(coord(a), coord(b), coord(c));
        let at = |(x, y): Xy| Point::from_units(x, y).unwrap();
        let ours = keepout_kernel::exact::segment::orientation(at(a), at(b), at(c));
        let sign = match ours {
            keepout_kernel::exact::predicate::Orientation::Left => 1.0,
            keepout_kernel::exact::predicate::Orientation::On => 0.0,
            keepout_kernel::exact::predicate::Orientation::Right => -1.0,
        };
        prop_assert!(if exact == 0.0 { sign == 0.0 } else { sign == exact.signum() }, "{exact} {ours:?}");
    }

    #[test]
    fn point_segment(p in point(), a in point(), b in point(), pick in 0_i64..8, any in 0..=LIMIT) {
        properties::point_segment_is_exact::<Product>(p, a, b, threshold(p, a, pick, any));
        // An axis-parallel segment, so that the foot lies at a lattice distance.
        let flat = (b.0, a.1);
        properties::point_segment_is_exact::<Product>(p, a, flat, (p.1 - a.1).abs().min(LIMIT));
    }

    #[test]
    fn segment_segment(a in point(), b in point(), c in point(), d in point(), pick in 0_i64..8, any in 0..=LIMIT) {
        properties::segment_segment_is_exact::<Product>(a, b, c, d, threshold(b, c, pick, any));
    }

    #[test]
    fn triangle_segment(
        a in point(), b in point(), c in point(), d in point(), e in point(), pick in 0_i64..8, any in 0..=LIMIT,
    ) {
        properties::triangle_segment_is_exact::<Product>([a, b, c], d, e, threshold(c, d, pick, any));
        let r = threshold(c, d, pick, any);
        properties::swept_triangle_covers_every_retargeted_motion::<Product>([a, b, c], (1, 2), d, e, r);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn retracting(p in point(), q in point(), a in point(), b in point()) {
        properties::retracting_never_comes_nearer::<Product>(p, q, a, b);
        // The motion begins beside the segment, and leads straight away from it or along it.
        properties::retracting_never_comes_nearer::<Product>(p, (p.0, q.1), a, (b.0, a.1));
        properties::retracting_never_comes_nearer::<Product>(p, (q.0, p.1), a, (b.0, a.1));
    }

    #[test]
    fn boxes(p in point(), q in point(), a in point(), b in point(), pick in 0_i64..8, any in 0..=LIMIT) {
        properties::box_segment_is_exact::<Product>(p, q, a, b, threshold(q, a, pick, any));
    }
}

/// A star-shaped ring about the origin. It is simple for all radii.
fn star(radii: &[i64]) -> Option<Vec<Point>> {
    let n = radii.len() as f64;
    let vertex = |(k, &r): (usize, &i64)| {
        let phi = std::f64::consts::TAU * k as f64 / n;
        Point::from_units((r as f64 * phi.cos()).round() as i64, (r as f64 * phi.sin()).round() as i64).ok()
    };
    radii.iter().enumerate().map(vertex).collect()
}

fn part(radii: &[i64]) -> Option<(ProhibitedRegion, Vec<Point>)> {
    let vertices = star(radii)?;
    let ring = Ring::new(vertices.clone()).ok()?;
    Some((ProhibitedRegion::new(Region::new(vec![ring]).ok()?, Side::Outside).ok()?, vertices))
}

fn big(p: Point) -> Big {
    Big::new(i64::from(p.x.units()), i64::from(p.y.units()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    /// Clear queries over a region agree with the definition over all its edges.
    #[test]
    fn queries_agree_with_brute_force(
        radii in prop::collection::vec(200_i64..4000, 3..90),
        a in (-6000_i64..6000, -6000_i64..6000),
        b in (-6000_i64..6000, -6000_i64..6000),
        c in (-6000_i64..6000, -6000_i64..6000),
        r in 0_i64..1500,
    ) {
        let Some((part, vertices)) = part(&radii) else { return Ok(()) };
        let at = |(x, y): Xy| Point::from_units(x, y).unwrap();
        let threshold = Length::from_units(r).unwrap();
        let polygon: Vec<Big> = vertices.iter().map(|&p| big(p)).collect();
        let edges: Vec<(Big, Big)> =
            polygon.iter().cloned().zip(polygon.iter().cycle().skip(1).cloned()).collect();
        let (ba, bb, bc) = (big(at(a)), big(at(b)), big(at(c)));
        let start_clear = edges.iter().all(|(p, q)| !segment_segment_within(&ba, &ba, p, q, r));
        let free = part.free_point(at(a), threshold);
        let outside = inside_polygon(&ba, &polygon) == Some(false);
        prop_assert_eq!(free.is_ok(), start_clear && outside);
        let Ok(free) = free else { return Ok(()) };
        let motion_clear = edges.iter().all(|(p, q)| !segment_segment_within(&ba, &bb, p, q, r));
        let motion = part.motion(free, at(b));
        prop_assert_eq!(motion.is_ok(), motion_clear);
        let clipped = part.clip(free, at(b));
        let end = big(clipped.point());
        let clear = edges.iter().all(|(p, q)| !segment_segment_within(&ba, &end, p, q, r));
        prop_assert!(clear, "prefix is clear");
        if motion_clear {
            prop_assert_eq!(clipped.point(), at(b));
        }
        if let Ok(second) = motion {
            let triangle_clear = edges.iter().all(|(p, q)| !triangle_segment_within([&ba, &bb, &bc], p, q, r));
            prop_assert_eq!(part.swept_triangle(free, second, at(c)).is_ok(), triangle_clear);
        }
    }

    /// The index never leaves out an edge whose box meets the window.
    #[test]
    fn index_leaves_no_edge_out(
        radii in prop::collection::vec(200_i64..400_000, 3..600),
        a in (-500_000_i64..500_000, -500_000_i64..500_000),
        b in (-500_000_i64..500_000, -500_000_i64..500_000),
    ) {
        let Some((part, _)) = part(&radii) else { return Ok(()) };
        let at = |(x, y): Xy| Point::from_units(x, y).unwrap();
        let window = Triangle { corners: [at(a), at(b), at(b)] }.bounds();
        let mut seen = 0;
        let _ = part.index().visit(window, |_, edge| {
            seen += usize::from(edge.bounds().meets(window));
            std::ops::ControlFlow::Continue(())
        });
        prop_assert_eq!(seen, part.edges().iter().filter(|edge| edge.bounds().meets(window)).count());
    }

    /// Every point of a true arc lies within the chord-error bound of the checked chords.
    #[test]
    fn chords_stay_within_their_chord_error(
        radius in 100_i64..50_000_000,
        from in 0.0_f64..std::f64::consts::TAU,
        sweep in 0.01_f64..3.1,
        left in any::<bool>(),
        chord_error in 7_u8..250,
    ) {
        let r = radius as f64;
        let turn = if left { keepout_kernel::Turn::CounterClockwise } else { keepout_kernel::Turn::Clockwise };
        let signed = if left { sweep } else { -sweep };
        let at = |phi: f64| keepout_kernel::curve::nearest_point(Vec2::new(r * phi.cos(), r * phi.sin())).unwrap();
        let (start, end) = (at(from), at(from + signed));
        if start == end {
            return Ok(());
        }
        let Ok(arc) = keepout_kernel::curve::fit_arc(start, end, Vec2::new(0.0, 0.0), turn) else { return Ok(()) };
        let chord_error = Length::small(chord_error);
        let points = Curve::Arc(arc).chord_points(chord_error).unwrap();
        let chords: Vec<Segment> = points.windows(2).map(|w| Segment { from: w[0], to: w[1] }).collect();
        // Rounding a point of the arc to the lattice moves it by less than a unit.
        let reach = chord_error.plus(Length::small(1)).unwrap();
        for k in 0..=40 {
            let on_arc = at(from + signed * f64::from(k) / 40.0);
            prop_assert!(chords.iter().any(|chord| !chord.near_point(on_arc, reach).is_clear()), "{k}");
        }
    }
}
