//! What is written is read by the crate `mcap`, and by the reader of bags; a file that is cut off anywhere is read as far as it goes.

use std::collections::BTreeMap;
use std::io::{Cursor, ErrorKind, Seek, SeekFrom, Write};

use dsslam_bag::Bag;
use dsslam_bag::out::{Cloud, CloudPoint, Header, McapWriter, Odometry, Path, Pose, Transform, Transforms};
use geometry::{Mat6, Vec3};
use mcap::{MessageStream, Summary};

const SECOND: i64 = 1_000_000_000;
/// More digits than a double of seconds holds.
const START: i64 = 1_403_636_579_763_555_584;

fn pose(i: usize) -> Pose {
    Pose { position: Vec3::new(i as f64 / 3.0, -1.5, 0.25), quaternion: [0.0, 0.6, 0.0, 0.8] }
}

fn header(i: usize, frame: &str) -> Header<'_> {
    Header { t_ns: START + i as i64 * SECOND / 10, frame }
}

/// Thirty frames of odometry and transforms, and a cloud at the end; flushed after every ten.
fn file() -> Vec<u8> {
    let mut writer = McapWriter::new(Cursor::new(Vec::new())).unwrap();
    for i in 0..30 {
        let odometry = Odometry {
            header: header(i, "odom"),
            child: "base_link",
            pose: pose(i),
            covariance: Mat6::from_fn(|row, column| (10 * row + column) as f64),
            linear: Vec3::new(1.0, 2.0, 3.0),
            angular: Vec3::zeros(),
            twist_covariance: Mat6::zeros(),
        };
        let link = Transform { header: header(i, "odom"), child: "base_link", pose: pose(i) };
        writer.write("/odometry", odometry.header.t_ns, &odometry).unwrap();
        writer.write("/tf", odometry.header.t_ns, &Transforms(vec![link])).unwrap();
        if i % 10 == 9 {
            writer.flush().unwrap();
        }
    }
    let point =
        CloudPoint { position: Vec3::x(), color: [1, 2, 3], activation: 0.5, trust: 0.25, observations: 4 };
    let cloud = Cloud { header: header(29, "map"), points: vec![point; 3] };
    writer.write("/map_points", cloud.header.t_ns, &cloud).unwrap();
    let path =
        Path { header: header(29, "map"), poses: (0..30).map(|i| (header(i, "").t_ns, pose(i))).collect() };
    writer.write("/path", path.header.t_ns, &path).unwrap();
    writer.finish().unwrap().into_inner()
}

#[test]
fn the_crate_mcap_reads_messages_and_summary() {
    let file = file();
    let messages: Vec<_> = MessageStream::new(&file).unwrap().map(|message| message.unwrap()).collect();
    assert_eq!(messages.len(), 62);
    let odometry: Vec<_> = messages.iter().filter(|message| message.channel.topic == "/odometry").collect();
    for (i, message) in odometry.iter().enumerate() {
        assert_eq!((message.sequence, message.log_time), (i as u32, header(i, "").t_ns as u64));
        assert_eq!(message.channel.message_encoding, "cdr");
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("nav_msgs/msg/Odometry", "ros2msg"));
    }
    let summary = Summary::read(&file).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    assert_eq!((statistics.message_count, statistics.channel_count, statistics.schema_count), (62, 4, 4));
    assert_eq!(summary.chunk_indexes.len(), 4, "three of ten frames and the rest");
    let counts: BTreeMap<&str, u64> = summary
        .channels
        .iter()
        .map(|(id, channel)| (channel.topic.as_str(), statistics.channel_message_counts[id]))
        .collect();
    assert_eq!(counts, BTreeMap::from([("/odometry", 30), ("/tf", 30), ("/map_points", 1), ("/path", 1)]));
    // Each index leads to its message, which is where the index of the chunk says.
    for chunk in &summary.chunk_indexes {
        let indexed = summary.read_message_indexes(&file, chunk).unwrap();
        for (channel, entries) in indexed {
            for entry in entries {
                let message = summary.seek_message(&file, chunk, &entry).unwrap();
                assert_eq!((message.channel.id, message.log_time), (channel.id, entry.log_time));
            }
        }
    }
}

#[test]
fn equal_messages_give_equal_bytes() {
    assert_eq!(file(), file());
}

