//! Layouts of datasets beyond KITTI odometry, TUM RGB-D and EuRoC.

use dsslam_io::{Sensor, Sequence, SequenceKind, Times, open_sequence, save_png_depth};
use geometry::{DepthImage, Vec3};

use super::support::{Folder, P0, P1};

pub(super) fn open(folder: &Folder) -> Sequence {
    open_sequence(folder.path(), None).unwrap_or_else(|error| panic!("{error}"))
}

pub(super) fn warnings(folder: &Folder, sequence: &Sequence) -> Vec<String> {
    sequence.warnings.iter().map(|warning| folder.hide(warning)).collect()
}

pub(super) fn depth(folder: &Folder, name: &str) {
    save_png_depth(&folder.prepare(name), &DepthImage::new(40, 20, 1500)).unwrap();
}

/// A raw drive with its calibration in the folder of the date.
fn raw_drive(folder: &Folder) -> String {
    let drive = "2011_09_30/2011_09_30_drive_0020_sync";
    let times: String = (0..3).map(|i| format!("2011-09-30 12:40:25.{i}64389445\n")).collect();
    for camera in 0..2 {
        for i in 0..3 {
            folder.gray(&format!("{drive}/image_0{camera}/data/{i:010}.png"), 40, 20);
        }
        folder.write(&format!("{drive}/image_0{camera}/timestamps.txt"), &times);
    }
    let raw = |line: &str, n: usize| line.replace(&format!("P{n}"), &format!("P_rect_0{n}"));
    let calibration = format!("calib_time: 09-Jan-2012 13:57:47\n{}\n{}\n", raw(P0, 0), raw(P1, 1));
    folder.write("2011_09_30/calib_cam_to_cam.txt", calibration);
    drive.to_owned()
}

#[test]
fn a_kitti_raw_drive_as_downloaded() {
    let folder = Folder::new();
    let drive = raw_drive(&folder);
    // The drive, the folder of its date, and that of its camera.
    for path in [drive.clone(), "2011_09_30".to_owned(), format!("{drive}/image_00")] {
        let sequence = open_sequence(&folder.file(&path), None).unwrap();
        assert_eq!(
            (sequence.kind, sequence.sensor, sequence.frames.len()),
            (SequenceKind::KittiRaw, Sensor::Stereo, 3)
        );
        assert_eq!(sequence.frames[2].timestamp_ns, 1_317_386_425_264_389_445);
        let rig = sequence.calibration.unwrap().rig;
        assert_eq!((rig.camera.fx, rig.baseline_m), (700.0, 0.54));
        assert_eq!(sequence.warnings, Vec::<String>::new());
    }
}

#[test]
fn the_inertial_unit_of_a_raw_drive_is_ground_truth() {
    let folder = Folder::new();
    let drive = raw_drive(&folder);
    // 1e-5 degrees north are 1.11 m, here in the direction of travel after a quarter turn (yaw 0 is east).
    for i in 0..3 {
        let row = format!("{} 8.4 112.8 0 0 1.5707963267948966 0 0 0\n", 49.0 + f64::from(i) * 1e-5);
        folder.write(&format!("{drive}/oxts/data/{i:010}.txt"), row);
    }
    let sequence = open_sequence(&folder.file(&drive), None).unwrap();
    let truth = sequence.ground_truth.unwrap();
    let last = truth.poses[2].world_from_cam.translation;
    assert!((last - Vec3::new(2.226_39, 0.0, 0.0)).norm() < 1e-4, "{last}");
    // Forward of the unit is the camera's z.
    let forward = sequence.body_from_left.rotation * Vec3::z();
    assert!((forward - Vec3::x()).norm() < 1e-12);
    assert!(sequence.warnings[0].contains("no calib_imu_to_velo.txt"), "{:?}", sequence.warnings);
    let identity = "R: 1 0 0 0 1 0 0 0 1\nT: 0.5 0 0\n";
    folder.write("2011_09_30/calib_imu_to_velo.txt", identity);
    folder.write("2011_09_30/calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 -0.25\n");
    let sequence = open_sequence(&folder.file(&drive), None).unwrap();
    // x_cam = z axis: x_imu + 0.5 - 0.25: the camera sits 0.25 m behind the unit.
    assert!((sequence.body_from_left.translation - Vec3::new(-0.25, 0.0, 0.0)).norm() < 1e-12);
    assert_eq!(sequence.warnings, Vec::<String>::new());
}

