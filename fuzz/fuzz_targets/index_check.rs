//! Fuzz target: [`keepout_fuzz::index_check`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::index_check(bytes));
