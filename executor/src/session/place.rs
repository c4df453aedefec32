//! The place of the drawing on the machine, and the start place of the tool.
//!
//! Implements SR-15, SR-16, SR-26.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Length, Point, Vector};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{height_from_mm, length_up_from_mm, mm, point_from_mm, point_mm, window_mm};
use keepout_planner::{Box2, Mm2};
use thiserror::Error;

use crate::dialect::{DialectConfig, DialectName, DialectZ};

/// The place of a drawing on a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePlacement {
    /// Machine coordinates minus drawing coordinates.
    pub offset: Vector,
    /// The machine's travel, drawing coordinates.
    pub travel: Window,
    /// The third axis. `None` for a plan for two axes.
    pub z: Option<PlacedZ>,
}

/// The place of a drawing along the third axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlacedZ {
    /// The machine's height where the drawing's height is zero.
    pub zero: Height,
    /// The lowest and the greatest height of the travel, drawing coordinates.
    pub travel: [Height; 2],
}

impl TablePlacement {
    /// The lowest and the greatest height of the travel, drawing coordinates.
    #[must_use]
    pub fn heights(&self) -> Option<[Height; 2]> {
        self.z.map(|z| z.travel)
    }

    /// The placement with the top of the part at this height, machine coordinates, mm. The top is rounded up to
    /// 1 µm: the tool then never goes deeper than the stated top permits.
    ///
    /// # Errors
    /// [`PlaceError::TopBeyond`] if the safe height or the deepest pass then lies beyond the travel.
    pub fn with_top(self, plan: &CertifiedPlan, top_mm: Option<f64>) -> Result<Self, PlaceError> {
        let (Some(z), Some(relief), Some(top_mm)) = (self.z, &plan.plan.relief, top_mm) else {
            return Ok(self);
        };
        let travel_mm = mm(z.travel[1].units()) - mm(z.travel[0].units());
        let (safe_mm, deepest_mm) = (mm(relief.safe.units()), mm(relief.deepest.units()));
        let (lowest, highest) = (-travel_mm - deepest_mm, -safe_mm);
        let top_mm = (top_mm * 1000.0 - SAME_GRID).ceil() / 1000.0;
        if !(lowest..=highest).contains(&top_mm) {
            return Err(PlaceError::TopBeyond { lowest, highest });
        }
        let zero = height_from_mm(top_mm)?;
        let top_of_travel = Height::from_units(-i64::from(zero.units()))?;
        let travel = [top_of_travel.lowered(length_up_from_mm(travel_mm)?), top_of_travel];
        Ok(Self { z: Some(PlacedZ { zero, travel }), ..self })
    }

    /// Refuses a dialect that cannot move the axes of the plan.
    ///
    /// # Errors
    /// [`PlaceError::TwoAxisDialect`] if the plan has depths and the dialect moves two axes,
    /// [`PlaceError::ThreeAxisDialect`] if the plan has none and each motion of the dialect states a height.
    pub fn moved_by(&self, dialect: &DialectName) -> Result<(), PlaceError> {
        if self.z.is_none() && dialect.needs_third_axis() {
            return Err(PlaceError::ThreeAxisDialect { dialect: dialect.name().into() });
        }
        if self.z.is_some() && !dialect.has_third_axis() {
            return Err(PlaceError::TwoAxisDialect { dialect: dialect.name().into() });
        }
        Ok(())
    }

    /// The dialect's parameters for a plan's machine.
    #[must_use]
    pub fn config(&self, machine: &MachineProfile) -> DialectConfig {
        let axis = |z: PlacedZ| {
            let ZProfile { steps_per_mm, travel_mm, .. } = *machine.z.as_ref()?;
            Some(DialectZ { zero: z.zero, steps_per_mm, travel_mm: Some(travel_mm) })
        };
        DialectConfig { z: self.z.and_then(axis), ..DialectConfig::of(machine, self.offset) }
    }
}

