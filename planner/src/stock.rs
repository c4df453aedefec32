//! What a run leaves of the stock: a map of heights from which the tool's places are cut.
//!
//! Each cell of the map has the height of the stock at its middle. A cylinder that goes from place to place lowers the
//! cells below its end. So an edge of the stock lies right to half a cell.

use std::collections::{BTreeMap, BTreeSet};

use keepout_kernel::Height;

use crate::contour::short;
use crate::plan::CertifiedPlan;
use crate::units::{mm, point_from_mm};
use crate::{Box2, Mm2, Mm3};

/// A map of the stock's heights over a box. Height zero is the top of the stock.
#[derive(Clone, Debug, PartialEq)]
pub struct StockMap {
    /// Middle of the first cell, mm.
    first: Mm2,
    /// Side of a cell, mm.
    cell_mm: f64,
    columns: usize,
    /// Rows upward, one after another, mm.
    heights_mm: Vec<f64>,
    /// Way of the tool since it last removed stock or was in air for certain, mm.
    open_mm: f64,
}

/// What a motion did to the stock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chip {
    /// Stock removed, mm³.
    pub removed_mm3: f64,
    /// Length of the way on which the tool removed stock, mm.
    pub in_stock_mm: f64,
    /// Length of the way below the top of the stock on which it removed none, mm.
    pub in_air_mm: f64,
}

impl Chip {
    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            removed_mm3: self.removed_mm3 + other.removed_mm3,
            in_stock_mm: self.in_stock_mm + other.in_stock_mm,
            in_air_mm: self.in_air_mm + other.in_air_mm,
        }
    }
}

/// Share of the tool's radius that a cell may be: the tool covers about 800 cells.
const CELL_SHARE: f64 = 1.0 / 16.0;
/// Most cells of a map.
const CELLS_MAX: f64 = 1e6;
/// Share of a cell from one look at the tool to the next.
const STEP_SHARE: f64 = 0.5;
/// A tool that removes nothing over so many cells is in air.
const AIR_CELLS: f64 = 2.0;
/// Most looks at one motion.
const STEPS_MAX: f64 = 1e5;

impl StockMap {
    /// Solid stock over a box, for a tool of this radius.
    #[must_use]
    pub fn solid(bounds: Box2, radius_mm: f64) -> Self {
        let size = bounds.size();
        let cell_mm = (radius_mm * CELL_SHARE).max((size.x * size.y / CELLS_MAX).sqrt()).max(1e-3);
        let count = |side_mm: f64| to_index((side_mm / cell_mm).ceil()).max(1);
        let (columns, rows) = (count(size.x), count(size.y));
        let first = bounds.low + Mm2::new(cell_mm, cell_mm) / 2.0;
        Self { first, cell_mm, columns, heights_mm: vec![0.0; columns * rows], open_mm: 0.0 }
    }

    /// Solid stock along a line of this many cells at a y.
    #[must_use]
    pub fn line(from: Mm2, length_mm: f64, columns: usize) -> Self {
        let cell_mm = length_mm / count(columns);
        let first = from + Mm2::new(cell_mm / 2.0, 0.0);
        let columns = columns.max(1);
        Self { first, cell_mm, columns, heights_mm: vec![0.0; columns], open_mm: 0.0 }
    }

    /// Side of a cell, mm.
    #[must_use]
    pub fn cell_mm(&self) -> f64 {
        self.cell_mm
    }

