//! What can be wrong with a stream.

use std::io;

use thiserror::Error;

use crate::VERSION;

/// Why a stream cannot be read, or not any further.
#[derive(Debug, Error)]
pub enum ReadError {
    /// It does not begin like an event stream.
    #[error("not an event stream: it does not begin with DSEVENTS")]
    NotAStream,
    /// It was written by another version of the program.
    #[error(
        "the event stream has version {found}, this program reads version {VERSION}: use the program that wrote it"
    )]
    OtherVersion {
        /// Its version.
        found: u32,
    },
    /// A record is not what it was when it was written.
    #[error("the event stream is damaged at byte {at}: {what}")]
    Damaged {
        /// Where the record begins.
        at: u64,
        /// What is wrong with it.
        what: String,
    },
    /// The source fails.
    #[error("the event stream cannot be read: {0}")]
    Io(#[from] io::Error),
}

/// Why a record cannot be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// It cannot be put into bytes.
    #[error("a record cannot be encoded: {0}")]
    Encode(#[from] postcard::Error),
    /// It is too large.
    #[error("a record has {0} bytes, which is too many")]
    TooLarge(usize),
    /// The target fails.
    #[error("the event stream cannot be written: {0}")]
    Io(#[from] io::Error),
}
