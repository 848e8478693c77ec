//! The container: records one after another, messages in chunks with an index behind each, a summary at the end.
//!
//! Format: <https://mcap.dev/spec>. The writer of the crate `mcap` lists types and channels of its summary in the order of a hash map, so
//! that equal runs would give other bytes; here all stands in the order in which it came. The file grows by whole chunks: one that is
//! cut off anywhere is readable up to its last chunk.

use std::collections::BTreeMap;
use std::io::{Error, ErrorKind, Result, Write};

use crc32fast::Hasher;

use super::cdr::Cdr;
use super::messages::Message;
use crate::mcap_file::MAGIC;

mod op {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const MESSAGE_INDEX: u8 = 0x07;
    pub(super) const CHUNK_INDEX: u8 = 0x08;
    pub(super) const STATISTICS: u8 = 0x0B;
    pub(super) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(super) const DATA_END: u8 = 0x0F;
}

/// A chunk ends when it holds this many bytes.
const CHUNK_BYTES: usize = 1 << 20;

/// Writes messages; what was flushed can be read whatever happens afterwards.
#[derive(Debug)]
pub struct McapWriter<W: Write> {
    target: W,
    /// Bytes written.
    at: u64,
    /// Checksum of all of them.
    crc: Hasher,
    schemas: Vec<Schema>,
    channels: Vec<Channel>,
    chunk: Chunk,
    chunks: Vec<ChunkIndex>,
}

#[derive(Debug)]
struct Schema {
    name: &'static str,
    record: Vec<u8>,
}

#[derive(Debug)]
struct Channel {
    topic: String,
    record: Vec<u8>,
    n_messages: u64,
}

/// What has not been written yet.
#[derive(Debug, Default)]
struct Chunk {
    records: Vec<u8>,
    /// First and last time.
    times: Option<(u64, u64)>,
    /// Times and offsets of the messages of each channel.
    index: BTreeMap<u16, Vec<(u64, u64)>>,
}

#[derive(Debug)]
struct ChunkIndex {
    times: (u64, u64),
    /// Where the chunk begins.
    at: u64,
    length: u64,
    /// Where the index of each channel lies, and how long all of them are.
    indices: Vec<(u16, u64)>,
    index_length: u64,
    /// Bytes of its records.
    size: u64,
}

/// A record's body.
#[derive(Default)]
struct Body(Vec<u8>);

impl Body {
    fn put(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }

    fn u16(self, value: u16) -> Self {
        self.put(&value.to_le_bytes())
    }

    fn u32(self, value: usize) -> Self {
        self.put(&(value as u32).to_le_bytes())
    }

    fn u64(self, value: u64) -> Self {
        self.put(&value.to_le_bytes())
    }

    fn text(self, text: &str) -> Self {
        self.u32(text.len()).put(text.as_bytes())
    }

    fn numbers(self, pairs: impl Iterator<Item = (u64, u64)>) -> Self {
        pairs.fold(self, |body, (a, b)| body.u64(a).u64(b))
    }

    /// The record with its code and length.
    fn record(self, code: u8) -> Vec<u8> {
        Body::default().put(&[code]).u64(self.0.len() as u64).put(&self.0).0
    }
}

