//! What a run says of its errors, and what suites and `eval traj` say of the same files: one evaluator, and the same body on both
//! sides (the suite once compared EuRoC's body with the left camera: t_rel 148.8 % in the place of 0.063 %).

use std::fs;
use std::path::Path;

use geometry::{SE3, SO3, Vec3};
use serde_json::Value;

use crate::program::{dsslam, summary, text};
use crate::sensors::rendered_radtan;
use crate::sequence::Copy;

const LENGTHS: &str = "2,4";

/// Runs a suite of one run with this ground truth; returns the folder of the run.
fn run_suite(folder: &Path, sequence: &Path, truth: &Path) -> std::path::PathBuf {
    let (suite, results) = (folder.join("suite.yaml"), folder.join("results"));
    let content = format!(
        "name: one\nsequences: [{{name: s, path: '{}', ground_truth: '{}'}}]\nconfigurations: [{{name: c}}]\n\
         lengths_m: [{LENGTHS}]\n",
        sequence.display(),
        truth.display()
    );
    fs::write(&suite, content).unwrap();
    dsslam(&["eval", "run", text(&suite), "--out", text(&results)]).expect_success();
    results.join("s/c/1")
}

fn evaluation(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("evaluation.json")).unwrap()).unwrap()
}

/// What `eval traj` finds for two files.
fn of_files(est: &Path, truth: &Path) -> Value {
    let call = dsslam(&["eval", "traj", text(est), text(truth), "--lengths", LENGTHS, "--json"]);
    call.expect_success();
    serde_json::from_str(&call.stdout).unwrap()
}

/// Equal but for the last digits that files keep.
#[track_caller]
fn check_equal(a: &Value, b: &Value, place: &str) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().for_each(|(key, value)| check_equal(value, &b[key], &format!("{place}.{key}")));
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().zip(b).for_each(|(a, b)| check_equal(a, b, place));
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            assert!((x - y).abs() < 1e-6 * (1.0 + x.abs()), "{place}: {x} and {y}");
        }
        _ => assert_eq!(a, b, "{place}"),
    }
}

/// The figures of the summary are those of the evaluation.
#[track_caller]
fn check_summary(run: &Path, e: &Value) {
    let s = summary(run);
    for (of_summary, of_evaluation) in [
        ("ate_rmse_m", &e["ate_m"]["rmse"]),
        ("ate_frames", &e["ate_m"]["n"]),
        ("t_rel_percent", &e["t_rel_percent"]),
        ("r_rel_deg_per_100m", &e["r_rel_deg_per_100m"]),
        ("t_rel_filled_frames", &e["coverage"]["n_lost"]),
        ("path_m", &e["path_m"]),
    ] {
        assert_eq!(&s[of_summary], of_evaluation, "{of_summary}");
    }
}

#[test]
fn suites_compare_the_body_of_euroc_with_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let truth = rendered_radtan().join("mav0/state_groundtruth_estimate0/data.csv");
    let run = run_suite(folder.path(), rendered_radtan(), &truth);
    let mut found = evaluation(&run);
    check_summary(&run, &found);
    assert_eq!(found["compared"], "body");
    assert!(found["t_rel_percent"].as_f64().is_some_and(|t| t < 2.0), "{found:#}");
    found["compared"] = Value::Null;
    check_equal(&found, &of_files(&run.join("trajectory_body.tum.txt"), &truth), "data.csv");
    // The true poses at the frames are the same ones; there are only fewer of them in the file.
    let mut at_frames =
        of_files(&run.join("trajectory_body.tum.txt"), &run.join("ground_truth_body.tum.txt"));
    at_frames["n_gt"] = found["n_gt"].clone();
    check_equal(&found, &at_frames, "ground_truth_body.tum.txt");
    // What was compared before.
    let mistaken = of_files(&run.join("trajectory.tum.txt"), &truth);
    assert!(mistaken["t_rel_percent"].as_f64() > Some(50.0), "{mistaken:#}");
    assert!(mistaken["ate_m"]["rmse"].as_f64() > found["ate_m"]["rmse"].as_f64());
    // One camera has no scale to get to the body with.
    let mono = folder.path().join("mono");
    let args = ["run", text(rendered_radtan()), "--sensor", "mono", "--lengths", LENGTHS];
    dsslam(&[&args[..], &["--out", text(&mono)]].concat()).expect_success();
    let found = evaluation(&mono);
    check_summary(&mono, &found);
    assert_eq!((&found["compared"], &found["alignment"]), (&"left_camera".into(), &"sim3".into()));
    assert!(!mono.join("ground_truth_body.tum.txt").exists());
}

