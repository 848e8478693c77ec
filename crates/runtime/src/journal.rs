//! What happened in which order: enough to repeat a run bit for bit, whatever its threads did.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Version of the journal's form.
const VERSION: u32 = 1;

/// What tracking saw at each frame, and what mapping did in which order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Journal {
    version: u32,
    /// Tells setups apart; see [`JournalError::OtherSetup`].
    pub(crate) setup: u64,
    /// Bits of the disparity offset in force.
    pub(crate) disparity_offset: u64,
    /// By position of the frame in the feed.
    pub(crate) frames: Vec<Seen>,
    /// In the order in which the map went through them.
    pub(crate) operations: Vec<Operation>,
}

/// Outcome of a frame before tracking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Seen {
    /// Not looked at: tracking was behind.
    Skipped,
    /// The images could not be used.
    Unusable,
    /// Tracked in the map after this number of operations, and whether mapping was idle.
    After(usize, bool),
}

/// A step of the map. Numbers are positions of frames in the feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Operation {
    /// The statistics of a frame were added.
    Count(usize),
    /// A frame was inserted as a keyframe.
    Insert(usize),
    /// The slow work on the keyframe that a frame became.
    Refine(usize),
    /// The loop found at the keyframe that a frame became was closed.
    CloseLoop(usize),
    /// The global solution started by the loop of a frame was applied.
    Adopt(usize),
    /// That solution was discarded, since another loop was closed.
    Discard(usize),
    /// The calibration was looked at once more after the last frame.
    Settle,
}

/// Why a journal cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum JournalError {
    /// Not a journal at all, or damaged.
    #[error("not a journal: {0}")]
    Broken(String),
    /// Its form is of another version of the program.
    #[error("journal version {found} is not supported, expected version {VERSION}")]
    Version {
        /// The version that it claims.
        found: u64,
    },
    /// Configuration, camera, vocabulary or start map differ from those of the run that it describes.
    #[error("the journal was recorded with a different configuration, camera, vocabulary or start map")]
    OtherSetup,
    /// It describes more frames than there are.
    #[error("the journal covers at least {frames} frames, the sequence has {available}")]
    TooLong {
        /// Frames in the journal.
        frames: usize,
        /// Frames in the feed.
        available: usize,
    },
    /// It asks for a step that is not possible there.
    #[error("the journal does not match these frames: {0}")]
    DoesNotFit(String),
}

impl Journal {
    pub(crate) fn new(
        setup: u64,
        disparity_offset_px: f64,
        frames: Vec<Seen>,
        operations: Vec<Operation>,
    ) -> Self {
        Journal {
            version: VERSION,
            setup,
            disparity_offset: disparity_offset_px.to_bits(),
            frames,
            operations,
        }
    }

    /// Frames that it describes.
    pub fn n_frames(&self) -> usize {
        self.frames.len()
    }

    /// The disparity offset that was in force, pixels.
    pub fn disparity_offset_px(&self) -> f64 {
        f64::from_bits(self.disparity_offset)
    }

    /// The journal as JSON.
    pub fn to_json(&self) -> Vec<u8> {
        // A structure of numbers and names always has a JSON form.
        let mut bytes = serde_json::to_vec(self).unwrap_or_default();
        bytes.push(b'\n');
        bytes
    }

    /// Reads what [`Journal::to_json`] wrote.
    ///
    /// # Errors
    /// [`JournalError::Broken`] or [`JournalError::Version`].
    pub fn from_json(bytes: &[u8]) -> Result<Self, JournalError> {
        let broken = |error: serde_json::Error| JournalError::Broken(error.to_string());
        let tree: serde_json::Value = serde_json::from_slice(bytes).map_err(broken)?;
        match tree.get("version").and_then(serde_json::Value::as_u64) {
            None => Err(JournalError::Broken("the version is missing".into())),
            Some(found) if found != u64::from(VERSION) => Err(JournalError::Version { found }),
            Some(_) => serde_json::from_value(tree).map_err(broken),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal() -> Journal {
        let frames = vec![Seen::Unusable, Seen::After(0, true), Seen::Skipped, Seen::After(3, false)];
        let operations = vec![
            Operation::Count(1),
            Operation::Insert(1),
            Operation::Refine(1),
            Operation::CloseLoop(1),
            Operation::Adopt(1),
            Operation::Discard(1),
        ];
        Journal::new(u64::MAX, -0.1, frames, operations)
    }

    #[test]
    fn what_is_written_is_read_again() {
        let journal = journal();
        assert_eq!(Journal::from_json(&journal.to_json()), Ok(journal.clone()));
        assert_eq!(journal.disparity_offset_px(), -0.1);
    }

    #[test]
    fn broken_and_newer_journals_are_named() {
        let json = journal().to_json();
        let cut = Journal::from_json(&json[..json.len() / 2]).unwrap_err();
        assert!(cut.to_string().starts_with("not a journal: EOF while parsing"), "{cut}");
        let newer = String::from_utf8(json).unwrap().replace("\"version\":1", "\"version\":2");
        assert_eq!(Journal::from_json(newer.as_bytes()), Err(JournalError::Version { found: 2 }));
        assert_eq!(
            Journal::from_json(b"{}").unwrap_err().to_string(),
            "not a journal: the version is missing"
        );
    }
}
