//! The format: a header, then records until the end.
//!
//! | part | bytes |
//! |---|---|
//! | header | `DSEVENTS`, version as u32 |
//! | each record | length of the payload as u32, CRC-32 of the payload as u32, payload |
//! | payload | one byte of packing (0: none, 1: zstd), then the [`Record`] in postcard's format |
//!
//! All numbers are little-endian. A stream that ends within a record was cut off there; everything before is good.

use std::io::Read;

use crate::Record;
use crate::error::{ReadError, WriteError};

/// Name of the stream's file in a results folder.
pub const FILE_NAME: &str = "events.dslog";
/// Version of the format that this crate writes and reads.
pub const VERSION: u32 = 2;

/// What a stream begins with.
pub(crate) const MAGIC: [u8; 8] = *b"DSEVENTS";
/// Bytes of the header.
pub(crate) const HEADER: usize = MAGIC.len() + 4;
/// Bytes in front of each payload.
pub(crate) const PREFIX: usize = 8;
/// The longest payload, packed or not; a longer one is damage.
pub(crate) const MAX_PAYLOAD: usize = 256 << 20;

/// Payloads shorter than this are not worth packing.
const PACK_FROM: usize = 256;
/// Level of zstd: fast.
const PACK_LEVEL: i32 = 1;
const PLAIN: u8 = 0;
const PACKED: u8 = 1;

/// A record with its prefix.
pub(crate) fn encode(record: &Record) -> Result<Vec<u8>, WriteError> {
    let plain = postcard::to_allocvec(record)?;
    // JPEG files do not get smaller.
    let is_worth_packing = plain.len() >= PACK_FROM && !matches!(record, Record::Image(_));
    let (packing, body) =
        if is_worth_packing { (PACKED, zstd::bulk::compress(&plain, PACK_LEVEL)?) } else { (PLAIN, plain) };
    let length = body.len() + 1;
    let length_field =
        u32::try_from(length).ok().filter(|_| length <= MAX_PAYLOAD).ok_or(WriteError::TooLarge(length))?;
    let mut bytes = Vec::with_capacity(PREFIX + length);
    bytes.extend(length_field.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.push(packing);
    bytes.extend(body);
    let checksum = crc32fast::hash(&bytes[PREFIX..]);
    bytes[4..PREFIX].copy_from_slice(&checksum.to_le_bytes());
    Ok(bytes)
}

/// The record of a payload whose prefix began at byte `at`.
pub(crate) fn decode(payload: &[u8], checksum: u32, at: u64) -> Result<Record, ReadError> {
    let damaged = |what: String| ReadError::Damaged { at, what };
    let found = crc32fast::hash(payload);
    if found != checksum {
        return Err(damaged(format!("checksum {found:08x}, expected {checksum:08x}")));
    }
    let record = match payload.split_first() {
        Some((&PLAIN, body)) => postcard::from_bytes(body),
        Some((&PACKED, body)) => {
            let plain = unpack(body).map_err(|error| damaged(error.to_string()))?;
            postcard::from_bytes(&plain)
        }
        Some((packing, _)) => return Err(damaged(format!("unknown packing {packing}"))),
        None => return Err(damaged("an empty record".to_owned())),
    };
    record.map_err(|error| damaged(error.to_string()))
}

/// Unpacks a body, at most [`MAX_PAYLOAD`] bytes: anything longer is cut there and is then not a record.
fn unpack(body: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut plain = Vec::new();
    zstd::stream::Decoder::with_buffer(body)?.take(MAX_PAYLOAD as u64).read_to_end(&mut plain)?;
    Ok(plain)
}
