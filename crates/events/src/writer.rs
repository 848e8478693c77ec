//! Writes a stream, whole records at a time.

use std::io::Write;

use crate::Record;
use crate::error::WriteError;
use crate::format::{MAGIC, VERSION, encode};

/// Writes records to a file or a pipe.
#[derive(Debug)]
pub struct StreamWriter<W> {
    target: W,
    n_bytes: u64,
}

impl<W: Write> StreamWriter<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// Those of the target.
    pub fn new(mut target: W) -> Result<Self, WriteError> {
        let header = [&MAGIC[..], &VERSION.to_le_bytes()].concat();
        target.write_all(&header)?;
        Ok(StreamWriter { target, n_bytes: header.len() as u64 })
    }

    /// Writes a record and hands it on at once, so that a reader of a pipe sees it.
    ///
    /// # Errors
    /// A record that cannot be encoded, or a target that fails: nothing more can then be written to it.
    pub fn write(&mut self, record: &Record) -> Result<(), WriteError> {
        let bytes = encode(record)?;
        self.target.write_all(&bytes)?;
        self.target.flush()?;
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }

    /// Bytes written so far.
    pub fn n_bytes(&self) -> u64 {
        self.n_bytes
    }
}
