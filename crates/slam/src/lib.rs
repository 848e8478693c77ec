//! The steps of SLAM: initialise, track, map, relocalise, close loops.
//!
//! [`Tracker`] turns a frame and an immutable [`World`] into a [`Tracked`] value; [`LoopCloser`] turns a keyframe and a
//! world into a [`LoopCorrection`], or a reason why there is none; [`Mapper`] owns the world and is its only writer. None
//! knows a clock, a thread or a file: schedules live in the crate `runtime`.
//! Start reading at [`Tracker::track`], [`Mapper::refine`] and [`LoopCloser::detect`].

mod assign;
mod calibrate;
mod guided;
pub mod loops;
pub mod lost;
pub mod mapper;
mod noise;
pub mod params;
mod places;
mod pose;
pub mod probe;
pub mod tracker;
mod visibility;
mod world;

pub use calibrate::{OffsetEstimate, estimate_disparity_offset};
pub use loops::{
    GlobalSolution, LoopCloser, LoopCorrection, LoopOutcome, LoopReport, NoLoop, adjust_globally,
};
pub use lost::{Lost, NotReady};
pub use mapper::{Mapper, MappingReport};
pub use params::{LoopParams, MappingParams, Params, TrackingParams, Weights};
pub use places::Places;
pub use probe::{NoProbe, Probe, Stage, staged};
pub use tracker::{
    InitialPair, KeyframeReason, KeyframeRequest, NoPair, Placement, TrackState, TrackStats, Tracked, Tracker,
};
pub use world::World;
