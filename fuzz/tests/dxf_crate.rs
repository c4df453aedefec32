//! The dxf crate on the inputs that fuzzing found for our reader.

use std::io::Cursor;
use std::path::Path;

use keepout_fuzz::corpus;

/// An input that makes the crate panic must be on the page of upstream faults, with the beginning of its
/// bytes.
#[test]
fn panics_of_the_dxf_crate_are_listed() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/contributor/upstream.md");
    let listed = std::fs::read_to_string(page).expect("readable");
    let inputs = corpus::stored("dxf_import").unwrap_or_else(|error| panic!("{error}"));
    assert!(inputs.len() >= 100, "only {} inputs", inputs.len());
    for input in inputs {
        let load = || dxf::Drawing::load(&mut Cursor::new(&input.bytes)).is_ok();
        let panics = std::panic::catch_unwind(load).is_err();
        assert!(!panics || listed.contains(&input.name), "the dxf crate panics over {}", input.name);
    }
}
