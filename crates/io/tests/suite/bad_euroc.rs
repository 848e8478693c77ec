//! Broken EuRoC folders: the exact message.

use dsslam_io::{Sensor, open_sequence};

use super::support::{Folder, euroc_stamp, sensor_yaml};

/// The message of opening `folder`, its path written as `DIR`.
fn refused(folder: &Folder) -> String {
    folder.hide(open_sequence(folder.path(), None).unwrap_err())
}

/// The message when a file has this content.
fn refused_with(name: &str, content: impl AsRef<[u8]>) -> String {
    let folder = Folder::euroc(3);
    folder.write(name, content);
    refused(&folder)
}

/// The message when one piece of the right camera's `sensor.yaml` is another one.
fn refused_sensor(piece: &str, other: &str) -> String {
    let yaml = sensor_yaml(0.25);
    assert!(yaml.contains(piece), "{yaml}");
    let message = refused_with("mav0/cam1/sensor.yaml", yaml.replace(piece, other));
    message.strip_prefix("DIR/mav0/cam1/sensor.yaml").map_or(message.clone(), str::to_string)
}

#[test]
fn a_camera_without_distortion_model() {
    assert_eq!(
        refused_sensor("distortion_model: radial-tangential\n", ""),
        ": distortion_model: found nothing, expected pinhole-radtan (also radtan, radial-tangential, \
             plumb_bob, opencv), rational_polynomial, kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none"
    );
}

#[test]
fn missing_fields() {
    for (field, rest) in [
        ("camera_model: pinhole\n", ": camera_model: found nothing, expected pinhole"),
        (
            "intrinsics: [30.0, 31.0, 19.0, 9.5] #fu, fv, cu, cv\n",
            ": intrinsics: found nothing, expected 4 numbers (fu, fv, cu, cv in pixels)",
        ),
        (
            "resolution: [40, 20]\n",
            ": resolution: found nothing, expected width and height in pixels, each from 1 to 65535",
        ),
        (
            "distortion_coefficients: [-0.1, 0.01, 0.001, 0.002]\n",
            ": distortion_coefficients: found nothing, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3), or 8 (also k4, k5, k6)",
        ),
    ] {
        assert_eq!(refused_sensor(field, ""), rest);
    }
    let no_pose = sensor_yaml(0.25).replace("T_BS", "T_SB");
    assert_eq!(
        refused_with("mav0/cam1/sensor.yaml", no_pose),
        "DIR/mav0/cam1/sensor.yaml: T_BS: found nothing, expected 16 numbers (a rigid motion as a 4x4 matrix, row by row)"
    );
}

#[test]
fn wrong_fields_with_their_lines() {
    for (piece, other, rest) in [
        (
            "distortion_model: radial-tangential",
            "distortion_model: fov",
            ":14: distortion_model: found `fov`, expected pinhole-radtan (also radtan, radial-tangential, \
             plumb_bob, opencv), rational_polynomial, kannala-brandt (also equidistant, fisheye, opencv_fisheye) or none",
        ),
        ("camera_model: pinhole", "camera_model: omni", ":12: camera_model: found `omni`, expected pinhole"),
        (
            "[30.0, 31.0, 19.0, 9.5]",
            "[30.0, 31.0, 19.0]",
            ":13: intrinsics: found 3 numbers, expected 4 numbers (fu, fv, cu, cv in pixels)",
        ),
        (
            "[30.0, 31.0, 19.0, 9.5]",
            "[-30.0, 31.0, 19.0, 9.5]",
            ":13: intrinsics: found [-30, 31, 19, 9.5], expected 4 numbers (fu, fv, cu, cv in pixels)",
        ),
        (
            "[-0.1, 0.01, 0.001, 0.002]",
            "[-0.1, 0.01]",
            ":15: distortion_coefficients: found 2 numbers, expected 4 or 5 finite numbers (k1, k2, p1, p2, k3), or 8 (also k4, k5, k6)",
        ),
        (
            "resolution: [40, 20]",
            "resolution: [40, 0]",
            ":11: resolution: found [40, 0], expected width and height in pixels, each from 1 to 65535",
        ),
        (
            "0.0, 1.0, 0.0, 0.5",
            "0.0, 2.0, 0.0, 0.5",
            ":4: T_BS: found a matrix that is 1.000 from a rigid motion, expected 16 numbers (a rigid motion as a \
             4x4 matrix, row by row)",
        ),
        (
            ",\n         0.0, 0.0, 0.0, 1.0]",
            ", 1.0]",
            ":4: T_BS: found 13 numbers, expected 16 numbers (a rigid motion as a 4x4 matrix, \
             row by row)",
        ),
    ] {
        assert_eq!(refused_sensor(piece, other), rest);
    }
}

