//! Broken configurations and arguments: refused with the exact message, all problems at once, and code 2; an output folder
//! that cannot be written with code 3.

use std::fs;

use crate::program::{command, dsslam, ended, summary, text};
use crate::sequence::Copy;

#[test]
fn an_unknown_key_is_refused_with_the_nearest_known_one() {
    let copy = Copy::of_first(2);
    copy.run(&["--set", "features.kep=500"])
        .expect(2, "error: --set features.kep=500: features.kep: unknown key, did you mean features.keep?");
}

#[test]
fn a_negative_focal_length_is_refused_with_its_unit() {
    let copy = Copy::of_first(2);
    copy.run(&["--set", "camera.fx=-700"])
        .expect(2, "error: --set camera.fx=-700: camera.fx: found -700, expected a number above 0 px");
}

#[test]
fn broken_yaml_is_refused_with_its_place() {
    let copy = Copy::of_first(2);
    copy.write("broken.yaml", "features:\n  keep: [500\n");
    let file = copy.file("broken.yaml");
    let call = copy.run(&["--config", &file]);
    assert_eq!(call.code, 2, "{call}");
    let place = call.stderr.lines().find(|line| line.starts_with(&format!("error: {file}:")));
    assert!(place.is_some_and(|line| line.contains(": invalid YAML: ")), "{call}");
}

#[test]
fn all_problems_of_a_configuration_are_reported_at_once() {
    let copy = Copy::of_first(2);
    copy.write("bad.yaml", "features:\n  keep: many\n  lewels: 8\n");
    let file = copy.file("bad.yaml");
    let call = copy.run(&["--config", &file, "--set", "seed=-1"]);
    call.expect(2, "--set seed=-1: seed: found -1, expected a whole number, at least 0");
    for part in [
        format!("{file}:2:9: features.keep: found \"many\", expected a whole number from 50 to 100000"),
        format!("{file}:3:11: features.lewels: unknown key, did you mean features.levels?"),
    ] {
        assert!(call.stderr.contains(&part), "no\n{part}\nin {call}");
    }
}

#[test]
fn a_missing_configuration_is_named() {
    let copy = Copy::of_first(2);
    copy.run(&["--config", "/nowhere.yaml"])
        .expect(2, "error: /nowhere.yaml: no such file, expected a configuration in YAML");
}

#[test]
fn the_calibration_of_the_dataset_wins_and_the_program_says_so() {
    let copy = Copy::of_first(2);
    let own = ["camera.fx=500", "camera.fy=500", "camera.cx=600", "camera.cy=180"].map(|o| ["--set", o]);
    let call = copy.run(own.as_flattened());
    call.expect_success();
    let calib = copy.file("calib.txt");
    let line =
        call.stderr.lines().find(|line| line.starts_with("warning: camera.fx = 500 (--set camera.fx=500)"));
    assert!(line.is_some_and(|line| line.ends_with(&format!("from {calib}"))), "{call}");
    assert_eq!(summary(&copy.results())["notices"].as_array().unwrap().len(), 4, "{call}");
    let in_force = fs::read_to_string(copy.results().join("config.yaml")).unwrap();
    assert!(!in_force.contains("fx: 500"), "{in_force}");
}

#[test]
fn an_output_folder_that_cannot_be_written_is_refused_before_the_work() {
    let copy = Copy::of_first(2);
    let out = copy.file("times.txt/results");
    let path = copy.path();
    let call = dsslam(&["run", text(&path), "--out", &out]);
    call.expect(3, &format!("error: {out}: cannot be written: Not a directory (os error 20)"));
    assert!(!call.stdout.contains("frames"), "nothing was run: {call}");
}

#[test]
fn without_a_folder_the_results_go_to_the_working_directory() {
    let copy = Copy::of_first(2);
    let place = tempfile::tempdir().unwrap();
    let path = copy.path();
    let call = ended(command(&["run", text(&path)]).current_dir(place.path()).output().unwrap());
    call.expect_success();
    assert_eq!(summary(&place.path().join("results/latest"))["frames"], 2);
    let taken = tempfile::tempdir().unwrap();
    fs::write(taken.path().join("results"), "").unwrap();
    let call = ended(command(&["run", text(&path)]).current_dir(taken.path()).output().unwrap());
    assert_eq!(call.code, 3, "{call}");
    assert!(call.stderr.contains("\nerror: results/seq: cannot be written: "), "{call}");
}

#[test]
fn wrong_arguments_end_with_code_2() {
    for args in [
        vec!["run"],
        vec!["run", "x", "--max-frames", "0"],
        vec!["fly"],
        vec!["run", "x", "--sensor", "nose"],
    ] {
        assert_eq!(dsslam(&args).code, 2, "{args:?}");
    }
}
