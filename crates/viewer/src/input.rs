//! Where the stream comes from.

use std::fs::File;
use std::io::{BufReader, Read, stdin};
use std::path::Path;

use anyhow::{Context, Result};
use events::{FILE_NAME, StreamReader};

/// A stream from anywhere.
pub(crate) type Reader = StreamReader<Box<dyn Read>>;

/// Opens `-`, a file, or the file of events in a results folder.
///
/// # Errors
/// A file that is missing or is not a stream of this version.
pub(crate) fn open(input: &Path) -> Result<Reader> {
    if input == Path::new("-") {
        return StreamReader::new(Box::new(stdin()) as Box<dyn Read>).context("standard input");
    }
    let path = if input.is_dir() { input.join(FILE_NAME) } else { input.to_owned() };
    let file = File::open(&path)
        .with_context(|| format!("{}: cannot be read; `dsslam run --events` writes it", path.display()))?;
    StreamReader::new(Box::new(BufReader::new(file)) as Box<dyn Read>)
        .with_context(|| path.display().to_string())
}