/// An error in the placement of a drawing.
#[derive(Debug, Error)]
pub enum PlaceError {
    /// The machine is too small.
    #[error(
        "the job needs {needed_x:.1} × {needed_y:.1} mm of travel, {machine} has {has_x:.1} × {has_y:.1} mm. \
         Turn the drawing, or use a larger machine (--travel-mm for the simulated one)."
    )]
    TooLarge {
        /// Travel needed in x, mm.
        needed_x: f64,
        /// Travel needed in y, mm.
        needed_y: f64,
        /// The machine.
        machine: String,
        /// Travel in x, mm.
        has_x: f64,
        /// Travel in y, mm.
        has_y: f64,
    },
    /// The third axis is too short.
    #[error(
        "the job needs {needed_mm:.1} mm of travel in z, {machine} has {has_mm:.1} mm: \
         lower --safe-height-mm, or use a longer axis"
    )]
    TooTall {
        /// Travel needed, mm.
        needed_mm: f64,
        /// The machine.
        machine: String,
        /// Its travel in z, mm.
        has_mm: f64,
    },
    /// The plan has depths, and the machine has two axes.
    #[error("the plan has depths, and {machine} has two axes: use a machine profile with a [z] table")]
    TwoAxes {
        /// The machine.
        machine: String,
    },
    /// The top of the part lies too high or too low.
    #[error(
        "with the top of the part there the job lies beyond the travel of z: \
         --top-mm may be {lowest:.1} to {highest:.1}"
    )]
    TopBeyond {
        /// Least height of the top, machine coordinates, mm.
        lowest: f64,
        /// Greatest height of the top, mm.
        highest: f64,
    },
    /// The plan has depths, and the dialect moves two axes.
    #[error(
        "the plan has depths, and the dialect {dialect} moves two axes: choose grbl, grblhal or zaber, or describe \
         the third axis in [units.z]"
    )]
    TwoAxisDialect {
        /// The dialect.
        dialect: String,
    },
    /// Each motion of the dialect states a height, and the plan has none.
    #[error(
        "each motion of the dialect {dialect} states a height, and the plan is for two axes: plan with --thickness-mm \
         and a machine with a [z] table, or leave out [units.z] and {{z}} in the description"
    )]
    ThreeAxisDialect {
        /// The dialect.
        dialect: String,
    },
    /// The drawing lies beyond the travel.
    #[error(
        "with its origin there the drawing lies beyond the machine's travel: \
         --origin-mm may be {:.1} to {:.1} in x and {:.1} to {:.1} in y",
        x.0, x.1, y.0, y.1
    )]
    Misplaced {
        /// Least and largest x of the origin, machine coordinates, mm.
        x: (f64, f64),
        /// Least and largest y of the origin, machine coordinates, mm.
        y: (f64, f64),
    },
    /// The tool cannot start there.
    #[error("the tool cannot start at {at}: {reason}. Choose another --start-mm.")]
    Start {
        /// The place.
        at: Point,
        /// The reason.
        reason: String,
    },
    /// The offset lies outside the lattice.
    #[error(
        "the drawing lies too far from its origin for this machine: {0}. \
         Move it nearer to its origin in the CAD system."
    )]
    OffLattice(#[from] keepout_kernel::LatticeError),
    /// No clear start place was found.
    #[error(
        "the tool fits nowhere clear of the part with the stock to leave. \
         Lower --stock-to-leave-mm, or take a smaller tool."
    )]
    NoStart,
}

/// Grid of the offset, in lattice units: 1 µm. Jog targets then need three decimals in mm.
const GRID: i32 = 100;

/// Part of the grid by which a stated top may exceed a point of the grid and still count as that point. A decimal
/// such as 0.001 mm has no exact binary fraction.
const SAME_GRID: f64 = 1e-6;

/// Travel that stays free at the table's edges, mm. The home position lies there.
const EDGE_MM: f64 = 2.0;

