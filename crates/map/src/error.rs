//! Why the map refuses a mutation.

use crate::{KeyframeId, PointId};

/// A refused mutation: the map is as it was.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// No such keyframe, or it was removed.
    #[error("keyframe {keyframe} is not in the map (next id {next})")]
    NoKeyframe {
        /// The id given.
        keyframe: KeyframeId,
        /// The first id not given out yet.
        next: KeyframeId,
    },
    /// No such point, or it was removed or merged.
    #[error("point {point} is not in the map (next id {next})")]
    NoPoint {
        /// The id given.
        point: PointId,
        /// The first id not given out yet.
        next: PointId,
    },
    /// The frame has fewer features.
    #[error("keyframe {keyframe} has {n_features} features, feature {feature} does not exist")]
    NoFeature {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature given.
        feature: u32,
        /// How many there are.
        n_features: usize,
    },
    /// A feature can show one point only.
    #[error("feature {feature} of keyframe {keyframe} already shows point {holder}")]
    FeatureTaken {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature given.
        feature: u32,
        /// The point that it shows.
        holder: PointId,
    },
    /// Two entries of one batch want the same feature.
    #[error("feature {feature} of keyframe {keyframe} is given to two points of the batch")]
    FeatureTwice {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature given twice.
        feature: u32,
    },
    /// A keyframe can observe a point once only.
    #[error("point {point} is already observed by keyframe {keyframe}, at feature {feature}")]
    AlreadyObserved {
        /// The point.
        point: PointId,
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature that shows it there.
        feature: u32,
    },
    /// The observation does not exist.
    #[error("point {point} is not observed by keyframe {keyframe}")]
    NotObserved {
        /// The point.
        point: PointId,
        /// The keyframe.
        keyframe: KeyframeId,
    },
    /// A list names a keyframe twice.
    #[error("keyframe {keyframe} is listed twice")]
    KeyframeTwice {
        /// The keyframe.
        keyframe: KeyframeId,
    },
    /// A list names a point twice.
    #[error("point {point} is listed twice")]
    PointTwice {
        /// The point.
        point: PointId,
    },
    /// A new point needs an observation.
    #[error("new point number {index} of the batch has no observation")]
    NewPointUnobserved {
        /// Index in the batch.
        index: usize,
    },
    /// A new point is observed twice by one keyframe.
    #[error("new point number {index} of the batch has two observations in keyframe {keyframe}")]
    NewPointObservedTwice {
        /// Index in the batch.
        index: usize,
        /// The keyframe.
        keyframe: KeyframeId,
    },
    /// Not finite or out of range.
    #[error("position of new point number {index} of the batch is not finite")]
    NewPointPosition {
        /// Index in the batch.
        index: usize,
    },
    /// Not finite or out of range.
    #[error("position of point {point} is not finite")]
    Position {
        /// The point.
        point: PointId,
    },
    /// Not a rigid motion.
    #[error("pose of keyframe {keyframe} {defect}")]
    Pose {
        /// The keyframe.
        keyframe: KeyframeId,
        /// What is wrong with it.
        defect: PoseDefect,
    },
    /// No such loop stands, or it cannot be taken back.
    #[error("no loop from keyframe {keyframe} to {matched} can be taken back")]
    NoLoop {
        /// The keyframe of the earlier visit given.
        matched: KeyframeId,
        /// The keyframe of the later visit given.
        keyframe: KeyframeId,
    },
    /// A point cannot be merged with itself.
    #[error("point {point} cannot be merged with itself")]
    MergeWithItself {
        /// The point.
        point: PointId,
    },
    /// The root of a sub-map stays.
    #[error("keyframe {keyframe} is the root of a sub-map and cannot be removed")]
    RemoveRoot {
        /// The root.
        keyframe: KeyframeId,
    },
    /// The first keyframe of a new sub-map shares nothing with older ones.
    #[error(
        "keyframe {keyframe} cannot start a sub-map: it shows points of the map, or a new one that others show"
    )]
    SubmapMatched {
        /// The id that the keyframe would have had.
        keyframe: KeyframeId,
    },
    /// Only different sub-maps can be joined.
    #[error("keyframes {keyframe} and {parent} cannot be joined: they are in the same sub-map")]
    SameSubmap {
        /// The keyframe of the sub-map to join.
        keyframe: KeyframeId,
        /// The keyframe that it should hang under.
        parent: KeyframeId,
    },
    /// A scale, or the product of all scales of a keyframe, is not a positive finite number.
    #[error("scale of keyframe {keyframe} is {scale}, expected a positive finite number")]
    Scale {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The scale.
        scale: f64,
    },
    /// A correction from the future.
    #[error("correction saw revision {seen}, the map is at {now}")]
    RevisionAhead {
        /// Revision of the correction.
        seen: u64,
        /// Revision of the map.
        now: u64,
    },
    /// A correction moves a keyframe that it cannot have seen.
    #[error("correction of revision {seen} moves keyframe {keyframe}, inserted at revision {inserted_at}")]
    NotSeen {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The revision of its insertion.
        inserted_at: u64,
        /// Revision of the correction.
        seen: u64,
    },
    /// A loop joins two keyframes.
    #[error("loop edge from keyframe {keyframe} to itself")]
    LoopToItself {
        /// The keyframe.
        keyframe: KeyframeId,
    },
}

/// What makes a pose unusable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseDefect {
    /// A NaN, an infinity or a translation out of range.
    #[error("is not finite")]
    NotFinite,
    /// The matrix is not orthonormal or has determinant -1.
    #[error("has no rotation (deviation {deviation:.1e})")]
    NotRotation {
        /// Largest absolute entry of `R^T R - I`, or 2 for a reflection.
        deviation: f64,
    },
}
