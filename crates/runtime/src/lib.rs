//! Schedules, threads, journal and timings: the only crate with threads and clocks.
//!
//! [`run`] takes frames from a [`FrameFeed`], [`Sequential`] and [`Threaded`] from the caller, one by one. They go through the
//! stages: decode, extract, track, map, and beside mapping the services that find loops and adjust the whole map. One mapping
//! stage owns the world and shows immutable snapshots of it to tracking; stages exchange values over bounded channels and end
//! when a neighbor is gone.
//!
//! | schedule | threads | what tracking sees |
//! |---|---|---|
//! | `Sequential` | one, beside decoding | the state of the rule |
//! | `Lockstep` | one per stage | the state of the rule; the stage that is ahead waits |
//! | `Live` | one per stage | the newest state; its [`Journal`] repeats the run |
//!
//! The rule (`rule.rs`) knows frame numbers only: the same frames and setup give the same bits with the first two.
//!
//! Start reading in `sequential.rs`: the whole system in turn, from top to bottom. Then the stages, in the order of the data:
//!
//! | room | what it does |
//! |---|---|
//! | `run.rs` | all frames by the schedule asked for |
//! | `stages/fetch.rs` | decodes ahead |
//! | `stages/extract.rs` | images to a frame with features |
//! | `stages/track.rs` | a frame and a state of the map to a pose |
//! | `stages/map.rs` | the operations of the map, in the order of the rule |
//! | `services.rs` | loops and global bundle adjustment |
//! | `snapshot.rs` | which state of the map tracking sees |
//! | `lockstep.rs`, `live.rs` | the same stages on threads |
//! | `threaded.rs` | frames pushed to those threads by the caller |
//! | `journal.rs`, `replay.rs` | what happened in which order, and the run done again |
//! | `words.rs`, `stream/` | what a run tells: in words, as a stream for a viewer |

mod events;
mod failure;
mod faults;
mod feed;
mod journal;
mod lags;
mod live;
mod lockstep;
mod network;
mod outcome;
mod prepare;
mod record;
mod replay;
mod rule;
mod run;
mod sequential;
mod services;
mod setup;
mod snapshot;
mod stages {
    pub(crate) mod extract;
    pub(crate) mod fetch;
    pub(crate) mod map;
    pub(crate) mod motion;
    pub(crate) mod track;
}
mod stream;
mod threaded;
mod timings;
mod words;

pub use events::{Event, FrameAnswer, FrameDetails, Observer, Silent, SourceImages};
pub use failure::StageFailure;
pub use faults::Faults;
pub use feed::{FrameFeed, FrameInfo, FrameMask, SequenceFeed};
pub use geometry::Sensor;
pub use journal::{Journal, JournalError};
pub use lags::Lags;
pub use prepare::Preparation;
pub use record::{
    FrameRecord, FrameStatus, LoopRecord, LoopResult, RunError, RunOutcome, Statistics, Unusable,
};
pub use replay::replay;
pub use run::run;
pub use sequential::Sequential;
pub use setup::{Schedule, Selection, Setup};
pub use stream::{EventStream, StreamOptions, StreamReport};
pub use threaded::{RunEnded, Threaded};
pub use timings::{FrameTimings, Summary, Timings};
pub use words::{Narrator, Weight, Words};
