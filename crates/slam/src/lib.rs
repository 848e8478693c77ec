//! The steps of SLAM: initialize, track, map, relocalize, close loops.
//!
//! [`Tracker`] turns a frame and an immutable [`World`] into a [`Tracked`] value; [`LoopCloser`] turns a keyframe and a
//! world into a [`LoopCorrection`], or a reason why there is none; [`Mapper`] owns the world and is its only writer. None
//! knows a clock, a thread or a file: schedules live in the crate `runtime`.
//! Start reading at [`Tracker::track`], [`Mapper::refine`] and [`LoopCloser::detect`].

// A small world that the tests of all steps share.
#[cfg(test)]
#[path = "../tests/common/scene.rs"]
mod scene;

mod assess;
mod assign;
mod covariance;
mod keyframe_database;
pub mod loops;
pub mod lost;
pub mod mapper;
mod match_keyframe;
mod noise;
pub mod params;
mod pose;
pub mod probe;
mod problem;
mod quality;
mod refine;
mod search;
mod seed;
pub mod tracker;
mod visibility;
mod world;

pub use assess::{Assessment, COVARIANCE_FRAMES, QualityReason};
pub use keyframe_database::KeyframeDatabase;
pub use loops::{GlobalSolution, LoopCloser, LoopCorrection, LoopOutcome, NoLoop, adjust_globally};
pub use lost::{Lost, NotReady};
pub use mapper::{Mapper, MappingReport};
pub use params::{CameraParams, LoopParams, MappingParams, Params, TrackingParams, Weights};
pub use probe::{NoProbe, Probe, Stage, staged};
pub use refine::{CALIBRATION_NAMES, RefinedCalibration};
pub use tracker::{
    InitialPair, KeyframeReason, KeyframeRequest, NoPair, Placement, TrackState, TrackStats, Tracked, Tracker,
};
pub use world::World;
