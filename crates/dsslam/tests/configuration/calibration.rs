//! Whose camera is used: the dataset's file wins over the configuration, and says so.

use std::path::Path;

use dsslam::Config;
use geometry::{Distortion, Pinhole, Sensor, StereoRig};
use io::{Calibration, Provenance};

use super::support::Folder;

fn calibration(baseline_m: f64) -> Calibration {
    let camera = Pinhole { fx: 700.0, fy: 710.0, cx: 20.0, cy: 10.0 };
    let rig = StereoRig { camera, baseline_m };
    Calibration { rig, distortion: Distortion::default(), source: "seq/calib.txt".to_string() }
}

#[test]
fn without_a_configured_camera_there_is_nothing_to_say() {
    let mut config = Config::load(None, &[]).unwrap();
    assert!(config.apply_calibration(&calibration(0.54)).is_empty());
    let in_force = config.camera_in_force(Path::new("seq"), Sensor::Stereo).unwrap();
    assert_eq!(in_force, calibration(0.54));
}

#[test]
fn the_dataset_wins_and_says_so() {
    let folder = Folder::new();
    let path = folder.write("c.yaml", "camera: {fx: 718.5, fy: 710, cx: 20, cy: 10, k1: 0.25}\n");
    let mut config = Config::load(Some(&path), &["camera.baseline_m=0.5".to_string()]).unwrap();
    let notices: Vec<String> =
        config.apply_calibration(&calibration(0.54)).iter().map(|notice| folder.hide(notice)).collect();
    assert_eq!(
        notices,
        [
            "camera.fx = 718.5 (DIR/c.yaml:1:14) is replaced by 700 from seq/calib.txt",
            "camera.baseline_m = 0.5 (--set camera.baseline_m=0.5) is replaced by 0.54 from seq/calib.txt",
            "camera.k1 = 0.25 (DIR/c.yaml:1:50) is replaced by 0 from seq/calib.txt",
        ]
    );
    assert_eq!(
        (config.camera.fx, config.camera.k1, config.camera.baseline_m),
        (Some(700.0), 0.0, Some(0.54))
    );
    assert_eq!(config.provenance("camera.cy"), &Provenance::Calibration("seq/calib.txt".to_string()));
    assert!(
        config.to_yaml().contains("  fx: 700.0  # focal length, horizontal"),
        "the dump shows what is in force"
    );
}

#[test]
fn a_monocular_calibration_leaves_the_baseline_alone() {
    let mut config = Config::load(None, &["camera.baseline_m=0.5".to_string()]).unwrap();
    assert!(config.apply_calibration(&calibration(0.0)).is_empty());
    assert_eq!(config.camera.baseline_m, Some(0.5));
}

#[test]
fn no_camera_at_all() {
    let mut config = Config::load(None, &[]).unwrap();
    let missing = |config: &Config| {
        config.camera_in_force(Path::new("data/desk"), Sensor::Rgbd).unwrap_err().to_string()
    };
    assert_eq!(
        missing(&config),
        "data/desk: the dataset has no calibration file and the configuration lacks camera.fx; pass a configuration with a `camera` section (such as --config configs/tum-rgbd.yaml), --set camera.fx=... or --calib FILE"
    );
    config.apply_calibration(&calibration(0.0));
    let rig = |sensor| config.camera_in_force(Path::new("x"), sensor).unwrap().rig;
    assert_eq!(rig(Sensor::Rgbd).baseline_m, 0.08, "RGB-D has a virtual baseline");
    assert_eq!(config.camera_in_force(Path::new("x"), Sensor::Mono).unwrap().rig.baseline_m, 0.0);
}

#[test]
fn the_shipped_camera_of_tum_fr1() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/tum-rgbd.yaml");
    let config = Config::load(Some(&path), &[]).unwrap();
    let camera = config.camera_in_force(Path::new("x"), Sensor::Rgbd).unwrap();
    assert!((camera.rig.bf() - 40.0).abs() < 1e-5);
    assert_eq!((camera.distortion.k3, config.camera.depth_units_per_metre), (1.163314, 5000.0));
}
