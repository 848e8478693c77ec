//! Situations that people have: a figure is wrong, and the run would come to a result all the same. The program names it before the
//! first frame, `--strict` refuses the run, and good sequences are left alone.

use std::fs;
use std::path::Path;

use geometry::DepthImage;

use crate::program::{Call, dsslam, summary, text};
use crate::real_data::real;
use crate::sensors::rendered_radtan;
use crate::sequence::{Copy, rendered};

/// Refused with `--strict` because of exactly these rules, before anything is written.
#[track_caller]
fn doubted(copy: &Copy, args: &[&str], rules: &str) -> Call {
    let call = copy.run(&[&["--strict"], args].concat());
    call.expect(2, &format!("error: refused by --strict, since these figures are doubtful: {rules}"));
    assert!(!copy.results().exists(), "nothing is written for a run that is refused");
    call
}

/// Not doubted at all: a run of one frame ends well.
#[track_caller]
fn plausible(path: &Path, args: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let one = ["--strict", "--max-frames", "2", "--set", "features.selection=response"];
    let call = dsslam(&[&["run", text(path), "--out", text(folder.path())], &one[..], args].concat());
    assert!(!call.stderr.contains("doubtful"), "{}: {call}", path.display());
}

/// Situation: nothing is wrong, with rendered sequences of both layouts and the real ones.
#[test]
fn good_sequences_are_not_doubted() {
    for sequence in [rendered(), rendered_radtan()] {
        plausible(sequence, &[]);
        plausible(sequence, &["--sensor", "mono"]);
        plausible(sequence, &["--set", "input.scale=0.5"]);
    }
    for (name, config) in
        [("kitti06_first51", "kitti"), ("tum_fr1_desk", "tum-rgbd"), ("euroc_MH01_200", "euroc")]
    {
        let Some(path) = real(name) else { return };
        plausible(&path, &["--config", config]);
        plausible(&path, &["--config", config, "--sensor", "mono"]);
    }
}

/// Situation: a baseline of 110 m was accepted in silence, as was one in millimeters.
#[test]
fn a_baseline_in_millimeters_is_named() {
    let copy = Copy::of_first(3);
    let calib = String::from_utf8(copy.bytes("calib.txt")).unwrap();
    let right = calib.lines().find(|line| line.starts_with("P1")).unwrap();
    let mut words: Vec<String> = right.split_whitespace().map(str::to_owned).collect();
    words[4] = (words[4].parse::<f64>().unwrap() * 1000.0).to_string();
    copy.edit("calib.txt", |_, line| {
        Some(if line.starts_with("P1") { words.join(" ") } else { line.to_owned() })
    });
    let call = doubted(&copy, &[], "baseline, depth");
    assert!(call.stderr.contains("usual are 0.001 to 3: is it in millimeters or pixels?"), "{call}");
    // Without --strict the run goes on, and the summary tells.
    let call = copy.run(&[]);
    assert!(call.stderr.contains("warning: the baseline is "), "{call}");
    let summary = summary(&copy.results());
    assert_eq!(summary["doubts"], serde_json::json!(["baseline", "depth"]), "{summary:#}");
    let notices = summary["notices"].as_array().unwrap();
    assert!(notices.iter().any(|notice| notice.as_str().unwrap().starts_with("the baseline is ")));
    assert!(summary["figures"]["camera"].as_str().unwrap().starts_with("1241x376 pixels"), "{summary:#}");
}

