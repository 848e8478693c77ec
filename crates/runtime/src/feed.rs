//! Where frames come from: a dataset on disk, a renderer, a test.

use io::{LoadedFrame, Sequence, load_frame};

use crate::rectify::Rectification;

/// What is known of a frame before it is loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInfo {
    /// Number of the frame in its sequence.
    pub index: u32,
    /// Time, seconds.
    pub timestamp_s: f64,
}

/// A source of frames. Loading happens on a thread of its own, ahead of tracking.
pub trait FrameFeed: Sync {
    /// Number of frames.
    fn len(&self) -> usize;
    /// Whether there is no frame.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Number and time of the `i`-th frame.
    fn info(&self, i: usize) -> FrameInfo;
    /// The images of the `i`-th frame.
    ///
    /// # Errors
    /// Why this frame has to be dropped; the run goes on.
    fn load(&self, i: usize) -> Result<LoadedFrame, String>;
}

/// The first frames of a dataset, rectified where the dataset's images are raw.
#[derive(Clone, Debug)]
pub struct SequenceFeed<'a> {
    sequence: &'a Sequence,
    rectification: Option<Rectification>,
    len: usize,
}

impl<'a> SequenceFeed<'a> {
    /// All frames of a sequence, or the first `max_frames`. Computes the tables of the rectification.
    pub fn new(sequence: &'a Sequence, max_frames: Option<usize>) -> Self {
        let len = sequence.frames.len();
        SequenceFeed {
            sequence,
            rectification: Rectification::of(sequence),
            len: max_frames.map_or(len, |max| max.min(len)),
        }
    }
}

impl FrameFeed for SequenceFeed<'_> {
    fn len(&self) -> usize {
        self.len
    }

    fn info(&self, i: usize) -> FrameInfo {
        let frame = &self.sequence.frames[i];
        FrameInfo { index: frame.index, timestamp_s: frame.timestamp_s }
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, String> {
        let files = &self.sequence.frames[i];
        let frame = load_frame(files).map_err(|error| error.to_string())?;
        match &self.rectification {
            Some(rectification) => rectification.apply(frame, files),
            None => Ok(frame),
        }
    }
}
