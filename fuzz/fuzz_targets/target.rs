//! Every target: the bytes go to the one that has the name of the binary.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| isolux_fuzz::run(env!("CARGO_BIN_NAME"), data));
