//! What `write_kitti` leaves on disk.

use dsslam_synth::{Lens, Preset, World, WriteOptions, write_euroc, write_kitti};
use geometry::SE3;
use std::ops::ControlFlow;
use std::path::Path;

fn quiet() -> World {
    World::new(Preset::Quiet, 3, 1)
}

#[test]
fn a_written_world_is_read_back_as_a_kitti_sequence() {
    let world = quiet();
    let folder = tempfile::tempdir().unwrap();
    let options = WriteOptions { max_frames: Some(3), masks: true, depth: true };
    let mut seen = Vec::new();
    let written = write_kitti(&world, folder.path(), &options, &mut |p| {
        seen.push(p);
        ControlFlow::Continue(())
    });
    assert_eq!(written.unwrap(), 3);
    assert_eq!(seen, [1, 2, 3]);
    let sequence = io::open_sequence(folder.path(), None).unwrap();
    assert_eq!(sequence.frames.len(), 3);
    let calibration = sequence.calibration.unwrap();
    assert!((calibration.rig.baseline_m - 0.54).abs() < 1e-9);
    assert!((calibration.rig.camera.fx - 707.0912).abs() < 1e-9);
    let truth = sequence.ground_truth.unwrap();
    let frame = world.frame(2);
    assert!((truth.poses[2].world_from_cam.translation - frame.world_from_cam.translation).norm() < 1e-9);
    assert!((truth.poses[2].timestamp_s - 0.2).abs() < 1e-9);
    let loaded = io::load_frame(&sequence.frames[2]).unwrap();
    assert!(loaded.left == frame.left && loaded.right == Some(frame.right));
    let mask = io::load_gray(&folder.path().join("masks/000002.png")).unwrap();
    assert!(mask == frame.labels);
    let depth = io::load_depth(&folder.path().join("depth/000002.png")).unwrap();
    for (units, meters) in depth.data.iter().zip(&frame.depth_m.data) {
        let expected = if *meters < 255.9 { *meters } else { 0.0 };
        assert!((f32::from(*units) / 256.0 - expected).abs() < 0.01, "{units} {meters}");
    }
    let json = std::fs::read_to_string(folder.path().join("synth.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["preset"], &json["frames"], &json["seed"]), (&"quiet".into(), &3.into(), &3.into()));
}

#[test]
fn stopping_early_leaves_a_shorter_but_whole_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let options = WriteOptions { max_frames: Some(10), ..WriteOptions::default() };
    let stop_at_two = &mut |done| if done == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    assert_eq!(write_kitti(&quiet(), folder.path(), &options, stop_at_two).unwrap(), 2);
    let sequence = io::open_sequence(folder.path(), None).unwrap();
    assert_eq!((sequence.frames.len(), sequence.ground_truth.unwrap().poses.len()), (2, 2));
    assert!(!folder.path().join("masks").exists());
}

#[test]
fn an_unwritable_place_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("occupied");
    std::fs::write(&file, "a file, not a folder").unwrap();
    let write =
        |out: &Path| write_kitti(&quiet(), out, &WriteOptions::default(), &mut |_| ControlFlow::Break(()));
    let message = write(&file).unwrap_err().to_string();
    assert!(
        message.starts_with(&format!("{}: cannot be written: ", file.join("image_0").display())),
        "{message}"
    );
    std::fs::create_dir_all(folder.path().join("calib.txt")).unwrap();
    let message = write(folder.path()).unwrap_err().to_string();
    assert!(
        message.starts_with(&format!("{}: cannot be written: ", folder.path().join("calib.txt").display())),
        "{message}"
    );
}

#[test]
fn raw_cameras_are_written_as_an_euroc_sequence() {
    let world = quiet();
    let folder = tempfile::tempdir().unwrap();
    let written =
        write_euroc(&world, folder.path(), Lens::Fisheye, Some(2), &mut |_| ControlFlow::Continue(()));
    assert_eq!(written.unwrap(), 2);
    let sequence = io::open_sequence(folder.path(), None).unwrap();
    assert_eq!(
        (sequence.frames.len(), sequence.sensor, &sequence.warnings[..]),
        (2, io::Sensor::Stereo, &[][..])
    );
    let raw = sequence.raw_calibration.unwrap();
    for (read, camera) in raw.cameras.iter().zip(Lens::Fisheye.cameras()) {
        assert_eq!((read.model, (read.size.width, read.size.height)), (camera.model, camera.size));
    }
    let right_from_left = |left: SE3, right: SE3| right.inverse() * left;
    let [left, right] = Lens::Fisheye.cameras().map(|camera| camera.rig_from_cam);
    let expected = right_from_left(left, right);
    let found = right_from_left(raw.cameras[0].body_from_cam, raw.cameras[1].body_from_cam);
    assert!((found.matrix() - expected.matrix()).amax() < 1e-9);
    // The left camera's center is that of the drive, wherever the body is.
    let truth = sequence.ground_truth.unwrap();
    let center = |i: usize| (truth.poses[i].world_from_cam * raw.cameras[0].body_from_cam).translation;
    let moved = world.world_from_cam(1).translation - world.world_from_cam(0).translation;
    assert!((center(1) - center(0) - moved).norm() < 1e-9);
    let loaded = io::load_frame(&sequence.frames[1]).unwrap();
    let images = world.lens_rig(&Lens::Fisheye.cameras()).images(1);
    assert!(loaded.left == images[0] && loaded.right.as_ref() == Some(&images[1]));
}
