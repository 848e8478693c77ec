//! Broken images at the start and in the middle: the frame is dropped, counted and named, and the run goes on.

use std::path::Path;

use image::{GrayImage, ImageFormat};

use crate::program::{Call, summary};
use crate::sequence::Copy;

/// Frames of each run.
const N: usize = 8;

/// A gray PNG of one brightness.
pub(crate) fn flat_png(width: u32, height: u32, brightness: u8) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = GrayImage::from_pixel(width, height, image::Luma([brightness]));
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Frame `dropped` was dropped for `reason`, all others have a pose, and a row stands for each.
#[track_caller]
fn only_one_is_dropped(copy: &Copy, call: &Call, dropped: usize, reason: &str) {
    call.expect(0, &format!("warning: frame {dropped} dropped: {reason}"));
    let summary = summary(&copy.results());
    for (key, expected) in [("frames", N), ("dropped", 1), ("tracked", N - 1), ("lost", 0)] {
        assert_eq!(summary[key], expected, "{key}: {summary:#}");
    }
    let without = &summary["without_pose"][0];
    assert_eq!(
        (&without["frame"], without["state"].as_str()),
        (&dropped.into(), Some("dropped")),
        "{summary:#}"
    );
    assert_eq!(without["reason"], reason);
    let rows = std::fs::read_to_string(copy.results().join("trajectory.kitti.txt")).unwrap();
    assert_eq!(rows.lines().count(), N);
}

/// Breaks one image at the start and in the middle and expects that frame, and no other, to be dropped.
#[track_caller]
fn dropped_at_start_and_in_the_middle(
    camera: &str,
    breaks: impl Fn(&Copy, &str),
    reason: impl Fn(&Copy, &str) -> String,
) {
    for frame in [0, 4] {
        let copy = Copy::of_first(N);
        let name = format!("{camera}/{frame:06}.png");
        breaks(&copy, &name);
        let call = copy.run(&[]);
        only_one_is_dropped(&copy, &call, frame, &reason(&copy, &name));
    }
}

#[test]
fn a_truncated_image_is_dropped() {
    dropped_at_start_and_in_the_middle(
        "image_0",
        |copy, name| {
            let bytes = copy.bytes(name);
            copy.write(name, &bytes[..bytes.len() / 2]);
        },
        |copy, name| format!("{}: truncated or corrupt PNG image: unexpected end of file", copy.file(name)),
    );
}

#[test]
fn an_empty_image_is_dropped() {
    dropped_at_start_and_in_the_middle(
        "image_1",
        |copy, name| copy.write(name, ""),
        |copy, name| format!("{}: empty file (0 bytes), expected an image", copy.file(name)),
    );
}

#[test]
fn a_missing_image_is_dropped() {
    dropped_at_start_and_in_the_middle(
        "image_0",
        |copy, name| copy.remove(name),
        |copy, name| format!("{}: no such image", copy.file(name)),
    );
}

#[test]
fn a_text_file_is_no_image() {
    dropped_at_start_and_in_the_middle(
        "image_0",
        |copy, name| copy.write(name, "this is a text"),
        |copy, name| {
            format!(
                "{}: not an image: begins with the text \"this is a text\", expected PNG, JPEG, PGM, PPM, BMP, TIFF or WebP",
                copy.file(name)
            )
        },
    );
}

#[test]
fn left_and_right_must_have_one_size() {
    dropped_at_start_and_in_the_middle(
        "image_1",
        |copy, name| copy.write(name, flat_png(640, 376, 90)),
        |copy, name| {
            let left = copy.file(&name.replace("image_1", "image_0"));
            format!("{}: found 640x376 pixels, expected 1241x376 (as {left})", copy.file(name))
        },
    );
}

#[test]
fn a_pair_of_another_size_than_the_rest_is_dropped() {
    let copy = Copy::of_first(N);
    for camera in ["image_0", "image_1"] {
        copy.write(&format!("{camera}/000003.png"), flat_png(640, 480, 90));
    }
    let call = copy.run(&[]);
    only_one_is_dropped(&copy, &call, 3, "the left image is 640 x 480 pixels, expected 1241 x 376");
}

#[test]
fn nothing_but_text_files_is_refused() {
    let copy = Copy::of_first(2);
    for name in ["image_0/000000.png", "image_0/000001.png"] {
        copy.write(name, "text");
    }
    let first = copy.file("image_0/000000.png");
    let expected = format!(
        "error: none of the sequence's images can be read: {first}: not an image: begins with the text \"text\", \
         expected PNG, JPEG, PGM, PPM, BMP, TIFF or WebP"
    );
    copy.run(&[]).expect(2, &expected);
}

#[test]
fn right_images_that_are_all_of_another_size_end_with_code_1() {
    let copy = Copy::of_first(3);
    for i in 0..3 {
        copy.write(&format!("image_1/{i:06}.png"), flat_png(600, 376, 90));
    }
    let call = copy.run(&[]);
    call.expect(1, "error: no frame has a pose; 3 of 3 frames: an image has another size than expected");
    assert_eq!(summary(&copy.results())["dropped"], 3);
}

#[test]
fn black_images_end_with_code_1_and_still_write_their_results() {
    let copy = Copy::of_first(3);
    for i in 0..3 {
        for camera in ["image_0", "image_1"] {
            copy.write(&format!("{camera}/{i:06}.png"), flat_png(1241, 376, 0));
        }
    }
    let call = copy.run(&[]);
    assert_eq!(call.code, 1, "{call}");
    assert!(
        call.stderr.contains(
            "error: no frame has a pose; 3 of 3 frames: the image has no features (the left image is dark"
        ),
        "{call}"
    );
    let summary = summary(&copy.results());
    assert_eq!((&summary["not_ready"], &summary["ate_rmse_m"]), (&3.into(), &serde_json::Value::Null));
    let rows = std::fs::read_to_string(copy.results().join("trajectory.kitti.txt")).unwrap();
    assert_eq!(rows.lines().count(), 3, "a row per frame: the identity");
}

#[test]
fn a_sequence_of_one_frame_has_a_pose_and_no_error() {
    let copy = Copy::of_first(1);
    let call = copy.run(&[]);
    call.expect_success();
    let summary = summary(&copy.results());
    assert_eq!((&summary["frames"], &summary["tracked"]), (&1.into(), &1.into()));
    assert_eq!(summary["evaluation_problem"], "alignment SE3 needs at least 3 matched poses, found 1");
    assert!(files_are_there(&copy.results()), "{call}");
}

/// Whether a results folder is complete.
fn files_are_there(results: &Path) -> bool {
    [
        "trajectory.kitti.txt",
        "trajectory.tum.txt",
        "trajectory.png",
        "config.yaml",
        "timings.csv",
        "summary.json",
    ]
    .iter()
    .all(|name| results.join(name).exists())
}
