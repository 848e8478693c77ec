//! Frames of a video or a camera as a run takes them: one after another, from a stream.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use geometry::GrayImage;
use io::{ImageError, LoadedFrame, Packing};
use runtime::{FrameFeed, FrameInfo, Preparation, Unusable};

use crate::video::{Opened, Stream};

/// The frames of an opened video.
pub(crate) struct VideoFeed {
    path: PathBuf,
    packing: Packing,
    preparation: Preparation,
    frame_rate_hz: f64,
    max_frames: Option<usize>,
    state: Mutex<State>,
}

/// How far the stream has been read.
struct State {
    stream: Stream,
    /// Number and image of the frame read last, until it is taken.
    held: Option<(usize, GrayImage)>,
    /// Times of all frames read so far, seconds.
    times_s: Vec<f64>,
    /// Frames read from this stream.
    n_read: usize,
    has_ended: bool,
    remark: Option<String>,
}

impl VideoFeed {
    /// The frames of a video, or the first `max_frames`.
    pub(crate) fn new(opened: Opened, preparation: Preparation, max_frames: Option<usize>) -> Self {
        let Opened { video, path, stream, frame_rate_hz } = opened;
        let state =
            State { stream, held: None, times_s: Vec::new(), n_read: 0, has_ended: false, remark: None };
        Self {
            path,
            packing: video.packing,
            preparation,
            frame_rate_hz,
            max_frames,
            state: Mutex::new(state),
        }
    }

    /// The state with the stream read up to the `i`-th frame.
    fn at(&self, i: usize) -> MutexGuard<'_, State> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if i < state.n_read && state.held.as_ref().is_none_or(|(held, _)| *held != i) {
            state.restart(&self.path);
        }
        while state.n_read <= i && !state.has_ended {
            state.read(self.frame_rate_hz);
        }
        state
    }
}

impl State {
    /// Begins with the first frame again, as a second run over the same input does.
    fn restart(&mut self, path: &Path) {
        match Stream::open(path) {
            Ok(stream) => {
                (self.stream, self.held, self.n_read, self.has_ended) = (stream, None, 0, false);
            }
            Err(error) => {
                self.has_ended = true;
                self.remark = Some(format!("{}: cannot be read again: {error}", path.display()));
            }
        }
    }

    fn read(&mut self, frame_rate_hz: f64) {
        let n = self.n_read;
        self.held = None;
        match self.stream.reader.next_frame() {
            Ok(Some(frame)) => {
                // Whole nanoseconds, as those of files.
                let time_s = frame.timestamp_s.unwrap_or(n as f64 / frame_rate_hz);
                let time_s = io::seconds((time_s * 1e9).round() as i64);
                // A second pass gives the same times.
                if n == self.times_s.len() {
                    self.times_s.push(time_s);
                }
                self.held = Some((n, frame.image));
                self.n_read += 1;
            }
            Ok(None) => self.has_ended = true,
            Err(error) => {
                self.has_ended = true;
                self.remark = Some(format!("{error}; only the {n} frames before it are used"));
            }
        }
    }
}

impl FrameFeed for VideoFeed {
    fn size_hint(&self) -> Option<usize> {
        self.max_frames
    }

    fn ends_before(&self, i: usize) -> bool {
        self.at(i).held.as_ref().is_none_or(|(held, _)| *held != i)
    }

    fn remarks(&self) -> Vec<String> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.remark.clone().into_iter().collect()
    }

    fn info(&self, i: usize) -> FrameInfo {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let time_s = state.times_s.get(i).copied();
        FrameInfo::new(i, time_s.unwrap_or(i as f64 / self.frame_rate_hz))
    }

    fn load(&self, i: usize) -> Result<LoadedFrame, Unusable> {
        let held = self.at(i).held.take();
        let Some((_, image)) = held.filter(|(held, _)| *held == i) else {
            let reason = format!("the video has ended before frame {i}");
            return Err(ImageError::Unreadable { path: self.path.clone(), reason }.into());
        };
        let frame = LoadedFrame::unpacked(image, self.packing, &self.path)?;
        self.preparation.apply(frame, &self.path)
    }
}
