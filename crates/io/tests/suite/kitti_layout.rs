//! KITTI folders: which frames, which camera, which ground truth, which warnings.

use std::fs;

use dsslam_io::{
    ImageError, OpenOptions, Sensor, Sequence, SequenceKind, load_frame, open_sequence, open_sequence_with,
};
use geometry::Vec3;

use super::support::{Folder, P0, P1};

const P2: &str = "P2: 7.0e+02 0 20 42 0 7.0e+02 10 0 0 0 1 0";
const P3: &str = "P3: 7.0e+02 0 20 -329 0 7.0e+02 10 0 0 0 1 0";
const IDENTITY_ROW: &str = "1 0 0 0 0 1 0 0 0 0 1 0\n";

fn open(folder: &Folder, sensor: Option<Sensor>) -> Sequence {
    open_sequence(folder.path(), sensor).unwrap()
}

fn warnings(folder: &Folder, sequence: &Sequence) -> Vec<String> {
    sequence.warnings.iter().map(|warning| folder.hide(warning)).collect()
}

#[test]
fn stereo_pairs_with_times_and_camera() {
    let folder = Folder::kitti(3);
    let sequence = open(&folder, None);
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::Kitti, Sensor::Stereo));
    assert!(sequence.warnings.is_empty(), "{:?}", sequence.warnings);
    assert_eq!(sequence.name, folder.path().file_name().unwrap().to_string_lossy());
    let frame = &sequence.frames[2];
    assert_eq!((sequence.frames.len(), frame.index, frame.timestamp_s()), (3, 2, 0.2));
    assert_eq!(frame.left, folder.file("image_0/000002.png"));
    assert_eq!(frame.right, Some(folder.file("image_1/000002.png")));
    let calibration = sequence.calibration.clone().unwrap();
    assert_eq!(calibration.rig.camera.fx, 700.0);
    assert_eq!((calibration.rig.camera.cx, calibration.rig.camera.cy), (20.0, 10.0));
    assert_eq!(calibration.rig.baseline_m, 0.54);
    assert_eq!(folder.hide(&calibration.source), "DIR/calib.txt");
    let loaded = load_frame(frame).unwrap();
    assert_eq!(loaded.left, loaded.right.unwrap());
    let (position, size) = sequence.image_size().unwrap();
    assert_eq!((position, size.to_string().as_str()), (0, "40x20"));
}

#[test]
fn a_sequence_of_one_frame() {
    assert_eq!(open(&Folder::kitti(1), None).frames.len(), 1);
}

#[test]
fn numbers_of_ten_digits() {
    let folder = Folder::kitti(1);
    for side in ["image_0", "image_1"] {
        fs::rename(
            folder.file(&format!("{side}/000000.png")),
            folder.file(&format!("{side}/0000000000.png")),
        )
        .unwrap();
        folder.gray(&format!("{side}/0000000002.png"), 40, 20);
    }
    folder.write("times.txt", "0\n1\n2\n");
    let sequence = open(&folder, None);
    assert_eq!(sequence.frames.len(), 3);
    assert_eq!(sequence.frames[0].left, folder.file("image_0/0000000000.png"));
    assert_eq!(sequence.frames[1].left, folder.file("image_0/0000000001.png"), "missing, but named alike");
}

#[test]
fn a_missing_image_keeps_its_number() {
    for missing in [0, 1] {
        let folder = Folder::kitti(3);
        folder.remove(&format!("image_0/00000{missing}.png"));
        let sequence = open(&folder, None);
        assert_eq!(sequence.frames.iter().map(|frame| frame.index).collect::<Vec<_>>(), [0, 1, 2]);
        let error = load_frame(&sequence.frames[missing]).unwrap_err();
        assert_eq!(error, ImageError::Missing { path: folder.file(&format!("image_0/00000{missing}.png")) });
        assert!(load_frame(&sequence.frames[2]).is_ok());
        assert_eq!(sequence.image_size().unwrap().0, usize::from(missing == 0), "the first readable one");
    }
}

