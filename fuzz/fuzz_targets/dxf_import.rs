//! Fuzz target: [`keepout_fuzz::dxf_import`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_fuzz::dxf_import(bytes));
