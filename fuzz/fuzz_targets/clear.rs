//! Fuzz target: [`keepout_fuzz::clear`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::clear(bytes));