/// Places the drawing's origin at `origin_mm` (machine coordinates), or the job in the middle of the travel.
/// The travel is [−width, 0] × [−height, 0].
///
/// # Errors
/// [`PlaceError`] if the finishing toolpath, grown by the stock to leave, does not fit the travel.
pub fn place_on_table(
    plan: &CertifiedPlan,
    machine: &MachineProfile,
    origin_mm: Option<Mm2>,
) -> Result<TablePlacement, PlaceError> {
    let (low, high) = path_box(plan)?;
    let [width, height] = machine.travel_mm;
    let job = Box2 { low: point_mm(low), high: point_mm(high) };
    // A drawn travel is centred in the machine's travel. Without it the job is centred.
    let centred = plan.plan.travel.map_or(job, window_mm);
    let middle = -Mm2::new(width, height) / 2.0 - centred.middle();
    let offset = point_from_mm(origin_mm.unwrap_or(middle))?;
    let to_grid = |c: i32| c.div_euclid(GRID) * GRID;
    let offset = Vector { dx: to_grid(offset.x.units()), dy: to_grid(offset.y.units()) };
    let back = Vector { dx: -offset.dx, dy: -offset.dy };
    let corner = |x: f64, y: f64| point_from_mm(Mm2::new(x, y))?.translated(back);
    let travel = Window::of(corner(-width, -height)?).including(corner(0.0, 0.0)?);
    let travel = plan.plan.travel.map_or(travel, |drawn| travel.common(drawn));
    let needed = job.size() + Mm2::new(EDGE_MM, EDGE_MM);
    if needed.x > width || needed.y > height {
        return Err(PlaceError::TooLarge {
            needed_x: needed.x,
            needed_y: needed.y,
            machine: machine.name.clone(),
            has_x: width,
            has_y: height,
        });
    }
    if !(travel.holds(low) && travel.holds(high)) {
        let Box2 { low, high } = job;
        return Err(PlaceError::Misplaced { x: (-width - low.x, -high.x), y: (-height - low.y, -high.y) });
    }
    Ok(TablePlacement { offset, travel, z: place_z(plan, machine)? })
}

/// Travel above the safe height, mm, as far as the axis has it.
const ABOVE_SAFE_MM: f64 = 10.0;

/// Places the job along the third axis, near the upper end of its travel, which is [−travel, 0].
fn place_z(plan: &CertifiedPlan, machine: &MachineProfile) -> Result<Option<PlacedZ>, PlaceError> {
    let Some(relief) = &plan.plan.relief else { return Ok(None) };
    let Some(z) = &machine.z else { return Err(PlaceError::TwoAxes { machine: machine.name.clone() }) };
    let (safe_mm, deepest_mm) = (mm(relief.safe.units()), mm(relief.deepest.units()));
    let spare_mm = (z.travel_mm - (safe_mm - deepest_mm)) / 2.0;
    if spare_mm < 0.0 {
        let (needed_mm, has_mm) = (safe_mm - deepest_mm, z.travel_mm);
        return Err(PlaceError::TooTall { needed_mm, machine: machine.name.clone(), has_mm });
    }
    let to_grid = |c: i32| i64::from(c.div_euclid(GRID) * GRID);
    let top = height_from_mm(safe_mm + spare_mm.min(ABOVE_SAFE_MM))?;
    let zero = Height::from_units(-to_grid(top.units()))?;
    let highest = Height::from_units(-i64::from(zero.units()))?;
    let lowest = highest.lowered(length_up_from_mm(z.travel_mm)?);
    Ok(Some(PlacedZ { zero, travel: [lowest, highest] }))
}

/// The box of the finishing toolpath, grown by the stock to leave, because roughing goes around it too.
fn path_box(plan: &CertifiedPlan) -> Result<(Point, Point), PlaceError> {
    let chord_error = Length::small(200);
    let loops = plan.plan.passes.iter().flat_map(|pass| &pass.path.loops);
    let points = loops
        .flat_map(|each| &each.curves)
        .flat_map(|curve| curve.chord_points(chord_error).unwrap_or_else(|_| vec![curve.from(), curve.to()]));
    let window = points.map(Window::of).reduce(Window::union).unwrap_or(Window::of(Point::ORIGIN));
    let grown = window.grown(plan.plan.stock_to_leave).grown(length_up_from_mm(0.1)?);
    let (x0, y0, x1, y1) = grown.corners();
    Ok((Point::from_units(x0.into(), y0.into())?, Point::from_units(x1.into(), y1.into())?))
}

