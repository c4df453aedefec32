//! Each property is a test: `cargo test -p keepout-proofs --test properties NAME`. A group in brackets, such as
//! `[lattice]`, names all its properties.
//!
//! The tests come from the list of properties, and so the crate is not compiled once more for them.

use keepout_proofs::properties;
use libtest_mimic::{Arguments, Trial};

fn main() {
    let test = |property: &'static keepout_proofs::property::Property| {
        let check = || {
            property.check();
            Ok(())
        };
        Trial::test(property.name, check).with_kind(property.group)
    };
    libtest_mimic::run(&Arguments::from_args(), properties::all().into_iter().map(test).collect()).exit();
}
