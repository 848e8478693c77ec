//! EuRoC folders: pairs by time, sensors, raw and rectified cameras, ground truth of the body.

use dsslam_io::{Sensor, SequenceKind, load_frame, open_sequence};
use geometry::{CameraModel, Distortion, SE3, SO3, Vec3};

use super::support::{Folder, euroc_stamp, sensor_yaml};

/// The list of a camera with these times.
fn list(stamps: impl IntoIterator<Item = u64>) -> String {
    stamps.into_iter().map(|stamp| format!("{stamp},{stamp}.png\n")).collect()
}

#[test]
fn stereo_pairs_with_raw_and_rectified_cameras() {
    let folder = Folder::euroc(3);
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::Euroc, Sensor::Stereo));
    assert_eq!((sequence.frames.len(), sequence.warnings), (3, Vec::<String>::new()));
    let frame = &sequence.frames[2];
    let stamp = euroc_stamp(2);
    assert_eq!((frame.index, frame.timestamp_ns), (2, stamp as i64));
    assert_eq!(frame.left, folder.file(&format!("mav0/cam0/data/{stamp}.png")));
    assert_eq!(frame.right, Some(folder.file(&format!("mav0/cam1/data/{stamp}.png"))));
    assert_eq!(load_frame(frame).unwrap().size().to_string(), "40x20");

    let raw = sequence.raw_calibration.unwrap();
    let CameraModel::Pinhole { camera, distortion } = raw.cameras[1].model else { panic!("{raw:?}") };
    assert_eq!((camera.fx, camera.fy, camera.cx, camera.cy), (30.0, 31.0, 19.0, 9.5));
    assert_eq!(distortion, Distortion { k1: -0.1, k2: 0.01, p1: 0.001, p2: 0.002, k3: 0.0 });
    assert_eq!(raw.cameras[1].body_from_cam.translation, Vec3::new(0.25, 0.5, 0.0));

    let calibration = sequence.calibration.unwrap();
    assert!(calibration.distortion.is_zero() && (calibration.rig.baseline_m - 0.25).abs() < 1e-12);
    assert_eq!(calibration.source, folder.file("mav0/cam0/sensor.yaml").display().to_string());
    // The cameras look alike already.
    assert_eq!(sequence.rectification.len(), 2);
    assert!(sequence.rectification.iter().all(|view| view.rectified_from_cam == SO3::identity()));
    assert_eq!(sequence.body_from_left, SE3::new(SO3::identity(), Vec3::new(0.0, 0.5, 0.0)));
}

#[test]
fn the_pose_of_the_rectified_camera_in_the_body_undoes_its_turn() {
    let folder = Folder::euroc(2);
    // The right camera stands somewhat behind the left one, so that both turn.
    let behind = sensor_yaml(0.25).replace("0.0, 0.0, 1.0, 0.0,", "0.0, 0.0, 1.0, -0.05,");
    folder.write("mav0/cam1/sensor.yaml", behind);
    let sequence = open_sequence(folder.path(), None).unwrap();
    let [left, right] = &sequence.rectification[..] else { panic!("two views") };
    assert!(left.rectified_from_cam.angle() > 0.1);
    assert_eq!(left.rectified_from_cam, right.rectified_from_cam);
    let raw = sequence.raw_calibration.unwrap();
    let back = sequence.body_from_left * SE3::new(left.rectified_from_cam, Vec3::zeros());
    assert!((back.matrix() - raw.cameras[0].body_from_cam.matrix()).amax() < 1e-15);
    // The right center lies along x of the rectified left camera.
    let center = sequence.body_from_left.inverse() * raw.cameras[1].body_from_cam.translation;
    let baseline_m = sequence.calibration.unwrap().rig.baseline_m;
    assert!((center - Vec3::new(baseline_m, 0.0, 0.0)).norm() < 1e-15, "{center}");
}

#[test]
fn the_folder_mav0_itself_and_the_flat_layout_are_taken_too() {
    let folder = Folder::euroc(2);
    let named = open_sequence(&folder.file("mav0"), None).unwrap();
    let whole = open_sequence(folder.path(), None).unwrap();
    assert_eq!((&named.name, named.frames.len()), (&whole.name, 2));
    assert_ne!(named.name, "mav0");
}

#[test]
fn images_without_a_partner_are_left_out_and_counted() {
    let folder = Folder::euroc(5);
    // Frame 1 is missing on the right, frame 3 on the left, frame 4 is 0.9 ms late, which is near enough.
    folder.write("mav0/cam0/data.csv", list([0, 1, 2, 4].map(euroc_stamp)));
    let late = euroc_stamp(4) + 900_000;
    folder.gray(&format!("mav0/cam1/data/{late}.png"), 40, 20);
    folder.write("mav0/cam1/data.csv", list([euroc_stamp(0), euroc_stamp(2), euroc_stamp(3), late]));
    let sequence = open_sequence(folder.path(), None).unwrap();
    let times: Vec<f64> = sequence.frames.iter().map(|frame| frame.timestamp_s()).collect();
    assert_eq!(times, [0, 2, 4].map(|i| euroc_stamp(i) as f64 / 1e9));
    let warnings: Vec<String> = sequence.warnings.iter().map(|warning| folder.hide(warning)).collect();
    assert_eq!(
        warnings,
        [
            "DIR/mav0/cam0/data.csv: 1 of 4 images have no image of cam1 within 1 ms and are skipped",
            "DIR/mav0/cam1/data.csv: 1 of 4 images have no image of cam0 within 1 ms and are skipped",
        ]
    );
}

