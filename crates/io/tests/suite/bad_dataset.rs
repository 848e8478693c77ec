//! Broken dataset folders: the exact message.

use dsslam_io::{Sensor, open_sequence};

use super::support::{Folder, P0, P1};

/// The message of opening `folder`, its path written as `DIR`.
fn refused(folder: &Folder, sensor: Option<Sensor>) -> String {
    folder.hide(open_sequence(folder.path(), sensor).unwrap_err())
}

/// The message of a KITTI folder whose file `name` has this content.
fn refused_with(name: &str, content: &str) -> String {
    let folder = Folder::kitti(3);
    folder.write(name, content);
    refused(&folder, None)
}

#[test]
fn missing_folder() {
    let folder = Folder::new();
    let error = open_sequence(&folder.file("nowhere"), None).unwrap_err();
    assert_eq!(folder.hide(error), "DIR/nowhere: no such folder");
}

#[test]
fn file_instead_of_folder() {
    let folder = Folder::new();
    let error = open_sequence(&folder.write("file", "x"), None).unwrap_err();
    assert_eq!(folder.hide(error), "DIR/file: not a folder");
}

#[test]
fn unknown_layout() {
    let folder = Folder::new();
    let message = refused(&folder, None);
    assert!(
        message.starts_with("DIR: no known dataset layout: found nothing; expected KITTI (image_0"),
        "{message}"
    );
    for name in ["notes.doc", "a.raw", "b.raw"] {
        folder.write(name, "x");
    }
    std::fs::create_dir(folder.file("frames")).unwrap();
    let found = "found the folders frames; 2 files end in .raw, 1 in .doc; expected";
    assert!(refused(&folder, None).contains(found), "{}", refused(&folder, None));
}

#[test]
fn no_images() {
    let folder = Folder::kitti(0);
    folder.write("times.txt", "0\n");
    assert_eq!(
        refused(&folder, None),
        "DIR: found no image, expected images such as 000000.png in image_0 or image_2"
    );
}

#[test]
fn missing_times() {
    let folder = Folder::kitti(2);
    folder.remove("times.txt");
    assert_eq!(refused(&folder, None), "DIR/times.txt: no such file, expected a time in seconds per line");
}

#[test]
fn empty_times() {
    assert_eq!(
        refused_with("times.txt", " \n\n"),
        "DIR/times.txt: found no data, expected a time in seconds per line"
    );
}

#[test]
fn times_that_are_no_numbers() {
    assert_eq!(refused_with("times.txt", "0\nsoon\n2\n"), "DIR/times.txt:2: found `soon`, expected a number");
    assert_eq!(
        refused_with("times.txt", "0\nNaN\n2\n"),
        "DIR/times.txt:2: found `NaN`, expected a finite number"
    );
    assert_eq!(
        refused_with("times.txt", "0\n1 2\n"),
        "DIR/times.txt:2: found 2 numbers, expected a time in seconds per line"
    );
}

#[test]
fn times_that_go_back_or_stand_still() {
    assert_eq!(
        refused_with("times.txt", "0\n0.2\n0.1\n"),
        "DIR/times.txt:3: found time 0.1 after 0.2 of the previous entry, expected strictly increasing times"
    );
    assert_eq!(
        refused_with("times.txt", "0\n0\n0\n"),
        "DIR/times.txt:3: found time 0 after 0 of the previous entry, expected strictly increasing times"
    );
}

#[test]
fn binary_times() {
    let folder = Folder::kitti(1);
    folder.write("times.txt", b"0\n\xff\xfe\n");
    assert_eq!(
        refused(&folder, None),
        "DIR/times.txt:2: found bytes that are not UTF-8 text, expected a time in seconds per line"
    );
}

#[test]
fn missing_calibration_line() {
    assert_eq!(
        refused_with("calib.txt", P0),
        "DIR/calib.txt: found no line `P1:` or `P_rect_01:`, expected 12 numbers (projection matrix, row by row)"
    );
    assert_eq!(
        refused_with("calib.txt", ""),
        "DIR/calib.txt: found no line `P0:` or `P_rect_00:`, expected 12 numbers (projection matrix, row by row)"
    );
}

#[test]
fn short_calibration_line() {
    let short = P1.rsplit_once(' ').unwrap().0;
    assert_eq!(
        refused_with("calib.txt", &format!("{P0}\n{short}\n")),
        "DIR/calib.txt:2: found 11 numbers, expected 12 numbers (projection matrix, row by row)"
    );
}

#[test]
fn calibration_that_is_no_number() {
    let nan = P0.replacen("20", "nan", 1);
    assert_eq!(
        refused_with("calib.txt", &format!("{nan}\n{P1}\n")),
        "DIR/calib.txt:1: found `nan`, expected a finite number"
    );
    let word = P0.replacen("20", "cx", 1);
    assert_eq!(
        refused_with("calib.txt", &format!("{word}\n{P1}\n")),
        "DIR/calib.txt:1: found `cx`, expected a number"
    );
}

