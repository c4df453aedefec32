//! The curves of a sketch, computed independently. The curves that the importer reads must lie on them and
//! leave out no curve.

use std::f64::consts::TAU;

use keepout_kernel::Curve;
use keepout_planner::Mm2;
use keepout_planner::drawing::{Chained, Repair};
use keepout_planner::profile::Profile;

use super::shape::SketchOutline;
use super::spoil::{Spoilt, SpoiltEdge, spoilt};
use super::{Nest, Sketch, SketchFigure};
use crate::oracle::{self, UNIT, Xy, between, on_the_way, to_chord};

/// Allowed deviation of the curves read, lattice units. The importer joins ends this near without a note,
/// and reads curves this flat as lines.
const ROUNDING: f64 = 15.0;
/// Number of chords for an edge, or for a span of a spline.
const CHORDS: u32 = 64;
/// Number of chords for a circle or an ellipse.
const ROUND: u32 = 1024;
/// Largest number of points compared on either side.
const PLACES_MAX: usize = 400;
/// Largest number of computed distances.
const DISTANCES_MAX: usize = 1_000_000;
/// The importer leaves out a contour this near to another, beyond the gap tolerance. The value is doubled,
/// because chords stand for the contour's arcs.
const COARSE: f64 = 200.0;
/// Range of the size of bulges. Outside of it, rounding moves the arc.
const BULGES: std::ops::Range<f64> = 1e-5..8.0;
/// Coordinates beyond this, mm, inside or outside of blocks, are off the lattice or lose their last digits.
const FAR_MM: f64 = 1e6;

/// The curves of the figures on one layer, each as points along it, lattice units.
struct Truth<'a> {
    sketch: &'a Sketch,
    curves: Vec<Along>,
    /// The positions of all curves are known.
    whole: bool,
    bent: bool,
}

/// A curve as points along it.
struct Along {
    points: Vec<Xy>,
    /// Largest distance between the chords and the curve.
    sagitta: f64,
}

/// Compares the curves read for the part, or for the keep-out zones, with the sketch.
///
/// # Panics
/// When a curve was not drawn, or a drawn curve is missing.
pub fn compare(sketch: &Sketch, zones: bool, chained: &Chained) {
    let truth = Truth::of(sketch, zones);
    let gap_mm = chained.repairs.iter().filter_map(|repair| match repair {
        Repair::GapClosed { gap_mm, .. } => Some(*gap_mm),
        _ => None,
    });
    let gap = gap_mm.fold(0.0, f64::max) * UNIT;
    if gap > 0.0 && truth.bent {
        // A moved end changes the whole arc.
        return;
    }
    let off = (sketch.order.curve_mm * UNIT).max(gap) + ROUNDING;
    truth.is_all(&chained.profile, off);
    if chained.problems.is_empty() {
        let joined = (sketch.order.join_mm * UNIT).max(ROUNDING);
        let doubled = chained.repairs.iter().any(|repair| matches!(repair, Repair::DuplicateDropped { .. }));
        let apart = if doubled { joined + 2.0 * COARSE } else { 0.0 };
        // A line drawn there and back encloses no area. It may be left out, if it is listed with its length.
        let flat_mm = chained.repairs.iter().filter_map(|repair| match repair {
            Repair::ThereAndBack { length_mm, .. } => Some(2.0 * length_mm),
            _ => None,
        });
        let flat = flat_mm.fold(0.0, f64::max) * UNIT;
        let short = if flat > 0.0 { flat + ROUNDING } else { 0.0 };
        truth.is_there(&chained.profile, off + 2.0 * joined + apart, short.max(4.0 * joined));
    }
}

impl<'a> Truth<'a> {
    fn of(sketch: &'a Sketch, zones: bool) -> Self {
        let mut truth = Self { sketch, curves: Vec::new(), whole: true, bent: false };
        for figure in sketch.outlines.iter().filter(|figure| figure.zone == zones) {
            let drawn = Drawn::of(figure);
            truth.bent |= drawn.bent;
            truth.whole &= drawn.whole;
            let places = places(figure);
            truth.whole &= places.is_some();
            for place in places.unwrap_or_default() {
                for curve in &drawn.curves {
                    truth.take(curve.iter().map(|&point| sketch.seen(place.of(point))).collect());
                }
            }
        }
        truth
    }

