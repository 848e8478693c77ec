//! Map files: a map as bytes and back. Where the bytes go is the caller's matter, this module knows no paths.
//!
//! Stored are the facts; what follows from them (tables of keyframes, covisibility, children, descriptors and viewing
//! geometry of points, grids of frames) is computed when a file is read, bit for bit as it was, and the map that is
//! returned has passed [`Map::check`].
//!
//! Closed loops can still be taken back in a map that was read. What had been heard against them belongs to the run that heard it and
//! is not stored: in the next run two places must contradict a loop again.
//!
//! | bytes | content (numbers little-endian) |
//! |---|---|
//! | 8 | `DSMAP`, 0, CR, LF |
//! | 4 | format version |
//! | 4 | length of the description |
//! | 8 | length of the content as stored |
//! | 8 | length of the content unpacked |
//! | 8 | first bytes of the SHA-256 of all bytes before |
//! | | description: [`MapFileInfo`] as JSON, never packed |
//! | | content: postcard of the records of `content.rs`, packed by zstd |
//! | 32 | SHA-256 of all bytes before |
//!
//! This frame is the same in every version. A change of the records needs a new [`FORMAT_VERSION`]; a new field of the
//! description does not: it is read by name and has a default.

mod container;
mod content;
mod error;
mod frames;
mod info;
mod read;
mod write;

pub use container::FORMAT_VERSION;
pub use error::MapFileError;
pub use info::MapFileInfo;

use crate::Map;

/// The bytes of a map file.
///
/// The same map and description give the same bytes (with the same version of zstd).
pub fn encode(map: &Map, info: &MapFileInfo) -> Vec<u8> {
    container::seal(info, &write::content_of(map))
}

/// The map and the description of a map file. The map has the ids, the revision and everything else of the one that was
/// encoded, so that mutations go on as they would have.
///
/// # Errors
/// The bytes are not a map file, truncated, damaged, of another version, or hold an inconsistent map.
pub fn decode(bytes: &[u8]) -> Result<(Map, MapFileInfo), MapFileError> {
    let (info, content) = container::open(bytes)?;
    Ok((read::map_of(&content)?, info))
}