impl<W: Write> McapWriter<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// What the target says.
    pub fn new(target: W) -> Result<Self> {
        let (chunk, schemas, channels, chunks) = (Chunk::default(), Vec::new(), Vec::new(), Vec::new());
        let mut writer = Self { target, at: 0, crc: Hasher::new(), schemas, channels, chunk, chunks };
        writer.put(MAGIC)?;
        let library = concat!("dsslam ", env!("CARGO_PKG_VERSION"));
        writer.put(&Body::default().text("ros2").text(library).record(op::HEADER))?;
        Ok(writer)
    }

    /// Adds a message. It is in the file after the next [`McapWriter::flush`], or when enough others have come.
    ///
    /// # Errors
    /// A time that ROS cannot hold (its seconds have 32 bits), and what the target says.
    pub fn write<M: Message>(&mut self, topic: &str, t_ns: i64, message: &M) -> Result<()> {
        if i32::try_from(t_ns.div_euclid(1_000_000_000)).is_err() {
            let reason =
                format!("{topic}: found the time {t_ns} ns, expected seconds of 32 bits, as ROS has");
            return Err(Error::new(ErrorKind::InvalidInput, reason));
        }
        let id = self.channel::<M>(topic);
        let mut to = Cdr::new();
        message.encode(&mut to);
        // Times before 1970 are in the message; the container has none.
        let log_ns = u64::try_from(t_ns).unwrap_or(0);
        let channel = &mut self.channels[usize::from(id) - 1];
        let sequence = channel.n_messages as usize;
        channel.n_messages += 1;
        let body = Body::default().u16(id).u32(sequence).u64(log_ns).u64(log_ns).put(&to.into_bytes());
        let chunk = &mut self.chunk;
        chunk.index.entry(id).or_default().push((log_ns, chunk.records.len() as u64));
        chunk.records.extend(body.record(op::MESSAGE));
        let (first, last) = chunk.times.unwrap_or((log_ns, log_ns));
        chunk.times = Some((first.min(log_ns), last.max(log_ns)));
        if chunk.records.len() >= CHUNK_BYTES { self.flush() } else { Ok(()) }
    }

    /// The number of a topic's channel, counted from 1; a new one is described first.
    fn channel<M: Message>(&mut self, topic: &str) -> u16 {
        if let Some(found) = self.channels.iter().position(|channel| channel.topic == topic) {
            return found as u16 + 1;
        }
        let definition = M::DEFINITION;
        let known = self.schemas.iter().position(|schema| schema.name == definition.name);
        let schema = known.unwrap_or_else(|| {
            let (name, id) = (definition.name, self.schemas.len() as u16 + 1);
            let body = Body::default().u16(id).text(name).text("ros2msg").text(&definition.text());
            self.schemas.push(Schema { name, record: body.record(op::SCHEMA) });
            self.chunk.records.extend(&self.schemas[usize::from(id) - 1].record);
            usize::from(id) - 1
        });
        let id = self.channels.len() as u16 + 1;
        // The profile asks for it; empty stands for the default.
        let metadata = Body::default().text("offered_qos_profiles").text("").0;
        let body = Body::default().u16(id).u16(schema as u16 + 1).text(topic).text("cdr");
        let record = body.u32(metadata.len()).put(&metadata).record(op::CHANNEL);
        self.chunk.records.extend(&record);
        self.channels.push(Channel { topic: topic.to_owned(), record, n_messages: 0 });
        id
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.target.write_all(bytes)?;
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Ends the chunk, so that everything up to here can be read.
    ///
    /// # Errors
    /// What the target says.
    pub fn flush(&mut self) -> Result<()> {
        let chunk = std::mem::take(&mut self.chunk);
        let Some(times) = chunk.times else { return Ok(()) };
        let (at, size) = (self.at, chunk.records.len() as u64);
        let body = Body::default().u64(times.0).u64(times.1).u64(size);
        let body = body.u32(crc32fast::hash(&chunk.records) as usize).text("").u64(size);
        self.put(&body.put(&chunk.records).record(op::CHUNK))?;
        let length = self.at - at;
        let mut indices = Vec::new();
        for (channel, messages) in chunk.index {
            indices.push((channel, self.at));
            let body = Body::default().u16(channel).u32(16 * messages.len());
            self.put(&body.numbers(messages.into_iter()).record(op::MESSAGE_INDEX))?;
        }
        let index_length = self.at - at - length;
        self.chunks.push(ChunkIndex { times, at, length, indices, index_length, size });
        self.target.flush()
    }

    /// Ends the file with its summary.
    ///
    /// # Errors
    /// What the target says.
    pub fn finish(mut self) -> Result<W> {
        self.flush()?;
        let crc = self.crc.clone().finalize();
        self.put(&Body::default().u32(crc as usize).record(op::DATA_END))?;
        let start = self.at;
        let groups = [
            (op::SCHEMA, self.schemas.iter().map(|schema| schema.record.clone()).collect()),
            (op::CHANNEL, self.channels.iter().map(|channel| channel.record.clone()).collect()),
            (op::STATISTICS, vec![self.statistics()]),
            (op::CHUNK_INDEX, self.chunks.iter().map(ChunkIndex::record).collect::<Vec<_>>()),
        ];
        self.crc = Hasher::new();
        let mut offsets = Vec::new();
        for (code, records) in groups.into_iter().filter(|(_, records)| !records.is_empty()) {
            let group = self.at;
            self.put(&records.concat())?;
            let body = Body::default().put(&[code]).u64(group).u64(self.at - group);
            offsets.extend(body.record(op::SUMMARY_OFFSET));
        }
        let offsets_at = self.at;
        self.put(&offsets)?;
        // The checksum covers the footer up to where it stands itself.
        let footer = Body::default().u64(start).u64(offsets_at).u32(0).record(op::FOOTER);
        self.put(&footer[..footer.len() - 4])?;
        let crc = self.crc.clone().finalize();
        self.put(&crc.to_le_bytes())?;
        self.put(MAGIC)?;
        self.target.flush()?;
        Ok(self.target)
    }

    fn statistics(&self) -> Vec<u8> {
        let n_messages = self.channels.iter().map(|channel| channel.n_messages).sum();
        let first = self.chunks.iter().map(|chunk| chunk.times.0).min().unwrap_or(0);
        let last = self.chunks.iter().map(|chunk| chunk.times.1).max().unwrap_or(0);
        let body = Body::default().u64(n_messages).u16(self.schemas.len() as u16).u32(self.channels.len());
        // Neither attachments nor metadata.
        let body = body.u32(0).u32(0).u32(self.chunks.len()).u64(first).u64(last);
        let counts = (1..)
            .zip(&self.channels)
            .fold(Body::default(), |counts, (id, channel)| counts.u16(id).u64(channel.n_messages));
        body.u32(counts.0.len()).put(&counts.0).record(op::STATISTICS)
    }
}

impl ChunkIndex {
    fn record(&self) -> Vec<u8> {
        let body = Body::default().u64(self.times.0).u64(self.times.1).u64(self.at).u64(self.length);
        let indices =
            self.indices.iter().fold(Body::default(), |body, (channel, at)| body.u16(*channel).u64(*at));
        let body = body.u32(indices.0.len()).put(&indices.0).u64(self.index_length);
        body.text("").u64(self.size).u64(self.size).record(op::CHUNK_INDEX)
    }
}
