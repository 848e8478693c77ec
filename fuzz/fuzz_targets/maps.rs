//! libFuzzer's way into the target `maps`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("maps", data));
