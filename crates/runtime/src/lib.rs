//! Schedules, threads, journal and timings: the only crate with threads and clocks.
//!
//! [`run`] takes frames from a [`FrameFeed`], [`Sequential`] and [`Threaded`] one by one from the caller, through the stages: decode, extract, track, map, and beside mapping the
//! services that find loops and adjust the whole map. One mapping stage owns the world and shows immutable snapshots of it
//! to tracking; stages exchange values over bounded channels and end when a neighbour is gone.
//!
//! | schedule | threads | what tracking sees |
//! |---|---|---|
//! | `Sequential` | one, beside decoding | the state of the rule |
//! | `Lockstep` | one per stage | the state of the rule; whoever is early waits |
//! | `Live` | one per stage | the newest state; its [`Journal`] does the run again |
//!
//! The rule (`rule.rs`) knows frame numbers only: the same frames and setup give the same bits with the first two.
//! Start reading there, then `sequential.rs` (the whole system in turn), `logical.rs` (mapping by the rule), `mapping.rs` (the
//! operations) and `threads.rs` (how stages are joined).

mod corrections;
mod details;
mod events;
mod extract;
mod failure;
mod faults;
mod feed;
mod fetch;
mod fingerprint;
mod job;
mod journal;
mod lags;
mod live;
mod logical;
mod map_log;
mod mapping;
mod outbox;
mod outcome;
mod prepare;
mod record;
mod replay;
mod rule;
mod run;
mod selection;
mod sequential;
mod service;
mod setup;
mod stream;
mod thread_work;
mod threaded;
mod threads;
mod timings;
mod track;
mod view;

pub use details::{FrameDetails, Seen};
pub use events::{Event, FrameAnswer, Observer, Silent};
pub use failure::StageFailure;
pub use faults::Faults;
pub use feed::{FrameFeed, FrameInfo, FrameMask, SequenceFeed};
pub use geometry::Sensor;
pub use journal::{Journal, JournalError};
pub use lags::Lags;
pub use map_log::{LoopRecord, LoopResult, Statistics};
pub use prepare::Preparation;
pub use record::{FrameRecord, FrameStatus, RunError, RunOutcome, Unusable};
pub use replay::replay;
pub use run::run;
pub use selection::{ActivationFactory, Selection};
pub use sequential::Sequential;
pub use setup::{Schedule, Setup};
pub use stream::{EventStream, StreamOptions, StreamReport};
pub use threaded::{RunEnded, Threaded};
pub use timings::{FrameTimings, Summary, Timings};
