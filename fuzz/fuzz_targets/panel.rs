//! Fuzz target: [`keepout_fuzz::panel`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::panel(bytes));
