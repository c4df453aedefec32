//! Jogs a disc of 3 mm radius around an L-shaped part: `cargo run -p keepout-kernel --example steer`.
//!
//! Shows the queries that a controller needs: a free point, a clipped motion, sliding along the wall, the
//! swept triangle of a new target in mid-motion, and the retract move of a tool inside the jogging clearance.

use std::error::Error;

use keepout_kernel::clip::{SLIDE_TURNS, contact_band};
use keepout_kernel::{Length, Point, ProhibitedRegion, Region, Ring, Side, UNITS_PER_MM, Vec2};

fn mm(x: f64, y: f64) -> Result<Point, Box<dyn Error>> {
    let unit = f64::from(UNITS_PER_MM);
    Ok(keepout_kernel::curve::nearest_point(Vec2::new(x * unit, y * unit))?)
}

fn show(what: &str, point: Point) {
    let in_mm = |units: i32| f64::from(units) / f64::from(UNITS_PER_MM);
    println!("{what:<44} ({:9.5}, {:9.5}) mm", in_mm(point.x.units()), in_mm(point.y.units()));
}

fn main() -> Result<(), Box<dyn Error>> {
    let corners = [(0.0, 0.0), (40.0, 0.0), (40.0, 15.0), (15.0, 15.0), (15.0, 40.0), (0.0, 40.0)];
    let vertices = corners.into_iter().map(|(x, y)| mm(x, y)).collect::<Result<_, _>>()?;
    let mut part = ProhibitedRegion::new(Region::new(vec![Ring::new(vertices)?])?, Side::Outside)?;

    // The threshold is the tool's radius and a margin of 50 µm. Cells make queries at this threshold faster
    // and do not change the answers.
    let threshold = Length::from_units(i64::from(UNITS_PER_MM) * 305 / 100)?;
    part.prepare(threshold)?;

    let start = part.free_point(mm(-20.0, 20.0)?, threshold)?;
    show("start, certified free", start.point());
    let at_wall = part.clip(start, mm(20.0, 30.0)?);
    show("jogged at the wall, stops at", at_wall.point());

    let input = mm(20.0, 30.0)?.minus(at_wall.point());
    if let Some(wall) = part.wall(at_wall, contact_band()) {
        let slides = SLIDE_TURNS.iter().filter_map(|&turn| wall.slide(input, turn));
        let target = slides
            .filter_map(|along| at_wall.point().translated(along).ok())
            .find(|&target| part.motion(at_wall, target).is_ok());
        if let Some(target) = target {
            show("jogged on, slides along the wall to", target);
        }
    }

    let aside = part.motion(start, mm(-10.0, -10.0)?)?;
    match part.swept_triangle(start, aside, mm(0.0, -20.0)?) {
        Ok(free) => show("new target in mid-motion, certified to", free.point()),
        Err(blocked) => println!("the new target is refused: {blocked}"),
    }
    if let Err(blocked) = part.swept_triangle(start, aside, mm(50.0, 20.0)?) {
        println!("another target is refused: {blocked}");
    }

    // The tool is 1 mm from the wall at power-up: nearer than the threshold, but free. Only a motion that
    // approaches no edge is permitted.
    let too_near = part.free_point(mm(-1.0, 20.0)?, Length::ZERO)?;
    if let Some(clearance) = part.clearance(too_near.point()) {
        println!(
            "the tool is {:.5} mm from the part",
            f64::from(clearance.units()) / f64::from(UNITS_PER_MM)
        );
    }
    show("the retract move, certified to", part.retract(too_near, mm(-4.0, 25.0)?, threshold)?.point());
    println!(
        "a motion toward the part is refused: {}",
        part.retract(too_near, mm(-0.9, 20.0)?, threshold).is_err()
    );
    Ok(())
}
