//! Positions and numbers in a described controller's form: its axes, its zero, its counts.

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{Point, UNITS_PER_MM, Vector};
use keepout_planner::Mm2;

use super::description::{Description, Figure};
use super::template::{Slot, Template};
use crate::dialect::exchange::Sent;
use crate::dialect::lines::{Sink, push_number};

/// The values for the slots of a motion's lines.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Values {
    pub(super) to: [i64; 2],
    pub(super) centre: [i64; 2],
    pub(super) feed: i64,
}

impl Description {
    /// Adds a line and its line end.
    pub(super) fn write(&self, template: &Template, values: &Values, sent: &mut Sent) {
        let Description { coordinate, speed, .. } = *self;
        template.write(sent, |slot, sent| match slot {
            Slot::X => push_figure(sent, values.to[0], coordinate),
            Slot::Y => push_figure(sent, values.to[1], coordinate),
            Slot::I => push_figure(sent, values.centre[0], coordinate),
            Slot::J => push_figure(sent, values.centre[1], coordinate),
            Slot::Feed => push_figure(sent, values.feed, speed),
            Slot::Status | Slot::Code | Slot::Any => {}
        });
        self.end.iter().for_each(|&byte| sent.put(byte));
    }

    /// A vector along the controller's axes, counts.
    pub(super) fn counts(&self, v: Vector) -> [i64; 2] {
        let Description { coordinate, swap, invert, .. } = *self;
        let (a, b) = if swap { (v.dy, v.dx) } else { (v.dx, v.dy) };
        let axis = |c: i32, invert: bool| coordinate.scale.counts(if invert { -c } else { c });
        [axis(a, invert[0]), axis(b, invert[1])]
    }

    /// The machine point from the controller's numbers.
    pub(super) fn point(&self, Mm2 { x: a, y: b }: Mm2) -> Option<Point> {
        let Description { coordinate, swap, invert, zero, .. } = *self;
        let axis = |written: f64, zero: i64, invert: bool| {
            let zero = f64::from(i32::try_from(zero).ok()?);
            let mm = written * coordinate.ten() - zero;
            let units = nearest_unit(mm / coordinate.scale.per_mm_f64() * f64::from(UNITS_PER_MM));
            Some(if invert { units.checked_neg()? } else { units })
        };
        let (a, b) = (axis(a, zero[0], invert[0])?, axis(b, zero[1], invert[1])?);
        let (x, y) = if swap { (b, a) } else { (a, b) };
        Point::from_units(x, y).ok()
    }
}

/// Writes counts as an exact number with the figure's decimals.
pub(super) fn push_figure(out: &mut Sent, counts: i64, figure: Figure) {
    if counts < 0 {
        out.put(b'-');
    }
    let ten = 10_u64.pow(figure.decimals.into());
    push_number(out, counts.unsigned_abs() / ten);
    let mut place = ten / 10;
    if place > 0 {
        out.put(b'.');
    }
    while place > 0 {
        push_number(out, counts.unsigned_abs() / place % 10);
        place /= 10;
    }
}
