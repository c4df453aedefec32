//! Fuzz target: [`keepout_fuzz::session_log`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::session_log(bytes));
