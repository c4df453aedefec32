//! Runs inputs without libFuzzer: `cargo run -p keepout-fuzz --example replay -- TARGET [FILE...]`. Without files, the
//! target's corpus; without a target, the corpus of all.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use keepout_fuzz::{TARGETS, Target};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next();
    let named: Vec<PathBuf> = arguments.map(PathBuf::from).collect();
    let chosen: Vec<&Target> =
        TARGETS.iter().filter(|target| name.as_ref().is_none_or(|name| name == target.name)).collect();
    if chosen.is_empty() {
        let known: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
        return Err(format!("there is no such target; there are {}", known.join(", ")).into());
    }
    for target in chosen {
        let files = if named.is_empty() { corpus(target.name)? } else { named.clone() };
        for file in &files {
            let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
            (target.holds)(&bytes);
        }
        println!("{}: {} inputs", target.name, files.len());
    }
    Ok(())
}

fn corpus(target: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    let entries = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
    files.sort();
    Ok(files)
}
