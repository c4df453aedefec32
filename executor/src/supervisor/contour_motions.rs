//! The motions of a contour as they are sent, and their look-ahead.

use std::f64::consts::FRAC_PI_2;

use keepout_guard::{ContourMotion, Interpolation};
use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{Arc, Curve, Height, Length, Place, Point, Segment, UNITS_PER_MM};
use keepout_planner::Mm2;
use keepout_planner::units::{arc_mm, dividing_point, length_up_from_mm, mm, point_from_mm};

use super::Supervisor;
use super::contouring::NoContour;
use super::event::{Command, Mode};
use super::jog::length_mm;

impl Supervisor {
    /// The motions that the controller gets for a motion of the job: its curve in pieces, lines for a controller
    /// without arcs and for every ramp, or short steps for non-interpolated axes.
    pub(super) fn as_sent(
        &self,
        motion: &ContourMotion,
        stock: Length,
        into: &mut Vec<ContourMotion>,
    ) -> Result<(), NoContour> {
        let ContourMotion { curve, heights: [from, to], feed_mm_min } = *motion;
        let longest_mm = longest_mm(feed_mm_min);
        if curve.from() == curve.to() && matches!(curve, Curve::Line(_)) {
            climb(motion, longest_mm, into);
            return Ok(());
        }
        if let Curve::Arc(arc) = &curve
            && self.abilities.arcs
            && self.abilities.contours == Interpolation::Linear
            && from == to
        {
            let piece = |piece| ContourMotion { curve: Curve::Arc(piece), ..*motion };
            into.extend(quarters(arc, longest_mm)?.into_iter().map(piece));
            return Ok(());
        }
        let points = if from == to {
            curve.chord_points(self.chord_error_bound())?
        } else {
            self.ramp_points(curve, from.min(to))?
        };
        let mut lines: Vec<Segment> = Vec::new();
        for pair in points.windows(2) {
            let line = Segment { from: pair[0], to: pair[1] };
            self.steps(line, stock, longest_mm, &mut |from, to| lines.push(Segment { from, to }))?;
        }
        let all_mm: f64 = lines.iter().map(|line| length_mm(line.to.minus(line.from))).sum();
        let (count, mut gone_mm, mut height) = (lines.len(), 0.0, from);
        for (index, line) in lines.into_iter().enumerate() {
            gone_mm += length_mm(line.to.minus(line.from));
            let end = if index + 1 == count { to } else { part_of_climb(from, to, gone_mm / all_mm) };
            let heights = [std::mem::replace(&mut height, end), end];
            into.push(ContourMotion { curve: Curve::Line(line), heights, feed_mm_min });
        }
        Ok(())
    }

    /// The corners of the chords of a ramp. The lap after it cuts the contour, so they may lie beside the curve, on
    /// the side away from the part.
    fn ramp_points(&self, curve: Curve, lowest: Height) -> Result<Vec<Point>, NoContour> {
        let (part, clearance) = (self.plan().region(lowest), self.guard.rules().finishing_clearance);
        let is_clear = |points: &Vec<Point>| {
            points
                .windows(2)
                .all(|pair| part.edges_clear(Segment { from: pair[0], to: pair[1] }, clearance).is_ok())
        };
        let around = if let Curve::Arc(arc) = &curve { Some(circumscribed(arc)?) } else { None };
        let inside = length_up_from_mm(RAMP_CHORD_MM)?;
        let beside = curve.chord_points(inside).ok().into_iter().chain(around).find(is_clear);
        beside.map_or_else(|| Ok(curve.chord_points(self.chord_error_bound())?), Ok)
    }

    /// Chord-error bound for arcs: the difference between the finishing clearances of the plan and of the
    /// guard.
    fn chord_error_bound(&self) -> Length {
        let left = self.plan().finishing.units() - self.guard.rules().finishing_clearance.units();
        Length::from_units(i64::from(left) - 2).unwrap_or(CHORD_LEAST).max(CHORD_LEAST)
    }

