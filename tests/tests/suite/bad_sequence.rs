//! Broken dataset folders: each is refused before the first image is processed, with the exact message and code 2.

use crate::program::{dsslam, text};
use crate::sequence::Copy;

/// Line of `calib.txt` with the left gray camera's projection matrix.
const P0: usize = 0;

/// The numbers of the left camera with one of them replaced.
fn with_number(copy: &Copy, position: usize, value: &str) {
    copy.edit("calib.txt", |i, line| {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        if i == P0 {
            words[1 + position] = value;
        }
        Some(words.join(" "))
    });
}

/// The sequence is refused with this message, and nothing is written.
#[track_caller]
fn refused(copy: &Copy, message: &str) {
    copy.run(&[]).expect(2, &format!("error: {message}"));
    assert!(!copy.results().exists(), "nothing is written for a sequence that is refused");
}

#[test]
fn a_missing_folder_is_named() {
    dsslam(&["run", "/nowhere/at/all"]).expect(2, "error: /nowhere/at/all: no such folder");
}

#[test]
fn a_file_is_no_sequence() {
    let copy = Copy::of_first(1);
    let file = copy.path().join("times.txt");
    dsslam(&["run", text(&file)]).expect(2, &format!("error: {}: not a folder", file.display()));
}

#[test]
fn an_empty_folder_has_no_known_layout() {
    let folder = tempfile::tempdir().unwrap();
    let found = dsslam(&["run", text(folder.path())]);
    let expected = format!(
        "error: {}: no known dataset layout: found nothing; expected KITTI (image_0 or image_2 with times.txt), KITTI raw",
        folder.path().display()
    );
    assert!(found.code == 2 && found.stderr.contains(&expected), "{found}");
}

#[test]
fn a_missing_calibration_line_is_named() {
    let copy = Copy::of_first(2);
    copy.edit("calib.txt", |i, line| (i != P0).then(|| line.to_owned()));
    let calib = copy.file("calib.txt");
    refused(
        &copy,
        &format!(
            "{calib}: found no line `P0:` or `P_rect_00:`, expected 12 numbers (projection matrix, row by row)"
        ),
    );
}

#[test]
fn a_short_calibration_line_is_counted() {
    let copy = Copy::of_first(2);
    copy.edit("calib.txt", |i, line| {
        Some(if i == P0 { line.rsplit_once(' ').unwrap().0.to_owned() } else { line.to_owned() })
    });
    let calib = copy.file("calib.txt");
    refused(
        &copy,
        &format!("{calib}:1: found 11 numbers, expected 12 numbers (projection matrix, row by row)"),
    );
}

#[test]
fn not_a_number_in_the_calibration_is_found() {
    let copy = Copy::of_first(2);
    with_number(&copy, 0, "NaN");
    refused(&copy, &format!("{}:1: found `NaN`, expected a finite number", copy.file("calib.txt")));
}

#[test]
fn a_negative_focal_length_in_the_calibration_is_found() {
    let copy = Copy::of_first(2);
    with_number(&copy, 0, "-707.09");
    let calib = copy.file("calib.txt");
    refused(&copy, &format!("{calib}:1: found fx = -707.09 in P0, expected a focal length above 0 px"));
}

#[test]
fn an_empty_list_of_times_is_refused() {
    let copy = Copy::of_first(2);
    copy.write("times.txt", "");
    refused(
        &copy,
        &format!("{}: found no data, expected a time in seconds per line", copy.file("times.txt")),
    );
}

#[test]
fn a_missing_list_of_times_is_refused() {
    let copy = Copy::of_first(2);
    copy.remove("times.txt");
    refused(&copy, &format!("{}: no such file, expected a time in seconds per line", copy.file("times.txt")));
}

#[test]
fn a_time_that_is_no_number_is_quoted() {
    let copy = Copy::of_first(3);
    copy.write("times.txt", "0.0\nsoon\n0.2\n");
    refused(&copy, &format!("{}:2: found `soon`, expected a number", copy.file("times.txt")));
}

#[test]
fn times_must_increase() {
    let copy = Copy::of_first(3);
    copy.write("times.txt", "0.0\n0.2\n0.1\n");
    let times = copy.file("times.txt");
    refused(
        &copy,
        &format!(
            "{times}:3: found time 0.1 after 0.2 of the previous entry, expected strictly increasing times"
        ),
    );
}

#[test]
fn a_sensor_that_the_folder_does_not_have_is_refused() {
    let copy = Copy::of_first(2);
    let (path, results) = (copy.path(), copy.results());
    let call = dsslam(&["run", text(&path), "--sensor", "rgbd", "--out", text(&results)]);
    let path = path.display();
    call.expect(
        2,
        &format!("error: {path}: sensor rgbd is not possible here: KITTI folders contain no depth images"),
    );
}

/// Situation: a named pipe or a device where a file is expected; a map, a vocabulary, a journal and a video waited for ever.
#[cfg(unix)]
#[test]
fn pipes_and_devices_in_the_place_of_files_are_refused_at_once() {
    let copy = Copy::of_first(1);
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.y4m");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for option in ["--load-map", "--vocab", "--ground-truth", "--calib", "--config"] {
        let call = copy.run(&[option, text(&pipe)]);
        let place = text(&pipe);
        let is_told = call.stderr.contains(place)
            && (call.stderr.contains("it is a pipe or a device") || call.stderr.contains("no such file"));
        assert!(is_told && (call.code == 2 || option == "--ground-truth"), "{option}: {call}");
        let _ = std::fs::remove_dir_all(copy.results());
    }
    dsslam(&["run", text(&pipe)]).expect(2, &format!("error: {}: not a folder", text(&pipe)));
    let call = dsslam(&["export", "/dev/zero", "--to", "ply", "--out", text(&folder.path().join("a.ply"))]);
    assert!(call.code == 2 && call.stderr.starts_with("error: /dev/zero: cannot be read"), "{call}");
}
