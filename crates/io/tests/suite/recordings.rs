//! Recordings that people make themselves: pairs, color and depth, lists, calibrations that lie about, repeated stamps.

use dsslam_io::{OpenOptions, Sensor, SequenceKind, Times, load_frame, open_sequence, open_sequence_with};

use super::layouts::{depth, open, warnings};
use super::support::{Folder, calibration_yaml};

#[test]
fn pairs_in_one_folder_or_in_folders_of_other_names() {
    for (left, right) in [
        ("left_#", "right_#"),
        ("#_left", "#_right"),
        ("#_L", "#_R"),
        ("infra1/#", "infra2/#"),
        ("left_images/#", "right_images/#"),
        ("image_left/#", "image_right/#"),
        ("Left/#", "Right/#"),
    ] {
        let folder = Folder::new();
        folder.write("calibration.yaml", calibration_yaml(2));
        for i in 0..3 {
            for name in [left, right] {
                folder.gray(&format!("{}.png", name.replace('#', &format!("{i:06}"))), 40, 20);
            }
        }
        let sequence = open(&folder);
        assert_eq!((sequence.sensor, sequence.frames.len()), (Sensor::Stereo, 3), "{left}");
        let expected = folder.file(&format!("{}.png", right.replace('#', "000001")));
        assert_eq!(sequence.frames[1].right.as_ref(), Some(&expected));
    }
}

#[test]
fn folders_of_color_and_depth_by_number_and_by_time() {
    let folder = Folder::new();
    for i in 0..3 {
        folder.gray(&format!("color/{i}.png"), 40, 20);
        depth(&folder, &format!("depth/{i}.png"));
    }
    let sequence = open(&folder);
    assert_eq!((sequence.sensor, sequence.frames.len(), sequence.times), (Sensor::Rgbd, 3, Times::Invented));
    let folder = Folder::new();
    for i in 0..3 {
        folder.gray(&format!("rgb/1305031452.{i}91720.png"), 40, 20);
        depth(&folder, &format!("depth/1305031452.{i}95720.png"));
    }
    let sequence = open(&folder);
    assert_eq!((sequence.sensor, sequence.frames.len(), sequence.times), (Sensor::Rgbd, 3, Times::Names));
    assert_eq!(sequence.frames[1].timestamp_ns, 1_305_031_452_191_720_000);
}

#[test]
fn one_repeated_stamp_costs_one_frame() {
    let folder = Folder::kitti(3);
    folder.write("times.txt", "0\n0.1\n0.1\n");
    let sequence = open(&folder);
    assert_eq!(sequence.frames.iter().map(|frame| frame.index).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(
        warnings(&folder, &sequence),
        ["DIR/image_0/000002.png: its time is that of the frame before; the frame is left out"]
    );
    let folder = Folder::tum();
    folder.write("rgb.txt", "1.000 rgb/a.png\n1.100 rgb/b.png\n1.100 rgb/b.png\n1.200 rgb/c.png\n");
    assert_eq!(open(&folder).frames.len(), 3);
}

#[test]
fn recordings_that_are_files_are_named() {
    let folder = Folder::new();
    for (name, what) in [("a.zip", "an archive"), ("a.svo2", "a ZED recording")] {
        let message = folder.hide(open_sequence(&folder.file(name), None).unwrap_err());
        assert!(message.starts_with(&format!("DIR/{name}: {what}, which is not read;")), "{message}");
    }
}

#[test]
fn lists_as_people_write_them() {
    let folder = Folder::tum();
    let name = folder.path().file_name().unwrap().to_string_lossy().into_owned();
    let rows = |prefix: &str, separator: &str| {
        format!("1.0{separator}{prefix}/a.png\n1.1{separator}{prefix}/b.png\n")
    };
    for (list, is_told) in [
        (rows("rgb", ","), false),
        (rows(&format!("{name}/rgb"), " "), true),
        (rows("/home/other/data/rgb", "\t"), true),
    ] {
        folder.write("rgb.txt", &list);
        let sequence = open(&folder);
        assert_eq!(load_frame(&sequence.frames[1]).unwrap().size().to_string(), "40x20", "{list}");
        let told =
            sequence.warnings.iter().any(|warning| warning.contains("the images are not where it says"));
        assert_eq!(told, is_told, "{list}: {:?}", sequence.warnings);
    }
    // Names alone, where they are times.
    for name in ["a", "b"] {
        let time = if name == "a" { "1305031452.791720" } else { "1305031452.823674" };
        std::fs::copy(folder.file(&format!("rgb/{name}.png")), folder.file(&format!("rgb/{time}.png")))
            .unwrap();
    }
    folder.write("rgb.txt", "rgb/1305031452.791720.png\nrgb/1305031452.823674.png\n");
    let sequence = open_sequence(folder.path(), Some(Sensor::Mono)).unwrap();
    assert_eq!(sequence.frames[1].timestamp_ns, 1_305_031_452_823_674_000);
    std::fs::rename(folder.file("rgb"), folder.file("my rgb")).unwrap();
    folder.write("rgb.txt", rows("my rgb", " "));
    assert_eq!(open(&folder).frames[0].left, folder.file("my rgb/a.png"));
}

#[test]
fn one_list_of_color_and_depth_in_either_order() {
    for list in [
        "# both\n1.0 rgb/a.png 1.01 depth/a.png\n1.1 rgb/b.png 1.11 depth/b.png\n",
        "1.01 depth/a.png 1.0 rgb/a.png\n1.11 depth/b.png 1.1 rgb/b.png\n",
    ] {
        let folder = Folder::tum();
        folder.remove("rgb.txt");
        folder.remove("depth.txt");
        folder.write("associations.txt", list);
        let sequence = open(&folder);
        assert_eq!(
            (sequence.kind, sequence.sensor, sequence.frames.len()),
            (SequenceKind::TumRgbd, Sensor::Rgbd, 2)
        );
        let frame = &sequence.frames[1];
        assert_eq!((frame.timestamp_s(), &frame.left), (1.1, &folder.file("rgb/b.png")));
        assert_eq!(frame.depth, Some(folder.file("depth/b.png")));
    }
}

#[test]
fn a_tum_folder_keeps_its_layout_with_a_calibration_file() {
    let folder = Folder::tum();
    folder.write("calibration.yaml", calibration_yaml(1));
    let sequence = open(&folder);
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::TumRgbd, Sensor::Rgbd));
    assert_eq!((sequence.calibration.unwrap().rig.camera.fy, sequence.frame_rate_hz), (31.0, Some(25.0)));
}

