//! A finishing loop in the direction of the cut, and places on it.

use keepout_kernel::Vec2;
use keepout_kernel::{Curve, Point, Segment, Turn, UNITS_PER_MM};

use crate::Mm2;
use crate::finish::FinishingLoop;
use crate::plan::Cut;
use crate::units::{along_mm, arc_mm, dividing_point, point_from_mm, point_mm};

/// Least length that is split off a curve, lattice units (10 µm).
const SHORT: i32 = 1000;
/// A place nearer than this to a curve's end moves to that end, mm.
const AT_END_MM: f64 = 0.001;
/// Least length of a curve's remainder where a loop is resumed, mm.
pub(super) const PIECE_MM: f64 = 0.015;

/// Loop in the direction of the cut.
pub(super) struct Track {
    curves: Vec<Curve>,
    /// Start of each curve, and the end of the last one, along the loop, mm.
    starts_mm: Vec<f64>,
    cut: Cut,
}

/// Place on a track.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Number of the curve.
    index: usize,
    /// The place, mm.
    pub at: Mm2,
    /// Position along the track, mm.
    pub along_mm: f64,
    /// Unit vector away from the part.
    outward: Mm2,
    /// Unit vector of travel.
    travel: Mm2,
}

impl Entry {
    /// The lattice point that is `along_mm` farther in the direction of travel and `out_mm` farther from
    /// the part.
    pub fn aside(&self, along_mm: f64, out_mm: f64) -> Option<Point> {
        point_from_mm(self.at + self.travel * along_mm + self.outward * out_mm).ok()
    }

    /// Its distance from a point, mm.
    pub fn distance_mm(&self, point: Point) -> f64 {
        self.at.distance(point_mm(point))
    }
}

/// Place on a track where a motion begins or ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    /// The place.
    pub entry: Entry,
    /// Its lattice point.
    pub point: Point,
}

impl Track {
    /// The loop in the direction of the cut; `None` when one of its arcs cannot be reversed.
    pub fn of(each: &FinishingLoop, cut: Cut) -> Option<Self> {
        let curves: Vec<Curve> = match cut {
            Cut::Conventional => each.curves.clone(),
            Cut::Climb => each.curves.iter().rev().map(Curve::reversed).collect::<Option<_>>()?,
        };
        let mut starts_mm = vec![0.0];
        let mut along = 0.0;
        for curve in &curves {
            along += length_mm(curve);
            starts_mm.push(along);
        }
        (!curves.is_empty()).then_some(Self { curves, starts_mm, cut })
    }

    /// Its length, mm.
    pub fn length_mm(&self) -> f64 {
        self.starts_mm.last().copied().unwrap_or(0.0)
    }

    /// Turn of a lead arc: it touches the track from the tool's side, in the direction of travel.
    pub fn lead_turn(&self) -> Turn {
        match self.cut {
            Cut::Conventional => Turn::Clockwise,
            Cut::Climb => Turn::CounterClockwise,
        }
    }

    /// The place at `along_mm`, taken modulo the length.
    pub fn at(&self, along_mm: f64) -> Entry {
        let along = along_mm.rem_euclid(self.length_mm().max(f64::MIN_POSITIVE));
        let index = self.starts_mm.partition_point(|&start| start <= along).clamp(1, self.curves.len()) - 1;
        let share = (along - self.starts_mm[index]) / length_mm(&self.curves[index]);
        self.on(index, share.clamp(0.0, 1.0))
    }

    fn on(&self, index: usize, share: f64) -> Entry {
        let curve = &self.curves[index];
        let (at, travel) = along_mm(curve, share);
        let outward = match self.cut {
            Cut::Conventional => -travel.left(),
            Cut::Climb => travel.left(),
        };
        let along_mm = self.starts_mm[index] + share * length_mm(curve);
        Entry { index, at, along_mm, outward, travel }
    }

    /// The place of each curve that is nearest to `point`, with its distance in mm.
    pub fn nearest_of_each(&self, point: Point) -> impl Iterator<Item = (f64, Entry)> {
        self.curves.iter().enumerate().map(move |(index, curve)| {
            let entry = self.on(index, share_nearest(curve, point_mm(point)));
            (entry.distance_mm(point), entry)
        })
    }

    /// The place that is nearest to `point`, with its distance in mm.
    pub fn nearest(&self, point: Point) -> (f64, Entry) {
        let by_distance = |a: &(f64, Entry), b: &(f64, Entry)| a.0.total_cmp(&b.0);
        let nearest = self.nearest_of_each(point).min_by(by_distance);
        nearest.unwrap_or_else(|| (f64::INFINITY, self.on(0, 0.0)))
    }