    /// The middles of the cells and the heights of the stock there, mm.
    pub fn cells(&self) -> impl Iterator<Item = (Mm2, f64)> + '_ {
        self.heights_mm.chunks(self.columns).enumerate().flat_map(move |(row, heights)| {
            heights.iter().enumerate().map(move |(column, &height)| {
                (self.first + Mm2::new(count(column), count(row)) * self.cell_mm, height)
            })
        })
    }

    /// Cuts a motion of the end of a cylindrical tool. A way of up to two cells may count with the next motion.
    pub fn cut(&mut self, [from, to]: [Mm3; 2], radius_mm: f64) -> Chip {
        let step = to - from;
        let length_mm = step.length();
        if from.z >= 0.0 && to.z >= 0.0 || !length_mm.is_finite() {
            return Chip::default();
        }
        let looks = (length_mm / (self.cell_mm * STEP_SHARE)).ceil().clamp(1.0, STEPS_MAX);
        let mut chip = Chip::default();
        let mut look = 0.0;
        while look <= looks {
            let at = from + step * (look / looks);
            let removed_mm3 = self.sink(at, radius_mm);
            let way_mm = if look > 0.0 { length_mm / looks } else { 0.0 };
            chip.removed_mm3 += removed_mm3;
            self.open_mm += if at.z < 0.0 { way_mm } else { 0.0 };
            // A short step can reach the middle of no new cell, and still be in stock.
            if removed_mm3 > 0.0 {
                chip.in_stock_mm += std::mem::take(&mut self.open_mm);
            } else if self.open_mm > AIR_CELLS * self.cell_mm {
                chip.in_air_mm += std::mem::take(&mut self.open_mm);
            }
            look += 1.0;
        }
        chip
    }

    /// Lowers the cells below the tool's end. Returns the stock removed, mm³.
    fn sink(&mut self, at: Mm3, radius_mm: f64) -> f64 {
        if at.z >= 0.0 {
            return 0.0;
        }
        let rows = self.heights_mm.len() / self.columns;
        let row_of = |y: f64| (y - self.first.y) / self.cell_mm;
        let (low, high) = (row_of(at.y - radius_mm).ceil(), row_of(at.y + radius_mm).floor());
        let mut removed_mm = 0.0;
        for row in to_index(low)..rows.min(to_index(high + 1.0)) {
            let aside = self.first.y + count(row) * self.cell_mm - at.y;
            let half = (radius_mm * radius_mm - aside * aside).max(0.0).sqrt();
            let column_of = |x: f64| (x - self.first.x) / self.cell_mm;
            let from = to_index(column_of(at.x - half).ceil());
            let to = self.columns.min(to_index(column_of(at.x + half).floor() + 1.0));
            let line = &mut self.heights_mm[row * self.columns..(row + 1) * self.columns];
            for height in line.iter_mut().take(to).skip(from).filter(|height| **height > at.z) {
                removed_mm += *height - at.z;
                *height = at.z;
            }
        }
        removed_mm * self.cell_mm * self.cell_mm
    }
}

/// What a run did to the stock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StockFigures {
    /// The jogs.
    pub by_hand: Chip,
    /// The contours, with their link moves.
    pub by_contour: Chip,
    /// The faces on which stock is left, downward.
    pub faces: Vec<FaceLeft>,
}

/// Stock that is left on the faces of one height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceLeft {
    /// The height of the faces.
    pub top: Height,
    /// Area on which stock is left, mm².
    pub area_mm2: f64,
    /// Height of the stock above the face, mm.
    pub highest_mm: f64,
}

/// Stock lower than this above a face does not count, besides the height margin, mm.
const THIN_MM: f64 = 0.01;

impl StockFigures {
    /// The figures of a run, from its places and whether the way to each is part of a contour. `None` for a plan for
    /// two axes.
    #[must_use]
    pub fn of(plan: &CertifiedPlan, way: impl Iterator<Item = (Mm3, bool)>) -> Option<Self> {
        let relief = plan.plan.relief.as_ref()?;
        let radius_mm = mm(plan.plan.tool_radius.units());
        let mut stock = StockMap::solid(plan.part_box().grown(radius_mm), radius_mm);
        let (mut figures, mut before) = (Self::default(), None);
        for (place, of_contour) in way {
            let from = before.replace(place).unwrap_or(place);
            let chip = stock.cut([from, place], radius_mm);
            let sum = if of_contour { &mut figures.by_contour } else { &mut figures.by_hand };
            *sum = sum.and(chip);
        }
        let tops = relief.tops.iter().copied().flatten().filter(|&top| top < Height::ZERO);
        let tops: BTreeSet<Height> = tops.collect();
        let margin_mm = mm(plan.height_margin.units()) + THIN_MM;
        let mut left: BTreeMap<Height, (f64, f64)> = BTreeMap::new();
        for (at, height_mm) in stock.cells().filter(|_| !tops.is_empty()) {
            let top = point_from_mm(at).ok().and_then(|point| plan.top_at(point));
            let Some(top) = top.filter(|top| tops.contains(top)) else { continue };
            let above_mm = height_mm - mm(top.units());
            if above_mm > margin_mm {
                let (area_mm2, highest_mm) = left.entry(top).or_default();
                *area_mm2 += stock.cell_mm * stock.cell_mm;
                *highest_mm = highest_mm.max(above_mm);
            }
        }
        let face = |(top, (area_mm2, highest_mm))| FaceLeft { top, area_mm2, highest_mm };
        figures.faces = left.into_iter().rev().map(face).collect();
        Some(figures)
    }

