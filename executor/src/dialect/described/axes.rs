//! Positions and numbers in a described controller's form: its axes, its zero, its counts.
//!
//! Implements SR-17, SR-18.

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{Height, Place, Point, UNITS_PER_MM, Vector};
use keepout_planner::Mm3;

use super::description::{Description, DescriptionError, Figure, figure};
use super::file::UnitsZTable;
use super::template::{Slot, Template};
use crate::dialect::exchange::Sent;
use crate::dialect::lines::{Sink, push_number};

/// The third axis of a described controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescribedZ {
    /// The form of heights.
    pub coordinate: Figure,
    /// The controller's number at the machine's zero, counts.
    pub zero: i64,
    /// Whether the axis points downward.
    pub invert: bool,
}

impl DescribedZ {
    pub(super) fn of(table: &UnitsZTable) -> Result<Self, DescriptionError> {
        let coordinate = figure("units.z.counts_per_mm", table.counts_per_mm, table.decimals)?;
        Ok(Self { coordinate, zero: table.zero, invert: table.invert })
    }
}

/// The values for the slots of a motion's lines.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Values {
    pub(super) to: [i64; 2],
    /// The height, counts of the third axis.
    pub(super) height: i64,
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
            Slot::Z => push_figure(sent, values.height, self.z.map_or(coordinate, |z| z.coordinate)),
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

    /// A height of the machine, counts of the third axis.
    pub(super) fn height_counts(&self, height: Height) -> i64 {
        let of = |z: DescribedZ| {
            let units = if z.invert { -height.units() } else { height.units() };
            z.coordinate.scale.counts(units).saturating_add(z.zero)
        };
        self.z.map_or(0, of)
    }

    /// The machine place from the controller's numbers. Without a third axis its height is zero.
    pub(super) fn place(&self, Mm3 { x: a, y: b, z: up }: Mm3) -> Option<Place> {
        let Description { coordinate, swap, invert, zero, .. } = *self;
        let axis = |written: f64, coordinate: Figure, zero: i64, invert: bool| {
            let zero = f64::from(i32::try_from(zero).ok()?);
            let mm = written * coordinate.ten() - zero;
            let units = nearest_unit(mm / coordinate.scale.per_mm_f64() * f64::from(UNITS_PER_MM));
            Some(if invert { units.checked_neg()? } else { units })
        };
        let (a, b) = (axis(a, coordinate, zero[0], invert[0])?, axis(b, coordinate, zero[1], invert[1])?);
        let (x, y) = if swap { (b, a) } else { (a, b) };
        let height = match self.z {
            Some(z) => axis(up, z.coordinate, z.zero, z.invert)?,
            None => 0,
        };
        Some(Point::from_units(x, y).ok()?.at_height(Height::from_units(height).ok()?))
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