/// A clear start place beside the longest finishing loop that has one. The tool starts there if it cannot
/// come in from outside.
///
/// # Errors
/// [`PlaceError::NoStart`] if the search finds no such place.
pub fn start_inside(plan: &CertifiedPlan) -> Result<Point, PlaceError> {
    [0.1, 0.02, 0.004].into_iter().find_map(|beyond| start_beside(plan, beyond)).ok_or(PlaceError::NoStart)
}

/// A clear place `beyond` mm outside the jogging clearance, beside the longest curve that has one.
fn start_beside(plan: &CertifiedPlan, beyond: f64) -> Option<Point> {
    let beyond = mm(plan.plan.stock_to_leave.units()) + beyond;
    let mut curves: Vec<_> = plan.plan.finish().loops.iter().flat_map(|each| &each.curves).collect();
    curves.sort_by(|a, b| b.length().total_cmp(&a.length()));
    curves
        .into_iter()
        .filter_map(|curve| {
            let points = curve.chord_points(Length::small(250)).ok()?;
            let pair = points.windows(2).nth(points.len().saturating_sub(1) / 2)?;
            let (a, b) = (point_mm(pair[0]), point_mm(pair[1]));
            let along = (b - a) / a.distance(b).max(f64::MIN_POSITIVE);
            // The free side is on the right of the path.
            point_from_mm(a.midpoint(b) - along.left() * beyond).ok()
        })
        .find(|&point| plan.part.free_point(point, plan.roughing).is_ok())
}

#[cfg(test)]
mod tests {
    use keepout_planner::depth::DepthParameters;
    use keepout_planner::request::PlanRequest;

    use super::*;

    // Evidence for SR-16.
    /// A machine height below the true top would let the tool enter the part by the difference.
    #[test]
    fn stated_top_is_never_rounded_down() {
        let bytes = include_bytes!("../../cli/drawings/cover.dxf");
        let machine = MachineProfile::simulated_three_axes();
        let mut request = PlanRequest::default();
        request.job.depth = Some(DepthParameters::of(6.0));
        let plan = request.plan("cover", bytes, &machine, &mut |_| {}).unwrap();
        let place = place_on_table(&plan, &machine, None).unwrap();
        let placed = |top_mm: f64| place.with_top(&plan, Some(top_mm));
        for (top_mm, units) in [
            (-40.0, -4_000_000),
            (-40.001, -4_000_100),
            (-40.000_4, -4_000_000),
            (-40.000_6, -4_000_000),
            (-40.000_999, -4_000_000),
            (-39.999_999, -3_999_900),
        ] {
            let PlacedZ { zero, travel } = placed(top_mm).unwrap().z.unwrap();
            assert_eq!(zero.units(), units, "{top_mm} mm");
            assert_eq!(travel[1].units(), -units, "{top_mm} mm");
        }
        // The greatest permitted top is a point of the grid, and a higher one is refused.
        let highest = -mm(plan.plan.relief.as_ref().unwrap().safe.units());
        assert_eq!(placed(highest).unwrap().z.unwrap().zero, height_from_mm(highest).unwrap());
        for beyond in [highest + 0.000_1, f64::NAN, f64::INFINITY] {
            assert!(matches!(placed(beyond), Err(PlaceError::TopBeyond { .. })), "{beyond}");
        }
    }
    // Evidence for SR-15.
    #[test]
    fn a_drawn_travel_never_exceeds_that_of_the_machine() {
        let (bytes, machine) =
            (include_bytes!("../../cli/drawings/bracket.dxf"), MachineProfile::simulated());
        let mut plan = PlanRequest::default().plan("bracket", bytes, &machine, &mut |_| {}).unwrap();
        let corner = |mm: f64| point_from_mm(Mm2::new(mm, mm)).unwrap();
        plan.plan.travel = Some(Window::of(corner(-900.0)).including(corner(900.0)));
        let (x0, y0, x1, y1) = place_on_table(&plan, &machine, None).unwrap().travel.corners();
        let [width, height] = machine.travel_mm;
        assert!(mm(x1 - x0) <= width && mm(y1 - y0) <= height, "{} × {} mm", mm(x1 - x0), mm(y1 - y0));
    }
}
