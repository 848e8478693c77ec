//! The description of a map: what a person or a tool wants to know before using it.

use geometry::Sensor;
use serde::{Deserialize, Serialize};

/// Where a map comes from.
///
/// A new field needs nothing but its line here: it is stored by name, is empty when a file does not have it, and is
/// passed over by a program that does not know it. Only text and whole numbers keep their value to the last digit.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct MapFileInfo {
    /// Which images its frames had; absent in a file that does not say.
    #[serde(with = "empty_if_absent")]
    pub sensor: Option<Sensor>,
    /// Version of the program that made the map.
    pub program_version: String,
    /// Name of the sequence that was mapped.
    pub sequence: String,
    /// The configuration in force, as text.
    pub configuration: String,
    /// SHA-256 of the vocabulary in use, hexadecimal; empty if there was none.
    pub vocabulary_sha256: String,
    /// Pose of the left camera in the body that carries it (IMU): the upper 3x4 row by row, numbers with spaces between, meters.
    /// Empty where the camera is the body, and where the map has no scale.
    pub body_from_left: String,
    /// Times of frames in nanoseconds, in order: those of them whose time in seconds, which is what the frame keeps, does not tell.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stamps_ns: Vec<i64>,
}

/// A word, or an empty text.
mod empty_if_absent {
    use geometry::Sensor;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub(super) fn serialize<S: Serializer>(sensor: &Option<Sensor>, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(sensor.map_or("", Sensor::word))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Sensor>, D::Error> {
        let word = String::deserialize(from)?;
        if word.is_empty() { Ok(None) } else { word.parse().map(Some).map_err(D::Error::custom) }
    }
}
