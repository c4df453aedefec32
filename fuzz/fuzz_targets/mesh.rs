//! Fuzz target: [`keepout_fuzz::mesh`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::mesh(bytes));
