//! Runs inputs without libFuzzer: `cargo run -p keepout-fuzz --example replay -- TARGET [FILE...]`. Without
//! files it runs the target's stored inputs; without a target, the stored inputs of all targets.

use std::error::Error;
use std::fs;

use keepout_fuzz::corpus::{self, Input};
use keepout_fuzz::{TARGETS, Target};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next();
    let files: Vec<String> = arguments.collect();
    let chosen: Vec<&Target> =
        TARGETS.iter().filter(|target| name.as_ref().is_none_or(|name| name == target.name)).collect();
    if chosen.is_empty() {
        let known: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
        return Err(format!("there is no such target. The targets are: {}", known.join(", ")).into());
    }
    for target in chosen {
        let inputs = if files.is_empty() { corpus::stored(target.name)? } else { read(&files)? };
        for input in &inputs {
            (target.holds)(&input.bytes);
        }
        println!("{}: {} inputs", target.name, inputs.len());
    }
    Ok(())
}

fn read(files: &[String]) -> Result<Vec<Input>, String> {
    let read = |file: &String| match fs::read(file) {
        Ok(bytes) => Ok(Input { name: file.clone(), bytes }),
        Err(error) => Err(format!("{file}: {error}")),
    };
    files.iter().map(read).collect()
}