#[test]
fn a_missing_right_image_in_the_middle() {
    let folder = Folder::kitti(3);
    folder.remove("image_1/000001.png");
    let sequence = open(&folder, None);
    assert_eq!(sequence.frames.len(), 3);
    assert!(load_frame(&sequence.frames[1]).is_err());
    assert_eq!(open(&folder, Some(Sensor::Mono)).frames[1].right, None);
}

#[test]
fn fewer_right_images_than_left_ones() {
    let folder = Folder::kitti(5);
    folder.remove("image_1/000003.png");
    folder.remove("image_1/000004.png");
    let stereo = open(&folder, None);
    assert_eq!(stereo.frames.len(), 3);
    assert_eq!(
        warnings(&folder, &stereo),
        [
            "DIR/image_1: 3 right images for 5 left ones; the stereo run ends at the last complete pair, number 2"
        ]
    );
    let mono = open(&folder, Some(Sensor::Mono));
    assert_eq!((mono.frames.len(), mono.warnings.len()), (5, 0));
}

#[test]
fn without_right_images_the_run_is_monocular() {
    let folder = Folder::kitti(2);
    fs::remove_dir_all(folder.file("image_1")).unwrap();
    let sequence = open(&folder, None);
    assert_eq!(sequence.sensor, Sensor::Mono);
    assert_eq!(warnings(&folder, &sequence), ["DIR/image_1: found no image, so the run is monocular"]);
    assert_eq!(sequence.calibration.unwrap().rig.baseline_m, 0.0);
}

#[test]
fn a_monocular_run_needs_one_camera_only() {
    let folder = Folder::kitti(1);
    folder.write("calib.txt", P0);
    assert_eq!(open(&folder, Some(Sensor::Mono)).calibration.unwrap().rig.camera.fx, 700.0);
}

#[test]
fn more_times_than_images_and_the_reverse() {
    let folder = Folder::kitti(3);
    folder.write("times.txt", "0\n1\n2\n3\n4\n");
    let sequence = open(&folder, None);
    assert_eq!(sequence.frames.len(), 3);
    assert_eq!(
        warnings(&folder, &sequence),
        ["DIR/times.txt: 5 times but images only up to number 2 in image_0; stopping there"]
    );
    folder.write("times.txt", "0\n1\n");
    let sequence = open(&folder, None);
    assert_eq!(sequence.frames.len(), 2);
    assert_eq!(
        warnings(&folder, &sequence),
        ["DIR/image_0: images up to number 2 but only 2 times in times.txt; stopping there"]
    );
}

#[test]
fn without_a_calibration_file_the_configuration_must_help() {
    let folder = Folder::kitti(1);
    folder.remove("calib.txt");
    let sequence = open(&folder, None);
    assert_eq!(sequence.calibration, None);
    assert_eq!(
        warnings(&folder, &sequence),
        ["DIR/calib.txt: no such file, so the configuration must give the camera"]
    );
}

/// A folder with a color pair only.
fn color_folder() -> Folder {
    let folder = Folder::kitti(1);
    fs::rename(folder.file("image_0"), folder.file("image_2")).unwrap();
    fs::rename(folder.file("image_1"), folder.file("image_3")).unwrap();
    folder.write("calib.txt", [P0, P1, P2, P3].join("\n"));
    folder
}

#[test]
fn the_color_pair_has_its_own_baseline() {
    let folder = color_folder();
    let sequence = open(&folder, None);
    assert_eq!(sequence.frames[0].right, Some(folder.file("image_3/000000.png")));
    assert!((sequence.calibration.unwrap().rig.baseline_m - 0.53).abs() < 1e-12, "(42 + 329) / 700");
}

#[test]
fn ground_truth_moves_to_the_color_camera() {
    let folder = color_folder();
    // A quarter turn to the left about the vertical axis, at (1, 2, 3).
    folder.write("poses.txt", "0 0 -1 1 0 1 0 2 1 0 0 3\n");
    let pose = open(&folder, None).ground_truth.unwrap().poses[0].world_from_cam;
    // The left color camera stands 42 / 700 = 0.06 m to the left of camera 0: x_cam2 = x_cam0 + 0.06.
    assert!((pose.translation - Vec3::new(1.0, 2.0, 3.0 - 0.06)).norm() < 1e-12);
}

