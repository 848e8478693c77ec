//! Images are decoded ahead on one thread; bounded channels keep memory small.

use std::sync::Arc;

use crossbeam::channel::Sender;
use features::Frame;
use io::LoadedFrame;

use crate::events::SourceImages;
use crate::faults::StageFaults;
use crate::feed::{FrameFeed, FrameInfo, FrameMask};
use crate::record::Unusable;
use crate::timings::Stopwatch;

/// Frames decoded ahead.
pub(crate) const AHEAD: usize = 3;

/// A frame on its way through the stages: what the last of them made of it, or why there is nothing.
pub(crate) struct Passing<T> {
    /// Position in the feed.
    pub(crate) n: usize,
    pub(crate) info: FrameInfo,
    pub(crate) content: Result<T, Unusable>,
    pub(crate) watch: Stopwatch,
}

/// After decoding: the images, and where features may be taken if that is not where the setup allows it.
pub(crate) type Fetched = Passing<(LoadedFrame, Option<FrameMask>)>;

/// After extraction: the frame, and what its features were found in if an observer wants details.
pub(crate) type Extracted = Passing<(Arc<Frame>, Option<SourceImages>)>;

/// Loads the `n`-th frame of a feed.
pub(crate) fn fetch(feed: &dyn FrameFeed, n: usize) -> Fetched {
    let info = feed.info(n);
    let mut watch = Stopwatch::new(info.index);
    let images = watch.time("decode", |_| feed.load(n));
    Passing { n, info, content: images.map(|images| (images, feed.mask(n))), watch }
}

/// Sends the first `frames` frames in order, each as soon as there is room, until the reader is gone. Returns how many there are, as
/// far as is known.
pub(crate) fn ahead(
    feed: &dyn FrameFeed,
    frames: usize,
    mut faults: StageFaults,
    to: &Sender<Fetched>,
) -> usize {
    for n in 0..frames {
        faults.step();
        if feed.ends_before(n) {
            return n;
        }
        if to.send(fetch(feed, n)).is_err() {
            break;
        }
    }
    frames
}