#[test]
fn calibration_that_is_no_camera() {
    let negative = P0.replacen("7.0e+02", "-7.0e+02", 1);
    assert_eq!(
        refused_with("calib.txt", &format!("{negative}\n{P1}\n")),
        "DIR/calib.txt:1: found fx = -700 in P0, expected a focal length above 0 px"
    );
    let skewed = P0.replacen("7.0e+02 0 20", "7.0e+02 3 20", 1);
    assert_eq!(
        refused_with("calib.txt", &format!("{skewed}\n{P1}\n")),
        "DIR/calib.txt:1: found `P0: 7.0e+02 3 20 0 0 7.0e+02 10 0 0 0 1 ...`, expected a rectified projection \
         matrix fx 0 cx tx 0 fy cy ty 0 0 1 tz"
    );
}

#[test]
fn cameras_that_are_no_pair() {
    let other = P1.replacen("20", "21", 1);
    assert_eq!(
        refused_with("calib.txt", &format!("{P0}\n{other}\n")),
        "DIR/calib.txt:2: found fx fy cx cy = 700 700 21 10 for the right camera, expected 700 700 20 10 as for the \
         left camera (rectified)"
    );
    let swapped = P1.replacen("-378", "378", 1);
    assert_eq!(
        refused_with("calib.txt", &format!("{P0}\n{swapped}\n")),
        "DIR/calib.txt:2: found a baseline of -0.54 m, expected a baseline above 0 m (right camera to the right)"
    );
}

#[test]
fn sensors_that_the_folder_does_not_have() {
    assert_eq!(
        refused(&Folder::kitti(1), Some(Sensor::Rgbd)),
        "DIR: sensor rgbd is not possible here: KITTI folders contain no depth images"
    );
    assert_eq!(
        refused(&Folder::tum(), Some(Sensor::Stereo)),
        "DIR: sensor stereo is not possible here: TUM RGB-D folders contain no right images"
    );
    let folder = Folder::kitti(1);
    folder.remove("image_1/000000.png");
    assert_eq!(
        refused(&folder, Some(Sensor::Stereo)),
        "DIR: sensor stereo is not possible here: found no image in image_1"
    );
    folder.gray("image_1/000007.png", 40, 20);
    assert_eq!(
        refused(&folder, Some(Sensor::Stereo)),
        "DIR: sensor stereo is not possible here: no image number occurs in both image_0 and image_1"
    );
}

#[test]
fn broken_ground_truth_never_stops_a_run() {
    let opened = |poses: &str| {
        let folder = Folder::kitti(3);
        folder.write("poses.txt", poses);
        let sequence = open_sequence(folder.path(), None).unwrap();
        let warning = folder.hide(&sequence.warnings[0]);
        (warning, sequence.ground_truth.map(|truth| truth.poses.len()))
    };
    assert_eq!(
        opened("1 0 0 0 0 1 0 0 0 0 1\n"),
        (
            "DIR/poses.txt:1: found 11 numbers, expected 12 numbers (the 3x4 pose, row by row); the run continues without ground \
             truth"
                .to_owned(),
            None
        )
    );
    let row = "1 0 0 0 0 1 0 0 0 0 1 0\n";
    let odd = row.replace("1 0\n", "1 nan\n");
    let (warning, n_poses) = opened(&format!("{row}{odd}{row}"));
    assert_eq!(
        (warning.as_str(), n_poses),
        (
            "DIR/poses.txt:2: found `nan`, expected a finite number; 1 such line of the ground truth left out",
            Some(2)
        )
    );
}

#[test]
fn broken_tum_lists() {
    let folder = Folder::tum();
    folder.remove("depth.txt");
    assert_eq!(
        refused(&folder, Some(Sensor::Rgbd)),
        "DIR/depth.txt: no such file, expected a time in seconds and a file name per line"
    );
    let folder = Folder::tum();
    folder.write("rgb.txt", "# nothing\n");
    assert_eq!(
        refused(&folder, None),
        "DIR/rgb.txt: found no data, expected a time in seconds and a file name per line"
    );
    folder.write("rgb.txt", "1.0\n");
    assert_eq!(
        refused(&folder, None),
        "DIR/rgb.txt:1: found 1 field, expected a time in seconds and a file name per line"
    );
    folder.write("rgb.txt", "2.0 rgb/a.png\n1.0 rgb/b.png\n");
    assert_eq!(
        refused(&folder, None),
        "DIR/rgb.txt:2: found time 1 after 2 of the previous entry, expected strictly increasing times"
    );
    folder.write("rgb.txt", "7.0 rgb/a.png\n");
    assert_eq!(
        refused(&folder, None),
        "DIR: sensor rgbd is not possible here: no color image has a depth image within 20 ms"
    );
}
