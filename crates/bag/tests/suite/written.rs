//! Writers of small bags.

use std::collections::BTreeMap;
use std::path::Path;

use super::bytes::{Bytes, field, record};

/// A message before it is written: topic, type, time of recording, body after the header.
pub(super) struct Message {
    pub(super) topic: &'static str,
    pub(super) kind: &'static str,
    pub(super) t_ns: i64,
    pub(super) body: Body,
}

/// What messages hold after their header.
pub(super) enum Body {
    /// Width, height, encoding, bytes.
    Image(u32, u32, &'static str, Vec<u8>),
    /// Position and quaternion x, y, z, w.
    Pose([f64; 7]),
}

impl Message {
    pub(super) fn image(topic: &'static str, t_ns: i64, width: u32, height: u32, data: Vec<u8>) -> Self {
        let body = Body::Image(width, height, "mono8", data);
        Message { topic, kind: "sensor_msgs/msg/Image", t_ns, body }
    }

    pub(super) fn bytes(&self, is_cdr: bool) -> Vec<u8> {
        let mut of = Bytes::with_header(is_cdr, self.t_ns);
        match &self.body {
            Body::Image(width, height, encoding, data) => {
                of.image((*width as usize, *height as usize), encoding, data);
            }
            Body::Pose(numbers) => of.numbers(numbers),
        }
        of.all
    }
}

/// Topics in the order of their first messages.
fn topics(messages: &[Message]) -> Vec<(&'static str, &'static str)> {
    let mut all = Vec::new();
    for message in messages {
        if !all.contains(&(message.topic, message.kind)) {
            all.push((message.topic, message.kind));
        }
    }
    all
}

pub(super) fn mcap(path: &Path, messages: &[Message], compression: Option<mcap::Compression>) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let options = mcap::WriteOptions::new().compression(compression).chunk_size(Some(2000)).profile("ros2");
    let mut writer = options.create(file).unwrap();
    let mut channels = BTreeMap::new();
    for (topic, kind) in topics(messages) {
        let schema = writer.add_schema(kind, "ros2msg", b"").unwrap();
        channels.insert(topic, writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap());
    }
    for (sequence, message) in (0..).zip(messages) {
        let time = message.t_ns as u64 + 5;
        let channel_id = channels[message.topic];
        let header =
            mcap::records::MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &message.bytes(true)).unwrap();
    }
    writer.finish().unwrap();
}

pub(super) fn sqlite(path: &Path, messages: &[Message]) {
    let connection = rusqlite::Connection::open(path).unwrap();
    let tables = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL);
                  CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);";
    connection.execute_batch(tables).unwrap();
    let topics = topics(messages);
    for (id, (topic, kind)) in topics.iter().enumerate() {
        let row = (id as i64, topic, kind);
        connection.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr')", row).unwrap();
    }
    for message in messages {
        let id = topics.iter().position(|(topic, _)| *topic == message.topic).unwrap() as i64;
        let row = (id, message.t_ns + 5, message.bytes(true));
        connection
            .execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)", row)
            .unwrap();
    }
}

/// Packs a chunk: its name, and how.
pub(super) type Pack = (&'static str, fn(&[u8]) -> Vec<u8>);

pub(super) fn ros1(path: &Path, messages: &[Message], (compression, pack): Pack) {
    let mut file = b"#ROSBAG V2.0\n".to_vec();
    file.extend(record(&[field("op", &[3]), field("index_pos", &[0; 8])], &[b' '; 64]));
    let topics = topics(messages);
    for (start, some) in messages.chunks(3).enumerate() {
        let mut records = Vec::new();
        if start == 0 {
            for (id, (topic, kind)) in (0_u32..).zip(&topics) {
                let data =
                    [field("topic", topic.as_bytes()), field("type", kind.replace("/msg", "").as_bytes())];
                let head =
                    [field("op", &[7]), field("conn", &id.to_le_bytes()), field("topic", topic.as_bytes())];
                records.extend(record(&head, &data.concat()));
            }
        }
        for message in some {
            let id = topics.iter().position(|(topic, _)| *topic == message.topic).unwrap() as u32;
            let time = [(message.t_ns / 1_000_000_000) as u32, (message.t_ns % 1_000_000_000) as u32];
            let time = time.map(u32::to_le_bytes).concat();
            let head = [field("op", &[2]), field("conn", &id.to_le_bytes()), field("time", &time)];
            records.extend(record(&head, &message.bytes(false)));
        }
        let size = (records.len() as u32).to_le_bytes();
        let head = [field("op", &[5]), field("compression", compression.as_bytes()), field("size", &size)];
        file.extend(record(&head, &pack(&records)));
    }
    std::fs::write(path, file).unwrap();
}