#[test]
fn a_calibration_that_is_no_yaml() {
    let message = refused_sensor("resolution: [40, 20]", "resolution: [40, 20");
    assert!(message.starts_with(":12: invalid YAML: "), "{message}");
    assert_eq!(
        refused_sensor("resolution: [40, 20]", "resolution: wide"),
        ":11: resolution: found `wide`, expected width and height in pixels, each from 1 to 65535"
    );
}

#[test]
fn cameras_that_cannot_be_a_stereo_rig() {
    let rig = |x_m: f64| refused_with("mav0/cam1/sensor.yaml", sensor_yaml(x_m));
    assert_eq!(
        rig(0.0),
        "DIR/mav0/cam1/sensor.yaml: T_BS: found no baseline between the two cameras, expected one above 0 m"
    );
    assert_eq!(
        rig(-0.25),
        "DIR/mav0/cam1/sensor.yaml: T_BS: found the second camera 0.2500 m to the left of the first, expected it to \
         the right"
    );
    assert_eq!(
        refused_sensor("resolution: [40, 20]", "resolution: [80, 20]").replace("DIR/mav0", ""),
        ": resolution: found 80x20, expected 40x20 as in /cam0/sensor.yaml"
    );
}

#[test]
fn only_one_calibration_file() {
    let folder = Folder::euroc(2);
    folder.remove("mav0/cam1/sensor.yaml");
    assert_eq!(
        refused(&folder),
        "DIR/mav0/cam1/sensor.yaml: no such file, expected the calibration of a camera"
    );
}

#[test]
fn a_right_camera_with_other_times() {
    let folder = Folder::euroc(2);
    let stamps = [euroc_stamp(0) + 25_000_000, euroc_stamp(1) + 2_500_000];
    folder.write("mav0/cam1/data.csv", stamps.map(|stamp| format!("{stamp},a.png\n")).concat());
    folder.gray("mav0/cam1/data/a.png", 40, 20);
    assert_eq!(
        refused(&folder),
        "DIR/mav0/cam1/data.csv: found no time of an image of cam0: DIR/mav0/cam0/data.csv has times \
         1403636589763555584 to 1403636589813555584, DIR/mav0/cam1/data.csv has times 1403636589788555584 to \
         1403636589816055584, the nearest two are 2.500 ms apart, expected one within 1 ms"
    );
}

#[test]
fn lists_with_broken_rows() {
    let list =
        |content: &str| refused_with("mav0/cam0/data.csv", content).replace("DIR/mav0/cam0/data.csv", "");
    let expected = "expected nanoseconds and a file name, separated by a comma";
    assert_eq!(list("#header\n"), format!(": found no data, {expected}"));
    assert_eq!(list("#header\n123\n"), format!(":2: found 1 field, {expected}"));
    assert_eq!(list("123,\n"), format!(":1: found no file name, {expected}"));
    assert_eq!(list("1.5,a.png\n"), ":1: found `1.5`, expected whole nanoseconds");
    assert_eq!(
        list("6,a.png\n5,b.png\n"),
        ":2: found time 0.000000005 after 0.000000006 of the previous entry, expected strictly increasing times"
    );
}

#[test]
fn a_list_that_names_missing_files_only() {
    let name = "DIR/mav0/cam0/data/a.png";
    assert_eq!(
        refused_with("mav0/cam0/data.csv", format!("{},a.png\n", euroc_stamp(0))),
        format!(
            "DIR/mav0/cam0/data.csv:1: found the name of a missing file ({name}), expected the name of an image in the \
             folder data"
        )
    );
}

#[test]
fn missing_list_and_sensors_that_are_not_there() {
    let folder = Folder::euroc(2);
    let refused = |sensor| folder.hide(open_sequence(folder.path(), Some(sensor)).unwrap_err());
    assert_eq!(
        refused(Sensor::Rgbd),
        "DIR: sensor rgbd is not possible here: EuRoC folders contain no depth images"
    );
    std::fs::remove_dir_all(folder.file("mav0/cam1")).unwrap();
    assert_eq!(
        refused(Sensor::Stereo),
        "DIR: sensor stereo is not possible here: found no folder DIR/mav0/cam1"
    );
}
