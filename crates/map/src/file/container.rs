//! The frame of a map file: magic, version, lengths, checksums, compression.

use std::io::Read;

use sha2::{Digest, Sha256};

use super::{MapFileError, MapFileInfo};

/// The format version that is written.
pub const FORMAT_VERSION: u32 = 3;

/// The oldest one that is read. Its content ends before the loops.
const OLDEST_VERSION: u32 = 2;

/// The first bytes of every map file; the line end shows up transfers as text.
const MAGIC: [u8; 8] = *b"DSMAP\0\r\n";
/// Bytes of the header, its checksum included.
const HEADER: usize = 40;
/// Bytes of the header that its checksum covers.
const CHECKED: usize = 32;
/// Bytes of the checksum at the end.
const SEAL: usize = 32;
/// The strongest that zstd can pack: a block of 128 KiB in 4 bytes.
const MAX_RATIO: u64 = 32_768;
/// zstd's own default: nearly all of the gain in a tenth of the time.
const LEVEL: i32 = 3;

/// What the header says.
struct Header {
    version: u32,
    info_len: u64,
    stored_len: u64,
    content_len: u64,
}

/// Packs content and closes the file.
pub(super) fn seal(info: &MapFileInfo, content: &[u8]) -> Vec<u8> {
    let info = serde_json::to_vec(info).expect("text and numbers can be written as JSON");
    let stored = zstd::bulk::compress(content, LEVEL).expect("memory for the packed content");
    let header = Header {
        version: FORMAT_VERSION,
        info_len: info.len() as u64,
        stored_len: stored.len() as u64,
        content_len: content.len() as u64,
    };
    let mut file = Vec::with_capacity(HEADER + info.len() + stored.len() + SEAL);
    file.extend(header.to_bytes());
    file.extend(info);
    file.extend(stored);
    let seal = Sha256::digest(&file);
    file.extend(seal);
    file
}

/// The description and the unpacked content of an undamaged file.
pub(super) fn open(bytes: &[u8]) -> Result<(MapFileInfo, Vec<u8>), MapFileError> {
    let (header, body) = checked(bytes)?;
    let (info, stored) = body.split_at(header.info_len as usize);
    let mut content = unpack(stored, header.content_len)?;
    if header.version == OLDEST_VERSION {
        // No loops: a list of length 0.
        content.push(0);
    }
    Ok((parse_info(info)?, content))
}

/// The header and what lies between it and the seal; lengths and checksums are right.
fn checked(bytes: &[u8]) -> Result<(Header, &[u8]), MapFileError> {
    let header = Header::read(bytes)?;
    let found = bytes.len() as u64;
    let expected = [header.info_len, header.stored_len]
        .into_iter()
        .try_fold((HEADER + SEAL) as u64, u64::checked_add)
        .ok_or_else(|| MapFileError::malformed("lengths in the header beyond 64 bits"))?;
    if found < expected {
        return Err(MapFileError::Truncated { found, expected });
    }
    if found > expected {
        return Err(MapFileError::TooLong { found, expected });
    }
    let (sealed, seal) = bytes.split_at(bytes.len() - SEAL);
    compare("the file", &Sha256::digest(sealed), seal)?;
    Ok((header, &sealed[HEADER..]))
}

fn parse_info(json: &[u8]) -> Result<MapFileInfo, MapFileError> {
    serde_json::from_slice(json).map_err(|e| MapFileError::malformed(format!("description: {e}")))
}

/// Unpacks into at most the stated length, and never takes more memory than the packed bytes can fill.
fn unpack(stored: &[u8], content_len: u64) -> Result<Vec<u8>, MapFileError> {
    let failed = |e: std::io::Error| MapFileError::malformed(format!("content cannot be unpacked: {e}"));
    if content_len > MAX_RATIO * (stored.len() as u64 + 1) {
        let reason = format!("{} bytes cannot hold a content of {content_len}", stored.len());
        return Err(MapFileError::malformed(reason));
    }
    let mut content = Vec::new();
    let decoder = zstd::stream::read::Decoder::with_buffer(stored).map_err(failed)?;
    decoder.take(content_len + 1).read_to_end(&mut content).map_err(failed)?;
    if content.len() as u64 != content_len {
        let found = if content.len() as u64 > content_len { "longer" } else { "shorter" };
        return Err(MapFileError::malformed(format!(
            "content is {found} than the {content_len} bytes stated"
        )));
    }
    Ok(content)
}

impl Header {
    fn to_bytes(&self) -> [u8; HEADER] {
        let mut bytes = [0; HEADER];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..12].copy_from_slice(&self.version.to_le_bytes());
        let info_len = u32::try_from(self.info_len).expect("a description below 4 GiB");
        bytes[12..16].copy_from_slice(&info_len.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.stored_len.to_le_bytes());
        bytes[24..32].copy_from_slice(&self.content_len.to_le_bytes());
        let check = Sha256::digest(&bytes[..CHECKED]);
        bytes[CHECKED..].copy_from_slice(&check[..HEADER - CHECKED]);
        bytes
    }

    /// Reads and checks a header: the magic first, then its checksum, and only then the version.
    fn read(bytes: &[u8]) -> Result<Self, MapFileError> {
        let n_magic = bytes.len().min(MAGIC.len());
        if bytes.is_empty() || bytes[..n_magic] != MAGIC[..n_magic] {
            return Err(MapFileError::NotAMapFile { found: first_bytes(bytes) });
        }
        let Some(header) = bytes.first_chunk::<HEADER>() else {
            return Err(MapFileError::Truncated { found: bytes.len() as u64, expected: HEADER as u64 });
        };
        compare("the header", &Sha256::digest(&header[..CHECKED]), &header[CHECKED..])?;
        let number = |from: usize, to: usize| {
            header[from..to].iter().rev().fold(0, |sum, &byte| (sum << 8) | u64::from(byte))
        };
        let version = number(8, 12) as u32;
        if !(OLDEST_VERSION..=FORMAT_VERSION).contains(&version) {
            let (oldest, newest) = (OLDEST_VERSION, FORMAT_VERSION);
            return Err(MapFileError::Version { found: version, oldest, newest });
        }
        Ok(Header {
            version,
            info_len: number(12, 16),
            stored_len: number(16, 24),
            content_len: number(24, 32),
        })
    }
}

/// The stated checksum is the beginning of the computed one.
fn compare(part: &'static str, computed: &[u8], stated: &[u8]) -> Result<(), MapFileError> {
    if computed[..stated.len()] == *stated {
        return Ok(());
    }
    // Eight bytes with the first difference.
    let from = computed.iter().zip(stated).position(|(a, b)| a != b).unwrap_or(0).min(stated.len() - 8);
    let shown = |bytes: &[u8]| bytes[from..from + 8].iter().map(|b| format!("{b:02x}")).collect();
    Err(MapFileError::Checksum { part, found: shown(computed), expected: shown(stated) })
}

/// The beginning of foreign bytes, as text.
fn first_bytes(bytes: &[u8]) -> String {
    match bytes {
        [] => "the file is empty".to_owned(),
        _ => format!("it begins with `{}`", bytes[..bytes.len().min(8)].escape_ascii()),
    }
}
