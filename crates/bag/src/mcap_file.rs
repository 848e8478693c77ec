//! MCAP: records one after another, most of them in chunks. They are walked through, so that a file without its index is read as well.

use std::collections::BTreeMap;
use std::path::Path;

use mcap::parse_record;
use mcap::records::{Record, op};

use crate::error::BagError;
use crate::storage::{Pieces, Place, Seen, Storage, limited, plain, unzstd};
use crate::wire::Wire;

/// What the file begins and ends with.
pub(crate) const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// A record's code and length.
const HEAD: u64 = 9;

/// Channel number, log and publish time before a message's data: 2 + 4 + 8 + 8 bytes.
const MESSAGE_HEAD: usize = 22;

/// A channel: topic, type, how its messages are written.
struct Channel {
    topic: String,
    type_name: String,
    wire: Option<Wire>,
}

pub(crate) struct McapFile {
    pieces: Pieces,
    /// Whether each message is packed by itself.
    is_packed: bool,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    /// Chunks that are whole and damaged, and what is wrong with the first.
    damaged: (usize, Option<String>),
}

impl McapFile {
    pub(crate) fn open(path: &Path, is_packed: bool) -> Result<Self, BagError> {
        let pieces = Pieces::open(path)?;
        Ok(Self {
            pieces,
            is_packed,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            damaged: (0, None),
        })
    }

