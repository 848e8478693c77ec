//! libFuzzer's way into the target `bags`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("bags", data));
