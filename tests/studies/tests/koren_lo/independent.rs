//! Cross-coupling against an evaluation of eqs. (15) to (17) that shares no code with it: curves by their formulas
//! or as points, friction by small steps, and distances to many points of the curve.

use std::f64::consts::TAU;

use keepout_drives::controllers::kind::Kind;
use keepout_drives::reference::Ramp;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_studies::koren_lo::finishing::loops;
use keepout_studies::koren_lo::scenario::{DriveScenario, PathShape};

use super::{Row, UM};

/// A point of a curve: x, y, direction and signed curvature.
#[derive(Clone, Copy)]
struct Place {
    at: [f64; 2],
    way: f64,
    bend: f64,
}

/// A curve as many points, with their distances along it.
struct Dense {
    places: Vec<Place>,
    along: Vec<f64>,
}

impl Dense {
    fn of(places: Vec<Place>) -> Self {
        let mut along = vec![0.0];
        for pair in places.windows(2) {
            let step = (pair[1].at[0] - pair[0].at[0]).hypot(pair[1].at[1] - pair[0].at[1]);
            along.push(along[along.len() - 1] + step);
        }
        Self { places, along }
    }

    fn length(&self) -> f64 {
        self.along[self.along.len() - 1]
    }

    /// The place at a distance from the start, between the points around it.
    fn at(&self, along: f64) -> Place {
        let next = self.along.partition_point(|&each| each < along).clamp(1, self.along.len() - 1);
        let (a, b) = (self.places[next - 1], self.places[next]);
        let share = (along - self.along[next - 1]) / (self.along[next] - self.along[next - 1]);
        let turn = (b.way - a.way + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        Place {
            at: [0, 1].map(|axis| a.at[axis] + share * (b.at[axis] - a.at[axis])),
            way: a.way + share * turn,
            bend: a.bend,
        }
    }

    /// The distance of `point` from the part of the curve up to `far` behind the reference and a little ahead of it.
    fn distance(&self, point: [f64; 2], along: f64, far: f64) -> f64 {
        let first = self.along.partition_point(|&each| each < along - far);
        let last = self.along.partition_point(|&each| each < along + far / 4.0).min(self.places.len() - 1);
        let mut least = f64::INFINITY;
        for pair in self.places[first.min(last.saturating_sub(1))..=last].windows(2) {
            let (a, b) = (pair[0].at, pair[1].at);
            let (way, off) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
            let size = way[0] * way[0] + way[1] * way[1];
            let share = ((off[0] * way[0] + off[1] * way[1]) / size).clamp(0.0, 1.0);
            least = least.min((off[0] - share * way[0]).hypot(off[1] - share * way[1]));
        }
        least
    }
}

/// One axis: speed and position under a command, in small steps.
struct Motor {
    position: f64,
    speed: f64,
}

const GAIN: f64 = 10.0;
const TAU_S: f64 = 0.045;
const PERIOD_S: f64 = 0.004;
const PARTS: u32 = 400;

impl Motor {
    fn go_on(&mut self, command: f64, friction: f64) {
        let dt = PERIOD_S / f64::from(PARTS);
        for _ in 0..PARTS {
            if self.speed == 0.0 && command.abs() <= friction {
                continue;
            }
            let against = if self.speed == 0.0 { command.signum() } else { self.speed.signum() } * friction;
            let next = self.speed + dt / TAU_S * (GAIN * (command - against) - self.speed);
            // Friction stops an axis, and does not turn it round.
            let next = if friction > 0.0 && next * self.speed < 0.0 { 0.0 } else { next };
            self.position += dt * f64::midpoint(self.speed, next);
            self.speed = next;
        }
    }
}

/// RMS contour error, pulses, of cross-coupling on a curve.
fn evaluated(curve: &Dense, feed: f64, friction: f64, distance_at: impl Fn(f64) -> f64, lasts_s: f64) -> f64 {
    let mut motors = [0, 1].map(|axis| Motor { position: curve.places[0].at[axis], speed: 0.0 });
    let (mut sum, mut before) = (0.0, 0.0);
    let (mut squares, mut count) = (0.0, 0.0);
    let mut number = 0.0;
    while number * PERIOD_S <= lasts_s + PERIOD_S {
        let along = distance_at((number * PERIOD_S).min(lasts_s));
        let Place { at, way, bend } = curve.at(along);
        let tool = [motors[0].position, motors[1].position];
        squares += curve.distance(tool, along, feed * 0.5).powi(2);
        count += 1.0;
        // Eqs. (15) to (17), with rho = 1/bend.
        let (ex, ey) = (at[0] - tool[0], at[1] - tool[1]);
        let (cx, cy) = (way.sin() - ex * bend / 2.0, way.cos() + ey * bend / 2.0);
        let error = -ex * cx + ey * cy;
        sum += PERIOD_S * error;
        let law = 8.0 * error + 60.0 * sum + 0.6 * (error - before) / PERIOD_S;
        before = error;
        motors[0].go_on(ex - cx * law, friction);
        motors[1].go_on(ey + cy * law, friction);
        number += 1.0;
    }
    f64::sqrt(squares / count)
}

fn agrees(found: f64, independent: f64, name: &str) {
    let (found, independent) = (found * UM, independent * UM);
    println!("{name}: {found:.3} µm, by the other evaluation {independent:.3} µm");
    assert!((found / independent - 1.0).abs() < 0.01, "{name}: {found} and {independent}");
}

/// The ellipse of X2 by its formula, with friction.
#[test]
fn ellipse_agrees_with_an_independent_evaluation() {
    let (a, b) = (2000.0, 800.0);
    let place = |number: u32| {
        let angle = TAU * f64::from(number) / 40_000.0;
        let (dx, dy) = (a * angle.sin(), b * angle.cos());
        // It turns clockwise.
        let bend = -a * b / dx.hypot(dy).powi(3);
        Place { at: [a - a * angle.cos(), b * angle.sin()], way: dy.atan2(dx), bend }
    };
    let curve = Dense::of((0..=40_000).map(place).collect());
    let (feed, ramp_s) = (1.5 * 1e5 / 60.0, 0.2);
    let length = curve.length();
    let lasts = length / feed + ramp_s;
    let rising = |t: f64| {
        let turn = TAU / 2.0 / ramp_s;
        if t < ramp_s { feed / 2.0 * (t - (turn * t).sin() / turn) } else { feed * (t - ramp_s / 2.0) }
    };
    let along = |t: f64| if t < lasts / 2.0 { rising(t) } else { length - rising(lasts - t) };
    let independent = evaluated(&curve, feed, 100.0, along, lasts);
    agrees(Row::named("X2").figures(Kind::Ccc).contour.rms, independent, "X2");
}

/// A spiral of arcs, by the formula of the spiral.
#[test]
fn spiral_agrees_with_an_independent_evaluation() {
    let (from, to, turns) = (500.0, 2000.0, 3.0);
    let place = |number: u32| {
        let angle = TAU * turns * f64::from(number) / 120_000.0;
        let grow = (to - from) / (TAU * turns);
        let radius = from + grow * angle;
        let (sin, cos) = angle.sin_cos();
        let (dx, dy) = (grow * cos - radius * sin, grow * sin + radius * cos);
        let bend = (radius * radius + 2.0 * grow * grow) / (radius * radius + grow * grow).powf(1.5);
        Place { at: [radius * cos, radius * sin], way: dy.atan2(dx), bend }
    };
    let curve = Dense::of((0..=120_000).map(place).collect());
    let feed = 1.5 * 1e5 / 60.0;
    let lasts = curve.length() / feed;
    let independent = evaluated(&curve, feed, 0.0, |t| feed * t, lasts);
    agrees(Row::named("X4").figures(Kind::Ccc).contour.rms, independent, "spiral");
}

/// The finishing contour of a drawing of splines.
#[test]
fn contour_of_splines_agrees_with_an_independent_evaluation() {
    let bytes = include_bytes!("../../../drawings/spline_periodic.dxf");
    let plan = PlanRequest::default()
        .plan("splines", bytes, &MachineProfile::simulated(), &mut |_| {})
        .expect("the drawing is planned");
    let found = loops(&plan.plan).swap_remove(0);
    assert!(found.pieces.len() > 8, "{} pieces", found.pieces.len());
    let mut places = Vec::new();
    for piece in &found.pieces {
        let count = (piece.length() * 2000.0).ceil();
        let mut number = 0.0;
        while number < count {
            let foot = piece.at(piece.length() * number / count);
            places.push(Place {
                at: [foot.point.x * 100.0, foot.point.y * 100.0],
                way: foot.tangent.y.atan2(foot.tangent.x),
                bend: foot.curvature / 100.0,
            });
            number += 1.0;
        }
    }
    let curve = Dense::of(places);
    let row = Row::named("S2");
    let scenario = DriveScenario { path: PathShape::Given(found.pieces), ramp: Ramp::None, ..row.row };
    let mut controller =
        Kind::Ccc.built(&row.machine.setting(super::Environment::of(&row.task, 0.0))).unwrap();
    let ours = scenario.task(&row.machine).run(controller.as_mut()).figures.contour.rms;
    let feed = scenario.feed_m_min * 1e5 / 60.0;
    let independent = evaluated(&curve, feed, 0.0, |t| feed * t, curve.length() / feed);
    agrees(ours, independent, "splines");
}