    /// Cuts a line into steps that are short enough to stop after each. With non-interpolated axes, the box
    /// of each step stays within the stock.
    fn steps(
        &self,
        line: Segment,
        stock: Length,
        longest_mm: f64,
        take: &mut dyn FnMut(Point, Point),
    ) -> Result<(), NoContour> {
        let d = line.to.minus(line.from);
        let parts = length_mm(d) / longest_mm;
        let mut count = nearest_unit(parts.ceil()).max(1);
        if self.abilities.contours == Interpolation::Independent && d.dx != 0 && d.dy != 0 {
            let room = i64::from(stock.units()) - BOX_ROUNDING;
            if room < BOX_ROOM_LEAST {
                return Err(NoContour::NoStock);
            }
            // Distance of a corner of the box from its diagonal. With n steps, the distance is n times
            // smaller.
            let (x, y) = (f64::from(d.dx), f64::from(d.dy));
            let beside = nearest_unit((x * y).abs() / x.hypot(y));
            count = count.max(beside.div_euclid(room) + 1);
        }
        let mut from = line.from;
        for k in 1..=count {
            let part = |c: i32, d: i32| i64::from(c) + i64::from(d) * k / count;
            let to = Point::from_units(part(line.from.x.units(), d.dx), part(line.from.y.units(), d.dy));
            let to = if k == count { line.to } else { to.unwrap_or(line.to) };
            if to != from {
                take(from, to);
            }
            from = to;
        }
        Ok(())
    }

    /// Sends the motions within the look-ahead. The look-ahead is only long enough for the tool to keep its
    /// speed, so that a feed hold takes effect soon.
    pub(super) fn contour_on(&mut self, commands: &mut Vec<Command>) {
        while self.runs_low() {
            let Some(certified) = self.guard.next_of_contour() else { break };
            self.counts.contour_motions += 1;
            commands.push(Command::Move(certified.slowed(self.operation.feed)));
        }
    }

    /// Whether the queued motions of the contour last for less than the look-ahead. The known place of the
    /// tool is as old as the last report, and the controller must acknowledge the next motion. So the
    /// look-ahead includes a round trip for each.
    fn runs_low(&self) -> bool {
        // On a path that runs back over itself, the guard may place the tool too far back.
        if self.mode == Some(Mode::Idle) {
            return true;
        }
        // Someone holds the controller. A motion that arrives during a hold can make it run away.
        if matches!(self.mode, Some(Mode::Held | Mode::Slowing)) {
            return false;
        }
        let (Some((sent, _)), Some(at)) = (self.guard.contour_progress(), self.guard.contour_at()) else {
            return false;
        };
        let mut queued = self.guard.contour_left().iter().take(sent.saturating_sub(at));
        let Some(under_way) = queued.next() else { return true };
        let here = self.position.unwrap_or(under_way.from());
        let speed = |motion: &ContourMotion| mm_s(self.operation.feed.of(motion.feed_mm_min));
        let feed_mm_s = speed(under_way);
        let first = way_mm(here, under_way.to()) / feed_mm_s;
        let seconds = |motion: &ContourMotion| {
            let along_mm = motion.curve.length() / f64::from(UNITS_PER_MM);
            along_mm.hypot(climb_mm(motion.heights)) / speed(motion)
        };
        let behind: f64 = queued.map(seconds).sum();
        let braking = feed_mm_s / self.limits.acceleration_mm_s2;
        first + behind < 2.0 * self.polling.round_trip.as_secs_f64() + braking + LOOK_AHEAD_S
    }
}

/// A plunge or a rise in pieces that are short enough to stop after each.
fn climb(motion: &ContourMotion, longest_mm: f64, into: &mut Vec<ContourMotion>) {
    let [from, to] = motion.heights;
    let count = (climb_mm(motion.heights) / longest_mm).ceil().max(1.0);
    let (mut height, mut k) = (from, 1.0);
    while k <= count {
        let end = if k + 0.5 > count { to } else { part_of_climb(from, to, k / count) };
        if end != height {
            into.push(ContourMotion { heights: [height, end], ..*motion });
        }
        (height, k) = (end, k + 1.0);
    }
}

/// The height at a share of the way from one height to another.
fn part_of_climb(from: Height, to: Height, share: f64) -> Height {
    let up = f64::from(to.units()) - f64::from(from.units());
    Height::from_units(nearest_unit(f64::from(from.units()) + up * share)).unwrap_or(to)
}

/// The difference of two heights, mm.
fn climb_mm([from, to]: [Height; 2]) -> f64 {
    (mm(to.units()) - mm(from.units())).abs()
}

/// The distance of two places, mm.
fn way_mm(from: Place, to: Place) -> f64 {
    length_mm(to.point.minus(from.point)).hypot(climb_mm([from.height, to.height]))
}

/// The arc in pieces. Each turns by at most a quarter circle, and is at most `longest` mm long.
fn quarters(arc: &Arc, longest: f64) -> Result<Vec<Arc>, NoContour> {
    let view = arc_mm(arc);
    let count = (view.sweep.abs() / FRAC_PI_2).max(view.length() / longest).ceil().max(1.0);
    let mut pieces = Vec::new();
    let (mut from, mut k) = (arc.from(), 1.0);
    while k <= count {
        let place = view.at(k / count).into();
        let to = if k + 0.5 > count { arc.to() } else { dividing_point(&Curve::Arc(*arc), place)? };
        pieces.push(Arc::new(from, to, arc.centre(), arc.turn())?);
        (from, k) = (to, k + 1.0);
    }
    Ok(pieces)
}

