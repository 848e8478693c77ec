//! Broken configurations: the exact message, all problems at once.

use dsslam::Config;

use super::support::Folder;

/// The message about a file with this content.
fn refused(yaml: &str) -> String {
    let folder = Folder::new();
    let path = folder.write("c.yaml", yaml);
    folder.hide(Config::load(Some(&path), &[]).unwrap_err())
}

/// The message about one `--set`.
fn refused_set(argument: &str) -> String {
    Config::load(None, &[argument.to_string()]).unwrap_err().to_string()
}

#[test]
fn missing_file() {
    let folder = Folder::new();
    assert_eq!(
        folder.hide(Config::load(Some(&folder.file("c.yaml")), &[]).unwrap_err()),
        "DIR/c.yaml: no such file, expected a configuration in YAML"
    );
}

#[test]
fn unknown_key() {
    assert_eq!(
        refused("features:\n  levles: 8\n"),
        "DIR/c.yaml:2:11: features.levles: unknown key, did you mean features.levels?"
    );
    assert_eq!(
        refused("feature:\n  keep: 8\n"),
        "DIR/c.yaml:2:9: feature.keep: unknown key, did you mean features.keep?"
    );
    assert_eq!(refused("color: blue\n"), "DIR/c.yaml:1:8: color: unknown key");
    assert_eq!(
        refused_set("features.kep=500"),
        "--set features.kep=500: features.kep: unknown key, did you mean features.keep?"
    );
}

#[test]
fn out_of_range() {
    assert_eq!(
        refused("camera:\n  fx: -718.8\n"),
        "DIR/c.yaml:2:7: camera.fx: found -718.8, expected a number above 0 px"
    );
    assert_eq!(
        refused("features: {levels: 99}\n"),
        "DIR/c.yaml:1:20: features.levels: found 99, expected a whole number from 1 to 16"
    );
    assert_eq!(
        refused_set("mapping.keyframe_cull_ratio=1.5"),
        "--set mapping.keyframe_cull_ratio=1.5: mapping.keyframe_cull_ratio: found 1.5, expected a number from 0.1 to 1"
    );
    assert_eq!(refused_set("seed=-1"), "--set seed=-1: seed: found -1, expected a whole number, at least 0");
    assert_eq!(
        refused("camera:\n  fps: .inf\n"),
        "DIR/c.yaml:2:8: camera.fps: found inf, expected a number above 0 Hz"
    );
    assert_eq!(
        refused_set("camera.cx=.nan"),
        "--set camera.cx=.nan: camera.cx: found NaN, expected a finite number"
    );
}

#[test]
fn wrong_type() {
    assert_eq!(
        refused("features:\n  keep: many\n"),
        "DIR/c.yaml:2:9: features.keep: found \"many\", expected a whole number from 50 to 100000"
    );
    assert_eq!(
        refused("features:\n  keep: 500.5\n"),
        "DIR/c.yaml:2:9: features.keep: found 500.5, expected a whole number from 50 to 100000"
    );
    assert_eq!(
        refused("features:\n  keep:\n"),
        "DIR/c.yaml:2:7: features.keep: found nothing, expected a whole number from 50 to 100000"
    );
    assert_eq!(
        refused("input:\n  sensor: lidar\n"),
        "DIR/c.yaml:2:11: input.sensor: found \"lidar\", expected one of stereo, rgbd, mono"
    );
    assert_eq!(
        refused_set("features.subpixel=3"),
        "--set features.subpixel=3: features.subpixel: found 3, expected true or false"
    );
    assert_eq!(
        refused("stereo: 5\n"),
        "DIR/c.yaml:1:9: stereo: found 5, expected a section with keys min_depth_m, close_depth_baselines, \
             disparity_offset_px"
    );
    assert_eq!(
        refused("seed: [1, 2]\n"),
        "DIR/c.yaml:1:7: seed: found a list, expected one value or a section with keys"
    );
    assert_eq!(
        refused("seed: {first: 1}\n"),
        "DIR/c.yaml:1:15: seed: found a section, expected a whole number, at least 0"
    );
    assert_eq!(refused("hello\n"), "DIR/c.yaml:1:1: found \"hello\", expected sections with keys");
}

#[test]
fn broken_yaml() {
    assert_eq!(
        refused("features:\n  keep: 500\n   levels: 8\n"),
        "DIR/c.yaml:3:10: invalid YAML: mapping values are not allowed in this context"
    );
}

#[test]
fn a_key_twice() {
    assert_eq!(refused("seed: 1\nseed: 2\n"), "DIR/c.yaml:2:7: seed: given twice, first at DIR/c.yaml:1:7");
    assert_eq!(
        refused("features: {keep: 60}\nfeatures: {keep: 70}\n"),
        "DIR/c.yaml:2:18: features.keep: given twice, first at DIR/c.yaml:1:18"
    );
    assert_eq!(
        refused("features.keep: 60\nfeatures: {keep: 70}\n"),
        "DIR/c.yaml:2:18: features.keep: given twice, first at DIR/c.yaml:1:16"
    );
}

#[test]
fn set_without_a_value() {
    assert_eq!(
        refused_set("features.keep"),
        "--set features.keep: found no `=`, expected key=value, such as features.keep=500"
    );
    assert_eq!(
        refused_set("features.keep="),
        "--set features.keep=: features.keep: found nothing, expected a whole number from 50 to 100000"
    );
}

#[test]
fn all_problems_at_once() {
    let folder = Folder::new();
    let path = folder.write("c.yaml", "camera:\n  fx: -1\n  fz: 3\nfeatures:\n  keep: many\n");
    let errors = Config::load(Some(&path), &["sed=4".to_string()]).unwrap_err();
    assert_eq!(errors.0.len(), 4);
    assert_eq!(
        folder.hide(errors),
        "DIR/c.yaml:2:7: camera.fx: found -1, expected a number above 0 px\n\
         DIR/c.yaml:3:7: camera.fz: unknown key, did you mean camera.fx?\n\
         DIR/c.yaml:5:9: features.keep: found \"many\", expected a whole number from 50 to 100000\n\
         --set sed=4: sed: unknown key, did you mean seed?"
    );
}

#[test]
fn rules_between_keys() {
    assert_eq!(
        refused("features:\n  fast_initial: 5\n  fast_minimum: 6\n"),
        "DIR/c.yaml:3:17: features.fast_minimum: found 6, expected at most features.fast_initial = 5"
    );
    assert_eq!(
        refused("camera: {fx: 500, cy: 240, width: 640}\n"),
        "DIR/c.yaml:1:14: camera.fy: found nothing, expected a value, since camera.fx is given\n\
         DIR/c.yaml:1:14: camera.cx: found nothing, expected a value, since camera.fx is given\n\
         DIR/c.yaml:1:35: camera.height: found nothing, expected a value, since camera.width is given"
    );
}
