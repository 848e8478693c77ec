//! The container: records one after another, messages in chunks with an index behind each, a summary at the end.
//!
//! Format: <https://mcap.dev/spec>. The crate `mcap` writes all but the summary: it would list types and channels there in the order of a
//! hash map, so that equal runs would give other bytes; here they stand in the order in which they came. The file grows by whole chunks:
//! one that is cut off anywhere is readable up to its last chunk.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{Cursor, Error, ErrorKind, Result, Seek, SeekFrom, Write};

use binrw::{BinResult, BinWrite};
use mcap::records::{Channel, Footer, MessageHeader, SchemaHeader, SummaryOffset, op};
use mcap::write::NoSeek;
use mcap::{McapError, Summary, WriteOptions, Writer};

use super::cdr::Cdr;
use super::held::{FirstError, Held};
use super::messages::Message;
use crate::mcap_file::MAGIC;

/// Bytes of the footer, with its code and length, and of the mark behind it.
const TAIL: i64 = 9 + 20 + MAGIC.len() as i64;

/// Writes messages; what was flushed can be read whatever happens afterwards.
pub struct McapWriter<W: Write + Seek> {
    writer: Writer<NoSeek<Held<W>>>,
    error: FirstError,
    /// Per topic its channel and the number of messages in it.
    channels: BTreeMap<String, (u16, u32)>,
}

impl<W: Write + Seek> McapWriter<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// What the target says.
    pub fn new(target: W) -> Result<Self> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("dsslam ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .disable_seeking(true)
            .emit_summary_records(false)
            .emit_summary_offsets(false);
        let error = FirstError::default();
        let target = NoSeek::new(Held::new(target, error.clone()));
        let writer = options.create(target).map_err(failed)?;
        error.check()?;
        Ok(Self { writer, error, channels: BTreeMap::new() })
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
        if !self.channels.contains_key(topic) {
            let id = self.describe::<M>(topic).map_err(failed)?;
            self.channels.insert(topic.to_owned(), (id, 0));
        }
        let (channel_id, n_messages) = &mut self.channels.entry(topic.to_owned()).or_default();
        // Times before 1970 are in the message; the container has none.
        let time = u64::try_from(t_ns).unwrap_or(0);
        let (channel_id, sequence) = (*channel_id, *n_messages);
        *n_messages += 1;
        let mut to = Cdr::new();
        message.encode(&mut to);
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, &to.into_bytes()).map_err(failed)?;
        self.error.check()
    }

    /// The number of a new channel.
    fn describe<M: Message>(&mut self, topic: &str) -> mcap::McapResult<u16> {
        let definition = M::DEFINITION;
        let schema = self.writer.add_schema(definition.name, "ros2msg", definition.text.as_bytes())?;
        // The profile asks for it; empty stands for the default.
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), String::new())]);
        self.writer.add_channel(schema, topic, "cdr", &metadata)
    }

    /// Ends the chunk, so that everything up to here can be read.
    ///
    /// # Errors
    /// What the target says.
    pub fn flush(&mut self) -> Result<()> {
        self.writer.flush().map_err(failed)?;
        self.error.check()
    }

    /// Ends the file with its summary.
    ///
    /// # Errors
    /// What the target says.
    pub fn finish(mut self) -> Result<W> {
        let summary = self.writer.finish().map_err(failed)?;
        self.error.check()?;
        let mut target = self.writer.into_inner().into_inner().into_target();
        let start = target.seek(SeekFrom::End(-TAIL))?;
        target.write_all(&summarized(&summary, start).map_err(Error::other)?)?;
        target.flush()?;
        Ok(target)
    }
}

impl<W: Write + Seek> fmt::Debug for McapWriter<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("McapWriter").field("channels", &self.channels).finish_non_exhaustive()
    }
}

fn failed(error: McapError) -> Error {
    match error {
        McapError::Io(error) => error,
        other => Error::other(other),
    }
}

/// The summary of a file whose data end at `start`, with everything behind it.
fn summarized(summary: &Summary, start: u64) -> BinResult<Vec<u8>> {
    let schemas: BTreeMap<_, _> = summary.schemas.iter().collect();
    let schemas = schemas.into_iter().map(|(&id, schema)| {
        let (name, encoding) = (schema.name.clone(), schema.encoding.clone());
        let header = body(&SchemaHeader { id, name, encoding })?;
        Ok([&header, &(schema.data.len() as u32).to_le_bytes()[..], &schema.data].concat())
    });
    let channels: BTreeMap<_, _> = summary.channels.iter().collect();
    let channels = channels.into_iter().map(|(&id, channel)| {
        body(&Channel {
            id,
            schema_id: channel.schema.as_ref().map_or(0, |schema| schema.id),
            topic: channel.topic.clone(),
            message_encoding: channel.message_encoding.clone(),
            metadata: channel.metadata.clone(),
        })
    });
    let groups: [(u8, BinResult<Vec<Vec<u8>>>); 4] = [
        (op::SCHEMA, schemas.collect()),
        (op::CHANNEL, channels.collect()),
        (op::STATISTICS, summary.stats.iter().map(body).collect()),
        (op::CHUNK_INDEX, summary.chunk_indexes.iter().map(body).collect()),
    ];
    let (mut bytes, mut offsets) = (Vec::new(), Vec::new());
    for (group_opcode, bodies) in groups {
        let group = bytes.len();
        bodies?.iter().for_each(|body| push(&mut bytes, group_opcode, body));
        let (group_start, group_length) = (start + group as u64, (bytes.len() - group) as u64);
        if group_length > 0 {
            let offset = body(&SummaryOffset { group_opcode, group_start, group_length })?;
            push(&mut offsets, op::SUMMARY_OFFSET, &offset);
        }
    }
    let summary_offset_start = start + bytes.len() as u64;
    bytes.extend(offsets);
    push(
        &mut bytes,
        op::FOOTER,
        &body(&Footer { summary_start: start, summary_offset_start, summary_crc: 0 })?,
    );
    // The checksum covers the footer up to where it stands itself.
    bytes.truncate(bytes.len() - size_of::<u32>());
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes.extend(MAGIC);
    Ok(bytes)
}

fn push(bytes: &mut Vec<u8>, code: u8, body: &[u8]) {
    bytes.push(code);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
}

fn body(record: &impl for<'a> BinWrite<Args<'a> = ()>) -> BinResult<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    record.write_le(&mut bytes)?;
    Ok(bytes.into_inner())
}