    /// A schema or a channel is remembered.
    fn learn(&mut self, code: u8, body: &[u8]) -> Result<(), String> {
        match parse_record(code, body).map_err(|error| error.to_string())? {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let type_name = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let wire = match channel.message_encoding.as_str() {
                    "cdr" => Some(Wire::Cdr),
                    "ros1" => Some(Wire::Ros1),
                    _ => None,
                };
                self.channels.insert(channel.id, Channel { topic: channel.topic, type_name, wire });
            }
            _ => {}
        }
        Ok(())
    }

    /// Visits a message whose record (without code and length) is `body`; it lies at `offset` of the record at `record`.
    fn visit(
        &self,
        record: u64,
        offset: usize,
        body: &[u8],
        visit: &mut dyn FnMut(Seen<'_>),
    ) -> Result<(), String> {
        let Some((head, data)) = body.split_at_checked(MESSAGE_HEAD) else {
            return Err(format!("a message of {} bytes", body.len()));
        };
        let channel = u16::from_le_bytes([head[0], head[1]]);
        let Some(Channel { topic, type_name, wire }) = self.channels.get(&channel) else {
            return Err(format!("a message of channel {channel}, which has not been described"));
        };
        let Some(wire) = *wire else { return Ok(()) };
        let log_ns =
            u64::from_le_bytes([head[6], head[7], head[8], head[9], head[10], head[11], head[12], head[13]]);
        let place =
            Place { file: 0, record, offset: (offset + MESSAGE_HEAD) as u32, length: data.len() as u32 };
        let log_ns = i64::try_from(log_ns).unwrap_or(i64::MAX);
        let data = &*plain(data, self.is_packed)?;
        visit(Seen { topic, type_name, wire, log_ns, place, data });
        Ok(())
    }

    fn scan_chunk(&mut self, at: u64, visit: &mut dyn FnMut(Seen<'_>)) -> Result<(), BagError> {
        let records = self.pieces.chunk(at, unpack)?;
        let mut here = 0;
        let mut walk = || -> Result<(), String> {
            while let Some(head) = records.get(here..here + HEAD as usize) {
                let body = here + HEAD as usize;
                let end = usize::try_from(length_of(head)).ok().and_then(|length| body.checked_add(length));
                let Some(bytes) = end.and_then(|end| records.get(body..end)) else {
                    return Err(format!("a record at {here} that leads beyond its chunk"));
                };
                match head[0] {
                    op::SCHEMA | op::CHANNEL => self.learn(head[0], bytes)?,
                    op::MESSAGE => self.visit(at, body, bytes, visit)?,
                    _ => {}
                }
                here = body + bytes.len();
            }
            Ok(())
        };
        walk().map_err(|reason| self.pieces.broken(at, reason))
    }

    /// As [`McapFile::scan_chunk`]; a chunk that is damaged is left out where the next one can be found behind it.
    fn scan_or_skip(&mut self, at: u64, end: u64, visit: &mut dyn FnMut(Seen<'_>)) -> Result<(), BagError> {
        match self.scan_chunk(at, visit) {
            Err(error @ BagError::Broken { .. }) if end < self.pieces.length => {
                self.damaged.0 += 1;
                self.damaged.1.get_or_insert_with(|| error.to_string());
                Ok(())
            }
            other => other,
        }
    }

    /// What is said at the end of a scan: where it ended early, and which chunks are left out.
    fn remark(&self, end: Option<String>) -> Option<String> {
        let (n, Some(first)) = &self.damaged else { return end };
        let chunks = if *n == 1 { "chunk is" } else { "chunks are" };
        let damaged = format!("{n} damaged {chunks} left out, the first: {first}");
        Some(end.map_or(damaged.clone(), |end| format!("{end}; {damaged}")))
    }

    /// Visits what the record at `at` holds; returns where the next one begins, `None` after the last.
    fn step(&mut self, at: u64, visit: &mut dyn FnMut(Seen<'_>)) -> Result<Option<u64>, BagError> {
        let head = self.pieces.read(at, HEAD)?;
        let (code, length) = (head[0], length_of(&head));
        match code {
            op::FOOTER => return Ok(None),
            op::CHUNK => self.scan_or_skip(at, at.saturating_add(HEAD).saturating_add(length), visit)?,
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                let body = self.pieces.read(at + HEAD, length)?;
                let done = match code {
                    op::MESSAGE => self.visit(at, HEAD as usize, &body, visit),
                    _ => self.learn(code, &body),
                };
                done.map_err(|reason| self.pieces.broken(at, reason))?;
            }
            _ => {}
        }
        Ok(Some(at.saturating_add(HEAD).saturating_add(length)))
    }
}

impl Storage for McapFile {
    fn scan(&mut self, visit: &mut dyn FnMut(Seen<'_>)) -> Result<Option<String>, BagError> {
        let mut at = MAGIC.len() as u64;
        loop {
            if at >= self.pieces.length {
                let end = format!("{}: ends without a footer: it was cut short", self.pieces.path.display());
                return Ok(self.remark(Some(end)));
            }
            match self.step(at, visit) {
                Ok(Some(next)) => at = next,
                Ok(None) => return Ok(self.remark(None)),
                Err(error) => return error.ends_scan().map(|end| self.remark(Some(end))),
            }
        }
    }

    fn read(&mut self, place: Place) -> Result<Vec<u8>, BagError> {
        let head = self.pieces.read(place.record, HEAD)?;
        let data = if head[0] == op::MESSAGE {
            Ok(self.pieces.read(place.record + u64::from(place.offset), u64::from(place.length))?)
        } else {
            place.cut(&self.pieces.chunk(place.record, unpack)?)
        };
        let data = data.and_then(|data| Ok(plain(&data, self.is_packed)?.into_owned()));
        data.map_err(|reason| self.pieces.broken(place.record, reason))
    }
}

/// Length of a record by its first nine bytes.
fn length_of(head: &[u8]) -> u64 {
    head[1..9].iter().rev().fold(0, |length, byte| length << 8 | u64::from(*byte))
}

/// The records in the chunk at `at`.
fn unpack(pieces: &mut Pieces, at: u64) -> Result<Vec<u8>, BagError> {
    let head = pieces.read(at, HEAD)?;
    let body = pieces.read(at + HEAD, length_of(&head))?;
    let records = if head[0] == op::CHUNK { records(&body) } else { Err("a chunk has moved".to_owned()) };
    records.map_err(|reason| pieces.broken(at, reason))
}

/// The records in a chunk.
fn records(body: &[u8]) -> Result<Vec<u8>, String> {
    let Record::Chunk { header, data } = parse_record(op::CHUNK, body).map_err(|error| error.to_string())?
    else {
        return Err("not a chunk".to_owned());
    };
    let limit = header.uncompressed_size;
    let records = match header.compression.as_str() {
        "" => Ok(data.into_owned()),
        "zstd" => unzstd(&data, limit),
        "lz4" => limited(lz4_flex::frame::FrameDecoder::new(&data[..]), limit),
        other => Err(format!("compression {other}, expected none, zstd or lz4")),
    }?;
    // Files without checksums have 0.
    let found = if header.uncompressed_crc == 0 { 0 } else { crc32fast::hash(&records) };
    if found == header.uncompressed_crc {
        Ok(records)
    } else {
        Err(format!("a chunk with checksum {found:08x}, expected {:08x}", header.uncompressed_crc))
    }
}