#[test]
fn a_raw_drive_with_its_folders_renamed() {
    let folder = Folder::kitti(3);
    folder.remove("times.txt");
    folder.write("timestamps.txt", "2011-09-30 12:40:25.0\n2011-09-30 12:40:25.1\n2011-09-30 12:40:25.2\n");
    folder.write("calib.txt", format!("{P0}\n{P1}\n").replace('P', "P_rect_0"));
    let sequence = open(&folder);
    assert_eq!(
        (sequence.kind, sequence.frames[1].timestamp_ns),
        (SequenceKind::Kitti, 1_317_386_425_100_000_000)
    );
}

#[test]
fn kitti_360_with_its_poses() {
    let folder = Folder::new();
    let drive = "data_2d_raw/2013_05_28_drive_0000_sync";
    for camera in 0..2 {
        for i in 3..6 {
            folder.gray(&format!("{drive}/image_0{camera}/data_rect/{i:010}.png"), 40, 20);
        }
    }
    folder.write(
        &format!("{drive}/image_00/timestamps.txt"),
        "2013-05-28 08:46:03.1\n2013-05-28 08:46:03.2\n2013-05-28 08:46:03.3\n",
    );
    let raw = format!("{P0}\n{P1}\n").replace('P', "P_rect_0");
    folder.write("calibration/perspective.txt", raw);
    folder.write(
        "data_poses/2013_05_28_drive_0000_sync/cam0_to_world.txt",
        "4 1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1\n",
    );
    let sequence = open_sequence(&folder.file(drive), None).unwrap();
    assert_eq!((sequence.kind, sequence.frames.len()), (SequenceKind::Kitti360, 3));
    assert_eq!(sequence.calibration.unwrap().rig.baseline_m, 0.54);
    let truth = sequence.ground_truth.unwrap();
    assert_eq!(truth.poses[0].timestamp_s, sequence.frames[1].timestamp_s());
    assert_eq!(truth.poses[0].world_from_cam.translation.x, 7.0);
    // Without its lists the frames come at the rate of the configuration, and the run doubts that.
    folder.remove(&format!("{drive}/image_00/timestamps.txt"));
    let sequence = open_sequence(&folder.file(drive), None).unwrap();
    assert_eq!((sequence.times, sequence.frames[2].timestamp_ns), (Times::Invented, 200_000_000));
    assert_eq!((sequence.frames[0].index, sequence.frames.len()), (3, 3));
}

#[test]
fn euroc_without_lists_takes_the_names_as_times() {
    let folder = Folder::euroc(3);
    let with_lists = open(&folder);
    folder.remove("mav0/cam0/data.csv");
    folder.remove("mav0/cam1/data.csv");
    let sequence = open(&folder);
    assert_eq!((&sequence.frames, sequence.times), (&with_lists.frames, Times::Names));
    assert!(
        sequence.warnings[0].ends_with("so the names of the images are taken as their times in nanoseconds")
    );
    // Its left images alone.
    let alone = open_sequence(&folder.file("mav0/cam0/data"), None).unwrap();
    assert_eq!((alone.kind, alone.times), (SequenceKind::Images, Times::Names));
    assert_eq!(alone.frames[2].timestamp_ns, with_lists.frames[2].timestamp_ns);
}

#[test]
fn lists_of_euroc_with_a_header_blanks_or_folders() {
    for edit in [
        |list: &str| list.replace("#timestamp [ns],filename", "timestamp,filename"),
        |list: &str| list.lines().skip(1).map(|line| line.replace(',', " ") + "\n").collect(),
        |list: &str| list.replace(",1", ",cam0/data/1"),
    ] {
        let folder = Folder::euroc(3);
        let expected = open(&folder).frames;
        let list = std::fs::read_to_string(folder.file("mav0/cam0/data.csv")).unwrap();
        folder.write("mav0/cam0/data.csv", edit(&list));
        assert_eq!(open(&folder).frames, expected);
    }
}

