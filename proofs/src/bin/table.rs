//! Writes the assurance table: `table [results of the solvers]`. Ends with 1 when something does not hold.

use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    let theorems = std::env::args().nth(1).map(PathBuf::from);
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    keepout_proofs::table::write(&page, theorems.as_deref())
}
