//! libFuzzer's way into the target `command_lines`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dsslam_fuzz::run("command_lines", data));
