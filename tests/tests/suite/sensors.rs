//! The program with every sensor on rendered drives: raw cameras with lenses, one camera, depth images; reduced and masked
//! images; localization only.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use image::GrayImage;
use serde_json::Value;

use crate::program::{dsslam, summary, text};
use crate::sequence::{Copy, N_RENDERED, rendered};

/// Frames of the drives with lenses.
const N_RAW: u32 = 16;

/// A rendered drive in EuRoC's layout, made once.
fn rendered_raw(lens: &str, folder: &'static OnceLock<PathBuf>) -> &'static Path {
    folder.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(lens);
        if folder.exists() {
            fs::remove_dir_all(&folder).unwrap();
        }
        let frames = N_RAW.to_string();
        dsslam(&["synth", text(&folder), "--layout", "euroc", "--lens", lens, "--frames", &frames])
            .expect_success();
        folder
    })
}

/// The drive seen through lenses with radial and tangential distortion.
pub(crate) fn rendered_radtan() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    rendered_raw("radtan", &FOLDER)
}

fn rendered_fisheye() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    rendered_raw("fisheye", &FOLDER)
}

/// Runs and returns the summary.
fn run(sequence: &Path, args: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let mut all = vec!["run", text(sequence), "--out", text(folder.path())];
    all.extend(args);
    dsslam(&all).expect_success();
    summary(folder.path())
}

/// All frames have a pose, and the error is at most this share of the path.
#[track_caller]
fn check_accuracy(s: &Value, n_frames: u32, share: f64) {
    assert_eq!((&s["tracked"], &s["lost"], &s["dropped"]), (&n_frames.into(), &0.into(), &0.into()), "{s:#}");
    let (ate, path) = (s["ate_rmse_m"].as_f64().unwrap(), s["path_m"].as_f64().unwrap());
    assert!(path > 4.0 && ate < share * path, "ATE {ate} m over {path} m");
}

#[test]
fn raw_stereo_is_rectified_on_the_way() {
    for sequence in [rendered_radtan(), rendered_fisheye()] {
        check_accuracy(&run(sequence, &[]), N_RAW, 0.01);
    }
}

#[test]
fn one_fisheye_is_drawn_anew_as_a_pinhole() {
    let s = run(rendered_fisheye(), &["--sensor", "mono"]);
    assert_eq!(
        (&s["sensor"], &s["lost"], &s["alignment"]),
        (&"mono".into(), &0.into(), &"Sim3".into()),
        "{s:#}"
    );
    let (tracked, ate) = (s["tracked"].as_u64().unwrap(), s["ate_rmse_m"].as_f64().unwrap());
    assert!(tracked >= 8 && ate < 0.1, "{tracked} frames, ATE {ate} m");
}

#[test]
fn reduced_images_give_nearly_the_same_path() {
    let s = run(rendered(), &["--set", "input.scale=0.5"]);
    check_accuracy(&s, N_RENDERED, 0.01);
    let s = run(rendered_radtan(), &["--set", "input.scale=0.7"]);
    check_accuracy(&s, N_RAW, 0.01);
}

#[test]
fn a_mask_keeps_features_out_and_must_have_the_size_of_the_images() {
    let copy = Copy::of_first(8);
    // Nothing below the horizon is used.
    let mask = GrayImage::from_fn(1241, 376, |_, y| image::Luma([if y < 188 { 255 } else { 0 }]));
    let file = copy.path().join("mask.png");
    mask.save(&file).unwrap();
    let set = format!("input.mask={}", file.display());
    let points = |args: &[&str]| {
        copy.run(args).expect_success();
        let s = summary(&copy.results());
        assert_eq!(s["tracked"], 8, "{s:#}");
        s["points"].as_u64().unwrap()
    };
    let (all, masked) = (points(&[]), points(&["--set", &set]));
    assert_ne!(all, masked);

    let line = |found: &str| {
        format!(
            "error: input.mask (--set {set}): {}: found {found} pixels, expected 1241x376, the size of the images",
            file.display()
        )
    };
    GrayImage::new(40, 30).save(&file).unwrap();
    copy.run(&["--set", &set]).expect(2, &line("40x30"));
    // Everything masked: no feature, no map.
    GrayImage::new(1241, 376).save(&file).unwrap();
    let call = copy.run(&["--set", &set]);
    assert_eq!(call.code, 1, "{call}");
}

