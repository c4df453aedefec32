use super::*;
use keepout_planner::Mm2;

#[test]
fn circle_agrees_with_the_papers_formula() {
    // x = rho(1 − cos wt), y = rho·sin wt.
    let circle = Path::circle(2000.0, true, 1);
    for angle in [0.1, 1.0, 4.0] {
        let (_, foot) = circle.at(2000.0 * angle).unwrap();
        let wanted = Axes::new(2000.0 * (1.0 - angle.cos()), 2000.0 * angle.sin());
        assert!((foot.point - wanted).norm() < 1e-9);
        assert!((foot.tangent - Axes::new(angle.sin(), angle.cos())).norm() < 1e-12);
        assert!((foot.curvature + 1.0 / 2000.0).abs() < 1e-15);
    }
}

/// Compares the distances with a search over many points.
#[test]
fn nearest_point_agrees_with_a_brute_force_search() {
    let path = Path::of(vec![
        PathPiece::Line { from: Axes::zeros(), to: Axes::new(100.0, 0.0) },
        PathPiece::arc(Axes::new(100.0, 30.0), Axes::new(100.0, 0.0), 2.0),
        PathPiece::arc(Axes::new(200.0, 30.0), Axes::new(180.0, 30.0), -1.0),
    ]);
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..300 {
        let index = random.usize(0..3);
        let piece = path.pieces()[index];
        let point = Axes::new(random.f64() * 260.0 - 30.0, random.f64() * 120.0 - 30.0);
        let foot = piece.nearest(point);
        let steps = 20_000;
        let nearest = (0..=steps)
            .map(|i| (piece.at(piece.length() * f64::from(i) / f64::from(steps)).point - point).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(((foot.point - point).norm() - nearest).abs() < 1e-2, "{index}");
        assert!((piece.at(piece.along(point)).point - foot.point).norm() < 1e-6, "{index}");
        assert!((foot.distance(point).abs() - (foot.point - point).norm()).abs() < 1e-12);
    }
}

#[test]
fn distance_to_the_left_is_positive() {
    let foot = Path::line(Axes::new(10.0, 0.0)).nearest(Axes::new(5.0, 2.0), 0);
    assert!((foot.distance(Axes::new(5.0, 2.0)) - 2.0).abs() < 1e-12);
    // The left side of a clockwise circle is the outside.
    let circle = Path::circle(20.0, true, 1);
    let point = Axes::new(-3.0, 0.1);
    assert!(circle.nearest(point, 0).distance(point) > 2.9);
}

#[test]
fn arcs_approximate_the_ellipse() {
    let (a, b) = (2000.0, 1000.0);
    let ellipse = Path::ellipse(a, b);
    let mut worst: f64 = 0.0;
    for step in 0..20_000 {
        let (_, foot) = ellipse.at(ellipse.length() * f64::from(step) / 20_000.0).unwrap();
        let (x, y) = ((foot.point.x - a) / a, foot.point.y / b);
        worst = worst.max((x.hypot(y) - 1.0).abs() * b);
    }
    assert!(worst < 1e-4, "{worst} pulses");
}

#[test]
fn overshoot_past_a_corner_is_measured() {
    let past = |path: &Path, Mm2 { x, y }: Mm2, on: usize| {
        let point = Axes::new(x, y);
        path.overshoot(point, &path.nearest(point, on), on)
    };
    let corner = Path::corner(100.0, std::f64::consts::FRAC_PI_2);
    assert!((past(&corner, Mm2::new(103.0, 20.0), 1) - 3.0).abs() < 1e-12);
    assert!((past(&corner, Mm2::new(103.0, 0.0), 0) - 3.0).abs() < 1e-12);
    assert!(past(&corner, Mm2::new(97.0, 0.0), 0) <= 0.0);
    // The second leg also advances in the direction of the first. That is not an overshoot.
    let flat = Path::corner(100.0, std::f64::consts::FRAC_PI_4);
    assert!(past(&flat, Mm2::new(150.0, 50.0), 1).abs() < 1e-9);
    assert!((past(&flat, Mm2::new(102.0, -2.0), 0) - 2.0).abs() < 1e-9);
    assert!(past(&Path::circle(10.0, true, 2), Mm2::new(-1.0, 3.0), 1) <= 0.0);
}
