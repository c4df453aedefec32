//! Where the drawing lies on the machine, and where the tool starts.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Length, Point, Vector};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{length_up_from_mm, mm, point_from_mm, point_mm};
use thiserror::Error;

/// A drawing placed on a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Machine coordinates less drawing coordinates.
    pub offset: Vector,
    /// The machine's travel, drawing coordinates.
    pub travel: Window,
}

/// Why a drawing can not be placed.
#[derive(Debug, Error)]
pub enum PlaceError {
    /// The machine is too small.
    #[error(
        "the job needs {needed_x:.1} × {needed_y:.1} mm of travel, {machine} has {has_x:.1} × {has_y:.1} mm. Turn the drawing, or use a larger machine (--travel-mm for the simulated one)."
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
    /// The drawing lies beyond the travel.
    #[error("with its origin there the drawing lies beyond the machine's travel: --origin-mm may be {:.1} to {:.1} in x and {:.1} to {:.1} in y", x.0, x.1, y.0, y.1)]
    Misplaced {
        /// Least and largest place of the origin in x, machine coordinates, mm.
        x: (f64, f64),
        /// The same in y.
        y: (f64, f64),
    },
    /// The tool can not be let down there.
    #[error("the tool can not start at {at}: {reason}. Choose another --start-mm.")]
    Start {
        /// The place.
        at: Point,
        /// Why not.
        reason: String,
    },
    /// The offset is off the lattice.
    #[error(
        "the drawing lies too far from its origin for this machine: {0}. Move it nearer to its origin in the CAD system."
    )]
    OffLattice(#[from] keepout_kernel::LatticeError),
    /// No clear place to start from.
    #[error(
        "the tool fits nowhere clear of the part with the roughing allowance. Lower --stock-to-leave-mm, or take a smaller tool."
    )]
    NoStart,
}

/// Offsets are multiples of this, lattice units (1 µm): jog targets are then written with three decimals.
const GRID: i32 = 100;

/// Travel kept free at the table's edges, mm: the home position lies there.
const EDGE_MM: f64 = 2.0;

/// Places the drawing's origin at `origin_mm` (machine coordinates), or the job in the middle of the travel, which is
/// [−width, 0] × [−height, 0].
///
/// # Errors
/// [`PlaceError`] when the finishing path leaves the travel.
pub fn place_on_table(
    plan: &CertifiedPlan,
    machine: &MachineProfile,
    origin_mm: Option<(f64, f64)>,
) -> Result<Placement, PlaceError> {
    let (low, high) = path_box(plan)?;
    let [width, height] = machine.travel_mm;
    let (x0, y0) = point_mm(low);
    let (x1, y1) = point_mm(high);
    // In the middle of the travel; travel that is drawn lies with its own middle there.
    let drawn = plan.plan.travel.map(|travel| {
        let (x0, y0, x1, y1) = travel.corners();
        (mm(x0), mm(y0), mm(x1), mm(y1))
    });
    let (left, low_y, right, high_y) = drawn.unwrap_or((x0, y0, x1, y1));
    let middle = (-width / 2.0 - f64::midpoint(left, right), -height / 2.0 - f64::midpoint(low_y, high_y));
    let offset = point_from_mm(origin_mm.unwrap_or(middle))?;
    let to_grid = |c: i32| c.div_euclid(GRID) * GRID;
    let offset = Vector { dx: to_grid(offset.x.units()), dy: to_grid(offset.y.units()) };
    let back = Vector { dx: -offset.dx, dy: -offset.dy };
    let corner = |x: f64, y: f64| point_from_mm((x, y))?.translated(back);
    let travel = Window::of(corner(-width, -height)?).including(corner(0.0, 0.0)?);
    let travel = plan.plan.travel.map_or(travel, |drawn| travel.common(drawn));
    if x1 - x0 + EDGE_MM > width || y1 - y0 + EDGE_MM > height {
        return Err(PlaceError::TooLarge {
            needed_x: x1 - x0 + EDGE_MM,
            needed_y: y1 - y0 + EDGE_MM,
            machine: machine.name.clone(),
            has_x: width,
            has_y: height,
        });
    }
    if !(travel.holds(low) && travel.holds(high)) {
        return Err(PlaceError::Misplaced { x: (-width - x0, -x1), y: (-height - y0, -y1) });
    }
    Ok(Placement { offset, travel })
}

/// The box of the finishing path, grown by the stock_to_leave: roughing goes around it too.
fn path_box(plan: &CertifiedPlan) -> Result<(Point, Point), PlaceError> {
    let chord_error = Length::small(200);
    let points =
        plan.plan.finish().loops.iter().flat_map(|each| &each.curves).flat_map(|curve| {
            curve.chord_points(chord_error).unwrap_or_else(|_| vec![curve.from(), curve.to()])
        });
    let window = points.map(Window::of).reduce(Window::union).unwrap_or(Window::of(Point::ORIGIN));
    let grown = window.grown(plan.plan.stock_to_leave).grown(length_up_from_mm(0.1)?);
    let (x0, y0, x1, y1) = grown.corners();
    Ok((Point::from_units(x0.into(), y0.into())?, Point::from_units(x1.into(), y1.into())?))
}

/// A clear place beside the longest finishing loops: where the tool is let down when it can not come in from outside.
///
/// # Errors
/// [`PlaceError::NoStart`] when no such place is found.
pub fn start_inside(plan: &CertifiedPlan) -> Result<Point, PlaceError> {
    [0.1, 0.02, 0.004].into_iter().find_map(|beyond| start_beside(plan, beyond)).ok_or(PlaceError::NoStart)
}

/// A clear place `beyond` mm outside the roughing threshold, beside the longest finishing loops.
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
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
            // The free side is on the right of the path.
            let middle = (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1));
            point_from_mm((middle.0 + dy / length * beyond, middle.1 - dx / length * beyond)).ok()
        })
        .find(|&point| plan.part.free_point(point, plan.roughing).is_ok())
}