#[test]
fn tum_vi_has_its_calibration_in_a_chain_and_its_truth_from_motion_capture() {
    let folder = Folder::euroc(2);
    let camera = "  camera_model: pinhole\n  distortion_coeffs: [0.01, 0.02, 0.001, 0.002]\n  distortion_model: equidistant\n  intrinsics: \
                  [30.0, 31.0, 19.0, 9.5]\n  resolution: [40, 20]\n";
    let place = |x: f64| {
        format!("  T_cam_imu:\n  - [1, 0, 0, {x}]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n")
    };
    folder.remove("mav0/cam0/sensor.yaml");
    folder.remove("mav0/cam1/sensor.yaml");
    folder.write("dso/camchain.yaml", format!("cam0:\n{}{camera}cam1:\n{}{camera}", place(0.5), place(0.25)));
    folder.write("mav0/mocap0/data.csv", "#timestamp [ns], p, q\n1403636589763555584,1,2,3,1,0,0,0\n");
    let sequence = open(&folder);
    assert_eq!((sequence.sensor, sequence.rectification.len()), (Sensor::Stereo, 2));
    assert!((sequence.body_from_left.translation.x + 0.5).abs() < 1e-9, "the unit is the body");
    assert_eq!(sequence.ground_truth.unwrap().poses.len(), 1);
}

#[test]
fn tartan_air_with_poses_of_a_body_that_looks_along_x() {
    let folder = Folder::new();
    for i in 0..3 {
        folder.gray(&format!("image_left/{i:06}_left.png"), 640, 480);
        folder.gray(&format!("image_right/{i:06}_right.png"), 640, 480);
    }
    folder.write("pose_left.txt", "0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n2 0 0 0 0 0 1\n");
    let sequence = open(&folder);
    assert_eq!(
        (sequence.kind, sequence.sensor, sequence.times),
        (SequenceKind::TartanAir, Sensor::Stereo, Times::Invented)
    );
    let rig = sequence.calibration.unwrap().rig;
    assert_eq!((rig.camera.fx, rig.baseline_m), (320.0, 0.25));
    assert_eq!(sequence.body_from_left.rotation * Vec3::z(), Vec3::x(), "forward");
    assert_eq!(sequence.body_from_left.rotation * Vec3::y(), Vec3::z(), "down");
    let truth = sequence.ground_truth.unwrap();
    assert_eq!((truth.poses[2].timestamp_s, truth.poses[2].world_from_cam.translation.x), (0.2, 2.0));
}

/// TartanAir's depth: NumPy files of meters beside the images.
#[test]
fn tartan_air_with_depth_in_numpy_files() {
    let folder = Folder::new();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (480, 640), }\n";
    let length = (header.len() as u16).to_le_bytes();
    let values = 2.5_f32.to_le_bytes().repeat(640 * 480);
    let numpy = [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &values].concat();
    for i in 0..2 {
        folder.gray(&format!("image_left/{i:06}_left.png"), 640, 480);
        folder.write(&format!("depth_left/{i:06}_left_depth.npy"), &numpy);
    }
    let sequence = open(&folder);
    assert_eq!((sequence.sensor, sequence.frames.len()), (Sensor::Rgbd, 2));
    assert_eq!(sequence.depth_units_per_metre, Some(2000.0), "meters as half millimeters");
    let depth = dsslam_io::load_depth(sequence.frames[1].depth.as_ref().unwrap()).unwrap();
    assert_eq!(depth.at(639, 479), 5000);
    // Beside two cameras depth is taken where it is asked for.
    for i in 0..2 {
        folder.gray(&format!("image_right/{i:06}_right.png"), 640, 480);
    }
    assert_eq!(open(&folder).sensor, Sensor::Stereo);
    assert_eq!(open_sequence(folder.path(), Some(Sensor::Rgbd)).unwrap().sensor, Sensor::Rgbd);
}

