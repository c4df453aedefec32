//! The fuzz targets. Each takes any bytes, and must neither panic nor accept anything false.
//!
//! `fuzz/run dxf_import` runs one under libFuzzer. `cargo test -p keepout-fuzz` runs all over their stored
//! inputs, over inputs that once failed, and over random bytes. See `fuzz/README.md`.
//!
//! ```
//! for target in keepout_fuzz::TARGETS {
//!     (target.holds)(b"");
//! }
//! ```

mod clear;
pub mod corpus;
mod dialects;
mod export;
mod field;
mod files;
mod import;
mod index;
mod job;
mod mesh;
mod offset;
mod oracle;
mod panel;
mod session;
pub mod sketch;
mod small;

pub use clear::clear;
pub use dialects::{described_decode, grbl_decode, round_trip, venus_decode, zaber_decode};
pub use files::{certificates_of_log, is_certified_plan, plan_file, session_log};
pub use import::dxf_import;
pub use index::{index, index_check};
pub use job::{plate, work};
pub use keepout_proofs::property_of_bytes as property;
pub use mesh::mesh;
pub use offset::offset;
pub use panel::panel;
pub use session::supervisor;
pub use sketch::drawing;
pub use small::{machine_profile, small_files};

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, and the name of its pack, its seeds and its dictionary.
    pub name: &'static str,
    /// The property that holds for all bytes.
    pub holds: fn(&[u8]),
}

macro_rules! targets {
    ($($name:ident),+ $(,)?) => { &[$(Target { name: stringify!($name), holds: $name }),+] };
}

/// All targets. A test compares them with the programs in `fuzz_targets/` and in the manifest.
pub const TARGETS: &[Target] = targets![
    // Evidence for SR-16, SR-27.
    dxf_import,
    drawing,
    // Evidence for SR-03.
    index,
    index_check,
    // Evidence for SR-03.
    mesh,
    // Evidence for SR-02, SR-04, SR-20.
    offset,
    // Evidence for SR-01, SR-02, SR-04, SR-14.
    clear,
    // Evidence for SR-16, SR-20.
    plan_file,
    // Evidence for SR-23.
    session_log,
    // Evidence for SR-29.
    machine_profile,
    small_files,
    // Evidence for SR-18.
    grbl_decode,
    zaber_decode,
    venus_decode,
    described_decode,
    // Evidence for SR-17.
    round_trip,
    // Evidence for SR-28.
    panel,
    // Evidence for SR-07, SR-12, SR-14, SR-22, SR-23, SR-25.
    supervisor,
    // Evidence for SR-01.
    property,
];
