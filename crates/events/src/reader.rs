//! Reads a stream, live or from a file, also one that was cut off.

use std::io::Read;

use crate::Record;
use crate::error::ReadError;
use crate::format::{HEADER, MAGIC, MAX_PAYLOAD, PREFIX, VERSION, decode};

/// How a stream ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Between two records.
    Whole,
    /// Within a record: the writer was interrupted.
    CutOff,
}

/// Reads records one after another.
#[derive(Debug)]
pub struct StreamReader<R> {
    source: R,
    at: u64,
    ending: Option<Ending>,
}

impl<R: Read> StreamReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// A source that is not a stream, or has another version.
    pub fn new(mut source: R) -> Result<Self, ReadError> {
        let header = up_to(&mut source, HEADER)?;
        let version = header.strip_prefix(&MAGIC).filter(|version| version.len() == HEADER - MAGIC.len());
        let found = le_u32(version.ok_or(ReadError::NotAStream)?);
        if found != VERSION {
            return Err(ReadError::OtherVersion { found });
        }
        Ok(StreamReader { source, at: HEADER as u64, ending: None })
    }

    /// The next record, waiting for it where the source does; `None` at the end.
    ///
    /// # Errors
    /// Damage; what came before is good, what comes after cannot be found.
    pub fn next_record(&mut self) -> Result<Option<Record>, ReadError> {
        if self.ending.is_some() {
            return Ok(None);
        }
        let prefix = up_to(&mut self.source, PREFIX)?;
        if prefix.len() < PREFIX {
            self.ending = Some(if prefix.is_empty() { Ending::Whole } else { Ending::CutOff });
            return Ok(None);
        }
        let (length, checksum) = (le_u32(&prefix[..4]) as usize, le_u32(&prefix[4..]));
        if length == 0 || length > MAX_PAYLOAD {
            let what = format!("a record of {length} bytes, expected 1 to {MAX_PAYLOAD}");
            return Err(ReadError::Damaged { at: self.at, what });
        }
        let payload = up_to(&mut self.source, length)?;
        if payload.len() < length {
            self.ending = Some(Ending::CutOff);
            return Ok(None);
        }
        let record = decode(&payload, checksum, self.at)?;
        self.at += (PREFIX + length) as u64;
        Ok(Some(record))
    }

    /// How the stream ended; `None` before its end.
    pub fn ending(&self) -> Option<Ending> {
        self.ending
    }
}

/// That many bytes, fewer where the source ends before.
fn up_to(source: &mut impl Read, length: usize) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    source.take(length as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn le_u32(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
