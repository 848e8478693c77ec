//! The steps of SLAM: initialise, track, map.
//!
//! [`Tracker`] turns a frame and an immutable [`map::Map`] into a [`Tracked`] value; [`Mapper`] owns the map and is
//! its only writer. Neither knows a clock, a thread or a file: schedules live in the crate `runtime`.
//! Start reading at [`Tracker::track`] and [`Mapper::refine`].

mod assign;
mod calibrate;
pub mod lost;
pub mod mapper;
mod noise;
pub mod params;
pub mod probe;
pub mod tracker;
mod visibility;

pub use calibrate::{OffsetEstimate, estimate_disparity_offset};
pub use lost::{Lost, NotReady};
pub use mapper::{Mapper, MappingReport};
pub use params::{MappingParams, Params, TrackingParams};
pub use probe::{NoProbe, Probe, Stage, staged};
pub use tracker::{KeyframeReason, KeyframeRequest, TrackState, TrackStats, Tracked, Tracker};
