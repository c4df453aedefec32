//! The kernel beside its peers, in one process on the same data: `cargo bench -p keepout-kernel`. With `-- --write` the
//! results become `docs/performance.md` and its pictures; numbers after `--` are the sizes to run.
#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, missing_docs)]

mod paths;
mod profiles;
mod queries;
mod rivals;
mod timing;

use profiles::Family;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut sizes: Vec<usize> = arguments.iter().filter_map(|argument| argument.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![100, 1_000, 10_000, 100_000, 1_000_000];
    }
    let mut results = Vec::new();
    for family in Family::ALL {
        for &size in &sizes {
            queries::run(family, size, 7, &mut results);
        }
    }
    for r in &results {
        print!("{} {} {} {}:", r.question.name(), r.family.name(), r.edges, r.motion.name());
        for t in &r.timed {
            print!(" {} {:.0},", t.name, t.ns);
        }
        println!();
    }
}