#[test]
fn a_named_file_that_is_missing_is_told_and_its_frame_stays() {
    let folder = Folder::euroc(4);
    let gone = euroc_stamp(2);
    folder.remove(&format!("mav0/cam1/data/{gone}.png"));
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!(sequence.frames.len(), 4);
    assert_eq!(
        folder.hide(&sequence.warnings[0]),
        format!(
            "DIR/mav0/cam1/data.csv:4: found the name of a missing file (DIR/mav0/cam1/data/{gone}.png); \
             1 of 4 images are missing, and their frames will be dropped"
        )
    );
    let error = load_frame(&sequence.frames[2]).unwrap_err();
    assert_eq!(folder.hide(error), format!("DIR/mav0/cam1/data/{gone}.png: no such image"));
}

#[test]
fn one_camera() {
    let folder = Folder::euroc(3);
    let sequence = open_sequence(folder.path(), Some(Sensor::Mono)).unwrap();
    assert_eq!((sequence.sensor, sequence.warnings.len()), (Sensor::Mono, 0));
    assert!(sequence.frames.iter().all(|frame| frame.right.is_none()));
    // Keypoints are undistorted, images stay.
    assert!(sequence.rectification.is_empty());
    let calibration = sequence.calibration.unwrap();
    assert_eq!((calibration.rig.camera.fx, calibration.rig.baseline_m), (30.0, 0.0));
    assert_eq!(calibration.distortion.k1, -0.1);
    assert_eq!(sequence.body_from_left.translation, Vec3::new(0.0, 0.5, 0.0));
    assert_eq!(sequence.raw_calibration.unwrap().cameras.len(), 1);

    std::fs::remove_dir_all(folder.file("mav0/cam1")).unwrap();
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!(sequence.sensor, Sensor::Mono);
    let warning = folder.hide(&sequence.warnings[0]);
    assert_eq!(warning, "DIR/mav0/cam1: no such folder, so the run is monocular");
}

#[test]
fn a_fisheye_alone_is_drawn_anew() {
    let folder = Folder::euroc(2);
    let fisheye = sensor_yaml(0.0).replace("radial-tangential", "equidistant");
    folder.write("mav0/cam0/sensor.yaml", fisheye);
    let sequence = open_sequence(folder.path(), Some(Sensor::Mono)).unwrap();
    let [view] = &sequence.rectification[..] else { panic!("one view") };
    assert!(matches!(view.model, CameraModel::KannalaBrandt(lens) if lens.k4 == 0.002));
    let calibration = sequence.calibration.unwrap();
    assert!(calibration.distortion.is_zero() && calibration.rig.camera.fx == calibration.rig.camera.fy);
}

#[test]
fn other_lenses() {
    let folder = Folder::euroc(2);
    let with = |model: &str, coefficients: &str| {
        let yaml = sensor_yaml(0.0).replace("radial-tangential", model);
        let yaml = yaml.replace("[-0.1, 0.01, 0.001, 0.002]", coefficients);
        folder.write("mav0/cam0/sensor.yaml", yaml);
        open_sequence(folder.path(), Some(Sensor::Mono)).unwrap().calibration.unwrap().distortion
    };
    assert!(with("none", "[]").is_zero());
    let five = with("radial-tangential", "[1, 0.2, 3e-3, 4e-4, 0.5]");
    assert_eq!(five, Distortion { k1: 1.0, k2: 0.2, p1: 3e-3, p2: 4e-4, k3: 0.5 });
}

#[test]
fn rectified_images_without_calibration_files() {
    let folder = Folder::euroc(2);
    folder.remove("mav0/cam0/sensor.yaml");
    folder.remove("mav0/cam1/sensor.yaml");
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!((sequence.sensor, sequence.calibration), (Sensor::Stereo, None));
    assert!(sequence.rectification.is_empty() && sequence.raw_calibration.is_none());
    assert_eq!(
        folder.hide(&sequence.warnings[0]),
        "DIR/mav0/cam0/sensor.yaml: no such file, so the configuration must give the camera of rectified images"
    );
}

#[test]
fn ground_truth_is_that_of_the_body() {
    let folder = Folder::euroc(2);
    assert_eq!(open_sequence(folder.path(), None).unwrap().ground_truth, None);
    let row = format!("#timestamp, p, q, v, b\n{},1,2,3,1,0,0,0,0,0,0,0,0,0,0,0,0\n", euroc_stamp(0));
    folder.write("mav0/state_groundtruth_estimate0/data.csv", row);
    let sequence = open_sequence(folder.path(), None).unwrap();
    let truth = sequence.ground_truth.unwrap();
    assert_eq!(truth.poses[0].world_from_cam.translation, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(truth.poses[0].timestamp_s, sequence.frames[0].timestamp_s());
}
