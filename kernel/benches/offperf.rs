#![allow(missing_docs, clippy::all)]
#[path = "peers/profiles.rs"]
mod profiles;
use keepout_kernel::offset::{Outline, propose};
use keepout_kernel::{Curve, Segment};
fn main() {
    let v = profiles::Family::Star.vertices(100);
    let curves: Vec<Curve> = v
        .iter()
        .zip(v.iter().cycle().skip(1))
        .map(|(&from, &to)| Curve::Line(Segment { from, to }))
        .collect();
    let o = [Outline { curves, free_on_left: false }];
    let t = std::time::Instant::now();
    for _ in 0..20000 {
        std::hint::black_box(propose(&o, 305_060.0));
    }
    println!("{:?}", t.elapsed() / 20000);
}
