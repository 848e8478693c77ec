//! Text files as editors leave them, and paths that are not files.

use dsslam_io::{Sensor, load_gray, open_sequence, read_calibration};

use super::support::{Folder, P0, P1};

#[test]
fn marks_line_ends_and_encodings_of_other_systems() {
    let list = "# color\n1.000 rgb/a.png\n1.100 rgb/b.png\n1.200 rgb/c.png\n";
    let utf16: Vec<u8> =
        std::iter::once(0xfeff).chain(list.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for (name, bytes) in [
        ("byte order mark", [b"\xef\xbb\xbf", list.as_bytes()].concat()),
        ("byte order mark before a number", [b"\xef\xbb\xbf", &list.as_bytes()[8..]].concat()),
        ("CRLF", list.replace('\n', "\r\n").into_bytes()),
        ("CR", list.replace('\n', "\r").into_bytes()),
        ("UTF-16", utf16),
        ("Latin-1 in a comment", [b"# gemessen von M\xfcller\n", &list.as_bytes()[8..]].concat()),
    ] {
        let folder = Folder::tum();
        folder.write("rgb.txt", bytes);
        let sequence = open_sequence(folder.path(), None).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(sequence.frames.len(), 3, "{name}");
    }
    let folder = Folder::kitti(2);
    folder.write("times.txt", b"\xef\xbb\xbf0\r\n0.1\r\n");
    folder.write("calib.txt", format!("\u{feff}{P0}\r\n{P1}\r\n"));
    assert_eq!(open_sequence(folder.path(), None).unwrap().sensor, Sensor::Stereo);
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_circular_links_are_refused_at_once() {
    let folder = Folder::new();
    let pipe = folder.file("pipe.png");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let expected = "DIR/pipe.png: cannot be read: it is a pipe or a device, expected a file";
    assert_eq!(folder.hide(load_gray(&pipe).unwrap_err()), expected);
    assert_eq!(folder.hide(dsslam_io::image_size(&pipe).unwrap_err()), expected);
    assert_eq!(folder.hide(read_calibration(&pipe).unwrap_err()), expected);
    let error = read_calibration("/dev/zero".as_ref()).unwrap_err().to_string();
    assert_eq!(error, "/dev/zero: cannot be read: it is a pipe or a device, expected a file");
    let error = folder.hide(read_calibration(folder.path()).unwrap_err());
    let expected = "DIR: found a folder without a calibration, expected one of these calibrations: a file, or a folder with cam0/sensor.yaml and cam1/sensor.yaml";
    assert_eq!(error, expected);
    std::os::unix::fs::symlink(folder.file("b"), folder.file("a")).unwrap();
    std::os::unix::fs::symlink(folder.file("a"), folder.file("b")).unwrap();
    assert!(read_calibration(&folder.file("a")).unwrap_err().to_string().contains("ymbolic link"));
}
