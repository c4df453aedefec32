//! Fuzz target: [`keepout_fuzz::plan_file`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::plan_file(bytes));
