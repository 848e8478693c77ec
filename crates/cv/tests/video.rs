//! `dsslam-video` on a video that OpenCV wrote, whole and cut.
#![cfg(feature = "video")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test stops at the first problem")]

use std::path::Path;
use std::process::Command;

use opencv::core::{CV_8UC3, Mat, Scalar, Size};
use opencv::prelude::*;
use opencv::videoio::VideoWriter;

/// Writes 40 frames of 64x48 pixels, each brighter than the one before.
fn write_video(path: &Path) {
    let fourcc = VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
    let mut writer = VideoWriter::new(path.to_str().unwrap(), fourcc, 25.0, Size::new(64, 48), true).unwrap();
    assert!(writer.is_opened().unwrap());
    for i in 0..40 {
        let frame =
            Mat::new_rows_cols_with_default(48, 64, CV_8UC3, Scalar::all(f64::from(10 + 5 * i))).unwrap();
        writer.write(&frame).unwrap();
    }
    writer.release().unwrap();
}

/// The stream of a video, its exit code and what it told.
fn stream(path: &Path) -> (Vec<u8>, i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_dsslam-video")).arg(path).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.stdout, output.status.code().unwrap(), told)
}

#[test]
fn frames_come_as_a_stream() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.avi");
    write_video(&path);
    let (bytes, code, told) = stream(&path);
    assert_eq!(code, 0, "{told}");
    let header = b"YUV4MPEG2 W64 H48 F25000:1000 Ip A1:1 Cmono XN40\n";
    assert_eq!(&bytes[..header.len()], header);
    assert_eq!(bytes.len(), header.len() + 40 * (6 + 64 * 48));
    for i in 0..40 {
        let frame = &bytes[header.len() + i * (6 + 64 * 48)..][..6 + 64 * 48];
        assert_eq!(&frame[..6], b"FRAME\n");
        assert!(frame[6].abs_diff((10 + 5 * i) as u8) <= 2, "frame {i}: {}", frame[6]);
    }
}

#[test]
fn a_cut_video_says_where_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.avi");
    write_video(&path);
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let (bytes, code, told) = stream(&path);
    assert_eq!(code, 0, "{told}");
    let end = bytes.windows(5).rposition(|word| word == b"XEND ").unwrap();
    let last = String::from_utf8_lossy(&bytes[end..]);
    let said = last.strip_prefix("XEND in the middle of frame ").and_then(|rest| rest.split_once(": "));
    let (frame, rest) = said.unwrap_or_else(|| panic!("{last}"));
    assert!((1..40).contains(&frame.parse::<u32>().unwrap()), "{last}");
    assert_eq!(rest, "the file announces 40 frames\n");
}

#[test]
fn a_text_is_no_video() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("text.mp4");
    std::fs::write(&path, "hello").unwrap();
    let (bytes, code, told) = stream(&path);
    assert_eq!((bytes.len(), code), (0, 1));
    assert!(told.ends_with("no frame can be decoded, expected a video or a camera\n"), "{told}");
}
