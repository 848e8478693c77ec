//! Schedules, image prefetching and timings: the only crate with threads and clocks.
//!
//! [`run`] takes frames from a [`FrameFeed`], decodes them ahead on a thread of its own and drives tracking and mapping
//! in turn (the sequential schedule): the same frames and setup give the same bits. Start reading at `sequential.rs`.

mod events;
mod feed;
mod prefetch;
mod record;
mod sequential;
mod setup;
mod timings;

pub use events::{Event, Observer, Silent};
pub use feed::{FrameFeed, FrameInfo, SequenceFeed};
pub use record::{FrameRecord, FrameStatus, RunError, RunOutcome};
pub use sequential::run;
pub use setup::{Sensor, Setup};
pub use timings::{FrameTimings, Summary, Timings};
