#![allow(missing_docs, clippy::all)]
#[path = "peers/profiles.rs"]
mod profiles;
use cavalier_contours::polyline::{PlineCreation, PlineOffsetOptions, PlineSource, PlineSourceMut, Polyline};
use keepout_kernel::offset::{Outline, certify_path, propose};
use keepout_kernel::{Curve, Length, ProhibitedRegion, Region, Ring, Segment, Side};
use profiles::Family;
use std::time::Instant;
fn main() {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    for family in Family::ALL {
        for &n in &sizes {
            for sign in [1.0, -1.0f64] {
                let v = family.vertices(n);
                let mut pl = Polyline::<f64>::new_closed();
                for &p in &v {
                    let (x, y) = profiles::mm(p);
                    pl.add(x, y, 0.0);
                }
                let t = Instant::now();
                let r = if n <= 20000 || family == Family::Maze {
                    pl.parallel_offset(-3.05 * sign)
                } else {
                    vec![]
                };
                let tc = t.elapsed();
                let curves: Vec<Curve> = v
                    .iter()
                    .zip(v.iter().cycle().skip(1))
                    .map(|(&from, &to)| Curve::Line(Segment { from, to }))
                    .collect();
                let t = Instant::now();
                let o = propose(&[Outline { curves, free_on_left: sign < 0.0 }], 305_060.0);
                let tp = t.elapsed();
                let ring = Ring::new(v.clone()).unwrap();
                let part = ProhibitedRegion::new(
                    Region::new(vec![ring]).unwrap(),
                    if sign > 0.0 { Side::Outside } else { Side::Inside },
                )
                .unwrap();
                let t = Instant::now();
                let mut bad = 0;
                for l in &o.loops {
                    if let Err(e) = certify_path(&part, Length::from_units(305_000).unwrap(), &l.curves) {
                        bad += 1;
                        if bad == 1 {
                            println!("{e}");
                        }
                    }
                }
                println!(
                    "{} {} {sign}: cavalier {:?} ({} loops, {} arcs) ours {:?} certify {:?} loops {} curves {} loose {} bad {bad}",
                    family.name(),
                    v.len(),
                    tc,
                    r.len(),
                    r.iter().map(|p| p.vertex_count()).sum::<usize>(),
                    tp,
                    t.elapsed(),
                    o.loops.len(),
                    o.loops.iter().map(|l| l.curves.len()).sum::<usize>(),
                    o.loose_ends.len()
                );
            }
        }
    }
}
