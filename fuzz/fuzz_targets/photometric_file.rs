#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| isolux_fuzz::run("photometric_file", data));
