//! What all kinds of bags have in common: messages in the order of the file, each with its topic.

use std::borrow::Cow;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::BagError;
use crate::wire::Wire;

/// Largest record that is read at once; a length above it is a broken one.
pub(crate) const MAX_RECORD: u64 = 512 << 20;

/// Where a message lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Which of the bag's files.
    pub(crate) file: u16,
    /// Start of the record that holds it, bytes; in SQLite its row.
    pub(crate) record: u64,
    /// Start of its data in the unpacked record.
    pub(crate) offset: u32,
    /// Length of its data.
    pub(crate) length: u32,
}

impl Place {
    /// The data in its unpacked record.
    ///
    /// # Errors
    /// A record that is shorter.
    pub(crate) fn cut(self, record: &[u8]) -> Result<Vec<u8>, String> {
        let from = self.offset as usize;
        Ok(record.get(from..from + self.length as usize).ok_or("a message has moved")?.to_vec())
    }
}

/// A message as a scan meets it.
pub(crate) struct Seen<'a> {
    pub(crate) topic: &'a str,
    pub(crate) type_name: &'a str,
    pub(crate) wire: Wire,
    /// Time of recording, nanoseconds.
    pub(crate) log_ns: i64,
    /// `file` is not set yet.
    pub(crate) place: Place,
    pub(crate) data: &'a [u8],
}

/// One file of a bag.
pub(crate) trait Storage: Send {
    /// Goes through all messages in the order of the file; returns what there is to say where it ends early.
    ///
    /// # Errors
    /// A file that cannot be read at all.
    fn scan(&mut self, visit: &mut dyn FnMut(Seen<'_>)) -> Result<Option<String>, BagError>;

    /// The data of a message.
    ///
    /// # Errors
    /// A file that has changed since the scan.
    fn read(&mut self, place: Place) -> Result<Vec<u8>, BagError>;
}

/// A file that is read in pieces at given places.
pub(crate) struct Pieces {
    pub(crate) path: PathBuf,
    file: File,
    pub(crate) length: u64,
    /// Place and records of the chunk read last.
    chunk: Option<(u64, Arc<Vec<u8>>)>,
}

impl Pieces {
    pub(crate) fn open(path: &Path) -> Result<Self, BagError> {
        let unreadable = |reason| BagError::Unreadable { path: path.to_path_buf(), reason };
        let file = File::open(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        Ok(Self { path: path.to_path_buf(), file, length, chunk: None })
    }

    /// `length` bytes from `at`.
    ///
    /// # Errors
    /// A file that ends before, or a length that no record has.
    pub(crate) fn read(&mut self, at: u64, length: u64) -> Result<Vec<u8>, BagError> {
        if length > MAX_RECORD {
            return Err(self.broken(at, format!("a record of {length} bytes, expected at most {MAX_RECORD}")));
        }
        if at.checked_add(length).is_none_or(|end| end > self.length) {
            return Err(self.broken(at, format!("the file ends within a record of {length} bytes")));
        }
        let mut bytes = vec![0; length as usize];
        let read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(&mut bytes));
        match read {
            Ok(()) => Ok(bytes),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                Err(self.broken(at, "the file ends".to_owned()))
            }
            Err(reason) => Err(BagError::Unreadable { path: self.path.clone(), reason }),
        }
    }

    /// The records in the chunk at `at`, which `unpack` reads unless it was the last one.
    ///
    /// # Errors
    /// Those of `unpack`.
    pub(crate) fn chunk(
        &mut self,
        at: u64,
        unpack: impl FnOnce(&mut Self, u64) -> Result<Vec<u8>, BagError>,
    ) -> Result<Arc<Vec<u8>>, BagError> {
        match &self.chunk {
            Some((place, records)) if *place == at => Ok(Arc::clone(records)),
            _ => {
                let records = Arc::new(unpack(self, at)?);
                self.chunk = Some((at, Arc::clone(&records)));
                Ok(records)
            }
        }
    }

    pub(crate) fn broken(&self, at: u64, reason: String) -> BagError {
        BagError::Broken { path: self.path.clone(), at, reason }
    }
}

/// Unpacks a zstd block of a known or bounded size.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn unzstd(bytes: &[u8], limit: u64) -> Result<Vec<u8>, String> {
    let decoder = zstd::Decoder::new(bytes).map_err(|error| error.to_string())?;
    limited(decoder, limit)
}

/// What a block packed by zstd begins with; no message does.
pub(crate) const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";

/// The data of a message, unpacked if each is packed by itself, which a file without its `metadata.yaml` does not tell.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn plain(data: &[u8], is_packed: bool) -> Result<Cow<'_, [u8]>, String> {
    let is_packed = is_packed || data.starts_with(ZSTD);
    if is_packed { unzstd(data, u64::MAX).map(Cow::Owned) } else { Ok(Cow::Borrowed(data)) }
}

/// Reads to the end, at most `limit` bytes.
///
/// # Errors
/// What is wrong, or more bytes.
pub(crate) fn limited(reader: impl Read, limit: u64) -> Result<Vec<u8>, String> {
    let limit = limit.min(MAX_RECORD);
    let mut bytes = Vec::new();
    reader.take(limit + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > limit {
        return Err(format!("it unpacks to more than {limit} bytes"));
    }
    Ok(bytes)
}
