//! The whole program on a rendered street: no loss, small error, complete results, equal bytes for any number of threads.

use std::fs;
use std::path::Path;
use std::time::Duration;

use sha2::{Digest, Sha256};

use crate::program::{command, dsslam, ended, summary, text};
use crate::sequence::{N_RENDERED, rendered};

/// Runs over the rendered sequence with further arguments and a number of threads.
fn run(out: &Path, threads: usize, args: &[&str]) {
    let mut all = vec!["run", text(rendered()), "--out", text(out)];
    all.extend(args);
    let threads = threads.to_string();
    ended(command(&all).env("RAYON_NUM_THREADS", threads).output().unwrap()).expect_success();
}

fn trajectory(results: &Path) -> Vec<u8> {
    fs::read(results.join("trajectory.kitti.txt")).unwrap()
}

#[test]
fn a_rendered_street_is_driven_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 2, &[]);
    let s = summary(folder.path());
    for (key, expected) in [("frames", N_RENDERED), ("tracked", N_RENDERED), ("lost", 0), ("dropped", 0)] {
        assert_eq!(s[key], expected, "{key}: {s:#}");
    }
    let (ate, path) = (s["ate_rmse_m"].as_f64().unwrap(), s["path_m"].as_f64().unwrap());
    assert!(path > 20.0, "the camera drives: {path} m");
    // Standing still at the start would give an error of a third of the path; one percent is what a run must do.
    assert!(ate < 0.01 * path, "ATE {ate} m over {path} m");
    assert!(s["keyframes"].as_u64().unwrap() >= 3 && s["points"].as_u64().unwrap() > 500, "{s:#}");
}

#[test]
fn the_results_folder_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), 2, &["--max-frames", "10"]);
    let s = summary(folder.path());
    for key in [
        "frames",
        "lost",
        "dropped",
        "keyframes",
        "points",
        "loops",
        "ate_rmse_m",
        "alignment",
        "t_rel_percent",
        "r_rel_deg_per_100m",
        "stages",
        "track_ms_median",
        "wall_s",
        "cpu_s",
        "peak_rss_mb",
        "trajectory_sha256",
        "schedule",
        "version",
    ] {
        assert!(s.get(key).is_some(), "summary.json lacks {key}");
    }
    for key in ["median", "p95", "max"] {
        assert!(s["stages"]["track"][key].as_f64().is_some_and(|ms| ms > 0.0), "{key}: {s:#}");
    }
    assert!(s["t_rel_percent"].is_null(), "no segment of 100 m in ten frames");
    assert_eq!((s["alignment"].as_str(), s["sensor"].as_str()), (Some("SE3"), Some("stereo")));
    let rows = trajectory(folder.path());
    let sha256: String = Sha256::digest(&rows).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(s["trajectory_sha256"].as_str(), Some(sha256.as_str()));
    let n_lines = |name: &str| {
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        text.lines().filter(|line| !line.starts_with('#')).count()
    };
    assert_eq!(
        (n_lines("trajectory.kitti.txt"), n_lines("trajectory.tum.txt"), n_lines("timings.csv")),
        (10, 10, 11)
    );
    let picture = image::open(folder.path().join("trajectory.png")).unwrap();
    assert!(picture.width() >= 400 && picture.height() >= 300);
    let mut names: Vec<String> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let expected = [
        "config.yaml",
        "evaluation.json",
        "frames.csv",
        "ground_truth.tum.txt",
        "loops.csv",
        "summary.json",
        "timings.csv",
        "trajectory.kitti.txt",
        "trajectory.png",
        "trajectory.tum.txt",
    ];
    assert_eq!(names, expected, "and nothing half-written is left");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let of = |threads: usize| {
        let out = folder.path().join(threads.to_string());
        run(&out, threads, &[]);
        trajectory(&out)
    };
    let one = of(1);
    assert!(one == of(2) && one == of(4), "1, 2 and 4 threads differ");
}

#[test]
fn the_written_configuration_gives_the_same_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second, other] = ["first", "second", "other"].map(|name| folder.path().join(name));
    let few = ["--max-frames", "12"];
    run(&first, 2, &[&few[..], &["--set", "features.keep=700"]].concat());
    let config = first.join("config.yaml");
    run(&second, 2, &[&few[..], &["--config", text(&config)]].concat());
    run(&other, 2, &few);
    assert!(trajectory(&first) == trajectory(&second));
    assert!(trajectory(&first) != trajectory(&other), "the configuration has an effect");
}

#[test]
fn an_interrupted_run_writes_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut child = command(&["run", text(rendered()), "--out", text(&out)])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while !out.exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended before it began");
        std::thread::sleep(Duration::from_millis(2));
    }
    let signaled =
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signaled.success());
    let call = ended(child.wait_with_output().unwrap());
    assert_eq!(call.code, 130, "{call}");
    let s = summary(&out);
    let frames = s["frames"].as_u64().unwrap();
    assert!(s["interrupted"] == true && frames < u64::from(N_RENDERED), "{s:#}");
    assert_eq!(String::from_utf8(trajectory(&out)).unwrap().lines().count() as u64, frames);
}

#[test]
fn the_demo_prints_its_errors_and_draws_its_trajectory() {
    let folder = tempfile::tempdir().unwrap();
    let call = dsslam(&["demo", "--frames", "8", "--out", text(folder.path())]);
    call.expect_success();
    for word in ["ATE", "drift", "t_rel", "lost", "trajectory.png"] {
        assert!(call.stdout.contains(word), "no {word} in {call}");
    }
    assert_eq!(summary(folder.path())["tracked"], 8);
    assert!(folder.path().join("trajectory.png").exists());
}