    fn take(&mut self, curve: Vec<Xy>) {
        let is_near = |point: &Xy| point.0.abs() < FAR_MM * UNIT && point.1.abs() < FAR_MM * UNIT;
        if !curve.iter().all(is_near) {
            self.whole = false;
            return;
        }
        let middle = |three: &[Xy]| {
            let (a, b) = (three[0], three[2]);
            between(three[1], (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1)))
        };
        // The sagitta of a chord over two even stretches is four times that over one. Half of it is a safe
        // value.
        let sagitta = curve.windows(3).map(middle).fold(0.0, f64::max) / 2.0;
        // If the points are too far apart to stand for the curve, its position is unknown.
        if sagitta > 0.01 * length(&curve) {
            self.whole = false;
        } else {
            self.curves.push(Along { points: curve, sagitta });
        }
    }

    /// Checks that the curves read lie on the drawn curves.
    fn is_all(&self, profile: &Profile, off: f64) {
        if !self.whole {
            return;
        }
        let read: Vec<Xy> = curves_of(profile).flat_map(oracle::places).collect();
        let chords: usize = self.curves.iter().map(|curve| curve.points.len()).sum();
        for &place in read.iter().step_by(step(read.len(), chords)) {
            let left = self.curves.iter().map(|curve| {
                let chords = curve.points.windows(2).map(|pair| to_chord(place, (pair[0], pair[1])));
                chords.fold(f64::INFINITY, f64::min) - curve.sagitta
            });
            let left = left.fold(f64::INFINITY, f64::min);
            assert!(
                left <= off,
                "{place:?} was not drawn: the nearest curve is {left} away, not {off}\n{:?}",
                self.sketch
            );
        }
    }

    /// Checks that the drawn curves were read. Curves no longer than `short` may be left out.
    fn is_there(&self, profile: &Profile, off: f64, short: f64) {
        let long = self.curves.iter().filter(|curve| length(&curve.points) > short);
        let drawn: Vec<Xy> = long.flat_map(|curve| &curve.points).copied().collect();
        for &place in drawn.iter().step_by(step(drawn.len(), curves_of(profile).count())) {
            let left = oracle::distance(place, curves_of(profile));
            assert!(
                left <= off,
                "{place:?} was drawn: the nearest contour is {left} away, not {off}\n{:?}",
                self.sketch
            );
        }
    }
}

/// The step between compared points that keeps the number of comparisons in its limits.
fn step(places: usize, others: usize) -> usize {
    places / PLACES_MAX.min(DISTANCES_MAX / (others + 1)).max(1) + 1
}

/// A figure's curves in its own coordinates.
struct Drawn {
    curves: Vec<Vec<Xy>>,
    whole: bool,
    bent: bool,
}

impl Drawn {
    fn of(figure: &SketchFigure) -> Self {
        let (curves, bent): (Vec<Option<Vec<Xy>>>, bool) = match spoilt(&figure.outline, &figure.spoilt) {
            Spoilt::Edges(edges) => {
                let bent = edges.iter().any(|edge| edge.from.bulge != 0.0);
                (edges.iter().map(points_of).collect(), bent)
            }
            Spoilt::Whole(outline, _) => (vec![whole(&outline)], true),
        };
        let known: Vec<Vec<Xy>> = curves.iter().flatten().cloned().collect();
        Self { whole: known.len() == curves.len(), curves: known, bent }
    }
}

/// Points along an edge; `None` if rounding could move it.
fn points_of(edge: &SpoiltEdge) -> Option<Vec<Xy>> {
    let (a, b, bulge) = (edge.from.at, edge.to, edge.from.bulge);
    if bulge == 0.0 {
        // The middle is left out, because an edge of another contour with the same corners may cross there.
        return Some((0..=5_u8).map(|k| on_the_way(a, b, f64::from(k) / 5.0)).collect());
    }
    if !BULGES.contains(&bulge.abs()) {
        return None;
    }
    // The edge turns about a point of the bisector, by four times the angle whose tangent is the bulge.
    let sweep = 4.0 * bulge.atan();
    let off = 0.5 / (sweep / 2.0).tan();
    let middle = on_the_way(a, b, 0.5);
    let centre = (middle.0 - (b.1 - a.1) * off, middle.1 + (b.0 - a.0) * off);
    let (x, y) = (a.0 - centre.0, a.1 - centre.1);
    let at = |k| {
        let (sine, cosine) = (sweep * f64::from(k) / f64::from(CHORDS)).sin_cos();
        (centre.0 + x * cosine - y * sine, centre.1 + x * sine + y * cosine)
    };
    Some((0..=CHORDS).map(at).collect())
}

/// Points along a full circle or ellipse, or a spline.
fn whole(outline: &SketchOutline) -> Option<Vec<Xy>> {
    match outline {
        SketchOutline::Corners(_) => None,
        SketchOutline::Round { centre, axis, ratio, range, circle } => {
            let ratio = if *circle { 1.0 } else { *ratio };
            if *range != (0.0, TAU) || !(1e-3..=1.0).contains(&ratio) {
                return None;
            }
            let at = |k| {
                let (sine, cosine) = (TAU * f64::from(k) / f64::from(ROUND)).sin_cos();
                let along = |a: f64, b: f64| a * cosine + b * ratio * sine;
                (centre.0 + along(axis.0, -axis.1), centre.1 + along(axis.1, axis.0))
            };
            Some((0..=ROUND).map(at).collect())
        }
        SketchOutline::Spline { degree, knots, points, weights } => {
            spline(usize::from(*degree), knots, points, weights)
        }
    }
}