#[test]
fn an_euroc_folder_keeps_its_layout_and_its_body_with_a_calibration_file() {
    let folder = Folder::euroc(3);
    let own = open(&folder);
    let options = |text: &str| OpenOptions {
        calibration: Some(folder.write("cam.yaml", text)),
        ..OpenOptions::default()
    };
    let two = open_sequence_with(folder.path(), &options(&calibration_yaml(2))).unwrap();
    assert_eq!((two.kind, two.sensor), (SequenceKind::Euroc, Sensor::Stereo));
    assert!((two.body_from_left.matrix() - own.body_from_left.matrix()).amax() < 1e-12);
    let one = open_sequence_with(folder.path(), &options(&calibration_yaml(1))).unwrap();
    assert_eq!(
        one.calibration.as_ref().unwrap().rig,
        own.calibration.unwrap().rig,
        "the right camera stays where it is"
    );
    assert!(one.warnings[0].contains("the place of the right one is that of"), "{:?}", one.warnings);
}

#[test]
fn numbering_from_any_number() {
    let folder = Folder::kitti(0);
    for i in [107, 108, 109] {
        folder.gray(&format!("image_0/{i:06}.png"), 40, 20);
        folder.gray(&format!("image_1/{i:06}.png"), 40, 20);
    }
    folder.write("times.txt", "0.5\n0.6\n0.7\n");
    folder.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n");
    let sequence = open(&folder);
    let found: Vec<(u32, f64)> =
        sequence.frames.iter().map(|frame| (frame.index, frame.timestamp_s())).collect();
    assert_eq!(found, [(107, 0.5), (108, 0.6), (109, 0.7)]);
    assert_eq!(sequence.ground_truth.unwrap().poses[1].timestamp_s, 0.6);
}

/// Folders that were packed on a Mac: `._0.png` beside `0.png`, `.DS_Store`, `__MACOSX`.
#[test]
fn what_macos_puts_beside_files_is_no_image() {
    let folder = Folder::new();
    for i in 0..3 {
        folder.gray(&format!("left/{i}.png"), 40, 20);
        folder.write(&format!("left/._{i}.png"), [0, 5, 22, 7, 0, 2, 0, 0]);
    }
    folder.write("left/.DS_Store", "Bud1");
    folder.write("__MACOSX/left/._0.png", "x");
    assert_eq!(open(&folder).frames.len(), 3);
    let kitti = Folder::kitti(3);
    kitti.write("image_0/._000000.png", "x");
    assert_eq!(open(&kitti).frames.len(), 3);
}

/// A ZED's images with the calibration of its left camera.
#[test]
fn an_image_twice_as_wide_as_its_camera_may_hold_two() {
    let error = dsslam_io::ImageError::wrong_size(
        "a.png".as_ref(),
        dsslam_io::ImageSize { width: 2560, height: 720 },
        dsslam_io::ImageSize { width: 1280, height: 720 },
        "resolution in left.yaml",
    );
    assert_eq!(
        error.to_string(),
        "a.png: found 2560x720 pixels, expected 1280x720 (resolution in left.yaml; it is twice as wide: two views side by side need the \
         calibration of both cameras)"
    );
}
