//! Fuzz target: [`keepout_fuzz::round_trip`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::round_trip(bytes));
