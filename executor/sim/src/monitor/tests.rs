use keepout_kernel::{HeightField, Region, Ring, Side};
use keepout_planner::{Mm2, Mm3};

use super::*;

fn monitor() -> CollisionMonitor {
    let at = |x, y| keepout_planner::units::point_from_mm(Mm2::new(x, y)).unwrap();
    let ring = Ring::new(vec![at(0.0, 0.0), at(40.0, 0.0), at(40.0, 30.0), at(0.0, 30.0)]).unwrap();
    let part = ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap();
    let levels = Arc::new(Levels::flat(Arc::new(part)));
    CollisionMonitor::new(
        levels,
        Length::from_units(300_000).unwrap(),
        (Vector { dx: 0, dy: 0 }, Height::ZERO),
    )
}

fn at(x: f64, y: f64) -> Sample {
    Sample { at: Time::ZERO, position_mm: Mm3::new(x, y, 0.0), kind: SampleKind::Jog }
}

#[test]
fn contact_is_found_to_a_lattice_unit() {
    let mut monitor = monitor();
    [at(-10.0, 10.0), at(-3.000_02, 10.0)].iter().for_each(|sample| monitor.watch(sample));
    assert_eq!(monitor.deepest(), None);
    assert_eq!(monitor.closest_mm(), Some(0.000_01), "a distance equal to the threshold is not clear");
    monitor.watch(&at(-2.999, 12.0));
    let depth = monitor.deepest().unwrap().depth_mm;
    assert!((depth - 0.001).abs() < 2e-5, "{depth}");
}

#[test]
fn crossing_between_samples_is_a_gouge() {
    let mut monitor = monitor();
    [at(-10.0, 15.0), at(50.0, 15.0)].iter().for_each(|sample| monitor.watch(sample));
    assert!(monitor.deepest().unwrap().depth_mm >= 3.0);
}

/// A plate with its top at 0, and a pocket 5 mm deep. The tool has a radius of 3 mm.
fn plate() -> CollisionMonitor {
    let at = |x, y| keepout_planner::units::point_from_mm(Mm2::new(x, y)).unwrap();
    let square =
        |low, high| Ring::new(vec![at(low, low), at(high, low), at(high, high), at(low, high)]).unwrap();
    let field = HeightField {
        outlines: Region::new(vec![square(0.0, 100.0), square(20.0, 80.0)]).unwrap(),
        tops: vec![Some(Height::ZERO), Height::from_units(-500_000).ok()],
        around: None,
        zones: Vec::new(),
        floor: None,
    };
    let levels = Arc::new(Levels::new(&field).unwrap());
    CollisionMonitor::new(
        levels,
        Length::from_units(300_000).unwrap(),
        (Vector { dx: 0, dy: 0 }, Height::ZERO),
    )
}

fn depth_of(path: &[(f64, f64, f64)]) -> Option<f64> {
    let mut monitor = plate();
    for &(x, y, z) in path {
        monitor.watch(&Sample { at: Time::ZERO, position_mm: Mm3::new(x, y, z), kind: SampleKind::Jog });
    }
    monitor.deepest().map(|gouge| (gouge.depth_mm * 1e5).round() / 1e5)
}

#[test]
fn tool_gouges_only_what_stands_above_its_tip() {
    assert_eq!(depth_of(&[(50.0, 50.0, 10.0), (50.0, 50.0, -5.0)]), None, "the floor of the pocket");
    assert_eq!(depth_of(&[(50.0, 50.0, 10.0), (50.0, 50.0, -5.01)]), Some(0.01), "into the floor");
    assert_eq!(depth_of(&[(10.0, 50.0, 10.0), (10.0, 50.0, 0.0)]), None, "on the plate");
    assert_eq!(depth_of(&[(10.0, 50.0, 10.0), (10.0, 50.0, -1.0)]), Some(1.0), "into the plate");
    assert_eq!(depth_of(&[(-10.0, 50.0, -20.0), (-3.1, 50.0, -20.0)]), None, "beside the plate");
    assert_eq!(depth_of(&[(-10.0, 50.0, -20.0), (-2.0, 50.0, -20.0)]), Some(1.00001), "into its side");
    assert_eq!(depth_of(&[(50.0, 50.0, -4.0), (24.0, 50.0, -4.0), (23.0, 50.0, -4.0)]), Some(0.00001));
}

/// The ramp passes the top of the plate 4 mm or 2 mm beside the wall of the pocket.
#[test]
fn ramps_are_cut_at_the_tops_that_they_pass() {
    assert_eq!(depth_of(&[(16.0, 50.0, 1.0), (32.0, 50.0, -1.0)]), None);
    assert_eq!(depth_of(&[(10.0, 50.0, 1.0), (26.0, 50.0, -1.0)]), Some(1.0));
    assert_eq!(depth_of(&[(32.0, 50.0, -1.0), (16.0, 50.0, 1.0)]), None, "and upward");
}

#[test]
fn depth_inside_the_part_adds_the_radius() {
    let mut monitor = monitor();
    [at(-10.0, 15.0), at(1.0, 15.0), at(10.0, 15.0)].iter().for_each(|sample| monitor.watch(sample));
    let depth = monitor.deepest().unwrap().depth_mm;
    assert!((depth - 13.0).abs() < 1e-4, "radius 3 mm, 10 mm inside: {depth}");
}
