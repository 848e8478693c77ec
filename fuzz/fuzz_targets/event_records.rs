//! libFuzzer's way into the target `event_records`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("event_records", data));
