//! The records of format version 3: plain numbers, apart from the types of the program, so that those can change; of these
//! only the camera is written as it is.
//!
//! Ids are their numbers. A change of any record here, or of [`Rig`], needs a new format version.

use std::borrow::Cow;

use features::Rig;
use serde::{Deserialize, Serialize};

/// A whole map.
#[derive(Serialize, Deserialize)]
pub(super) struct Content<'a> {
    pub(super) revision: u64,
    /// See the field of the same name in `Map`.
    pub(super) first_young: Vec<u32>,
    /// Cameras, shared by many frames.
    pub(super) rigs: Vec<Rig>,
    pub(super) scales: Vec<ScalesRecord>,
    /// One per id ever given out.
    #[serde(borrow)]
    pub(super) keyframes: Vec<KeyframeSlot<'a>>,
    /// One per id ever given out.
    pub(super) points: Vec<PointSlot>,
    /// Those that can be taken back.
    pub(super) loops: Vec<LoopRecord>,
}

/// Pyramid levels, shared by many frames.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct ScalesRecord {
    pub(super) factor: f32,
    /// Scale, variance, inverse variance of each level.
    pub(super) levels: Vec<[f32; 3]>,
}

#[derive(Serialize, Deserialize)]
pub(super) enum KeyframeSlot<'a> {
    Living(#[serde(borrow)] Box<KeyframeRecord<'a>>),
    Removed(Option<Box<RemovedRecord>>),
}

#[derive(Serialize, Deserialize)]
pub(super) struct KeyframeRecord<'a> {
    #[serde(borrow)]
    pub(super) frame: FrameRecord<'a>,
    /// `[R t]` row by row.
    pub(super) cam_from_world: [f64; 12],
    pub(super) inserted_at: u64,
    pub(super) scale: f64,
    pub(super) parent: Option<u32>,
    pub(super) loop_edges: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct RemovedRecord {
    pub(super) parent: u32,
    /// `[R t]` row by row.
    pub(super) removed_from_parent: [f64; 12],
    pub(super) scale: f64,
}

/// The features of a frame, one column per quantity. Columns of numbers hold the first bytes of all numbers, then the
/// second ones and so on, which packs better.
#[derive(Serialize, Deserialize)]
pub(super) struct FrameRecord<'a> {
    pub(super) index: u32,
    pub(super) timestamp_s: f64,
    /// Index of the camera.
    pub(super) rig: u32,
    /// Index of the pyramid levels.
    pub(super) scales: u32,
    #[serde(borrow)]
    pub(super) x: Cow<'a, [u8]>,
    #[serde(borrow)]
    pub(super) y: Cow<'a, [u8]>,
    #[serde(borrow)]
    pub(super) angle_deg: Cow<'a, [u8]>,
    #[serde(borrow)]
    pub(super) response: Cow<'a, [u8]>,
    #[serde(borrow)]
    pub(super) octave: Cow<'a, [u8]>,
    /// 32 bytes each.
    #[serde(borrow)]
    pub(super) descriptors: Cow<'a, [u8]>,
    #[serde(borrow)]
    pub(super) right_u: Cow<'a, [u8]>,
    /// Absent when it is what follows from `right_u`.
    #[serde(borrow)]
    pub(super) depth: Option<Cow<'a, [u8]>>,
    #[serde(borrow)]
    pub(super) activation: Cow<'a, [u8]>,
    #[serde(borrow)]
    pub(super) lasting: Cow<'a, [u8]>,
}

#[derive(Serialize, Deserialize)]
pub(super) enum PointSlot {
    Living(Box<PointRecord>),
    Merged(u32),
    Removed,
}

#[derive(Serialize, Deserialize)]
pub(super) struct PointRecord {
    pub(super) position: [f64; 3],
    pub(super) reference: u32,
    pub(super) created_by: u32,
    pub(super) seen: u32,
    pub(super) found: u32,
    pub(super) belief: i32,
    /// (keyframe, feature) in order of the keyframes.
    pub(super) observations: Vec<(u32, u32)>,
}

/// See the type `ClosedLoop`.
#[derive(Serialize, Deserialize)]
pub(super) struct LoopRecord {
    pub(super) matched: u32,
    pub(super) keyframe: u32,
    pub(super) revision: u64,
    pub(super) next: u32,
    pub(super) visit: Vec<u32>,
    pub(super) near: Vec<u32>,
    /// Keyframe, `[R t]` row by row, scale.
    pub(super) before: Vec<(u32, [f64; 12], f64)>,
}
