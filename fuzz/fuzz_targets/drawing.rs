//! Fuzz target: [`keepout_fuzz::drawing`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::drawing(bytes));
