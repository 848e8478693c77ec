//! Our own calibration file, EuRoC's and BoofCV's, and the exact message for what is wrong in them.

use dsslam_io::{OpenOptions, Sensor, Sequence, open_sequence_with};
use geometry::{CameraModel, Distortion, Vec3};

use super::support::{Folder, calibration_yaml, sensor_yaml};

/// Opens a folder with one pair of images and this calibration.
fn open_with(calibration: &str) -> Result<Sequence, String> {
    let folder = Folder::new();
    folder.gray("left/1.png", 40, 20);
    folder.gray("right/1.png", 40, 20);
    let calibration = Some(folder.write("camera", calibration));
    let options = OpenOptions { calibration, ..OpenOptions::default() };
    open_sequence_with(folder.path(), &options).map_err(|error| folder.hide(error).replace("DIR/camera", ""))
}

/// The message when one piece of a stereo calibration is another one.
fn refused(piece: &str, other: &str) -> String {
    let yaml = calibration_yaml(2);
    assert!(yaml.contains(piece), "{yaml}");
    open_with(&yaml.replace(piece, other)).unwrap_err()
}

const BOOFCV: &str = "<boofcv.struct.calib.StereoParameters>\n<left>\n<cx>19</cx>\n<cy>9.5</cy>\n<fx>30</fx>\n\
    <fy>31</fy>\n<height>20</height>\n<radial>\n<double>-0.1</double>\n<double>0.01</double>\n</radial>\n\
    <skew>0.0</skew>\n<width>40</width>\n</left>\n<right>\n<cx>19</cx>\n<cy>9.5</cy>\n<fx>30</fx>\n<fy>31</fy>\n\
    <height>20</height>\n<width>40</width>\n</right>\n<rightToLeft>\n<r>\n<data>\n<double>1</double>\n\
    <double>0</double>\n<double>0</double>\n<double>0</double>\n<double>1</double>\n<double>0</double>\n\
    <double>0</double>\n<double>0</double>\n<double>1</double>\n</data>\n</r>\n<t><x>0.25</x><y>0</y><z>0</z></t>\n\
    </rightToLeft>\n</boofcv.struct.calib.StereoParameters>\n";

#[test]
fn right_from_left_is_where_the_right_camera_looks_from() {
    let sequence = open_with(&calibration_yaml(2)).unwrap();
    let raw = sequence.raw_calibration.unwrap();
    // x_right = x_left - (0.25, 0, 0): the right camera stands 0.25 m to the right.
    assert_eq!(raw.cameras[1].body_from_cam.translation, Vec3::new(0.25, 0.0, 0.0));
    let four = calibration_yaml(2) + "  - [0, 0, 0, 1]\n";
    assert_eq!(open_with(&four).unwrap().raw_calibration.unwrap().cameras, raw.cameras);
}

#[test]
fn missing_fields() {
    const NUMBERS: &str = "4 numbers (fx, fy, cx, cy in pixels)";
    for (piece, expected) in [
        (
            "  - model: pinhole-radtan\n    resolution",
            ": cameras[0].model: found nothing, expected pinhole-radtan (also radtan, radial-tangential, \
             plumb_bob, opencv), rational_polynomial, kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none".to_string(),
        ),
        (
            "    intrinsics: [30.0, 31.0, 19.0, 9.5]\n",
            format!(": cameras[0].intrinsics: found nothing, expected {NUMBERS}"),
        ),
        (
            "    distortion: [-0.1, 0.01, 0.001, 0.002]\n",
            ": cameras[0].distortion: found nothing, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3), or 8 (also k4, k5, k6)"
                .to_string(),
        ),
    ] {
        let other = if piece.contains("model") { "  - resolution" } else { "" };
        assert_eq!(refused(piece, other), expected);
    }
    assert_eq!(
        refused("right_from_left:\n  - [1, 0, 0, -0.25]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n", ""),
        ": right_from_left: found nothing, expected 3 rows of 4 numbers (rotation and translation in meters: x_right = \
         R x_left + t)"
    );
    assert_eq!(
        open_with("fps: 3\n").unwrap_err(),
        ": cameras: found nothing, expected a list of one camera, or of the left and the right one"
    );
    assert_eq!(
        open_with("# nothing\n").unwrap_err(),
        ": found no data, expected the calibration of a camera"
    );
}

