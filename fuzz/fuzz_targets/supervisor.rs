//! Fuzz target: [`keepout_fuzz::supervisor`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::supervisor(bytes));
