//! Where frames come from: a dataset on disk, a renderer, a test.

use std::sync::Arc;

use features::FeatureMask;
use io::{FrameSource, LoadedFrame, Sequence, load_frame};

use crate::prepare::Preparation;
use crate::record::Unusable;

/// What is known of a frame before it is loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInfo {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
}

impl FrameInfo {
    /// The `i`-th frame.
    pub fn new(i: usize, timestamp_s: f64) -> Self {
        Self { index: u32::try_from(i).unwrap_or(u32::MAX), timestamp_s }
    }
}

/// Where features may be taken in a frame; `None`: everywhere.
pub type FrameMask = Option<Arc<FeatureMask>>;

/// A source of frames. Loading happens on a thread of its own, ahead of tracking.
pub trait FrameFeed: Sync {
    /// Number of frames; `None` if that is not known before the last has come, or if they never end. A feed that may end earlier
    /// than it says tells so by [`FrameFeed::ends_before`].
    fn size_hint(&self) -> Option<usize>;
    /// Whether there is no `i`-th frame, although [`FrameFeed::size_hint`] allows for it. Asked, for one frame after another, before
    /// it is loaded; waits until that is known.
    fn ends_before(&self, _i: usize) -> bool {
        false
    }
    /// Whether a frame that is there is due, whatever its timestamp says: the feed itself waits for each.
    fn keeps_pace(&self) -> bool {
        false
    }
    /// What there is to tell after the run, such as why the feed ended.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
    /// Number and time of the `i`-th frame.
    fn info(&self, i: usize) -> FrameInfo;
    /// The images of the `i`-th frame.
    ///
    /// # Errors
    /// Why this frame has to be dropped; the run goes on.
    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable>;
    /// The mask of the `i`-th frame, asked for after it was loaded; `None`: that of the setup.
    fn mask(&self, _i: usize) -> Option<FrameMask> {
        None
    }
}

/// The first frames of a dataset, prepared for feature extraction.
#[derive(Clone, Debug)]
pub struct SequenceFeed {
    frames: Vec<FrameSource>,
    preparation: Preparation,
}

impl SequenceFeed {
    /// All frames of a sequence, or the first `max_frames`, prepared in this way.
    pub fn prepared(sequence: &Sequence, preparation: Preparation, max_frames: Option<usize>) -> Self {
        let n = max_frames.unwrap_or(usize::MAX);
        SequenceFeed { frames: sequence.frames.iter().take(n).cloned().collect(), preparation }
    }
}

impl FrameFeed for SequenceFeed {
    fn size_hint(&self) -> Option<usize> {
        Some(self.frames.len())
    }

    fn info(&self, i: usize) -> FrameInfo {
        let frame = &self.frames[i];
        FrameInfo { index: frame.index, timestamp_s: frame.timestamp_s() }
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let files = &self.frames[i];
        let frame = load_frame(files)?;
        self.preparation.apply(frame, &files.left)
    }
}
