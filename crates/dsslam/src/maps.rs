//! The vocabulary of a run, and the files of maps.

use std::path::Path;
use std::sync::Arc;

use bow::Vocabulary;
use io::Sensor;
use map::{Map, MapFileInfo};
use sha2::{Digest, Sha256};

use crate::Error;

/// The vocabulary of a file, or the one that is part of the library.
///
/// # Errors
/// A file that is not a vocabulary.
pub fn vocabulary(file: Option<&Path>) -> Result<Arc<Vocabulary>, Error> {
    let vocabulary = match file {
        Some(file) => bow::tool::open(file)?,
        None => Vocabulary::built_in()?,
    };
    Ok(Arc::new(vocabulary))
}

/// Reads a map that was made with the same kind of camera.
///
/// # Errors
/// A file that is not a map, or the map of another sensor.
pub fn load_map(file: &Path, sensor: Sensor) -> Result<Map, Error> {
    open_map(file, sensor).map(|(map, _)| map)
}

/// As [`load_map`], with what else is in the file.
pub(crate) fn open_map(file: &Path, sensor: Sensor) -> Result<(Map, MapFileInfo), Error> {
    let bytes = io::read_file(file).map_err(|reason| Error::unreadable(file, &reason))?;
    let (map, info) =
        map::file::decode(&bytes).map_err(|problem| Error::Map { path: file.to_path_buf(), problem })?;
    if info.sensor != Some(sensor) {
        let found = info.sensor.map_or("unknown", Sensor::word).to_owned();
        return Err(Error::MapSensor { path: file.to_path_buf(), found, expected: sensor });
    }
    Ok((map, info))
}

/// Writes a map whole or not at all; returns the SHA-256 of its file, hexadecimal.
///
/// # Errors
/// A file that cannot be written; an older one is then untouched.
pub(crate) fn save_map(file: &Path, map: &Map, info: &MapFileInfo) -> Result<String, Error> {
    let bytes = map::file::encode(map, info);
    io::write_durable(file, &bytes)?;
    Ok(sha256(&bytes))
}

/// SHA-256 of bytes, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
