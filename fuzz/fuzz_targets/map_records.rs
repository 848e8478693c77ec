//! libFuzzer's way into the target `map_records`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("map_records", data));