#[test]
fn the_demo_heeds_scale_mask_and_sensor_as_a_run_does() {
    let out = tempfile::tempdir().unwrap();
    let demo = |set: &str| dsslam(&["demo", "--frames", "8", "--out", text(out.path()), "--set", set]);
    for (set, sensor) in [("input.scale=0.5", "stereo"), ("input.sensor=mono", "mono")] {
        demo(set).expect_success();
        let s = summary(out.path());
        assert_eq!((&s["sensor"], &s["dropped"]), (&sensor.into(), &0.into()), "{s:#}");
        assert!(s["tracked"].as_u64().unwrap() > 5, "{s:#}");
    }
    let set = "input.mask=none.png";
    demo(set).expect(2, &format!("error: input.mask (--set {set}): none.png: no such image"));
    let reason = "rendered frames have a left and a right image, and no depth";
    demo("input.sensor=rgbd").expect(2, &format!("error: town: sensor rgbd is not possible here: {reason}"));
}

/// The rendered drive as a TUM folder with depth images.
fn depth_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let rendered = folder.path().join("rendered");
    dsslam(&["synth", text(&rendered), "--preset", "town", "--frames", "25", "--depth"]).expect_success();
    let list = |images: &str| {
        (0..25)
            .map(|i| format!("{:.1} rendered/{images}/{i:06}.png\n", f64::from(i) * 0.1))
            .collect::<String>()
    };
    fs::write(folder.path().join("rgb.txt"), list("image_0")).unwrap();
    fs::write(folder.path().join("depth.txt"), list("depth")).unwrap();
    folder
}

/// Settings of the rendered camera for a folder without calibration.
const CAMERA: [&str; 6] = [
    "camera.fx=707.0912",
    "camera.fy=707.0912",
    "camera.cx=601.8873",
    "camera.cy=183.1104",
    "camera.baseline_m=0.54",
    "camera.depth_units_per_metre=256",
];

#[test]
fn every_sensor_localizes_in_its_map() {
    let depth = depth_folder();
    let camera: Vec<&str> = CAMERA.iter().flat_map(|setting| ["--set", *setting]).collect();
    for (sequence, n_first, args) in [
        (rendered_radtan(), "10", vec![]),
        (rendered(), "30", vec!["--sensor", "mono"]),
        (depth.path(), "15", camera),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let map = folder.path().join("first.dsmap");
        let first =
            run(sequence, &[&args[..], &["--max-frames", n_first, "--save-map", text(&map)]].concat());
        let found = run(sequence, &[&args[..], &["--load-map", text(&map), "--localize"]].concat());
        assert_eq!(found["keyframes"], first["keyframes"], "nothing is inserted: {found:#}");
        assert!(found["relocalizations"].as_u64() >= Some(1), "{found:#}");
        let tracked = |s: &Value| s["tracked"].as_u64().unwrap();
        assert!(tracked(&found) + 1 >= tracked(&first), "{} of {}", tracked(&found), tracked(&first));
        assert_eq!(found["sensor"], first["sensor"]);
    }
}

#[test]
fn depth_images_are_not_written_for_raw_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("x");
    let call = dsslam(&["synth", text(&out), "--layout", "euroc", "--depth"]);
    call.expect(2, "error: --masks and --depth need --layout kitti");
    assert!(!out.exists());
}

#[test]
fn an_exported_euroc_trajectory_is_that_of_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let [results, map, poses] = ["results", "hall.dsmap", "body.csv"].map(file);
    let export = |sensor: &str, to: &str| {
        let call = ["run", text(rendered_radtan()), "--out", text(&results), "--save-map", text(&map)];
        dsslam(&[&call[..], &["--sensor", sensor]].concat()).expect_success();
        let call = dsslam(&["export", text(&map), "--to", to, "-o", text(&poses)]);
        call.expect_success();
        call.stdout
    };
    assert!(export("stereo", "euroc").contains("poses of the body)"));
    let exported = io::read_trajectory(&poses, None).unwrap().trajectory;
    let body = io::read_trajectory(&results.join("trajectory_body.tum.txt"), None).unwrap().trajectory;
    assert!(exported.poses.len() >= 2);
    for pose in &exported.poses {
        // Times are written with six digits there, with nine here.
        let same = body.poses.iter().find(|p| (p.timestamp_s - pose.timestamp_s).abs() < 1e-5).unwrap();
        let gap = (same.world_from_cam.inverse() * pose.world_from_cam).log().norm();
        assert!(gap < 1e-6, "{gap}");
    }
    assert!(export("mono", "euroc").contains("poses of the left camera)"), "no scale, no way to the body");
    assert!(export("stereo", "tum").contains("poses of the left camera)"));
}
