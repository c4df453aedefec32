//! Packs and unpacks the stored inputs of a target:
//! `cargo run -p keepout-fuzz --example corpus -- unpack|pack TARGET FOLDER`.

use std::error::Error;
use std::path::Path;

use keepout_fuzz::{TARGETS, corpus};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [command, target, folder] = arguments.as_slice() else {
        return Err("usage: corpus unpack|pack TARGET FOLDER".into());
    };
    if !TARGETS.iter().any(|known| known.name == target) {
        return Err(format!("there is no target {target}").into());
    }
    let count = match command.as_str() {
        "unpack" => corpus::unpack_to(target, Path::new(folder))?,
        "pack" => corpus::pack_from(target, Path::new(folder))?,
        other => return Err(format!("there is no command {other}. The commands are unpack and pack").into()),
    };
    println!("{count}");
    Ok(())
}
