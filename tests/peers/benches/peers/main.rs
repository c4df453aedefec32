//! Comparison of the kernel with its peers, in one process on the same data:
//! `cargo bench -p keepout-peers --bench peers`.
//!
//! With `-- --write` the benchmark writes `docs/contributor/performance.md` and its pictures. Numbers after
//! `--` are the sizes to run.
#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, missing_docs)]

mod builds;
mod growth;
mod offsets;
mod page;
mod paths;
mod profiles;
mod queries;
mod rivals;
mod timing;

use std::path::Path;
use std::process::Command;

use page::Measured;
use profiles::ProfileFamily;

const ROUNDS: usize = 7;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "--memory") {
        let count = arguments.get(at + 2).and_then(|count| count.parse().ok()).unwrap_or(1_000);
        let bytes = arguments.get(at + 1).and_then(|name| builds::memory(name, count));
        println!("{}", bytes.unwrap_or(f64::NAN));
        return;
    }
    let mut sizes: Vec<usize> = arguments.iter().filter_map(|argument| argument.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![100, 1_000, 10_000, 100_000, 1_000_000];
    }
    let measured = measure(&sizes);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let docs = if arguments.iter().any(|argument| argument == "--write") {
        root.join("docs").join("contributor")
    } else {
        root.join("target").join("performance")
    };
    match page::write(&docs, &measured) {
        Ok(()) => println!("{} is written", docs.join("performance.md").display()),
        Err(error) => eprintln!("{} can not be written: {error}", docs.display()),
    }
}

fn measure(sizes: &[usize]) -> Measured {
    let largest = sizes.iter().copied().max().unwrap_or(100);
    let mut measured = Measured {
        queries: Vec::new(),
        builds: Vec::new(),
        memory: Vec::new(),
        memory_edges: largest,
        offsets: Vec::new(),
    };
    for family in ProfileFamily::ALL {
        for &size in sizes {
            eprintln!("queries: {} {size}", family.name());
            queries::run(family, size, ROUNDS, &mut measured.queries);
        }
    }
    for family in [ProfileFamily::Star, ProfileFamily::Maze] {
        for &size in sizes {
            eprintln!("builds: {} {size}", family.name());
            measured.builds.push(builds::run(family, size, if size > 200_000 { 3 } else { ROUNDS }));
        }
        for outside in [true, false] {
            let mut slow = Vec::new();
            for &size in sizes.iter().filter(|&&size| size <= 100_000) {
                eprintln!("offsets: {} {size}", family.name());
                measured.offsets.push(offsets::run(family, size, outside, &mut slow));
            }
        }
    }
    for name in builds::KEEPERS {
        let Ok(program) = std::env::current_exe() else { continue };
        let output = Command::new(program).args(["--memory", name, &largest.to_string()]).output();
        let text = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
        if let Some(bytes) = text.ok().and_then(|text| text.parse().ok()) {
            measured.memory.push((name.to_owned(), bytes));
        }
    }
    measured
}
