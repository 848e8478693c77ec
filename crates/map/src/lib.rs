//! The one shared data structure: keyframes, points and every relation between them.
//!
//! One stage owns the [`Map`] and mutates it; everybody else reads cheap snapshots (`Map::clone`). All relations change
//! through eight mutations ([`Map::insert`], [`Map::link`], [`Map::unlink`], [`Map::merge_points`],
//! [`Map::remove_point`], [`Map::remove_keyframe`], [`Map::set_estimates`], [`Map::apply_correction`]) and the
//! statistics through [`Map::count`]. Each validates its whole input before the first write: a refused mutation leaves
//! an equal map, revision included.
//!
//! | invariant, asserted by [`Map::check`] | kept by |
//! |---|---|
//! | an observation exists on both sides or neither | `observations.rs` |
//! | a feature holds at most one point, a point at most one feature per keyframe | validation |
//! | every point has two observations or is young ([`PROBATION_KEYFRAMES`]), never none | `insert.rs`, `observations.rs` |
//! | the reference keyframe of a point observes it | `observations.rs` |
//! | covisibility weights equal the counted shared points, symmetric, sorted | `covisibility.rs` |
//! | the spanning trees have one root per sub-map and no cycle | `forest.rs`, `remove.rs` |
//! | loop edges are symmetric | `correction.rs`, `remove.rs` |
//! | what is kept of closed loops names ids that were given out, in order | `closed_loop.rs`, `take_back.rs` |
//! | no id names a removed thing ([`MapPoint::created_by`], a fact of the past, excepted) | `remove.rs` |
//! | all numbers are finite, rotations are rotations, scales positive | validation |
//! | descriptor, normal and distance range of a point are those of its observations | `derived.rs` |
//!
//! When tracking stays lost, the map continues with a new *sub-map* ([`Parent::NewSubmap`]): another spanning tree
//! under the same ids, in coordinates (and for one camera in a scale) of its own, until a correction joins it to
//! another one ([`Correction::joined`]). [`Map::submap_of`] names the sub-map of a keyframe by its root.
//!
//! [`mod@file`] turns a map into bytes and back.
//!
//! Start reading at `map.rs` (queries), then `observations.rs` (the primitives that the mutations share).

mod arena;
mod changes;
mod check;
mod closed_loop;
mod correction;
mod covisibility;
mod derived;
mod digest;
mod error;
mod estimates;
pub mod file;
mod forest;
mod ids;
mod insert;
mod keyframe;
mod map;
mod observations;
mod point;
mod relative_pose;
mod remove;
mod take_back;
#[cfg(test)]
mod tests;
mod validate;

pub use changes::Changes;
pub use check::Violation;
pub use closed_loop::ClosedLoop;
pub use correction::{Correction, KeyframeCorrection};
pub use error::{MapError, PoseDefect};
pub use file::{MapFileError, MapFileInfo};
pub use ids::{KeyframeId, PointId};
pub use insert::{Batch, Inserted, NewKeyframe, NewPoint, Parent};
pub use keyframe::Keyframe;
pub use map::{Map, PROBATION_KEYFRAMES};
pub use observations::PointFate;
pub use point::{FIRST_BELIEF, MAX_BELIEF, MapPoint, Observation, PointCount};
pub use relative_pose::RelativePose;
pub use remove::Removed;
pub use validate::{MAX_COORDINATE_M, ROTATION_TOLERANCE};
