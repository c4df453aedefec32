//! Fuzz target: [`keepout_fuzz::index`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::index(bytes));
