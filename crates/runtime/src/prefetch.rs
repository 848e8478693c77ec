//! Images are decoded ahead on one thread; a bounded channel keeps memory small.

use crossbeam::channel::{Receiver, bounded};
use io::LoadedFrame;

use crate::feed::{FrameFeed, FrameInfo};
use crate::record::RunError;
use crate::timings::timed;

/// Frames decoded ahead of tracking.
const AHEAD: usize = 3;

/// A frame on its way from the decoder to tracking.
pub(crate) struct Fetched {
    pub(crate) info: FrameInfo,
    pub(crate) images: Result<LoadedFrame, String>,
    pub(crate) decode_ms: f64,
}

/// Runs `consume` with the first `frames` of `feed` in order. When `consume` returns early, the decoder ends with it.
pub(crate) fn with_prefetch<T>(
    feed: &dyn FrameFeed,
    frames: usize,
    consume: impl FnOnce(Receiver<Fetched>) -> T,
) -> Result<T, RunError> {
    let (sender, receiver) = bounded(AHEAD);
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .name("decode".into())
            .spawn_scoped(scope, move || {
                for i in 0..frames {
                    let (images, decode_ms) = timed(|| feed.load(i));
                    if sender.send(Fetched { info: feed.info(i), images, decode_ms }).is_err() {
                        return;
                    }
                }
            })
            .map_err(|error| RunError::Thread(error.to_string()))?;
        Ok(consume(receiver))
    })
}