    /// The rows of a table: name and value.
    #[must_use]
    pub fn rows(&self) -> Vec<(String, String)> {
        let removed = |chip: &Chip| format!("{:.1} cm³", chip.removed_mm3 / 1000.0);
        let cut = format!("{} by hand, {} by contours", removed(&self.by_hand), removed(&self.by_contour));
        let Chip { in_stock_mm, in_air_mm, .. } = self.by_contour;
        let air = format!("{in_stock_mm:.1} mm in stock, {in_air_mm:.1} mm in air below its top");
        let mut rows = vec![("stock removed".to_string(), cut), ("way of the contours".to_string(), air)];
        let left = self.faces.iter().map(|face| {
            let FaceLeft { top, area_mm2, highest_mm } = *face;
            let (top, highest) = (short(mm(top.units())), short((highest_mm * 1000.0).round() / 1000.0));
            let value = format!("{area_mm2:.1} mm², up to {highest} mm high: mill it by hand");
            (format!("stock left on faces at z {top}"), value)
        });
        rows.extend(left);
        rows
    }
}

pub(crate) fn count(value: usize) -> f64 {
    u32::try_from(value).map_or(f64::INFINITY, f64::from)
}

fn to_index(value: f64) -> usize {
    usize::try_from(keepout_kernel::curve::nearest_unit(value.max(0.0))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn map() -> StockMap {
        StockMap::solid(Box2 { low: Mm2::new(-20.0, -20.0), high: Mm2::new(20.0, 20.0) }, 3.0)
    }

    #[test]
    fn plunge_and_slot_remove_what_a_cylinder_sweeps() {
        let mut stock = map();
        let above = Mm2::new(-10.0, 1.0).at_height(5.0);
        let below = Mm2::new(-10.0, 1.0).at_height(-2.0);
        let plunge = stock.cut([above, below], 3.0);
        assert!((plunge.removed_mm3 - PI * 9.0 * 2.0).abs() < 0.02 * PI * 18.0, "{plunge:?}");
        let slot = stock.cut([below, Mm2::new(8.0, 1.0).at_height(-2.0)], 3.0);
        assert!((slot.removed_mm3 - 18.0 * 6.0 * 2.0).abs() < 0.02 * 216.0, "{slot:?}");
        assert!((slot.in_stock_mm - 18.0).abs() < 0.4 && slot.in_air_mm == 0.0, "{slot:?}");
        let again = stock.cut([below, Mm2::new(8.0, 1.0).at_height(-2.0)], 3.0);
        assert_eq!((again.removed_mm3, again.in_stock_mm), (0.0, 0.0));
        assert!((again.in_air_mm - 18.0).abs() < 0.5, "{again:?}");
        // Steps much shorter than a cell, along a thin wall of stock.
        let step = |k: u32| Mm2::new(-10.0 + 0.01 * f64::from(k), 1.2).at_height(-2.0);
        let thin = (0..1800).map(|k| stock.cut([step(k), step(k + 1)], 3.0)).fold(Chip::default(), Chip::and);
        assert!((thin.in_stock_mm - 18.0).abs() < 0.5 && thin.in_air_mm < 0.5, "{thin:?}");
        let over = stock.cut([above, Mm2::new(8.0, 1.0).at_height(5.0)], 3.0);
        assert_eq!(over, Chip::default());
        let left = stock.cells().filter(|(at, _)| at.distance(Mm2::new(0.0, 1.0)) < 2.5);
        assert!(left.into_iter().all(|(_, height_mm)| height_mm == -2.0));
    }

    #[test]
    fn tool_beyond_the_map_and_broken_numbers_change_nothing() {
        let mut stock = map();
        let before = stock.clone();
        let far = |x: f64| Mm2::new(x, 500.0).at_height(-3.0);
        stock.cut([far(-1e6), far(1e6)], 3.0);
        stock.cut([far(f64::NAN), far(0.0)], 3.0);
        stock.cut([far(f64::INFINITY), far(0.0)], 3.0);
        assert_eq!(stock, before);
    }
}
