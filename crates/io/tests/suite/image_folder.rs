//! Folders of images with a calibration file: order, pairs, halves, times, and what is wrong with them.

use std::path::PathBuf;

use dsslam_io::{
    DatasetError, OpenOptions, Packing, Sensor, Sequence, SequenceKind, load_frame, open_sequence_with,
};
use geometry::{CameraModel, Vec3};

use super::support::{Folder, calibration_yaml};

fn open(folder: &Folder, sensor: Option<Sensor>) -> Result<Sequence, DatasetError> {
    let options = OpenOptions { sensor, frame_rate_hz: 8.0, ..OpenOptions::default() };
    open_sequence_with(folder.path(), &options)
}

fn refused(folder: &Folder, sensor: Option<Sensor>) -> String {
    folder.hide(open(folder, sensor).unwrap_err())
}

/// The names of the left images.
fn names(sequence: &Sequence) -> Vec<String> {
    let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    sequence.frames.iter().map(|frame| name(&frame.left)).collect()
}

#[test]
fn one_camera_in_natural_order_at_its_frame_rate() {
    let folder = Folder::new();
    folder.write("calibration.yaml", calibration_yaml(1));
    for name in ["img10.png", "img9.png", "img1.png", "notes.txt.png.bak"] {
        folder.gray(name, 40, 20);
    }
    let sequence = open(&folder, None).unwrap();
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::Images, Sensor::Mono));
    assert_eq!(names(&sequence), ["img1.png", "img9.png", "img10.png"]);
    let times: Vec<f64> = sequence.frames.iter().map(|frame| frame.timestamp_s()).collect();
    assert_eq!((times, sequence.frame_rate_hz), (vec![0.0, 0.04, 0.08], Some(25.0)));
    let calibration = sequence.calibration.unwrap();
    assert_eq!((calibration.rig.camera.fx, calibration.distortion.k1), (30.0, -0.1));
    assert_eq!(calibration.source, folder.file("calibration.yaml").display().to_string());
    assert!(sequence.rectification.is_empty() && sequence.warnings.is_empty());
}

#[test]
fn left_and_right_folders_are_paired_by_their_numbers_and_rectified() {
    let folder = Folder::new();
    folder.write("calibration.yaml", calibration_yaml(2));
    for i in [1, 2, 4, 10] {
        folder.gray(&format!("left/l{i}.png"), 40, 20);
    }
    for i in [2, 3, 4, 10] {
        folder.gray(&format!("right/r{i}.png"), 40, 20);
    }
    folder.write("times.txt", "0.5\n0.75\n1.5\n2\n");
    let sequence = open(&folder, None).unwrap();
    assert_eq!(
        (sequence.sensor, names(&sequence)),
        (Sensor::Stereo, vec!["l2.png".into(), "l4.png".into(), "l10.png".into()])
    );
    assert_eq!(sequence.frames[2].right, Some(folder.file("right/r10.png")));
    let times: Vec<f64> = sequence.frames.iter().map(|frame| frame.timestamp_s()).collect();
    assert_eq!(times, [0.75, 1.5, 2.0], "a time belongs to a left image");
    assert_eq!(sequence.rectification.len(), 2);
    let baseline_m = sequence.calibration.as_ref().unwrap().rig.baseline_m;
    assert!((baseline_m - 0.25).abs() < 1e-12, "{baseline_m}");
    assert_eq!(
        sequence.warnings.iter().map(|warning| folder.hide(warning)).collect::<Vec<_>>(),
        [
            "DIR/left: 1 of 4 images have no partner and are skipped",
            "DIR/right: 1 of 4 images have no partner and are skipped"
        ]
    );
    let mono = open(&folder, Some(Sensor::Mono)).unwrap();
    assert_eq!((mono.frames.len(), mono.calibration.unwrap().distortion.k1), (4, -0.1));
}

#[test]
fn two_images_side_by_side_are_taken_apart() {
    let folder = Folder::new();
    folder.write("calibration.yaml", calibration_yaml(2));
    let whole = folder.gray("a1.png", 80, 20);
    let sequence = open(&folder, None).unwrap();
    assert_eq!((sequence.sensor, sequence.frames[0].packing), (Sensor::Stereo, Packing::BothHalves));
    assert_eq!(sequence.image_size().unwrap().1.to_string(), "40x20");
    let (frame, whole) = (load_frame(&sequence.frames[0]).unwrap(), dsslam_io::load_gray(&whole).unwrap());
    let right = frame.right.unwrap();
    for (x, y) in [(0, 0), (39, 19), (7, 3)] {
        assert_eq!((frame.left.at(x, y), right.at(x, y)), (whole.at(x, y), whole.at(40 + x, y)));
    }
    let mono = open(&folder, Some(Sensor::Mono)).unwrap();
    assert_eq!(mono.frames[0].packing, Packing::LeftHalf);
    let frame = load_frame(&mono.frames[0]).unwrap();
    assert!(frame.right.is_none() && frame.size().to_string() == "40x20");

    folder.gray("a0.png", 40, 20);
    let sequence = open(&folder, None).unwrap();
    assert_eq!(sequence.sensor, Sensor::Mono);
    assert_eq!(
        folder.hide(&sequence.warnings[0]),
        "DIR: found images of one camera although DIR/calibration.yaml describes two, so the run is monocular"
    );
}

