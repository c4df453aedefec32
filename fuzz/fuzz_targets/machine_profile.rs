//! Fuzz target: [`keepout_fuzz::machine_profile`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::machine_profile(bytes));