/// Points along a NURBS curve, span by span, by the definition of its basis (Piegl & Tiller, The NURBS
/// Book, eq. 2.5 and 4.1). `None` if knots are out of order or nearly equal.
fn spline(degree: usize, knots: &[f64], points: &[Xy], weights: &[f64]) -> Option<Vec<Xy>> {
    let (first, last) = (*knots.get(degree)?, *knots.get(points.len())?);
    let clear = |pair: &[f64]| pair[1] == pair[0] || pair[1] - pair[0] > 1e-3;
    if knots.len() != points.len() + degree + 1 || !knots.windows(2).all(clear) || last <= first {
        return None;
    }
    let mut out = Vec::new();
    for span in degree..points.len() {
        let (u0, u1) = (knots[span], knots[span + 1]);
        // The end of a span is the beginning of the next.
        let first = u32::from(!out.is_empty());
        for k in (first..=CHORDS).filter(|_| u1 > u0) {
            let u = u0 + (u1 - u0) * f64::from(k) / f64::from(CHORDS);
            let mut basis = vec![0.0; degree + 1];
            basis[degree] = 1.0;
            // The basis functions that are not zero on the span, degree by degree. Index i stands for span
            // − degree + i.
            for p in 1..=degree {
                for i in degree - p..=degree {
                    let knot = span + i - degree;
                    let share =
                        |part: f64, from: f64, to: f64| if to > from { part / (to - from) } else { 0.0 };
                    let up = share(u - knots[knot], knots[knot], knots[knot + p]);
                    let Some(&next) = basis.get(i + 1) else {
                        basis[i] *= up;
                        continue;
                    };
                    let end = knots[knot + p + 1];
                    basis[i] = up * basis[i] + share(end - u, knots[knot + 1], end) * next;
                }
            }
            let (mut x, mut y, mut w) = (0.0, 0.0, 0.0);
            for (i, value) in basis.iter().enumerate() {
                let number = span - degree + i;
                let weight = value * weights.get(number).copied().unwrap_or(1.0);
                (x, y, w) = (x + points[number].0 * weight, y + points[number].1 * weight, w + weight);
            }
            out.push((x / w, y / w));
        }
    }
    Some(out)
}

/// The placements of a figure; `None` if it is seen edge-on or its blocks have an unknown place.
fn places(figure: &SketchFigure) -> Option<Vec<Place>> {
    let mut all = vec![Place { axes: [(1.0, 0.0), (0.0, 1.0)], origin: (0.0, 0.0) }];
    for nest in &figure.nest {
        all = copies(nest)?.iter().flat_map(|copy| all.iter().map(|below| copy.after(below))).collect();
    }
    (all.len() < 500).then_some(all)
}

fn copies(nest: &Nest) -> Option<Vec<Place>> {
    let Nest { at, scale, degrees, array: (columns, rows, spacing) } = *nest;
    let figures = [at.0, at.1, spacing, degrees];
    let is_near = |figure: &f64| figure.abs() < FAR_MM;
    if !figures.iter().all(is_near) || scale.0 == 0.0 || scale.1 == 0.0 {
        return None;
    }
    let turned = |point| turned(point, degrees);
    let mut copies = Vec::new();
    for column in 0..columns.max(1) {
        for row in 0..rows.max(1) {
            let step = turned((f64::from(column) * spacing, f64::from(row) * spacing));
            copies.push(Place {
                axes: [turned((scale.0, 0.0)), turned((0.0, scale.1))],
                origin: (at.0 + step.0, at.1 + step.1),
            });
        }
    }
    Some(copies)
}

/// An affine map: the images of the axes, and of the origin.
#[derive(Clone, Copy)]
struct Place {
    axes: [Xy; 2],
    origin: Xy,
}

impl Place {
    fn of(&self, (x, y): Xy) -> Xy {
        let [a, b] = self.axes;
        (a.0 * x + b.0 * y + self.origin.0, a.1 * x + b.1 * y + self.origin.1)
    }

    fn after(&self, first: &Self) -> Self {
        let straight = Self { origin: (0.0, 0.0), ..*self };
        Self { axes: first.axes.map(|axis| straight.of(axis)), origin: self.of(first.origin) }
    }
}

impl Sketch {
    /// A point of the drawing on the lattice of the machine, not rounded.
    fn seen(&self, (x, y): Xy) -> Xy {
        let unit_mm = match self.units {
            Some(1) => 25.4,
            Some(6) => 1000.0,
            _ => 1.0,
        };
        let (x, y) = (x * unit_mm, y * unit_mm);
        let (x, y) = match self.order.choice.placed {
            None => (x, y),
            Some((degrees, Mm2 { x: dx, y: dy })) => {
                let (x, y) = turned((x, y), degrees);
                (x + dx, y + dy)
            }
        };
        (x * UNIT, y * UNIT)
    }
}

fn turned((x, y): Xy, degrees: f64) -> Xy {
    let (sine, cosine) = degrees.rem_euclid(360.0).to_radians().sin_cos();
    (x * cosine - y * sine, x * sine + y * cosine)
}

fn curves_of(profile: &Profile) -> impl Iterator<Item = &Curve> {
    profile.loops.iter().flat_map(|each| each.edges.iter().map(|edge| &edge.curve))
}

fn length(curve: &[Xy]) -> f64 {
    curve.windows(2).map(|pair| between(pair[0], pair[1])).sum()
}
