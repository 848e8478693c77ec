//! Reads a stream, live or from a file, also one that was cut off.

use std::io::{ErrorKind, Read};

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
        let mut header = [0; HEADER];
        let n = fill(&mut source, &mut header)?;
        let (magic, version) = header.split_at(MAGIC.len());
        if n < HEADER || magic != MAGIC {
            return Err(ReadError::NotAStream);
        }
        let found = le_u32(version);
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
        let mut prefix = [0; PREFIX];
        let n = fill(&mut self.source, &mut prefix)?;
        if n < PREFIX {
            self.ending = Some(if n == 0 { Ending::Whole } else { Ending::CutOff });
            return Ok(None);
        }
        let (length, checksum) = (le_u32(&prefix[..4]) as usize, le_u32(&prefix[4..]));
        if length == 0 || length > MAX_PAYLOAD {
            let what = format!("a record of {length} bytes, expected 1 to {MAX_PAYLOAD}");
            return Err(ReadError::Damaged { at: self.at, what });
        }
        let mut payload = Vec::new();
        let n = (&mut self.source).take(length as u64).read_to_end(&mut payload)?;
        if n < length {
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

/// Reads until the buffer is full or the source ends; how many bytes there were.
fn fill(source: &mut impl Read, buffer: &mut [u8]) -> Result<usize, ReadError> {
    let mut n = 0;
    while n < buffer.len() {
        match source.read(&mut buffer[n..]) {
            Ok(0) => break,
            Ok(more) => n += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(n)
}

fn le_u32(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
