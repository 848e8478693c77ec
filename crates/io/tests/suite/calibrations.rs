//! Calibrations as other programs write them: each is made from one camera and gives that camera.

use dsslam_io::{OpenOptions, Sensor, open_sequence_with, read_calibration};
use geometry::{CameraModel, Vec3};

use super::support::Folder;

/// What is read from a file of this content, as our YAML without comments.
fn read(name: &str, content: impl AsRef<[u8]>) -> String {
    let folder = Folder::new();
    let file =
        read_calibration(&folder.write(name, content)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let yaml = file.to_yaml();
    let again = read_calibration(&folder.write("again.yaml", &yaml)).unwrap().to_yaml();
    assert_eq!(plain(&again), plain(&yaml), "{name}: read again");
    plain(&yaml)
}

fn plain(yaml: &str) -> String {
    yaml.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect()
}

/// The message of a file that is not read.
fn refused(name: &str, content: impl AsRef<[u8]>) -> String {
    let folder = Folder::new();
    folder.hide(read_calibration(&folder.write(name, content)).unwrap_err())
}

/// One camera of 40x20 pixels in our words.
fn camera(model: &str, coefficients: &str) -> String {
    let lens =
        if coefficients.is_empty() { String::new() } else { format!("    distortion: [{coefficients}]\n") };
    format!("  - model: {model}\n    resolution: [40, 20]\n    intrinsics: [30, 31, 19, 9.5]\n{lens}")
}

fn one(model: &str, coefficients: &str) -> String {
    format!("cameras:\n{}", camera(model, coefficients))
}

fn two(model: &str, coefficients: &str) -> String {
    format!(
        "{}{}right_from_left:  # x_right = R x_left + t, meters\n  - [1, 0, 0, -0.25]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n",
        one(model, coefficients),
        camera(model, coefficients)
    )
}

const RADTAN: &str = "-0.1, 0.01, 0.001, 0.002, 0";
const EIGHT: &str = "0.5, -2.5, 0.001, -0.002, 1.5, 0.25, -2, 1.25";

#[test]
fn settings_of_orb_slam2_and_orb_slam3() {
    let lens = |name: &str| {
        format!(
            "{name}.fx: 30.0\n{name}.fy: 31.0\n{name}.cx: 19.0\n{name}.cy: 9.5\n{name}.k1: -0.1\n{name}.k2: 0.01\n{name}.p1: \
             0.001\n{name}.p2: 0.002\n"
        )
    };
    let size = "Camera.width: 40\nCamera.height: 20\nCamera.fps: 25.0\nORBextractor.nFeatures: 2000\n";
    let second = format!("%YAML:1.0\n\n#----\n{}{size}Camera.bf: 7.5\nThDepth: 40\n", lens("Camera"));
    assert_eq!(
        read("orb2.yaml", &second),
        format!("fps: 25\nbaseline_m: 0.25\n{}", one("pinhole-radtan", RADTAN))
    );
    let depth = format!("{second}DepthMapFactor: 5000.0\n");
    assert!(read("tum1.yaml", depth).starts_with("fps: 25\ndepth_units_per_metre: 5000\nbaseline_m: 0.25\n"));
    let third = format!(
        "%YAML:1.0\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n{}{}{size}Stereo.T_c1_c2: !!opencv-matrix\n  rows: 4\n  \
         cols: 4\n  dt: f\n  data: [1.0,0,0,0.25,\n         0,1,0,0, 0,0,1.,0,\n         0,0,0,1.0]\n",
        lens("Camera1"),
        lens("Camera2")
    );
    assert_eq!(read("orb3.yaml", &third), format!("fps: 25\n{}", two("pinhole-radtan", RADTAN)));
    let rectified = format!("Camera.type: \"Rectified\"\n{}{size}Stereo.b: 0.25\n", lens("Camera1"));
    assert_eq!(read("rect.yaml", rectified), format!("fps: 25\nbaseline_m: 0.25\n{}", one("none", "")));
    let fisheye = third.replace("PinHole", "KannalaBrandt8").replace("p1", "k3").replace("p2", "k4");
    let expected = two("kannala-brandt", "-0.1, 0.01, 0.001, 0.002");
    assert_eq!(read("tumvi.yaml", fisheye), format!("fps: 25\n{expected}"));
    assert_eq!(
        refused("orb3.yaml", third.replace("Camera2.fx: 30.0", "Camera2.fx: wide")),
        "DIR/orb3.yaml:12: Camera2.fx: found `wide`, expected a focal length above 0 px"
    );
}

#[test]
fn raw_cameras_with_their_rectification() {
    // Turned by 90 degrees about the axis and back: the right camera stands where it should.
    let settings = "%YAML:1.0\nCamera.fx: 30\nCamera.fy: 30\nCamera.cx: 1\nCamera.cy: 1\nCamera.bf: 7.5\nLEFT.width: 40\nLEFT.height: \
                    20\nLEFT.K: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [30,0,19, 0,31,9.5, 0,0,1]\nLEFT.D: \
                    !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [-0.1, 0.01, 0.001, 0.002, 0]\nLEFT.R: \
                    !!opencv-matrix\n   data: [1,0,0, 0,1,0, 0,0,1]\nRIGHT.K: {data: [30,0,19, 0,31,9.5, 0,0,1]}\nRIGHT.D: {data: \
                    [-0.1, 0.01, 0.001, 0.002, 0]}\nRIGHT.width: 40\nRIGHT.height: 20\nRIGHT.R: {data: [1,0,0, 0,1,0, 0,0,1]}\n\
                    RIGHT.P: {data: [30,0,1,-7.5, 0,30,1,0, 0,0,1,0]}\n";
    assert_eq!(read("euroc.yaml", settings), two("pinhole-radtan", RADTAN));
    let swapped = settings.replace("-7.5", "7.5");
    assert_eq!(
        refused("euroc.yaml", swapped),
        "DIR/euroc.yaml:26: RIGHT.P: found fx' = 30 and Tx = 7.5, expected 12 numbers (fx' 0 cx' Tx 0 fy' cy' Ty 0 0 1 0) with Tx \
         below 0"
    );
}

fn kalibr(places: [&str; 2]) -> String {
    let camera = |name: &str, place: &str| {
        format!(
            "{name}:\n{place}  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: [-0.1, 0.01, 0.001, 0.002]\n  \
             distortion_model: radtan\n  intrinsics: [30.0, 31.0, 19.0, 9.5]\n  resolution: [40, 20]\n  rostopic: /a\n"
        )
    };
    camera("cam0", places[0]) + &camera("cam1", places[1])
}

#[test]
fn kalibr_says_which_spelling_of_the_extrinsics_was_read() {
    let rows = |x: f64| {
        format!("  - [1.0, 0, 0, {x}]\n  - [0, 1.0, 0, 0]\n  - [0, 0, 1.0, 0]\n  - [0, 0, 0, 1.0]\n")
    };
    let expected = two("pinhole-radtan", RADTAN);
    let folder = Folder::new();
    for (left, right, spelling) in [
        (String::new(), format!("  T_cn_cnm1:\n{}", rows(-0.25)), "T_cn_cnm1 (right from left)"),
        (
            format!("  T_cam_imu:\n{}", rows(0.5)),
            format!("  T_cam_imu:\n{}", rows(0.25)),
            "T_cam_imu (camera from IMU)",
        ),
        (
            format!("  T_imu_cam:\n{}", rows(0.5)),
            format!("  T_imu_cam:\n{}", rows(0.75)),
            "T_imu_cam (IMU from camera)",
        ),
    ] {
        let chain = kalibr([&left, &right]);
        assert_eq!(read("camchain.yaml", &chain), expected, "{spelling}");
        let notes = read_calibration(&folder.write("camchain.yaml", chain)).unwrap().notes;
        assert_eq!(
            folder.hide(&notes[0]),
            format!("DIR/camchain.yaml: the cameras' places are read from {spelling}")
        );
    }
    let chain = kalibr(["", &format!("  T_cn_cnm1:\n{}", rows(-0.25))]);
    assert_eq!(
        refused("camchain.yaml", chain.replacen("camera_model: pinhole", "camera_model: ds", 1)),
        "DIR/camchain.yaml:3: cam0.camera_model: found `ds`, expected pinhole (omni, ds and eucm are not read; \
         calibrate wide lenses with pinhole-equi)"
    );
    assert_eq!(
        refused("camchain.yaml", kalibr(["", ""])),
        "DIR/camchain.yaml: cam1.T_cn_cnm1: found nothing, expected 16 numbers (a rigid motion as a 4x4 matrix, row by row)"
    );
}

fn camera_info(model: &str, coefficients: &str, tx: f64) -> String {
    format!(
        "image_width: 40\nimage_height: 20\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [30, 0, 19, 0, 31, 9.5, 0, \
         0, 1]\ndistortion_model: {model}\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{coefficients}]\n\
         rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nprojection_matrix:\n  rows: 3\n  cols: \
         4\n  data: [30, 0, 19, {tx}, 0, 31, 9.5, 0, 0, 0, 1, 0]\n"
    )
}

#[test]
fn camera_info_of_ros_alone_and_in_pairs() {
    for (model, coefficients, expected) in [
        ("plumb_bob", RADTAN, one("pinhole-radtan", RADTAN)),
        ("rational_polynomial", EIGHT, one("rational_polynomial", EIGHT)),
        ("rational_polynomial", "-0.1, 0.01, 0.001, 0.002, 0, 0, 0, 0", one("pinhole-radtan", RADTAN)),
        ("equidistant", "1, 2, 3, 4", one("kannala-brandt", "1, 2, 3, 4")),
        ("plumb_bob", "0, 0, 0, 0, 0", one("none", "")),
        ("plumb_bob", "", one("none", "")),
    ] {
        assert_eq!(read("ost.yaml", camera_info(model, coefficients, 0.0)), expected, "{model}");
    }
    let folder = Folder::new();
    let left = folder.write("left.yaml", camera_info("plumb_bob", RADTAN, 0.0));
    folder.write("right.yaml", camera_info("plumb_bob", RADTAN, -7.5));
    let pair = read_calibration(&left).unwrap();
    assert_eq!(plain(&pair.to_yaml()), two("pinhole-radtan", RADTAN));
    assert_eq!(folder.hide(&pair.notes[0]), "DIR/left.yaml: the right camera is read from DIR/right.yaml");
    assert_eq!(
        refused("ost.yaml", camera_info("thin_prism_fisheye", RADTAN, 0.0)),
        "DIR/ost.yaml:8: distortion_model: found `thin_prism_fisheye`, expected pinhole-radtan (also radtan, radial-tangential, \
         plumb_bob, opencv), rational_polynomial, kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none"
    );
    assert_eq!(
        refused("ost.yaml", camera_info("plumb_bob", "1, 2, 3", 0.0)),
        "DIR/ost.yaml:10: distortion_coefficients: found 3 numbers, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3), or 8 (also \
         k4, k5, k6)"
    );
}

#[test]
fn matrices_of_opencv_in_its_three_forms() {
    let yaml = "%YAML:1.0\n---\nimage_width: 40\nimage_height: 20\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 30., 0., \
                19., 0., 31., 9.5000000000000000e+00,\n       0., 0., 1. ]\nD: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: \
                [ -0.1, 0.01, 0.001, 0.002, 0. ]\n";
    let xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>40</image_width>\n<image_height>20</image_height>\n<K \
               type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>3</cols>\n  <dt>d</dt>\n  <data>\n    30. 0. 19. 0. 31. 9.5 0.\n    0. \
               1.</data></K>\n<D type_id=\"opencv-matrix\">\n  <rows>1</rows><cols>5</cols><dt>d</dt>\n  <data>-0.1 0.01 0.001 0.002 \
               0.</data></D>\n</opencv_storage>\n";
    let json = "{\n    \"image_width\": 40,\n    \"image_height\": 20,\n    \"K\": {\n        \"type_id\": \"opencv-matrix\",\n        \"rows\": \
                3, \"cols\": 3, \"dt\": \"d\",\n        \"data\": [ 30.0, 0.0, 19.0, 0.0, 31.0, 9.5, 0.0, 0.0, 1.0 ]\n    },\n    \"D\": \
                { \"type_id\": \"opencv-matrix\", \"data\": [ -0.1, 0.01, 0.001, 0.002, 0.0 ] }\n}\n";
    let expected = one("pinhole-radtan", RADTAN);
    assert_eq!(
        [read("a.yml", yaml), read("a.xml", xml), read("a.json", json)],
        [(); 3].map(|()| expected.clone())
    );
    let stereo = yaml.replace("K:", "M1:").replace("D:", "D1:")
        + "M2: {data: [30, 0, 19, 0, 31, 9.5, 0, 0, 1]}\nD2: {data: [-0.1, 0.01, 0.001, 0.002, 0]}\nR: {data: [1, 0, 0, 0, 1, 0, 0, 0, \
           1]}\nT: {data: [-0.25, 0, 0]}\n";
    assert_eq!(read("stereo.yml", &stereo), two("pinhole-radtan", RADTAN));
    assert_eq!(
        refused("stereo.yml", stereo.replace("30., 0., 19.", "30., 2., 19.")),
        "DIR/stereo.yml:6: M1: found [30, 2, 19, 0, 31, 9.5, 0, 0, 1], expected 9 numbers (fx 0 cx 0 fy cy 0 0 1)"
    );
}

#[test]
fn colmap_and_nerfstudio_count_from_the_corner_of_a_pixel() {
    let line =
        |rest: &str| format!("# Camera list\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 {rest}\n");
    for (rest, expected) in [
        ("PINHOLE 40 20 30 31 19.5 10", one("none", "")),
        ("OPENCV 40 20 30 31 19.5 10 -0.1 0.01 0.001 0.002", one("pinhole-radtan", RADTAN)),
        (
            "FULL_OPENCV 40 20 30 31 19.5 10 0.5 -2.5 0.001 -0.002 1.5 0.25 -2 1.25",
            one("rational_polynomial", EIGHT),
        ),
        ("OPENCV_FISHEYE 40 20 30 31 19.5 10 1 2 3 4", one("kannala-brandt", "1, 2, 3, 4")),
        (
            "SIMPLE_RADIAL 40 20 30 19.5 10 -0.1",
            one("pinhole-radtan", "-0.1, 0, 0, 0, 0").replace("31", "30"),
        ),
    ] {
        assert_eq!(read("cameras.txt", line(rest)), expected, "{rest}");
    }
    let message = refused("cameras.txt", line("FOV 40 20 30 31 19.5 10 0.9"));
    assert!(
        message
            .starts_with("DIR/cameras.txt:3: found FOV with 5 parameters, expected SIMPLE_PINHOLE, PINHOLE"),
        "{message}"
    );
    let json = "{\"camera_model\": \"OPENCV\", \"fl_x\": 30, \"fl_y\": 31, \"cx\": 19.5, \"cy\": 10, \"w\": 40, \"h\": 20, \"k1\": -0.1, \"k2\": \
                0.01, \"p1\": 0.001, \"p2\": 0.002, \"frames\": []}";
    assert_eq!(read("transforms.json", json), one("pinhole-radtan", RADTAN));
}

#[test]
fn further_json_and_yaml() {
    let replica = "{\"camera\": {\"w\": 40, \"h\": 20, \"fx\": 30.0, \"fy\": 31.0, \"cx\": 19.0, \"cy\": 9.5, \"scale\": 6553.5}}";
    assert_eq!(
        read("cam_params.json", replica),
        format!("depth_units_per_metre: 6553.5\n{}", one("none", ""))
    );
    let realsense = "{\"width\": 40, \"height\": 20, \"fx\": 30.0, \"fy\": 31.0, \"ppx\": 19.0, \"ppy\": 9.5, \"model\": \
                     \"inverse_brown_conrady\", \"coeffs\": [0, 0, 0, 0, 0], \"depth_scale\": 0.001}";
    assert_eq!(
        read("intrinsics.json", realsense),
        format!("depth_units_per_metre: 1000\n{}", one("none", ""))
    );
    let lab = "cameras:\n- {cam_name: rgb_0, cam_type: gray, cam_model: pinhole, distortion_type: radtan5, focal_length: [30, 31], \
               principal_point: [19, 9.5], distortion_coefficients: [-0.1, 0.01, 0.001, 0.002, 0], image_dimension: [40, 20], fps: \
               20.0, T_BS: [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}\n";
    assert_eq!(read("calibration.yaml", lab), format!("fps: 20\n{}", one("pinhole-radtan", RADTAN)));
    // Eight coefficients and the usual names in our own format.
    let own = one("radtan", EIGHT).replace("radtan", "opencv");
    assert_eq!(read("own.yaml", own), one("rational_polynomial", EIGHT));
}

#[test]
fn projection_matrices_of_kitti() {
    let raw = "calib_time: 09-Jan-2012 14:00:15\ncorner_dist: 9.950000e-02\nS_rect_00: 4.0e+01 2.0e+01\nP_rect_00: 30 0 19 0 0 31 9.5 0 0 0 \
               1 0\nP_rect_01: 30 0 19 -7.5 0 31 9.5 0 0 0 1 0\n";
    assert_eq!(read("calib_cam_to_cam.txt", raw), two("none", ""));
    let odometry: String = raw.lines().skip(3).map(|line| line.replace("_rect_0", "") + "\n").collect();
    assert_eq!(read("calib.txt", odometry), two("none", "").replace("    resolution: [40, 20]\n", ""));
}

#[test]
fn what_is_not_read_gets_the_list_of_what_is() {
    let message = refused("x.yaml", "lidar: 3\nbaud: 115200\n");
    assert!(
        message.starts_with("DIR/x.yaml: found the fields lidar, baud, expected one of these calibrations: BoofCV (XML), VSLAM-LAB"),
        "{message}"
    );
    for part in [
        "Kalibr camchain",
        "ORB-SLAM2",
        "ROS camera_info",
        "OpenCV FileStorage",
        "COLMAP cameras.txt",
        "KITTI calib.txt",
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
    let binary = refused("cameras.bin", [1, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xfe]);
    assert!(
        binary.starts_with("DIR/cameras.bin: found a file that is not text, expected one of"),
        "{binary}"
    );
}

#[test]
fn a_negative_fy_is_that_of_coordinates_with_y_up() {
    let folder = Folder::tum();
    folder.write("groundtruth.txt", "1.0 1 2 3 0 0 0 1\n1.1 1 4 3 0.6 0 0 0.8\n");
    let settings = "Camera.fx: 30\nCamera.fy: -31\nCamera.cx: 19\nCamera.cy: 9.5\nCamera.bf: 2.4\nDepthMapFactor: 5000\n";
    let options =
        OpenOptions { calibration: Some(folder.write("icl.yaml", settings)), ..OpenOptions::default() };
    let sequence = open_sequence_with(folder.path(), &options).unwrap();
    let rig = sequence.calibration.unwrap().rig;
    assert_eq!((sequence.sensor, rig.camera.fy, rig.baseline_m), (Sensor::Rgbd, 31.0, 0.08));
    let truth = sequence.ground_truth.unwrap();
    assert_eq!(truth.poses[0].world_from_cam.translation, Vec3::new(1.0, -2.0, 3.0));
    // A turn about x becomes one the other way round.
    let turned = truth.poses[1].world_from_cam.rotation.matrix();
    assert!((turned[(2, 1)] + 0.96).abs() < 1e-12 && (turned[(1, 2)] - 0.96).abs() < 1e-12, "{turned}");
    assert!(
        sequence.warnings.iter().any(|warning| warning.contains("fy is negative")),
        "{:?}",
        sequence.warnings
    );
}

#[test]
fn a_rational_lens_is_drawn_anew() {
    let folder = Folder::new();
    folder.gray("1.png", 40, 20);
    folder.write("calibration.yaml", one("rational_polynomial", "0.1, 0.02, 0, 0, 0, 0.05, 0, 0"));
    let sequence = open_sequence_with(folder.path(), &OpenOptions::default()).unwrap();
    let [view] = &sequence.rectification[..] else { panic!("one view") };
    assert!(matches!(view.model, CameraModel::Rational(lens) if lens.lower == [0.05, 0.0, 0.0]));
}
