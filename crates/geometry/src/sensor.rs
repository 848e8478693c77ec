//! Which images a frame has.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Which images a frame has. Its words are `stereo`, `rgbd` and `mono`, in files as well as on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Sensor {
    /// Left and right image, rectified.
    Stereo,
    /// An image with a registered depth image.
    Rgbd,
    /// One image: the map's unit of length is free.
    Mono,
}

/// A word that does not name a sensor.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found '{0}', expected {expected}", expected = Sensor::WORDS.join(", "))]
pub struct UnknownSensor(String);

impl Sensor {
    /// All sensors.
    pub const ALL: [Self; 3] = [Self::Stereo, Self::Rgbd, Self::Mono];
    /// Their words, in the same order.
    pub const WORDS: &[&str] = &["stereo", "rgbd", "mono"];

    /// Its word.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// Whether the map's unit of length is free, so that its scale can drift.
    pub fn is_scale_free(self) -> bool {
        self == Self::Mono
    }
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

impl FromStr for Sensor {
    type Err = UnknownSensor;

    fn from_str(text: &str) -> Result<Self, UnknownSensor> {
        Self::ALL.into_iter().find(|s| s.word() == text).ok_or_else(|| UnknownSensor(text.to_owned()))
    }
}

impl From<Sensor> for String {
    fn from(sensor: Sensor) -> String {
        sensor.word().to_owned()
    }
}

impl TryFrom<String> for Sensor {
    type Error = UnknownSensor;

    fn try_from(text: String) -> Result<Self, UnknownSensor> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_reads_back() {
        for sensor in Sensor::ALL {
            assert_eq!(sensor.to_string().parse(), Ok(sensor));
        }
        assert_eq!(Sensor::Rgbd.word(), "rgbd");
        let error = "lidar".parse::<Sensor>().unwrap_err().to_string();
        assert_eq!(error, "found 'lidar', expected stereo, rgbd, mono");
    }
}
