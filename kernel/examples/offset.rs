//! The certified offset of a part with a pocket that is too narrow for the disc:
//! `cargo run -p keepout-kernel --example offset`.

use std::error::Error;

use keepout_kernel::offset::{CutContour, Outline, certify_complete, certify_path, propose};
use keepout_kernel::{
    Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, UNITS_PER_MM, Vec2,
};

fn main() -> Result<(), Box<dyn Error>> {
    let unit = f64::from(UNITS_PER_MM);
    let corners = [
        (0.0, 0.0),
        (50.0, 0.0),
        (50.0, 30.0),
        (30.0, 30.0),
        (30.0, 10.0),
        (25.0, 10.0),
        (25.0, 30.0),
        (0.0, 30.0),
    ];
    let vertices: Vec<Point> = corners
        .into_iter()
        .map(|(x, y)| keepout_kernel::curve::nearest_point(Vec2::new(x * unit, y * unit)))
        .collect::<Result<_, _>>()?;
    let next = vertices.iter().cycle().skip(1);
    let curves = vertices.iter().zip(next).map(|(&from, &to)| Curve::Line(Segment { from, to })).collect();
    let outlines = [Outline { curves, free_on_left: false }];
    let part = ProhibitedRegion::new(Region::new(vec![Ring::new(vertices)?])?, Side::Outside)?;

    // The proposal is 0.6 µm outside the certified distance, because joints and arcs are rounded to the
    // lattice.
    let threshold = Length::from_units(300_000)?;
    let distance = f64::from(threshold.units()) + 60.0;
    let offset = propose(&outlines, distance);
    for each in &offset.loops {
        let end = certify_path(&part, threshold, &each.curves)?;
        let arcs = each.curves.iter().filter(|curve| matches!(curve, Curve::Arc(_))).count();
        println!(
            "a loop of {} motions, {arcs} of them arcs, certified: {}",
            each.curves.len(),
            end.is_some()
        );
    }
    let path = offset.loops.iter().flat_map(|each| &each.curves);
    certify_complete(&part, &outlines, distance, Length::small(20), path)?;
    println!("every piece of the offset has a loop");
    let cut: f64 = offset.loops.iter().map(|each| each.cut.double_area()).sum();
    let part: f64 = outlines.iter().map(|each| CutContour::of(each).double_area()).sum();
    println!("the disc leaves {:.3} mm² of rest material", (cut - part) / (2.0 * unit * unit));
    Ok(())
}