#[test]
fn suites_compare_the_color_camera_of_kitti_with_itself() {
    // The rendered camera as the left color camera, two meters to the left of camera 0, whose poses the file holds.
    let copy = Copy::of_first(16);
    for (gray, color) in [("image_0", "image_2"), ("image_1", "image_3")] {
        fs::rename(copy.path().join(gray), copy.path().join(color)).unwrap();
    }
    let calibration = fs::read_to_string(copy.path().join("calib.txt")).unwrap();
    let row = |camera: &str| -> Vec<f64> {
        let line = calibration.lines().find_map(|line| line.strip_prefix(camera)).unwrap();
        line.split_whitespace().map(|number| number.parse().unwrap()).collect()
    };
    let (mut left, mut right) = (row("P0:"), row("P1:"));
    for row in [&mut left, &mut right] {
        row[3] += 2.0 * row[0];
    }
    let line = |row: &[f64]| row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    copy.write("calib.txt", format!("P2: {}\nP3: {}\n", line(&left), line(&right)));
    let file = copy.path().join("poses.txt");
    let left_from_camera0 = SE3::new(SO3::identity(), Vec3::new(2.0, 0.0, 0.0));
    let mut poses = io::read_trajectory(&file, None).unwrap().trajectory;
    let rendered = poses.poses[5].world_from_cam;
    poses.poses.iter_mut().for_each(|p| p.world_from_cam = p.world_from_cam * left_from_camera0);
    let truth = copy.path().join("mine.txt");
    io::write_kitti(&truth, &poses).unwrap();
    copy.remove("poses.txt");

    let folder = tempfile::tempdir().unwrap();
    let run = run_suite(folder.path(), &copy.path(), &truth);
    let mut found = evaluation(&run);
    check_summary(&run, &found);
    assert_eq!(found["compared"], "left_camera");
    assert!(found["t_rel_percent"].as_f64().is_some_and(|t| t < 2.0), "{found:#}");
    found["compared"] = Value::Null;
    let of_camera = run.join("ground_truth.tum.txt");
    check_equal(&found, &of_files(&run.join("trajectory.tum.txt"), &of_camera), "ground_truth.tum.txt");
    let written = io::read_trajectory(&of_camera, None).unwrap().trajectory.poses[5].world_from_cam;
    assert!((written.inverse() * rendered).log().norm() < 1e-6, "the rendered camera is the color camera");
}

#[test]
fn an_evaluation_of_an_older_run_does_not_stay() {
    let copy = Copy::of_first(4);
    copy.run(&[]).expect_success();
    assert!(copy.results().join("evaluation.json").is_file());
    copy.remove("poses.txt");
    copy.run(&[]).expect_success();
    for name in ["evaluation.json", "ground_truth.tum.txt"] {
        assert!(!copy.results().join(name).exists(), "{name}");
    }
    copy.run(&["--ground-truth", "nowhere.txt"]).expect(
        2,
        "error: nowhere.txt: no such file, expected a trajectory (KITTI: 12 numbers a line, 13 with a frame number or time in \
         front; TUM: 8; EuRoC: at least 8 with commas)",
    );
}