    /// Joint for an entry: the place itself, or the end of the curve when that is near.
    pub fn joint(&self, entry: Entry) -> Option<Joint> {
        let curve = &self.curves[entry.index];
        let point = dividing_point(curve, entry.at).ok()?;
        let close = |end: Point| {
            let d = end.minus(point);
            d.dx.abs() <= SHORT && d.dy.abs() <= SHORT
        };
        let (from, to) = (curve.from(), curve.to());
        let joint = |point, entry| Some(Joint { entry, point });
        match (close(from), close(to)) {
            (true, _) => joint(from, self.on(entry.index, 0.0)),
            (_, true) => joint(to, self.on(entry.index, 1.0)),
            _ => joint(point, entry),
        }
    }

    /// Joint for resuming at `along_mm`: there, or a little before it. No remainder is shorter than
    /// [`PIECE_MM`].
    pub fn joint_before(&self, along_mm: f64) -> Option<Joint> {
        let Entry { index, along_mm, .. } = self.at(along_mm);
        let length = length_mm(&self.curves[index]);
        let on = (along_mm - self.starts_mm[index]).min(length - PIECE_MM);
        self.joint_on(index, if on < PIECE_MM { 0.0 } else { on })
    }

    /// Joint for leaving at `along_mm`: there, or a little beyond it. No remainder is shorter than
    /// [`PIECE_MM`].
    pub fn joint_behind(&self, along_mm: f64) -> Option<Joint> {
        let Entry { index, along_mm, .. } = self.at(along_mm);
        let length = length_mm(&self.curves[index]);
        let on = along_mm - self.starts_mm[index];
        let at_begin = on < AT_END_MM;
        let on = if length - on < PIECE_MM { length } else { on };
        self.joint_on(index, if at_begin { 0.0 } else { on })
    }

    fn joint_on(&self, index: usize, on_mm: f64) -> Option<Joint> {
        let (curve, length) = (&self.curves[index], length_mm(&self.curves[index]));
        if on_mm <= 0.0 {
            return Some(Joint { entry: self.on(index, 0.0), point: curve.from() });
        }
        if on_mm >= length {
            return Some(Joint { entry: self.on(index, 1.0), point: curve.to() });
        }
        let entry = self.on(index, on_mm / length);
        Some(Joint { entry, point: dividing_point(curve, entry.at).ok()? })
    }

    /// The curves from one place to another in the direction of travel. They go once around when `to` is
    /// not beyond `from` on the same curve.
    pub fn stretch(&self, from: &Joint, to: &Joint) -> Option<Vec<Curve>> {
        let (i, j) = (from.entry.index, to.entry.index);
        if i == j && from.entry.along_mm < to.entry.along_mm {
            return Some(between(&self.curves[i], from.point, to.point)?.into_iter().collect());
        }
        let mut curves: Vec<Curve> =
            between(&self.curves[i], from.point, self.curves[i].to())?.into_iter().collect();
        let count = (j + self.curves.len() - i - 1) % self.curves.len();
        curves.extend(self.curves.iter().cycle().skip(i + 1).take(count));
        curves.extend(between(&self.curves[j], self.curves[j].from(), to.point)?);
        Some(curves)
    }
}

/// A curve's length, mm.
pub(super) fn length_mm(curve: &Curve) -> f64 {
    curve.length() / f64::from(UNITS_PER_MM)
}

/// Share of the curve's length at which it is nearest to `p` (mm).
pub(crate) fn share_nearest(curve: &Curve, p: Mm2) -> f64 {
    let (a, b) = (point_mm(curve.from()), point_mm(curve.to()));
    match curve {
        Curve::Line(_) => a.distance(p.nearest_on(a, b)) / a.distance(b).max(f64::MIN_POSITIVE),
        Curve::Arc(arc) => {
            let nearer_end = || if a.distance(p) <= b.distance(p) { 0.0 } else { 1.0 };
            arc_mm(arc).share_beside(p.into()).unwrap_or_else(nearer_end)
        }
    }
}

/// The section of `curve` between two of its points; the inner `None` when the points are equal.
pub(super) fn between(curve: &Curve, from: Point, to: Point) -> Option<Option<Curve>> {
    if from == to {
        return Some(None);
    }
    match curve {
        Curve::Line(_) => Some(Some(Curve::Line(Segment { from, to }))),
        Curve::Arc(arc) if from == arc.from() && to == arc.to() => Some(Some(*curve)),
        Curve::Arc(arc) => Curve::fitted(from, to, Vec2::from(arc.centre()), arc.turn()).ok().map(Some),
    }
}
