//! The target of bags: ROS 1, rosbag2 in SQLite, MCAP; and small ones of each as seeds.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use dsslam::{Config, Input, InputOptions};

use bytes::{Bytes, field, record};

use super::files::in_folder;
use super::said;
use super::seeds::written;

/// What the tests of bags write with.
#[path = "../../crates/bag/tests/suite/bytes.rs"]
mod bytes;

/// Names by the first byte of an input.
const NAMES: [&str; 3] = ["drive.bag", "drive.db3", "drive.mcap"];

/// Opens a bag as a run does, and loads its first frames.
pub(super) fn bags(bytes: &[u8]) -> String {
    let (kind, bytes) = bytes.split_first().unwrap_or((&0, &[]));
    in_folder(|folder| {
        let path = folder.join(NAMES[usize::from(*kind) % NAMES.len()]);
        fs::write(&path, bytes).expect("an input is written");
        let with_poses = said(bag::Bag::open(&path, Some("/pose")));
        let options = InputOptions::default();
        let opened = match Input::open(&path, &Config::default(), &options) {
            Err(error) => error.to_string(),
            Ok(input) => {
                let feed = input.feed();
                let loaded = (0..feed.size_hint().unwrap_or(0).min(3)).map(|i| said(feed.load(i)));
                loaded.collect::<Vec<_>>().join("; ")
            }
        };
        format!("{with_poses}; {opened}")
    })
}

/// An image of 4 x 4 pixels.
fn image(is_cdr: bool, encoding: &str, bytes_per_pixel: usize) -> Vec<u8> {
    let mut of = Bytes::with_header(is_cdr, 1_000_000_500);
    let data: Vec<u8> = (0..16 * bytes_per_pixel).map(|i| (i * 7) as u8).collect();
    of.image((4, 4), encoding, &data);
    of.all
}

fn compressed(is_cdr: bool, jpeg: &[u8]) -> Vec<u8> {
    let mut of = Bytes::with_header(is_cdr, 1_000_000_500);
    of.text("mono8; jpeg compressed mono8");
    of.bytes(jpeg);
    of.all
}

fn camera_info(is_cdr: bool) -> Vec<u8> {
    let mut of = Bytes::with_header(is_cdr, 1_000_000_500);
    of.u32(4);
    of.u32(4);
    of.text("plumb_bob");
    of.u32(5);
    of.numbers(&[-0.1, 0.01, 0.0, 0.0, 0.0]);
    of.numbers(&[3.0, 0.0, 2.0, 0.0, 3.0, 2.0, 0.0, 0.0, 1.0]);
    of.numbers(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    of.numbers(&[3.0, 0.0, 2.0, 0.0, 0.0, 3.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    of.all
}

fn pose(is_cdr: bool) -> Vec<u8> {
    let mut of = Bytes::with_header(is_cdr, 1_000_000_500);
    of.numbers(&[1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]);
    of.all
}

/// Topic, type and bytes of messages.
type Messages = Vec<(&'static str, &'static str, Vec<u8>)>;

/// Bags of different topics in one form.
fn recordings(is_cdr: bool) -> [Messages; 3] {
    const IMAGE: &str = "sensor_msgs/msg/Image";
    let gray = geometry::GrayImage::from_fn(8, 8, |x, y| (x * 20 + y) as u8);
    let jpeg = io::preview(&gray, 8).map(|preview| preview.jpeg).unwrap_or_default();
    let info = ("/cam0/camera_info", "sensor_msgs/msg/CameraInfo", camera_info(is_cdr));
    let posed = ("/pose", "geometry_msgs/msg/PoseStamped", pose(is_cdr));
    [
        vec![
            ("/cam0/image_raw", IMAGE, image(is_cdr, "mono8", 1)),
            ("/cam1/image_raw", IMAGE, image(is_cdr, "bayer_rggb8", 1)),
            info.clone(),
            ("/cam1/camera_info", "sensor_msgs/msg/CameraInfo", camera_info(is_cdr)),
            posed.clone(),
        ],
        vec![
            ("/cam0/image_raw", IMAGE, image(is_cdr, "bgr8", 3)),
            ("/cam0/aligned_depth/image", IMAGE, image(is_cdr, "32FC1", 4)),
            info.clone(),
            posed.clone(),
        ],
        vec![("/cam0/compressed", "sensor_msgs/msg/CompressedImage", compressed(is_cdr, &jpeg)), info, posed],
    ]
}

/// A byte for the name, then a bag.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for messages in recordings(false) {
        all.push([&[0], &ros1(&messages)[..]].concat());
    }
    for messages in recordings(true) {
        all.push([&[1], &written("a.db3", |path| sqlite(path, &messages))[..]].concat());
        all.push([&[2], &mcap(&messages)[..]].concat());
    }
    all
}

/// One chunk, not packed, without an index.
fn ros1(messages: &Messages) -> Vec<u8> {
    let mut records = Vec::new();
    for (id, (topic, kind, bytes)) in (0_u32..).zip(messages) {
        let data = [field("topic", topic.as_bytes()), field("type", kind.replace("/msg", "").as_bytes())];
        let head = [field("op", &[7]), field("conn", &id.to_le_bytes()), field("topic", topic.as_bytes())];
        records.extend(record(&head, &data.concat()));
        let head =
            [field("op", &[2]), field("conn", &id.to_le_bytes()), field("time", &[1, 0, 0, 0, 0, 0, 0, 0])];
        records.extend(record(&head, bytes));
    }
    let mut file = b"#ROSBAG V2.0\n".to_vec();
    file.extend(record(&[field("op", &[3]), field("index_pos", &[0; 8])], &[b' '; 16]));
    let size = (records.len() as u32).to_le_bytes();
    file.extend(record(&[field("op", &[5]), field("compression", b"none"), field("size", &size)], &records));
    file
}

fn sqlite(path: &Path, messages: &Messages) {
    let file = rusqlite::Connection::open(path).expect("a database");
    let tables = "PRAGMA page_size = 512;
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);";
    file.execute_batch(tables).expect("tables");
    for (id, (topic, kind, bytes)) in (1_i64..).zip(messages) {
        file.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr')", (id, topic, kind)).expect("a row");
        file.execute("INSERT INTO messages VALUES (?1, ?1, 1000000505, ?2)", (id, bytes)).expect("a row");
    }
}

/// Without checksums, so that damage reaches what lies behind them.
fn mcap(messages: &Messages) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new()
        .compression(None)
        .profile("ros2")
        .calculate_chunk_crcs(false)
        .calculate_data_section_crc(false)
        .calculate_summary_section_crc(false);
    let mut writer = options.create(&mut file).expect("memory");
    for (sequence, (topic, kind, bytes)) in (0..).zip(messages) {
        let schema = writer.add_schema(kind, "ros2msg", b"").expect("memory");
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("memory");
        let time = 1_000_000_505;
        let header =
            mcap::records::MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, bytes).expect("memory");
    }
    writer.finish().expect("memory");
    drop(writer);
    file.into_inner()
}
