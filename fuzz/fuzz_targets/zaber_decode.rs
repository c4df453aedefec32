//! Fuzz target: [`keepout_fuzz::zaber_decode`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::zaber_decode(bytes));
