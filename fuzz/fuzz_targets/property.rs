//! Fuzz target: [`keepout_proofs::property_of_bytes`].
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| keepout_proofs::property_of_bytes(bytes));
