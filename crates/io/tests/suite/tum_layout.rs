//! TUM RGB-D folders: association of color and depth, sensors, ground truth.

use dsslam_io::{OpenOptions, Sensor, SequenceKind, load_frame, open_sequence, open_sequence_with};

use super::support::Folder;

#[test]
fn color_with_depth() {
    let folder = Folder::tum();
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::TumRgbd, Sensor::Rgbd));
    assert_eq!((sequence.frames.len(), sequence.warnings.len(), sequence.calibration), (3, 0, None));
    let frame = &sequence.frames[1];
    assert_eq!((frame.index, frame.timestamp_s()), (1, 1.1));
    assert_eq!(frame.left, folder.file("rgb/b.png"));
    assert_eq!(frame.depth, Some(folder.file("depth/b.png")));
    assert_eq!(load_frame(frame).unwrap().depth.unwrap().at(3, 4), 5000);
}

#[test]
fn color_without_depth_is_left_out() {
    let folder = Folder::tum();
    folder.write("depth.txt", "1.005 depth/a.png\n1.175 depth/b.png\n1.205 depth/c.png\n");
    let sequence = open_sequence(folder.path(), None).unwrap();
    let times: Vec<f64> = sequence.frames.iter().map(|frame| frame.timestamp_s()).collect();
    assert_eq!(times, [1.0, 1.2]);
    assert_eq!(sequence.frames[1].index, 1);
    assert_eq!(
        folder.hide(&sequence.warnings[0]),
        "DIR/rgb.txt: 1 of 3 color images have no depth image within 20 ms and are skipped"
    );
}

#[test]
fn the_tolerance_can_be_set() {
    let folder = Folder::tum();
    let open = |association_tolerance_s| {
        let options = OpenOptions { association_tolerance_s, ..OpenOptions::default() };
        open_sequence_with(folder.path(), &options)
    };
    assert_eq!(open(0.006).unwrap().frames.len(), 3);
    assert_eq!(
        folder.hide(open(0.004).unwrap_err()),
        "DIR: sensor rgbd is not possible here: no color image has a depth image within 4 ms"
    );
}

#[test]
fn monocular_takes_all_color_images() {
    let folder = Folder::tum();
    folder.write("depth.txt", "9.0 depth/a.png\n");
    let sequence = open_sequence(folder.path(), Some(Sensor::Mono)).unwrap();
    assert_eq!((sequence.frames.len(), sequence.sensor), (3, Sensor::Mono));
    assert!(sequence.frames.iter().all(|frame| frame.depth.is_none()));
    folder.remove("depth.txt");
    let sequence = open_sequence(folder.path(), None).unwrap();
    assert_eq!(sequence.sensor, Sensor::Mono);
    assert_eq!(folder.hide(&sequence.warnings[0]), "DIR/depth.txt: no such file, so the run is monocular");
}

#[test]
fn ground_truth_keeps_its_own_times() {
    let folder = Folder::tum();
    folder.write("groundtruth.txt", "# t x y z q\n0.5 1 2 3 0 0 0 1\n0.6 1 2 4 0 0 0 1\n");
    let truth = open_sequence(folder.path(), None).unwrap().ground_truth.unwrap();
    assert_eq!(truth.poses[1].timestamp_s, 0.6);
    assert_eq!(truth.poses[1].world_from_cam.translation.z, 4.0);
}
