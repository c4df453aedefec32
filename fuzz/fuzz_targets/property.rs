//! Fuzz target: [`keepout_fuzz::property`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::property(bytes));
