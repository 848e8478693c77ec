//! libFuzzer's way into the target `journals`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("journals", data));