#[test]
fn gray_images_come_first() {
    let folder = Folder::kitti(1);
    folder.gray("image_2/000000.png", 40, 20);
    folder.gray("image_3/000000.png", 40, 20);
    assert_eq!(open(&folder, None).frames[0].left, folder.file("image_0/000000.png"));
    fs::remove_dir_all(folder.file("image_1")).unwrap();
    folder.write("calib.txt", [P0, P1, P2, P3].join("\n"));
    assert_eq!(open(&folder, None).frames[0].left, folder.file("image_2/000000.png"), "stereo before mono");
}

#[test]
fn ground_truth_in_its_three_places() {
    let outer = Folder::new();
    let inside = outer.path().join("sequences/07");
    fs::create_dir_all(inside.parent().unwrap()).unwrap();
    let folder = Folder::kitti(2);
    fs::rename(folder.path(), &inside).unwrap();
    let truth_x = || {
        open_sequence(&inside, None)
            .unwrap()
            .ground_truth
            .map(|truth| truth.poses[0].world_from_cam.translation.x)
    };
    assert_eq!(truth_x(), None);
    let row = |x: u32| format!("1 0 0 {x} 0 1 0 0 0 0 1 0\n").repeat(2);
    outer.write("poses/07.txt", row(1));
    assert_eq!(truth_x(), Some(1.0));
    outer.write("sequences/poses/07.txt", row(2));
    assert_eq!(truth_x(), Some(2.0));
    outer.write("sequences/07/poses.txt", row(3));
    assert_eq!(truth_x(), Some(3.0));
    fs::create_dir_all(folder.path()).unwrap();
}

#[test]
fn ground_truth_takes_the_times_of_the_frames() {
    let folder = Folder::kitti(3);
    folder.write("poses.txt", IDENTITY_ROW.repeat(2));
    let sequence = open(&folder, None);
    let times: Vec<f64> =
        sequence.ground_truth.as_ref().unwrap().poses.iter().map(|pose| pose.timestamp_s).collect();
    assert_eq!(times, [0.0, 0.1]);
    assert_eq!(
        warnings(&folder, &sequence),
        ["DIR/poses.txt: 2 poses for 3 frames; errors are computed over the first 2"]
    );
    folder.write("poses.txt", IDENTITY_ROW.repeat(4));
    let sequence = open(&folder, None);
    assert_eq!(sequence.ground_truth.unwrap().poses.len(), 3);
}

#[test]
fn a_named_ground_truth_takes_the_place_of_the_dataset_s_own() {
    let folder = color_folder();
    folder.write("poses.txt", IDENTITY_ROW);
    let truth_of = |text: String| {
        let options =
            OpenOptions { ground_truth: Some(folder.write("mine.txt", text)), ..OpenOptions::default() };
        let poses = open_sequence_with(folder.path(), &options).unwrap().ground_truth.unwrap().poses;
        poses
            .iter()
            .map(|p| (p.timestamp_s, (p.world_from_cam.translation.x * 1e9).round()))
            .collect::<Vec<_>>()
    };
    // Both are of camera 0; the left color camera stands 0.06 m to its left.
    assert_eq!(truth_of(format!("0 {IDENTITY_ROW}")), [(0.0, -0.06e9)]);
    assert_eq!(truth_of("5.5 1 0 0 0 0 0 1\n".to_owned()), [(5.5, 0.94e9)]);
    let options = OpenOptions { ground_truth: Some(folder.file("none")), ..OpenOptions::default() };
    let error = open_sequence_with(folder.path(), &options).unwrap_err();
    assert!(folder.hide(error).starts_with("DIR/none: no such file, expected a trajectory"));
}

#[test]
fn other_files_are_no_frames() {
    let folder = Folder::kitti(1);
    folder.write("image_0/notes.txt", "x");
    folder.write("image_0/000009.txt", "x");
    folder.write("image_0/-00008.png", "x");
    folder.write("image_0/.png", "x");
    assert_eq!(open(&folder, None).frames.len(), 1);
}
