//! libFuzzer's way into the target `layouts`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("layouts", data));