/// Situation: the calibration was made at another image size, or with the principal point forgotten.
#[test]
fn intrinsics_of_another_image_size_are_named() {
    let copy = Copy::of_first(2);
    copy.edit("calib.txt", |_, line| {
        let (name, numbers) = line.split_once(':').unwrap();
        let mut numbers: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
        [0, 2, 3, 5, 6].iter().for_each(|&i| numbers[i] *= 0.5);
        Some(format!("{name}: {}", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")))
    });
    let call = doubted(&copy, &[], "other_size");
    assert!(call.stderr.contains("the intrinsics are those of another image size"), "{call}");
}

/// Situation: the images of the two cameras are exchanged, in a folder or by the plugs.
#[test]
fn exchanged_images_are_named() {
    let copy = Copy::of_first(3);
    for (from, to) in [("image_0", "x"), ("image_1", "image_0"), ("x", "image_1")] {
        fs::rename(copy.path().join(from), copy.path().join(to)).unwrap();
    }
    doubted(&copy, &[], "swapped");
}

/// Situation: the right camera lags by one frame, so that a drive through a town looks stereo and is not.
#[test]
fn a_right_camera_that_is_late_is_named() {
    let copy = Copy::of_first(20);
    for i in (1..20).rev() {
        let earlier = fs::read_link(copy.path().join(format!("image_1/{:06}.png", i - 1))).unwrap();
        let place = format!("image_1/{i:06}.png");
        copy.remove(&place);
        std::os::unix::fs::symlink(earlier, copy.path().join(place)).unwrap();
    }
    let call = doubted(&copy, &[], "right_late");
    assert!(call.stderr.contains("the right camera is late"), "{call}");
}

/// Situation: images were cropped or rectified by another calibration, so that rows do not agree.
#[test]
fn rows_that_do_not_agree_are_named() {
    let copy = Copy::of_first(2);
    for i in 0..2 {
        let name = format!("image_1/{i:06}.png");
        let image = io::load_gray(&copy.path().join(&name)).unwrap();
        copy.remove(&name);
        let lower = |x: usize, y: usize| image.at(x, y.saturating_sub(9));
        let moved = geometry::GrayImage::from_fn(image.width, image.height, lower);
        io::save_png_gray(&copy.path().join(&name), &moved).unwrap();
    }
    let call = doubted(&copy, &[], "rows");
    assert!(call.stderr.contains("the right one is +9.0 px off"), "{call}");
}

/// Situation: the right camera is covered or dead; the run said "0 of 2000 features have a depth".
#[test]
fn a_dead_right_camera_is_named() {
    let copy = Copy::of_first(3);
    for i in 0..3 {
        let name = format!("image_1/{i:06}.png");
        copy.remove(&name);
        let dark = geometry::GrayImage::new(1241, 376, 4);
        io::save_png_gray(&copy.path().join(&name), &dark).unwrap();
    }
    doubted(&copy, &[], "dark_or_blank");
    let call = copy.run(&[]);
    let cause = "error: no frame has a pose; 3 of 3 frames: too few features have a depth";
    assert!(call.code == 1 && call.stderr.contains(cause), "{call}");
    assert!(call.stderr.contains("(the right image is dark: it has 0 corners"), "{call}");
}

/// Situation: stamps in nanoseconds or milliseconds where seconds are expected.
#[test]
fn stamps_in_other_units_are_named() {
    let copy = Copy::of_first(3);
    for (unit, words) in [("e8", "nanoseconds"), ("00", "milliseconds")] {
        copy.write("times.txt", format!("0\n1{unit}\n2{unit}\n"));
        copy.remove("poses.txt");
        let call = doubted(&copy, &[], "times");
        assert!(call.stderr.contains(&format!("they look like {words}")), "{call}");
    }
}

/// Situation: depth in millimeters read as 1/5000 m and the other way round: all was tracked, with a wrong scale, and not a word.
#[test]
fn a_wrong_unit_of_depth_is_named_before_the_run_and_by_the_ground_truth() {
    let copy = rgbd_of_rendered();
    let run = |units: &str, extra: &[&str]| {
        let key = format!("camera.depth_units_per_metre={units}");
        let camera = ["fx=707.0912", "fy=707.0912", "cx=301.8873", "cy=183.1104", "baseline_m=0.05"];
        let camera: Vec<String> = camera.iter().map(|value| format!("camera.{value}")).collect();
        let mut args: Vec<&str> = camera.iter().flat_map(|value| ["--set", value]).collect();
        args.extend(["--set", &key]);
        args.extend(extra);
        copy.run(&args)
    };
    let call = run("200", &["--strict"]);
    call.expect(2, "error: refused by --strict, since these figures are doubtful: depth");
    // A factor that gives depths of a room: only the ground truth knows.
    let call = run("7000", &[]);
    assert!(call.stderr.contains("times the true ones"), "{call}");
    let scale = summary(&copy.results())["scale_against_truth"].as_f64().unwrap();
    assert!((scale - 5000.0 / 7000.0).abs() < 0.03, "{scale}");
    let call = run("7000", &["--strict"]);
    call.expect(1, "error: refused by --strict, since the scale is doubtful");
    let call = run("5000", &["--strict"]);
    call.expect_success();
}

/// Rendered frames with depth as a TUM folder, everything a tenth as large, so that a street is as near as a room.
fn rgbd_of_rendered() -> Copy {
    const N: usize = 12;
    const SMALLER: f64 = 10.0;
    let copy = Copy::of_first(N);
    let source = tempfile::tempdir().unwrap();
    let frames = N.to_string();
    let place = source.path().join("town");
    dsslam(&["synth", text(&place), "--preset", "town", "--frames", &frames, "--depth"]).expect_success();
    for name in ["calib.txt", "times.txt"] {
        copy.remove(name);
    }
    for name in ["rgb", "depth"] {
        fs::create_dir(copy.path().join(name)).unwrap();
        let line = |i: usize| format!("{}.{} {name}/{i}.png\n", 1 + i / 10, i % 10);
        copy.write(&format!("{name}.txt"), (0..N).map(line).collect::<String>());
    }
    let mut poses = io::read_trajectory(&place.join("poses.txt"), None).unwrap().trajectory;
    for (i, pose) in poses.poses.iter_mut().enumerate() {
        let [gray, depth] = ["image_0", "depth"].map(|folder| place.join(format!("{folder}/{i:06}.png")));
        let left = (1241 - 640) / 2;
        let image = io::load_gray(&gray).unwrap();
        let cut = geometry::GrayImage::from_fn(640, 376, |x, y| image.at(left + x, y));
        io::save_png_gray(&copy.path().join(format!("rgb/{i}.png")), &cut).unwrap();
        let image = io::load_depth(&depth).unwrap();
        let units = 5000.0 / SMALLER / synth::DEPTH_UNITS_PER_METRE;
        let cut = DepthImage::from_fn(640, 376, |x, y| {
            (f64::from(image.at(left + x, y)) * units).min(65535.0) as u16
        });
        io::save_png_depth(&copy.path().join(format!("depth/{i}.png")), &cut).unwrap();
        pose.timestamp_s = 1.0 + i as f64 / 10.0;
        pose.world_from_cam.translation /= SMALLER;
    }
    io::write_tum(&copy.path().join("groundtruth.txt"), &poses).unwrap();
    copy
}

/// Situation: a run is resumed from the map of a camera that is 10 % different; it was accepted in silence, and frames were lost.
#[test]
fn a_map_of_another_camera_is_named() {
    let copy = Copy::of_first(3);
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("street.dsmap");
    copy.run(&["--save-map", text(&map)]).expect_success();
    fs::remove_dir_all(copy.results()).unwrap();
    plausible(&copy.path(), &["--load-map", text(&map)]);
    copy.edit("calib.txt", |_, line| Some(line.replace("7.070912", "7.778003")));
    doubted(&copy, &["--load-map", text(&map)], "other_camera");
}
