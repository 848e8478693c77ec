//! Real sequences, where `DSSLAM_DATA` names their folder; without it these tests have nothing to look at.

use std::path::PathBuf;

use dsslam_io::{Sensor, Sequence, load_frame, open_sequence};

/// A sequence of the data folder, if there is one.
fn open(name: &str, sensor: Option<Sensor>) -> Option<Sequence> {
    let folder = PathBuf::from(std::env::var_os("DSSLAM_DATA")?).join(name);
    folder.is_dir().then(|| open_sequence(&folder, sensor).unwrap())
}

#[test]
fn kitti_sequences() {
    let expected = [
        ("kitti06_first51", 51, "1226x370", 707.0912, 0.5371506, 0),
        ("kitti03_first400", 99, "1242x375", 721.5377, 0.5371506, 1),
        ("kittiraw_1405", 377, "1242x375", 721.5377, 0.5371506, 0),
        ("kittiraw_0005", 154, "1242x375", 721.5377, 0.5371506, 0),
    ];
    for (name, n_frames, size, fx, baseline_m, n_warnings) in expected {
        let Some(sequence) = open(name, None) else { continue };
        assert_eq!((sequence.frames.len(), sequence.sensor), (n_frames, Sensor::Stereo), "{name}");
        assert_eq!(sequence.warnings.len(), n_warnings, "{:?}", sequence.warnings);
        let calibration = sequence.calibration.as_ref().unwrap();
        assert_eq!(calibration.rig.camera.fx, fx);
        assert!(
            (calibration.rig.baseline_m - baseline_m).abs() < 1e-3,
            "{name}: {}",
            calibration.rig.baseline_m
        );
        let frame = load_frame(&sequence.frames[n_frames / 2]).unwrap();
        assert_eq!(frame.size().to_string(), size);
        assert_eq!(sequence.image_size().unwrap(), (0, frame.size()));
        if let Some(truth) = &sequence.ground_truth {
            assert_eq!(truth.poses.len(), n_frames, "{name}");
        }
    }
}

#[test]
fn monocular_takes_all_left_images() {
    let Some(sequence) = open("kitti03_first400", Some(Sensor::Mono)) else { return };
    assert_eq!((sequence.frames.len(), sequence.warnings.len()), (400, 0));
}

/// The list of pairs in the folder was made by TUM's own tool.
#[test]
fn tum_association() {
    let Some(sequence) = open("tum_fr1_desk", None) else { return };
    let folder = PathBuf::from(std::env::var_os("DSSLAM_DATA").unwrap()).join("tum_fr1_desk");
    let list = std::fs::read_to_string(folder.join("associations.txt")).unwrap();
    let expected: Vec<(PathBuf, Option<PathBuf>)> = list
        .lines()
        .map(|line| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            (folder.join(fields[1]), Some(folder.join(fields[3])))
        })
        .collect();
    let found: Vec<_> =
        sequence.frames.iter().map(|frame| (frame.left.clone(), frame.depth.clone())).collect();
    assert_eq!(found, expected);
    assert_eq!(load_frame(&sequence.frames[100]).unwrap().size().to_string(), "640x480");
}

/// Numbered without padding, unrectified, calibrated in XML. The numbers are those of OpenCV's `stereoRectify`, which stops after
/// five steps of undistortion.
#[test]
fn boofcv_library() {
    let Some(sequence) = open("boofcv_library", None) else { return };
    assert_eq!((sequence.frames.len(), sequence.sensor), (346, Sensor::Stereo));
    let name = |i: usize| sequence.frames[i].left.file_name().unwrap().to_string_lossy().into_owned();
    assert_eq!(
        [name(0), name(1), name(10), name(345)],
        ["left1.jpg", "left2.jpg", "left11.jpg", "left346.jpg"]
    );
    let rig = sequence.calibration.unwrap().rig;
    let found = [rig.camera.fx, rig.camera.cx, rig.camera.cy, rig.camera.fx * rig.baseline_m];
    for (found, expected) in found.iter().zip([247.2163658, 158.7045002, 124.4748802, 29.67846906]) {
        assert!((found / expected - 1.0f64).abs() < 1e-4, "{found} {expected}");
    }
}

#[test]
fn euroc() {
    let Some(sequence) = open("euroc_MH01_200", None) else { return };
    assert_eq!((sequence.frames.len(), sequence.sensor), (200, Sensor::Stereo));
    assert_eq!((&sequence.name[..], &sequence.warnings[..]), ("euroc_MH01_200", &[][..]));
    let rig = sequence.calibration.unwrap().rig;
    assert!((rig.baseline_m - 0.110078).abs() < 1e-6 && (rig.camera.fx - 436.2).abs() < 0.1, "{rig:?}");
    assert_eq!(load_frame(&sequence.frames[100]).unwrap().size(), sequence.rectification[1].size);
    // The pose of the body is known at every frame to within the half period of 200 Hz.
    let truth = sequence.ground_truth.unwrap();
    assert!((truth.poses[0].world_from_cam.translation.x - 4.726707).abs() < 1e-9);
    assert!(sequence.frames.iter().all(|frame| truth.find_nearest(frame.timestamp_s(), 0.003).is_some()));
}
