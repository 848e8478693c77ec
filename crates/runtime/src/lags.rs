//! The section `runtime` of the configuration.

use serde::{Deserialize, Serialize};
use settings::{Entry, Section, integer};

/// How many frames later the work of the map is seen: the section `runtime` of the configuration. Without meaning for
/// `Live`, which sees everything as soon as it is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Lags {
    /// Frames after which tracking sees the finished mapping of a keyframe, at least 1; the keyframe itself is seen at once.
    pub lag: usize,
    /// Frames after which a loop found at a keyframe may be closed.
    pub loop_lag: usize,
}

impl Default for Lags {
    fn default() -> Self {
        Self { lag: 2, loop_lag: 10 }
    }
}

#[rustfmt::skip]
impl Section for Lags {
    const KEYS: &'static [Entry] = &[
        integer("runtime.lag", "frames", [1, 100], "tracking sees the finished mapping of a keyframe this many frames later; 1: at the next frame"),
        integer("runtime.loop_lag", "frames", [1, 1000], "a loop is closed this many frames after the keyframe that found it").expert(),
    ];
}
