//! Fuzz target: [`keepout_fuzz::offset`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::offset(bytes));