#[test]
fn the_reader_of_bags_finds_the_poses_to_the_nanosecond() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.mcap");
    std::fs::write(&path, file()).unwrap();
    for topic in ["/odometry", "/tf"] {
        let bag = Bag::open(&path, Some(topic)).unwrap();
        assert!(bag.remarks().is_empty(), "{:?}", bag.remarks());
        let poses = &bag.poses().0;
        assert_eq!(poses.len(), 30);
        for (i, found) in poses.iter().enumerate() {
            assert_eq!(
                (found.t_ns, found.parent.as_str(), found.child.as_str()),
                (header(i, "").t_ns, "odom", "base_link")
            );
            assert_eq!(found.pose.translation, pose(i).position);
            let q = found.pose.rotation.to_quaternion();
            assert!((q.j - 0.6).abs() < 1e-12 && (q.w - 0.8).abs() < 1e-12, "{q}");
        }
    }
}

#[test]
fn a_file_that_is_cut_off_has_what_was_flushed() {
    let (folder, whole) = (tempfile::tempdir().unwrap(), file());
    let path = folder.path().join("cut.mcap");
    let mut last = 0;
    for length in (8..whole.len()).step_by(97) {
        std::fs::write(&path, &whole[..length]).unwrap();
        // Before the first chunk is whole the topic is not known.
        let n = match Bag::open(&path, Some("/odometry")) {
            Ok(bag) => bag.poses().0.len(),
            Err(error) => {
                assert!(error.to_string().contains("/odometry"), "{error}");
                0
            }
        };
        assert!(n.is_multiple_of(10) && n >= last, "{n} after {last} of {length} bytes");
        last = n;
    }
    assert_eq!(last, 30);
}

#[test]
fn a_chunk_that_has_changed_is_left_out_and_said() {
    let (folder, mut bytes) = (tempfile::tempdir().unwrap(), file());
    let path = folder.path().join("changed.mcap");
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let second = &summary.chunk_indexes[1];
    // A byte of a message, which no reader could tell without the checksum.
    let at = (second.chunk_start_offset + second.chunk_length) as usize - 20;
    bytes[at] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let bag = Bag::open(&path, Some("/odometry")).unwrap();
    assert_eq!(bag.poses().0.len(), 20);
    let [remark] = bag.remarks() else { panic!("{:?}", bag.remarks()) };
    assert!(remark.contains("1 damaged chunk is left out, the first: "), "{remark}");
    assert!(remark.contains("a chunk with checksum "), "{remark}");
}

#[test]
fn times_that_ros_cannot_hold_are_refused() {
    let mut writer = McapWriter::new(Cursor::new(Vec::new())).unwrap();
    let late = Path { header: Header { t_ns: i64::MAX, frame: "map" }, poses: Vec::new() };
    let error = writer.write("/path", late.header.t_ns, &late).unwrap_err();
    assert_eq!(
        error.to_string(),
        "/path: found the time 9223372036854775807 ns, expected seconds of 32 bits, as ROS has"
    );
    let early = Path { header: Header { t_ns: -1, frame: "map" }, poses: Vec::new() };
    writer.write("/path", early.header.t_ns, &early).unwrap();
    let file = writer.finish().unwrap().into_inner();
    let message = MessageStream::new(&file).unwrap().next().unwrap().unwrap();
    assert_eq!(message.log_time, 0);
    assert_eq!(
        message.data[4..12],
        [0xff, 0xff, 0xff, 0xff, 0xff, 0xc9, 0x9a, 0x3b],
        "-1 s and 999999999 ns"
    );
}

/// Takes a number of bytes and no more, as a disk that becomes full.
struct Full {
    taken: Cursor<Vec<u8>>,
    room: usize,
}

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let room = self.room - self.taken.get_ref().len();
        if room == 0 {
            return Err(ErrorKind::StorageFull.into());
        }
        self.taken.write(&bytes[..room.min(bytes.len())])
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.taken.seek(to)
    }
}

#[test]
fn a_disk_that_becomes_full_is_an_error_at_any_byte_and_every_time() {
    let path = Path { header: header(0, "map"), poses: vec![(0, pose(0)); 4] };
    let written = |room: usize| -> std::io::Result<usize> {
        let mut writer = McapWriter::new(Full { taken: Cursor::default(), room })?;
        for i in 0..3 {
            writer.write("/path", header(i, "").t_ns, &path)?;
            if let Err(error) = writer.flush() {
                let again = writer.write("/path", header(i, "").t_ns, &path).unwrap_err();
                assert_eq!(again.kind(), error.kind());
                assert_eq!(writer.finish().err().map(|error| error.kind()), Some(error.kind()));
                return Err(error);
            }
        }
        Ok(writer.finish()?.taken.into_inner().len())
    };
    let whole = written(1 << 20).unwrap();
    for room in (0..whole).step_by(7) {
        let error = written(room).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull, "{room} of {whole}");
    }
    assert_eq!(written(whole).unwrap(), whole);
}
