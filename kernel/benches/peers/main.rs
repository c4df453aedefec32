//! The kernel beside its peers, in one process on the same data.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    missing_docs,
    clippy::unwrap_used
)]

mod paths;
mod profiles;
mod timing;

use keepout_kernel::index::{build, subdivide};
use keepout_kernel::{NearList, Point, ProhibitedRegion, Region, Ring, Segment, Side};
use paths::Motion;
use profiles::Family;
use std::time::Instant;
use timing::{Rival, race};

fn main() {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    for family in Family::ALL {
        for &n in &sizes {
            let v = family.vertices(n);
            let edges = profiles::edges(&v);
            let t = Instant::now();
            let index = build::build(edges.clone()).unwrap();
            let tb = t.elapsed();
            let t = Instant::now();
            let ring = Ring::new(v.clone());
            println!(
                "{} {} edges, build {:?}, ring {:?} {:?}",
                family.name(),
                v.len(),
                tb,
                t.elapsed(),
                ring.as_ref().err()
            );
            let t = Instant::now();
            let proposal = subdivide::propose(&index, paths::threshold()).unwrap();
            let tp = t.elapsed();
            let t = Instant::now();
            let cells = keepout_kernel::Cells::check(&index, proposal).unwrap();
            println!("   cells {:?} + check {:?} {} kB", tp, t.elapsed(), cells.bytes() / 1024);
            let mut part =
                ProhibitedRegion::new(Region::new(vec![ring.unwrap()]).unwrap(), Side::Outside).unwrap();
            let plain = part.clone();
            part.prepare(paths::threshold()).unwrap();
            for motion in Motion::ALL {
                let points = motion.points(&index, 5_000);
                let moves: Vec<Segment> = points
                    .windows(2)
                    .map(|w| Segment { from: w[0], to: w[1] })
                    .filter(|m| part.point_clear(m.from, paths::threshold()).is_clear())
                    .collect();
                let th = paths::threshold();
                let mut list = NearList::new();
                let mut list2 = NearList::new();
                let mut hint = None;
                let mut rivals = vec![
                    Rival::new("clear cells", || {
                        points.iter().map(|&p| u64::from(part.point_clear(p, th).is_clear())).sum()
                    }),
                    Rival::new("clear tree", || {
                        points.iter().map(|&p| u64::from(plain.point_clear(p, th).is_clear())).sum()
                    }),
                    Rival::new("clear list", || {
                        points.iter().map(|&p| u64::from(list.is_clear(&index, p, th))).sum()
                    }),
                    Rival::new("nearest tree", || {
                        points
                            .iter()
                            .map(|&p| {
                                let n = index.nearest(p, hint).unwrap();
                                hint = Some(n.edge);
                                n.distance() as u64
                            })
                            .sum()
                    }),
                    Rival::new("nearest list", || {
                        points.iter().map(|&p| list2.nearest(&index, p).unwrap().distance() as u64).sum()
                    }),
                    Rival::new("motion cells", || {
                        moves.iter().map(|&m| u64::from(part.motion_clear(m, th).is_clear())).sum()
                    }),
                    Rival::new("motion tree", || {
                        moves.iter().map(|&m| u64::from(plain.motion_clear(m, th).is_clear())).sum()
                    }),
                    Rival::new("clip cells", || clip(&part, &moves)),
                    Rival::new("clip tree", || clip(&plain, &moves)),
                ];
                let timed = race(&mut rivals, points.len(), 5);
                print!("   {:9}", motion.name());
                for t in timed {
                    print!(" {} {:.0} ({})|", t.name, t.ns, t.answers);
                }
                println!();
            }
        }
    }
}

fn clip(part: &ProhibitedRegion, moves: &[Segment]) -> u64 {
    let mut sum = 0;
    for m in moves {
        let from = part.free_point_unchecked(m.from, paths::threshold());
        let end: Point = part.clip(from, m.to).point();
        sum += u64::from(end.x.units().unsigned_abs());
    }
    sum
}