#[test]
fn an_image_of_odd_width_cannot_be_halved() {
    let folder = Folder::new();
    folder.gray("a.png", 41, 20);
    let sequence = open(&folder, Some(Sensor::Stereo)).unwrap();
    let expected = "DIR/a.png: found 41x20 pixels, expected an even width (two images side by side)";
    assert_eq!(folder.hide(load_frame(&sequence.frames[0]).unwrap_err()), expected);
    assert_eq!(folder.hide(sequence.image_size().unwrap_err()), expected);
}

#[test]
fn a_given_calibration_wins_over_that_in_the_folder_and_leaves_the_layout_alone() {
    let folder = Folder::kitti(3);
    let file = folder.write("elsewhere/my.yaml", calibration_yaml(1).replace("fps: 25\n", ""));
    folder.write("calibration.yaml", "broken: [");
    let options = OpenOptions { calibration: Some(file), ..OpenOptions::default() };
    let sequence = open_sequence_with(folder.path(), &options).unwrap();
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::Kitti, Sensor::Stereo));
    assert_eq!(sequence.frames[2].timestamp_s(), 0.2, "times.txt");
    let warning = folder.hide(&sequence.warnings[0]);
    assert_eq!(
        warning,
        "DIR/elsewhere/my.yaml: describes a single camera; the place of the right one is that of DIR/calib.txt"
    );
    let raw = sequence.raw_calibration.unwrap();
    assert_eq!(raw.cameras[1].body_from_cam.translation, Vec3::new(0.54, 0.0, 0.0));
    assert_eq!((raw.cameras[1].model, sequence.rectification.len()), (raw.cameras[0].model, 2));
}

#[test]
fn a_file_in_the_folder_that_cannot_be_read_is_told_and_left_alone() {
    let folder = Folder::kitti(3);
    folder.write("calibration.yaml", "broken: [");
    let sequence = open(&folder, None).unwrap();
    assert!(
        sequence.warnings[0].ends_with("; the layout's own calibration is used"),
        "{:?}",
        sequence.warnings
    );
    assert_eq!(sequence.calibration.unwrap().rig.camera.fx, 700.0);
}

#[test]
fn a_fisheye_is_drawn_anew_as_a_pinhole() {
    let folder = Folder::new();
    let yaml = calibration_yaml(1).replace("pinhole-radtan", "kannala-brandt");
    folder.write("calibration.yaml", yaml);
    folder.gray("1.png", 40, 20);
    let sequence = open(&folder, None).unwrap();
    let [view] = &sequence.rectification[..] else { panic!("one view") };
    assert!(matches!(view.model, CameraModel::KannalaBrandt(lens) if lens.k4 == 0.002));
    assert!(sequence.calibration.unwrap().distortion.is_zero());
}

#[test]
fn rectified_images_are_used_as_they_are() {
    let folder = Folder::new();
    let yaml = calibration_yaml(2).replace("pinhole-radtan", "none");
    folder.write("calibration.yaml", yaml.replace("    distortion: [-0.1, 0.01, 0.001, 0.002]\n", ""));
    folder.gray("left/1.png", 40, 20);
    folder.gray("right/1.png", 40, 20);
    let sequence = open(&folder, None).unwrap();
    assert!(sequence.rectification.is_empty());
    let rig = sequence.calibration.unwrap().rig;
    assert_eq!((rig.camera.fx, rig.camera.fy, rig.baseline_m), (30.0, 31.0, 0.25));
    let places = sequence.raw_calibration.unwrap();
    assert_eq!(places.cameras[1].body_from_cam.translation, Vec3::new(0.25, 0.0, 0.0));
}

#[test]
fn folders_that_cannot_be_used() {
    let folder = Folder::new();
    folder.write("calibration.yaml", calibration_yaml(1));
    assert!(
        refused(&folder, None)
            .starts_with("DIR: no known dataset layout: found 1 file ends in .yaml; expected")
    );
    folder.gray("left/a.png", 40, 20);
    assert_eq!(
        refused(&folder, Some(Sensor::Stereo)),
        "DIR: sensor stereo is not possible here: DIR/calibration.yaml describes a single camera"
    );
    assert_eq!(
        refused(&folder, Some(Sensor::Rgbd)),
        "DIR: sensor rgbd is not possible here: found no depth images"
    );
    folder.write("times.txt", "0\n1\n");
    assert_eq!(refused(&folder, None), "DIR/times.txt: found 2 times, expected 1 (one per image)");
    folder.remove("times.txt");
    folder.write("calibration.yaml", calibration_yaml(2));
    folder.gray("right/b.png", 40, 20);
    assert_eq!(
        refused(&folder, None),
        "DIR/left: sensor stereo is not possible here: no image number matches one in DIR/right (first: \
         DIR/left/a.png and DIR/right/b.png)"
    );
}

#[test]
fn images_without_calibration_need_a_configuration() {
    let folder = Folder::new();
    folder.gray("a.png", 40, 20);
    folder.gray("b.png", 40, 20);
    let sequence = open(&folder, None).unwrap();
    assert_eq!((sequence.sensor, &sequence.calibration), (Sensor::Mono, &None));
    assert_eq!(sequence.frames[1].timestamp_s(), 0.125);
    let warning = folder.hide(&sequence.warnings[0]);
    assert_eq!(warning, "DIR: no calibration file, so the configuration must give the camera");
}
