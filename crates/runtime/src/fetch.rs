//! Images are decoded ahead on one thread; bounded channels keep memory small.

use crossbeam::channel::{Receiver, Sender, TrySendError};
use io::LoadedFrame;

use crate::faults::StageFaults;
use crate::feed::{FrameFeed, FrameInfo, FrameMask};
use crate::record::Unusable;
use crate::timings::{Pace, timed};

/// Frames decoded ahead.
pub(crate) const AHEAD: usize = 3;

/// A frame on its way from the decoder to feature extraction.
pub(crate) struct Fetched {
    /// Position in the feed.
    pub(crate) n: usize,
    pub(crate) info: FrameInfo,
    pub(crate) images: Result<LoadedFrame, Unusable>,
    pub(crate) decode_ms: f64,
    /// Where features may be taken; `None`: where the setup allows it.
    pub(crate) mask: Option<FrameMask>,
}

/// Loads the `n`-th frame of a feed.
pub(crate) fn fetch(feed: &dyn FrameFeed, n: usize) -> Fetched {
    let (images, decode_ms) = timed(|| feed.load(n));
    Fetched { n, info: feed.info(n), images, decode_ms, mask: feed.mask(n) }
}

/// Sends the first `frames` frames in order, each as soon as there is room, until nobody reads any more. Returns how many there are, as
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

/// Sends frames at the pace of their timestamps. `slot` and `taken` are the ends of a channel for one frame: a frame
/// that nobody has taken by the time of the next one is replaced by it. Ends early when `reader_is_there` is closed. Returns how many
/// frames there are, as far as is known.
pub(crate) fn paced(
    feed: &dyn FrameFeed,
    frames: usize,
    mut faults: StageFaults,
    (slot, taken): (&Sender<Fetched>, &Receiver<Fetched>),
    reader_is_there: &Receiver<()>,
) -> usize {
    let pace = Pace::start();
    for n in 0..frames {
        faults.step();
        if feed.ends_before(n) {
            return n;
        }
        let since_first = |feed: &dyn FrameFeed| feed.info(n).timestamp_s - feed.info(0).timestamp_s;
        let seconds = if feed.keeps_pace() { 0.0 } else { since_first(feed) };
        let fetched = fetch(feed, n);
        if !pace.wait(seconds, reader_is_there) {
            break;
        }
        replace(slot, taken, fetched);
    }
    frames
}

/// Puts a value into a channel for one, in the place of one that nobody has taken yet.
pub(crate) fn replace<T>(slot: &Sender<T>, taken: &Receiver<T>, mut value: T) {
    while let Err(TrySendError::Full(back)) = slot.try_send(value) {
        // Either the reader has just taken the older value, or it is dropped here.
        drop(taken.try_recv());
        value = back;
    }
}