#[test]
fn wrong_fields_with_their_lines() {
    for (piece, other, expected) in [
        ("fps: 25", "fps: 0", ":1: fps: found 0, expected images per second, above 0"),
        (
            "model: pinhole-radtan",
            "model: omni",
            ":3: cameras[0].model: found `omni`, expected pinhole-radtan (also radtan, radial-tangential, \
             plumb_bob, opencv), rational_polynomial, kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none",
        ),
        (
            "model: pinhole-radtan",
            "model: none",
            ":6: cameras[0].distortion: found 4 numbers, expected nothing, since the model is none",
        ),
        (
            "[-0.1, 0.01, 0.001, 0.002]",
            "[0.1]",
            ":6: cameras[0].distortion: found 1 number, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3), or 8 (also k4, k5, k6)",
        ),
        (
            "[30.0, 31.0, 19.0, 9.5]",
            "[30.0, 0, 19.0, 9.5]",
            ":5: cameras[0].intrinsics: found [30, 0, 19, 9.5], expected 4 numbers (fx, fy, cx, cy in pixels)",
        ),
        (
            "  - [0, 0, 1, 0]\n",
            "",
            ":12: right_from_left: found 2 rows, expected 3 rows of 4 numbers (rotation and translation in meters: \
             x_right = R x_left + t)",
        ),
        (
            "  - [0, 0, 1, 0]\n",
            "  - [0, 0, 2, 0]\n",
            ":12: right_from_left: found a matrix that is 1.000 from a rigid motion, expected 3 rows of 4 numbers \
             (rotation and translation in meters: x_right = R x_left + t)",
        ),
        (
            "-0.25]",
            "0.25]",
            ": right_from_left: found the second camera 0.2500 m to the left of the first, expected it to the right",
        ),
    ] {
        assert_eq!(refused(piece, other), expected);
    }
    assert_eq!(
        refused("fps: 25", "rate: 25"),
        ":1: rate: found an unknown field, expected one of fps, cameras, right_from_left, depth_units_per_metre, baseline_m"
    );
    let one = calibration_yaml(1) + "right_from_left: [[1, 0, 0, 0]]\n";
    assert_eq!(
        open_with(&one).unwrap_err(),
        ":7: right_from_left: found 1 camera for a motion between two, expected it only with two cameras"
    );
}

#[test]
fn cameras_of_two_sizes() {
    let yaml = calibration_yaml(2);
    let (first, second) = yaml.split_at(yaml.rfind("resolution").unwrap());
    let other = format!("{first}{}", second.replacen("[40, 20]", "[80, 20]", 1));
    assert_eq!(open_with(&other).unwrap_err(), ": cameras[1].resolution: found 80x20, expected 40x20 as in ");
}

#[test]
fn the_file_of_an_euroc_camera_gives_one_camera() {
    let sequence = open_with(&sensor_yaml(0.5)).unwrap();
    assert_eq!((sequence.sensor, sequence.warnings.len()), (Sensor::Mono, 1));
    assert_eq!(sequence.calibration.unwrap().distortion.p2, 0.002);
    assert_eq!(sequence.body_from_left, geometry::SE3::identity(), "the body is the camera");
    assert_eq!(
        open_with(&sensor_yaml(0.5).replace("pinhole", "omni")).unwrap_err(),
        ":12: camera_model: found `omni`, expected pinhole"
    );
}

#[test]
fn the_xml_of_boofcv() {
    let sequence = open_with(BOOFCV).unwrap();
    assert_eq!(sequence.sensor, Sensor::Stereo);
    let raw = sequence.raw_calibration.unwrap();
    assert_eq!(raw.cameras[1].body_from_cam.translation, Vec3::new(0.25, 0.0, 0.0));
    let lens = |i: usize| match raw.cameras[i].model {
        CameraModel::Pinhole { distortion, .. } => distortion,
        CameraModel::KannalaBrandt(_) | CameraModel::Rational(_) => panic!("no fisheye"),
    };
    assert_eq!(lens(0), Distortion { k1: -0.1, k2: 0.01, ..Distortion::default() });
    assert!(lens(1).is_zero());
    assert!((sequence.calibration.unwrap().rig.baseline_m - 0.25).abs() < 1e-12);
}

#[test]
fn broken_xml_of_boofcv() {
    for (piece, other, expected) in [
        ("<cx>19</cx>", "<cx>wide</cx>", ":3: left.cx: found `wide`, expected a number"),
        ("<fx>30</fx>", "<fx>-30</fx>", ":5: left.fx: found `-30`, expected a focal length above 0 px"),
        ("<fx>30</fx>", "", ": left.fx: found nothing, expected a focal length above 0 px"),
        (
            "<width>40</width>",
            "<width>40.5</width>",
            ":13: left.width: found `40.5`, expected pixels, from 1 to 65535",
        ),
        ("<skew>0.0</skew>", "<skew>0.1</skew>", ":12: left.skew: found `0.1`, expected 0"),
        (
            "<double>1</double>\n<double>0</double>\n<double>0</double>\n",
            "",
            ":24: rightToLeft.r: found 6 numbers, expected 9 numbers (a rotation, row by row)",
        ),
        (
            "<double>1</double>\n<double>0</double>\n<double>0</double>\n",
            "<double>2</double>\n<double>0</double>\n<double>0</double>\n",
            ":24: rightToLeft.r: found a matrix that is 1.000 from a rigid motion, expected 9 numbers (a rotation, row by row)",
        ),
        ("StereoParameters>\n<left>", "Mono>\n<left>", ":"),
        (
            "<t><x>0.25</x>",
            "<t><x>-0.25</x>",
            ": rightToLeft: found the second camera 0.2500 m to the left of the first, expected it to the right",
        ),
    ] {
        assert!(BOOFCV.contains(piece), "{piece}");
        let message = open_with(&BOOFCV.replacen(piece, other, 1)).unwrap_err();
        if expected == ":" {
            assert!(message.contains("invalid XML"), "{message}");
        } else {
            assert_eq!(message, expected);
        }
    }
    let message = open_with("<opencv_storage/>").unwrap_err();
    assert!(
        message.starts_with(": found the fields opencv_storage, expected one of these calibrations: BoofCV"),
        "{message}"
    );
}