/// The corners of chords around an arc, within [`RAMP_CHORD_MM`] of it: its ends, and the corners of its tangents.
fn circumscribed(arc: &Arc) -> Result<Vec<Point>, NoContour> {
    let view = arc_mm(arc);
    let step = (8.0 * RAMP_CHORD_MM / view.radius).sqrt().min(FRAC_PI_2);
    let count = (view.sweep.abs() / step).ceil().max(1.0);
    let beyond = 1.0 / (view.sweep / count / 2.0).cos();
    let (mut points, mut k) = (vec![arc.from()], 0.5);
    while k < count {
        let on = Mm2::from(view.at(k / count));
        let centre = Mm2::from(view.centre);
        points.push(point_from_mm(centre + (on - centre) * beyond)?);
        k += 1.0;
    }
    points.push(arc.to());
    Ok(points)
}

/// Longest motion of a contour at a feed in mm/min, mm.
fn longest_mm(feed: u32) -> f64 {
    let speed = mm_s(feed);
    (speed * MOTION_S).max(MOTION_MM.min(speed * SLOW_S)).max(LEAST_MM)
}

/// A feed in mm/min, mm/s.
fn mm_s(feed: u32) -> f64 {
    f64::from(feed) / 60.0
}

/// Least duration of the motions ahead of the tool, s. Braking and two round trips are added to it.
const LOOK_AHEAD_S: f64 = 0.15;
/// Longest duration of one motion, s, so that a feed hold takes effect soon. With a longer round trip, the
/// tool stops between motions. The duration does not depend on the measured round trip, so a contour has the
/// same motions each time.
const MOTION_S: f64 = 0.3;
/// The longest permitted length is at least this, mm, if such a motion lasts at most [`SLOW_S`]. It is always
/// at least [`LEAST_MM`].
const MOTION_MM: f64 = 2.0;
const SLOW_S: f64 = 1.0;
const LEAST_MM: f64 = 0.05;
/// Rounding of steps and of the chords of arcs, lattice units (0.5 µm).
const BOX_ROUNDING: i64 = 50;
/// Least room beside the path for the steps of non-interpolated axes, lattice units (9.5 µm). With less room,
/// the steps are too short to drive.
const BOX_ROOM_LEAST: i64 = 950;
/// The stock that gives this room, mm.
pub(super) const BOX_STOCK_MM: f64 = 0.01;
/// Chord-error bound of a ramp, mm.
const RAMP_CHORD_MM: f64 = 0.02;
/// Least chord-error bound (0.1 µm).
const CHORD_LEAST: Length = Length::small(10);

#[cfg(test)]
mod tests {
    use keepout_kernel::curve::{fit_arc, sweep};
    use keepout_kernel::{Turn, Vec2};

    use super::*;

    #[test]
    fn arcs_of_every_size_fall_into_quarters() {
        let mut random = fastrand::Rng::with_seed(5);
        for _ in 0..20_000 {
            let radius = 2000.0 * 50_000.0_f64.powf(random.f64());
            let (begin, turns) = (random.f64() * 6.0, 0.05 + random.f64() * 6.2);
            let at = |phi: f64| {
                let (x, y) = (radius * phi.cos(), radius * phi.sin());
                point_from_mm(Mm2::new(x / 1e5, y / 1e5)).unwrap()
            };
            let turn = if random.bool() { Turn::CounterClockwise } else { Turn::Clockwise };
            let sign = if turn == Turn::CounterClockwise { 1.0 } else { -1.0 };
            let ends = (at(begin), at(begin + sign * turns));
            let Ok(arc) = fit_arc(ends.0, ends.1, Vec2::new(0.0, 0.0), turn) else { continue };
            let longest = if random.bool() { f64::INFINITY } else { 0.05 * 40.0_f64.powf(random.f64()) };
            let pieces = quarters(&arc, longest).unwrap();
            assert!(pieces.first().unwrap().from() == ends.0 && pieces.last().unwrap().to() == ends.1);
            assert!(pieces.windows(2).all(|pair| pair[0].to() == pair[1].from()));
            let longest = pieces.iter().map(sweep).fold(0.0, f64::max);
            assert!(longest < FRAC_PI_2 + 0.01, "{longest}");
        }
    }
}
