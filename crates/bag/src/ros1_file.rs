//! ROS 1 bags, version 2.0: records of named fields and data, messages in chunks. They are walked through, so that an unindexed bag is
//! read as well.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::BagError;
use crate::storage::{Pieces, Place, Seen, Storage, limited};
use crate::wire::Wire;

/// The first line.
pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

mod op {
    pub(super) const MESSAGE: u8 = 0x02;
    pub(super) const CHUNK: u8 = 0x05;
    pub(super) const CONNECTION: u8 = 0x07;
}

/// A connection: topic and type.
type Connection = (String, String);

pub(crate) struct Ros1File {
    pieces: Pieces,
    connections: BTreeMap<u32, Connection>,
}

/// The fields of a record's head.
type Fields<'a> = BTreeMap<&'a [u8], &'a [u8]>;

impl Ros1File {
    pub(crate) fn open(path: &Path) -> Result<Self, BagError> {
        Ok(Self { pieces: Pieces::open(path)?, connections: BTreeMap::new() })
    }

    fn learn(&mut self, head: &Fields<'_>, data: &[u8]) -> Result<(), String> {
        let id = number(head, b"conn")?;
        let data = fields(data)?;
        let text =
            |bytes: Option<&&[u8]>| String::from_utf8_lossy(bytes.copied().unwrap_or_default()).into_owned();
        self.connections.insert(id, (text(head.get(&b"topic"[..])), text(data.get(&b"type"[..]))));
        Ok(())
    }

    fn scan_chunk(&mut self, at: u64, visit: &mut dyn FnMut(Seen<'_>)) -> Result<(), BagError> {
        let records = self.pieces.chunk(at, unpack)?;
        self.walk(at, &records, visit).map_err(|reason| self.pieces.broken(at, reason))
    }

    fn walk(&mut self, at: u64, records: &[u8], visit: &mut dyn FnMut(Seen<'_>)) -> Result<(), String> {
        let mut here = 0;
        while here < records.len() {
            let (head, data_at) = sized(records, here)?;
            let (data, next) = sized(records, data_at)?;
            let head = fields(head)?;
            match head.get(&b"op"[..]).and_then(|code| code.first()).copied() {
                Some(op::CONNECTION) => self.learn(&head, data)?,
                Some(op::MESSAGE) => {
                    let id = number(&head, b"conn")?;
                    let Some((topic, type_name)) = self.connections.get(&id) else {
                        return Err(format!("a message of connection {id}, which has not been described"));
                    };
                    let log_ns = head.get(&b"time"[..]).map_or(0, |time| stamp(time));
                    let place = Place {
                        file: 0,
                        record: at,
                        offset: (data_at + 4) as u32,
                        length: data.len() as u32,
                    };
                    visit(Seen { topic, type_name, wire: Wire::Ros1, log_ns, place, data });
                }
                _ => {}
            }
            here = next;
        }
        Ok(())
    }
}

impl Storage for Ros1File {
    fn scan(&mut self, visit: &mut dyn FnMut(Seen<'_>)) -> Result<Option<String>, BagError> {
        let mut at = MAGIC.len() as u64;
        while at < self.pieces.length {
            let mut step = || -> Result<u64, BagError> {
                let (head, data, length) = record(&mut self.pieces, at)?;
                let broken = |reason| self.pieces.broken(at, reason);
                let code =
                    fields(&head).map_err(broken)?.get(&b"op"[..]).and_then(|code| code.first()).copied();
                match code {
                    Some(op::CHUNK) => self.scan_chunk(at, visit)?,
                    Some(op::CONNECTION) => {
                        let bytes = self.pieces.read(data, length)?;
                        let learned = fields(&head).and_then(|head| self.learn(&head, &bytes));
                        learned.map_err(|reason| self.pieces.broken(at, reason))?;
                    }
                    _ => {}
                }
                Ok(data.saturating_add(length))
            };
            match step() {
                Ok(next) => at = next,
                Err(error) => return error.ends_scan().map(Some),
            }
        }
        Ok(None)
    }

    fn read(&mut self, place: Place) -> Result<Vec<u8>, BagError> {
        let records = self.pieces.chunk(place.record, unpack)?;
        place.cut(&records).map_err(|reason| self.pieces.broken(place.record, reason))
    }
}

/// Head of the record at `at`, and place and length of its data.
fn record(pieces: &mut Pieces, at: u64) -> Result<(Vec<u8>, u64, u64), BagError> {
    let head_length = u64::from(u32_of(&pieces.read(at, 4)?));
    let head = pieces.read(at + 4, head_length)?;
    let data_length = u64::from(u32_of(&pieces.read(at + 4 + head_length, 4)?));
    Ok((head, at + 8 + head_length, data_length))
}

/// The records in the chunk at `at`.
fn unpack(pieces: &mut Pieces, at: u64) -> Result<Vec<u8>, BagError> {
    let (head, data, length) = record(pieces, at)?;
    let packed = pieces.read(data, length)?;
    let records = fields(&head).and_then(|fields| {
        let limit = fields.get(&b"size"[..]).map_or(u64::MAX, |size| u64::from(u32_of(size)));
        match fields.get(&b"compression"[..]).copied() {
            Some(b"none") => Ok(packed),
            Some(b"bz2") => limited(bzip2::read::BzDecoder::new(&packed[..]), limit),
            Some(b"lz4") => limited(lz4_flex::frame::FrameDecoder::new(&packed[..]), limit),
            other => {
                let found = String::from_utf8_lossy(other.unwrap_or_default()).into_owned();
                Err(format!("compression {found}, expected none, bz2 or lz4"))
            }
        }
    });
    records.map_err(|reason| pieces.broken(at, reason))
}

/// The first four bytes, which must be there unless the field is short: then 0.
fn u32_of(bytes: &[u8]) -> u32 {
    bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

/// A time of two numbers, nanoseconds.
fn stamp(bytes: &[u8]) -> i64 {
    i64::from(u32_of(bytes)) * 1_000_000_000 + i64::from(u32_of(bytes.get(4..).unwrap_or_default()))
}

fn number(head: &Fields<'_>, name: &[u8]) -> Result<u32, String> {
    let bytes = head.get(name).filter(|bytes| bytes.len() == 4);
    bytes
        .map(|bytes| u32_of(bytes))
        .ok_or_else(|| format!("no field {} of 4 bytes", String::from_utf8_lossy(name)))
}

/// Bytes with their length before them, and what comes after them.
fn sized(bytes: &[u8], at: usize) -> Result<(&[u8], usize), String> {
    let short = || format!("a record at {at} that leads beyond its chunk");
    let length = u32_of(bytes.get(at..at + 4).ok_or_else(short)?) as usize;
    let end = at + 4 + length;
    Ok((bytes.get(at + 4..end).ok_or_else(short)?, end))
}

/// Fields `name=value` with their lengths before them.
fn fields(bytes: &[u8]) -> Result<Fields<'_>, String> {
    let (mut all, mut at) = (Fields::new(), 0);
    while at < bytes.len() {
        let (field, next) = sized(bytes, at)?;
        let equals = field.iter().position(|byte| *byte == b'=').ok_or("a field without =")?;
        all.insert(&field[..equals], &field[equals + 1..]);
        at = next;
    }
    Ok(all)
}