#[test]
fn seven_scenes_with_a_pose_beside_each_image() {
    let folder = Folder::new();
    for i in 0..2 {
        folder.gray(&format!("frame-{i:06}.color.png"), 40, 20);
        depth(&folder, &format!("frame-{i:06}.depth.png"));
        let pose = format!("1 0 0 {i}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
        folder.write(&format!("frame-{i:06}.pose.txt"), pose);
    }
    let sequence = open(&folder);
    assert_eq!(
        (sequence.kind, sequence.sensor, sequence.frames.len()),
        (SequenceKind::SevenScenes, Sensor::Rgbd, 2)
    );
    assert_eq!(sequence.ground_truth.as_ref().unwrap().poses[1].world_from_cam.translation.x, 1.0);
    assert_eq!(sequence.calibration, None, "the documented camera has other images");
    folder.write("frame-000001.pose.txt", "nan\n");
    let sequence = open(&folder);
    assert_eq!(sequence.ground_truth.as_ref().unwrap().poses.len(), 1);
    assert!(
        warnings(&folder, &sequence).iter().any(|warning| warning.ends_with("the frame has no ground truth"))
    );
}

#[test]
fn replica_with_its_camera_beside() {
    let folder = Folder::new();
    for i in 0..2 {
        folder.gray(&format!("room0/results/frame{i:06}.png"), 40, 20);
        depth(&folder, &format!("room0/results/depth{i:06}.png"));
    }
    folder.write("room0/traj.txt", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1\n");
    let camera = "{\"camera\": {\"w\": 40, \"h\": 20, \"fx\": 30.0, \"fy\": 31.0, \"cx\": 19, \"cy\": 9.5, \"scale\": 6553.5}}";
    folder.write("cam_params.json", camera);
    let sequence = open_sequence(&folder.file("room0"), None).unwrap();
    assert_eq!((sequence.kind, sequence.depth_units_per_metre), (SequenceKind::Replica, Some(6553.5)));
    assert_eq!(sequence.calibration.unwrap().rig.camera.fx, 30.0);
    assert_eq!(sequence.ground_truth.unwrap().poses[1].world_from_cam.translation.x, 5.0);
}

#[test]
fn openloris_has_depth_in_millimeters() {
    let folder = Folder::tum();
    std::fs::rename(folder.file("rgb.txt"), folder.file("color.txt")).unwrap();
    std::fs::rename(folder.file("depth.txt"), folder.file("aligned_depth.txt")).unwrap();
    let sequence = open(&folder);
    assert_eq!((sequence.kind, sequence.sensor), (SequenceKind::TumRgbd, Sensor::Rgbd));
    assert_eq!(sequence.depth_units_per_metre, Some(1000.0));
}

#[test]
fn a_sequence_of_vslam_lab() {
    let folder = Folder::new();
    let mut list = "ts_rgb_0 (ns),path_rgb_0,ts_rgb_1 (ns),path_rgb_1\n".to_owned();
    for i in 0..3 {
        folder.gray(&format!("rgb_0/{i}.png"), 40, 20);
        folder.gray(&format!("rgb_1/{i}.png"), 40, 20);
        list += &format!("140363657976355558{i},rgb_0/{i}.png,140363657976355558{i},rgb_1/{i}.png\n");
    }
    folder.write("rgb.csv", list);
    let camera = |name: &str, x: f64| {
        format!(
            "- {{cam_name: {name}, cam_model: pinhole, focal_length: [30, 31], principal_point: [19, 9.5], image_dimension: [40, 20], fps: 20.0, \
             T_BS: [[1,0,0,{x}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}}\n"
        )
    };
    folder.write("calibration.yaml", format!("cameras:\n{}{}", camera("rgb_0", 0.5), camera("rgb_1", 0.75)));
    folder.write("groundtruth.csv", "ts (ns),tx,ty,tz,qx,qy,qz,qw\n1403636579763555580,1,2,3,0.6,0,0,0.8\n");
    let sequence = open(&folder);
    assert_eq!(
        (sequence.kind, sequence.sensor, sequence.frames.len()),
        (SequenceKind::VslamLab, Sensor::Stereo, 3)
    );
    assert_eq!(sequence.frames[2].timestamp_ns, 1_403_636_579_763_555_582);
    assert_eq!(sequence.calibration.unwrap().rig.baseline_m, 0.25);
    assert_eq!(sequence.body_from_left.translation.x, 0.5);
    let truth = sequence.ground_truth.unwrap();
    assert!((truth.poses[0].world_from_cam.rotation.to_quaternion().w - 0.8).abs() < 1e-12, "w stands last");
}
