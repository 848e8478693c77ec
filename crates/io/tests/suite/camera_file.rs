//! Calibration files: the three formats, and the exact message for what is wrong in them.

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
            ": cameras[0].model: found nothing, expected pinhole-radtan, kannala-brandt or none".to_string(),
        ),
        (
            "    intrinsics: [30.0, 31.0, 19.0, 9.5]\n",
            format!(": cameras[0].intrinsics: found nothing, expected {NUMBERS}"),
        ),
        (
            "    distortion: [-0.1, 0.01, 0.001, 0.002]\n",
            ": cameras[0].distortion: found nothing, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3)"
                .to_string(),
        ),
    ] {
        let other = if piece.contains("model") { "  - resolution" } else { "" };
        assert_eq!(refused(piece, other), expected);
    }
    assert_eq!(
        refused("resolution: [40, 20]\n    intrinsics", "intrinsics"),
        ": cameras[0].resolution: found nothing, expected width and height in pixels, each from 1 to 65535"
    );
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
            ":3: cameras[0].model: found `omni`, expected pinhole-radtan, kannala-brandt or none",
        ),
        (
            "model: pinhole-radtan",
            "model: none",
            ":6: cameras[0].distortion: found 4 numbers, expected nothing, since the model is none",
        ),
        (
            "[-0.1, 0.01, 0.001, 0.002]",
            "[0.1]",
            ":6: cameras[0].distortion: found 1 number, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3)",
        ),
        (
            "[30.0, 31.0, 19.0, 9.5]",
            "[30.0, 0, 19.0, 9.5]",
            ":5: cameras[0].intrinsics: found [30.0, 0.0, 19.0, 9.5], expected 4 numbers (fx, fy, cx, cy in pixels)",
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
    let message = refused("fps: 25", "rate: 25");
    assert!(message.starts_with(":1: invalid YAML: ") && message.contains("rate"), "{message}");
    let one = calibration_yaml(1) + "right_from_left: [[1, 0, 0, 0]]\n";
    assert_eq!(
        open_with(&one).unwrap_err(),
        ":7: right_from_left: found 1 camera for a motion between two (line 3), expected it only with two cameras"
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
        CameraModel::KannalaBrandt(_) => panic!("no fisheye"),
    };
    assert_eq!(lens(0), Distortion { k1: -0.1, k2: 0.01, ..Distortion::default() });
    assert!(lens(1).is_zero());
    assert!((sequence.calibration.unwrap().rig.baseline_m - 0.25).abs() < 1e-12);
}

#[test]
fn broken_xml_of_boofcv() {
    for (piece, other, expected) in [
        ("<cx>19</cx>", "<cx>wide</cx>", ":3: found `wide` in <cx>, expected a number"),
        ("<fx>30</fx>", "<fx>-30</fx>", ":5: found fx -30, expected a focal length above 0 px"),
        ("<fx>30</fx>", "", ":2: found no <fx> in <left>, expected one"),
        (
            "<width>40</width>",
            "<width>40.5</width>",
            ":13: found width 40.5, expected pixels, from 1 to 65535",
        ),
        ("<skew>0.0</skew>", "<skew>0.1</skew>", ":12: found a skew, expected 0"),
        (
            "<double>1</double>\n<double>0</double>\n<double>0</double>\n",
            "",
            ":25: found 6 numbers, expected 9 numbers (a rotation, row by row)",
        ),
        (
            "<double>1</double>\n<double>0</double>\n<double>0</double>\n",
            "<double>2</double>\n<double>0</double>\n<double>0</double>\n",
            ":25: found a matrix that is 1.000 from a rotation, expected a rotation, row by row",
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
    assert_eq!(
        open_with("<opencv_storage/>").unwrap_err(),
        ":1: found <opencv_storage>, expected <boofcv.struct.calib.StereoParameters>"
    );
}
