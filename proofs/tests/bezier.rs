//! The check that a Bézier curve follows a chain, compared with points of both from their definitions.

use fastrand::Rng;
use keepout_kernel::curve::fit_arc;
use keepout_kernel::exact::bezier::{Bezier, WEIGHTS};
use keepout_kernel::{Curve, Length, Point, Segment, Turn, Vec2};

type Xy = (f64, f64);

fn xy(point: Point) -> Xy {
    (f64::from(point.x.units()), f64::from(point.y.units()))
}

/// A point of the curve by the sum over Bernstein polynomials, lattice units.
fn at(curve: &Bezier, t: f64) -> Xy {
    let degree = curve.control().len() - 1;
    let mut sum = [0.0; 3];
    let mut choose = 1.0;
    for (i, (&p, &w)) in curve.control().iter().zip(curve.weights()).enumerate() {
        let (i, n) = (small(i), small(degree));
        let (x, y) = xy(p);
        let b = choose * t.powf(i) * (1.0 - t).powf(n - i) * big(w);
        sum = [sum[0] + b * x, sum[1] + b * y, sum[2] + b];
        choose *= (n - i) / (i + 1.0);
    }
    (sum[0] / sum[2], sum[1] / sum[2])
}

fn small(value: usize) -> f64 {
    f64::from(u8::try_from(value).expect("degrees are small"))
}

#[expect(clippy::cast_precision_loss, reason = "weights are at most 2^40")]
fn big(value: u64) -> f64 {
    value as f64
}

fn distance(curve: &Curve, p: Xy) -> f64 {
    let (a, b) = (xy(curve.from()), xy(curve.to()));
    let ends = (p.0 - a.0).hypot(p.1 - a.1).min((p.0 - b.0).hypot(p.1 - b.1));
    match curve {
        Curve::Line(_) => {
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let length_2 = dx * dx + dy * dy;
            let t = ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length_2;
            if (0.0..=1.0).contains(&t) { (p.0 - a.0 - dx * t).hypot(p.1 - a.1 - dy * t) } else { ends }
        }
        Curve::Arc(arc) => {
            let c = xy(arc.centre());
            let sign = if arc.turn() == Turn::CounterClockwise { 1.0 } else { -1.0 };
            let cross = |u: Xy, v: Xy| ((u.0 - c.0) * (v.1 - c.1) - (u.1 - c.1) * (v.0 - c.0)) * sign;
            let between = cross(a, p) >= 0.0 && cross(p, b) >= 0.0;
            let rho = f64::from(arc.radius().units());
            if between { ((p.0 - c.0).hypot(p.1 - c.1) - rho).abs().min(ends) } else { ends }
        }
    }
}

fn point(random: &mut Rng, size: i64) -> Point {
    Point::from_units(random.i64(-size..=size), random.i64(-size..=size)).expect("on the lattice")
}

fn any_curve(random: &mut Rng, size: i64) -> Bezier {
    let count = random.usize(2..=7);
    let control = (0..count).map(|_| point(random, size)).collect();
    let bits = 40 - random.u64(0..=16);
    let weights = (0..count).map(|_| random.u64(WEIGHTS.0..=(1 << bits))).collect();
    Bezier::new(control, weights).expect("weights in range")
}

/// A chain along the curve, of lines and of arcs through three points of the curve. Its inner joints are
/// moved a little.
fn chain_along(curve: &Bezier, random: &mut Rng, count: u32, moved: i64) -> Option<Vec<Curve>> {
    let mut joints = vec![curve.control()[0]];
    for k in 1..count {
        let (x, y) = at(curve, f64::from(k) / f64::from(count));
        let (dx, dy) = (random.i64(-moved..=moved), random.i64(-moved..=moved));
        let near = keepout_kernel::curve::nearest_point(Vec2::new(x, y)).ok()?;
        joints.push(Point::from_units(i64::from(near.x.units()) + dx, i64::from(near.y.units()) + dy).ok()?);
    }
    joints.push(*curve.control().last()?);
    let mut chain = Vec::new();
    for (k, pair) in (0_u32..).zip(joints.windows(2)) {
        let line = Curve::Line(Segment { from: pair[0], to: pair[1] });
        let middle = at(curve, (f64::from(k) + 0.5) / f64::from(count));
        let arc = random.bool().then(|| through(pair[0], middle, pair[1])).flatten();
        chain.push(arc.unwrap_or(line));
    }
    Some(chain)
}

