//! Keep-out zones with a part: `holds` and `motion_clear`, compared with the part and each zone alone.

use fastrand::Rng;
use keepout_kernel::exact::region::Location;
use keepout_kernel::{Length, Point, ProhibitedRegion, Region, Ring, Segment, Side};

#[expect(clippy::unwrap_used, reason = "the corners are fixed")]
fn ring(corners: &[(i64, i64)]) -> Ring {
    Ring::new(corners.iter().map(|&(x, y)| Point::from_units(x, y).unwrap()).collect()).unwrap()
}

fn triangle(random: &mut Rng) -> Ring {
    loop {
        let mut corner = || (random.i64(-60..60), random.i64(-60..60));
        let corners = [corner(), corner(), corner()].map(|(x, y)| Point::from_units(x, y).expect("small"));
        if let Ok(ring) = Ring::new(corners.to_vec()) {
            return ring;
        }
    }
}

/// The lattice is small, so points often fall on outlines, on corners, and on crossings of zones with the
/// part.
#[test]
fn part_and_keep_out_zones_are_prohibited_together() {
    let mut random = Rng::with_seed(31);
    let plate =
        [ring(&[(-50, -40), (50, -40), (50, 40), (-50, 40)]), ring(&[(-20, -10), (20, -10), (5, 25)])];
    for _ in 0..300 {
        let region = Region::new(plate.to_vec()).expect("apart");
        let zones: Vec<Ring> = (0..random.usize(1..5)).map(|_| triangle(&mut random)).collect();
        let side = if random.bool() { Side::Outside } else { Side::Inside };
        let alone = ProhibitedRegion::new(region.clone(), side).expect("few edges");
        let both = ProhibitedRegion::with_zones(region, side, zones.clone()).expect("few edges");
        let each: Vec<Region> =
            zones.iter().map(|zone| Region::new(vec![zone.clone()]).expect("one")).collect();
        let threshold = Length::from_units(random.i64(0..9)).expect("a length");
        for _ in 0..400 {
            let mut point = || Point::from_units(random.i64(-70..70), random.i64(-70..70)).expect("small");
            let (p, q) = (point(), point());
            let in_zone = each.iter().any(|zone| zone.locate(p) != Location::Outside);
            assert_eq!(both.holds(p), alone.holds(p) || in_zone, "{p:?} {zones:?}");
            let motion = Segment { from: p, to: q };
            let near_zone = zones
                .iter()
                .flat_map(Ring::segments)
                .any(|edge| !edge.near_segment(motion, threshold).is_clear());
            let clear = alone.motion_clear(motion, threshold).is_clear() && !near_zone;
            assert_eq!(both.motion_clear(motion, threshold).is_clear(), clear, "{motion:?} {zones:?}");
        }
    }
}
