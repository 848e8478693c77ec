//! The same messages in every kind of bag.

use std::io::Write;

use dsslam_bag::{Bag, Kind, choose, is_bag};
use geometry::Sensor;

use super::written::{Body, Message, mcap, ros1, sqlite};

const SECOND: i64 = 1_000_000_000;

/// Ten pairs of images of two cameras, out of order within each pair, and poses.
pub(super) fn drive() -> Vec<Message> {
    let mut all = Vec::new();
    for i in 0..10 {
        let t_ns = 1_700_000_000 * SECOND + i * SECOND / 10;
        let pixels = |add: u8| (0..48).map(|p| p + add + i as u8).collect();
        all.push(Message::image("/cam1/image_raw", t_ns, 8, 6, pixels(100)));
        all.push(Message::image("/cam0/image_raw", t_ns, 8, 6, pixels(0)));
        let body = Body::Pose([i as f64, 0.5, -1.0, 0.0, 0.0, 0.0, 1.0]);
        all.push(Message { topic: "/truth", kind: "geometry_msgs/msg/PoseStamped", t_ns, body });
    }
    all
}

/// Everything that is read of the drive is right.
fn check(mut bag: Bag) {
    assert!(bag.remarks().is_empty(), "{:?}", bag.remarks());
    let choice = choose(bag.path(), bag.topics(), None).unwrap();
    assert_eq!(choice.sensor(), Sensor::Stereo);
    let topic = &bag.topics()[choice.left];
    assert_eq!((topic.name.as_str(), topic.kind, topic.count), ("/cam0/image_raw", Kind::Image, 10));
    assert_eq!((topic.encoding.as_deref(), topic.size), (Some("mono8"), Some((8, 6))));
    assert!((topic.rate_hz().unwrap() - 10.0).abs() < 1e-9);
    for (at, add) in [(choice.left, 0), (choice.right.unwrap(), 100)] {
        let stamps = bag.stamps(at).to_vec();
        assert_eq!(stamps.len(), 10);
        // Backwards, so that no order of reading is taken for granted.
        for (i, stamp) in stamps.iter().enumerate().rev() {
            assert_eq!(stamp.t_ns, 1_700_000_000 * SECOND + i as i64 * SECOND / 10);
            let image = bag.image(at, *stamp, false).unwrap().into_gray().unwrap();
            assert_eq!((image.width, image.height), (8, 6));
            let expected: Vec<u8> = (0..48).map(|p| p + add + i as u8).collect();
            assert_eq!(image.data, expected);
        }
    }
    let poses = &bag.poses().0;
    assert_eq!(poses.len(), 10);
    assert_eq!(poses[3].pose.translation.as_slice(), [3.0, 0.5, -1.0]);
}

#[test]
fn mcap_with_every_compression() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.mcap");
    mcap(&file, &drive(), None);
    assert!(is_bag(&file) && is_bag(folder.path()));
    check(Bag::open(&file, Some("/truth")).unwrap());
}

#[test]
fn ros_1_with_every_compression() {
    let folder = tempfile::tempdir().unwrap();
    let bz2 = |bytes: &[u8]| {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let lz4 = |bytes: &[u8]| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    for pack in [("none", <[u8]>::to_vec as fn(&[u8]) -> Vec<u8>), ("bz2", bz2), ("lz4", lz4)] {
        let file = folder.path().join(format!("{}.bag", pack.0));
        ros1(&file, &drive(), pack);
        check(Bag::open(&file, Some("/truth")).unwrap());
    }
}

#[test]
fn rosbag2_folders_of_sqlite_files_also_split_and_packed() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = drive();
    let second = first.split_off(12);
    sqlite(&folder.path().join("drive_0.db3"), &first);
    let plain = folder.path().join("drive_1.db3");
    sqlite(&plain, &second);
    check(Bag::open(folder.path(), Some("/truth")).unwrap());
    let metadata = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - drive_0.db3\n    - drive_1.db3.zstd\n  compression_format: zstd\n  compression_mode: FILE\n";
    std::fs::write(folder.path().join("metadata.yaml"), metadata).unwrap();
    let packed = zstd::encode_all(std::fs::File::open(&plain).unwrap(), 1).unwrap();
    std::fs::write(folder.path().join("drive_1.db3.zstd"), packed).unwrap();
    check(Bag::open(folder.path(), Some("/truth")).unwrap());
}