/// The arc through three points.
fn through(from: Point, (mx, my): Xy, to: Point) -> Option<Curve> {
    let ((ax, ay), (bx, by)) = (xy(from), xy(to));
    let cross = (mx - ax) * (by - ay) - (my - ay) * (bx - ax);
    let (u, v) = ((mx - ax).powi(2) + (my - ay).powi(2), (bx - ax).powi(2) + (by - ay).powi(2));
    let centre = Vec2::new(
        ax + (u * (by - ay) - v * (my - ay)) / (2.0 * cross),
        ay + (v * (mx - ax) - u * (bx - ax)) / (2.0 * cross),
    );
    let turn = if cross < 0.0 { Turn::Clockwise } else { Turn::CounterClockwise };
    fit_arc(from, to, centre, turn).ok().map(Curve::Arc)
}

/// If the check accepts a chain, every point of the curve is within the chord-error bound of the chain, and
/// every point of the chain is within twice the bound of the curve.
#[test]
fn accepted_chain_and_curve_are_near_each_other() {
    const PLACES: u32 = 400;
    let mut random = Rng::with_seed(20_261_121);
    let (mut followed, mut refused) = (0, 0);
    for _ in 0..6_000 {
        let size = 10_i64.pow(random.u32(3..=7));
        let curve = any_curve(&mut random, size);
        let (count, chord_error) = (random.u32(1..=24), random.i64(3..=(size / 10).clamp(4, 200_000)));
        let Some(chain) = chain_along(&curve, &mut random, count, chord_error / 2) else { continue };
        let allowed = Length::from_units(chord_error).expect("a length");
        if curve.follows(&chain, allowed).is_err() {
            refused += 1;
            continue;
        }
        followed += 1;
        let allowed = f64::from(allowed.units());
        let places: Vec<Xy> = (0..=PLACES).map(|k| at(&curve, f64::from(k) / f64::from(PLACES))).collect();
        for &place in &places {
            let off = chain.iter().map(|each| distance(each, place)).fold(f64::INFINITY, f64::min);
            assert!(off <= allowed + 1e-3, "{curve:?} is {off} off {chain:?}, bound {allowed}");
        }
        // Between two sampled points the curve is near its chord, by the longest step and a little.
        let step = places.windows(2).map(|p| (p[0].0 - p[1].0).hypot(p[0].1 - p[1].1)).fold(0.0, f64::max);
        for each in &chain {
            let (a, b) = (xy(each.from()), xy(each.to()));
            let middle = (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1));
            for joint in [a, b].into_iter().chain(matches!(each, Curve::Line(_)).then_some(middle)) {
                let off =
                    places.iter().map(|p| (p.0 - joint.0).hypot(p.1 - joint.1)).fold(f64::INFINITY, f64::min);
                assert!(off <= 2.0 * allowed + step, "{joint:?} of {chain:?} is {off} off {curve:?}");
            }
        }
    }
    assert!(followed > 300 && refused > 300, "{followed} followed, {refused} refused");
}

// Evidence for SR-02.
/// The check refuses every chain from which the curve is off by more than the chord-error bound somewhere.
#[test]
fn chain_off_the_curve_is_refused() {
    let mut random = Rng::with_seed(7);
    let mut off_somewhere = 0;
    for _ in 0..6_000 {
        let curve = any_curve(&mut random, 100_000);
        let (count, moved) = (random.u32(2..=30), random.i64(0..=2_000));
        let Some(chain) = chain_along(&curve, &mut random, count, moved) else { continue };
        let places = (0..=300).map(|k| at(&curve, f64::from(k) / 300.0));
        let off = places
            .map(|place| chain.iter().map(|each| distance(each, place)).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        let chord_error = keepout_kernel::curve::round_down(off - 1.0);
        let Ok(chord_error) = Length::from_units(chord_error) else { continue };
        off_somewhere += 1;
        assert!(
            curve.follows(&chain, chord_error).is_err(),
            "{curve:?} is {off} off {chain:?}, bound {chord_error:?}"
        );
    }
    assert!(off_somewhere > 3_000, "{off_somewhere}");
}
