//! Fuzz target: [`keepout_fuzz::venus_decode`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::venus_decode(bytes));
