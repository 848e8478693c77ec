//! Real sequences, where `DSSLAM_DATA` names a folder with them; elsewhere each test says that it was skipped.

use std::path::PathBuf;

use crate::program::{dsslam, needs_onnxruntime, summary, text};
use crate::root;

/// A real sequence, if it is there.
pub(crate) fn real(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("DSSLAM_DATA").map(|data| PathBuf::from(data).join(name));
    match path {
        Some(path) if path.is_dir() => Some(path),
        Some(path) => panic!("DSSLAM_DATA is set, but {} does not exist", path.display()),
        None => {
            println!("skipped: DSSLAM_DATA is not set, so {name} is not available");
            None
        }
    }
}

/// Runs and returns the summary; `None`, said aloud, without the data or without a library that the configuration needs.
fn run(sequence: &str, config: &str, args: &[&str]) -> Option<serde_json::Value> {
    let path = real(sequence)?;
    let (folder, config) = (tempfile::tempdir().unwrap(), root().join("configs").join(config));
    let mut all = vec!["run", text(&path), "--config", text(&config), "--out", text(folder.path())];
    all.extend(args);
    let call = dsslam(&all);
    if needs_onnxruntime(&call) {
        return None;
    }
    call.expect_success();
    Some(summary(folder.path()))
}

/// ORB-SLAM2's median on the same frames.
const ORB_SLAM2_KITTI06_ATE_M: f64 = 0.054;

#[test]
fn kitti06_is_tracked_as_well_as_by_orb_slam2() {
    let Some(s) = run("kitti06_first51", "kitti.yaml", &[]) else { return };
    assert_eq!((&s["frames"], &s["lost"], &s["dropped"]), (&51.into(), &0.into(), &0.into()), "{s:#}");
    let ate = s["ate_rmse_m"].as_f64().unwrap();
    assert!(ate <= ORB_SLAM2_KITTI06_ATE_M, "{ate} m");
}

#[test]
fn the_desk_is_tracked_without_loss() {
    let Some(s) = run("tum_fr1_desk", "tum-rgbd.yaml", &["--max-frames", "120"]) else { return };
    assert_eq!((&s["sensor"], &s["lost"]), (&"rgbd".into(), &0.into()), "{s:#}");
    let ate = s["ate_rmse_m"].as_f64().unwrap();
    assert!(ate < 0.03, "{ate} m");
}

/// Numbered JPEGs and a calibration in XML, as they were published.
#[test]
fn a_folder_of_unrectified_images_is_run_as_it_is() {
    let Some(path) = real("boofcv_library") else { return };
    let folder = tempfile::tempdir().unwrap();
    dsslam(&["run", text(&path), "--out", text(folder.path()), "--max-frames", "60"]).expect_success();
    let s = summary(folder.path());
    assert_eq!((&s["sensor"], &s["tracked"], &s["lost"]), (&"stereo".into(), &60.into(), &0.into()), "{s:#}");
}

/// Pins every bit of tracking and mapping on real frames, without the network, whose last bits depend on the processor. The
/// value may be renewed in a change that means to change results, after the errors of the evaluation were seen not to be
/// worse: `DSSLAM_RENEW_GOLDEN=1 cargo test -p dsslam-tests golden`.
#[test]
fn the_golden_trajectory_is_reproduced() {
    let response = ["--set", "features.selection=response", "--set", "features.keep=2000"];
    let args = [&["--max-frames", "20"][..], &response].concat();
    let Some(s) = run("kitti06_first51", "kitti.yaml", &args) else { return };
    let file = root().join("tests/golden/kitti06_first20.sha256");
    let found = s["trajectory_sha256"].as_str().unwrap();
    if std::env::var_os("DSSLAM_RENEW_GOLDEN").is_some() {
        std::fs::write(&file, format!("{found}\n")).unwrap();
    }
    let golden = std::fs::read_to_string(&file).unwrap();
    assert_eq!(found, golden.trim(), "{}", file.display());
}
