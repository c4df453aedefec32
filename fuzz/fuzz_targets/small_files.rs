//! Fuzz target: [`keepout_fuzz::small_files`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::small_files(bytes));
