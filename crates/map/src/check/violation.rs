//! The ways in which a map can be broken.

use crate::{KeyframeId, PointId, PoseDefect};

/// A broken invariant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Violation {
    /// The thing under an id carries another id.
    #[error("keyframe {keyframe} calls itself {carries}")]
    KeyframeId {
        /// The id it is stored under.
        keyframe: KeyframeId,
        /// The id it carries.
        carries: KeyframeId,
    },
    /// The thing under an id carries another id.
    #[error("point {point} calls itself {carries}")]
    PointId {
        /// The id it is stored under.
        point: PointId,
        /// The id it carries.
        carries: PointId,
    },
    /// A merged point leads to an id that was never given out, or back to itself.
    #[error("merged point {point} leads nowhere")]
    PointForward {
        /// The merged point.
        point: PointId,
    },
    /// A removed keyframe does not lead to a living one.
    #[error("removed keyframe {keyframe} leads nowhere")]
    KeyframeForward {
        /// The removed keyframe.
        keyframe: KeyframeId,
    },
    /// A keyframe was inserted at a revision that is still to come or not after that of the keyframe before it.
    #[error("keyframe {keyframe} was inserted at revision {inserted_at} of {revision}, or out of order")]
    InsertedAt {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The revision of its insertion.
        inserted_at: u64,
        /// The revision of the map.
        revision: u64,
    },
    /// The note on where the points of one of the newest keyframes begin does not fit the points.
    #[error("points from keyframe {keyframe} on are noted to begin at {first:?}, which cannot be")]
    Probation {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The first point that it could create.
        first: Option<PointId>,
    },
    /// A keyframe's relation names a keyframe that does not exist.
    #[error("keyframe {keyframe} names keyframe {missing}, which does not exist")]
    MissingKeyframe {
        /// The keyframe that names it.
        keyframe: KeyframeId,
        /// The id that names nothing.
        missing: KeyframeId,
    },
    /// A point names a keyframe that does not exist.
    #[error("point {point} names keyframe {missing}, which does not exist")]
    MissingObserver {
        /// The point that names it.
        point: PointId,
        /// The id that names nothing.
        missing: KeyframeId,
    },
    /// A feature shows a point that does not exist.
    #[error("feature {feature} of keyframe {keyframe} shows point {missing}, which does not exist")]
    MissingPoint {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature.
        feature: u32,
        /// The id that names nothing.
        missing: PointId,
    },
    /// An observation that the keyframe does not know.
    #[error(
        "point {point} has an observation in feature {feature} of keyframe {keyframe}, which shows {shows:?}"
    )]
    OneSidedObservation {
        /// The point.
        point: PointId,
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature.
        feature: u32,
        /// What the keyframe holds there.
        shows: Option<PointId>,
    },
    /// An observation that the point does not know.
    #[error("feature {feature} of keyframe {keyframe} shows point {point}, which does not list it")]
    UnlistedObservation {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The feature.
        feature: u32,
        /// The point.
        point: PointId,
    },
    /// The table of a keyframe has not one entry per feature.
    #[error("keyframe {keyframe} has {n_features} features and {n_entries} entries for their points")]
    TableLength {
        /// The keyframe.
        keyframe: KeyframeId,
        /// Features of its frame.
        n_features: usize,
        /// Entries of its table.
        n_entries: usize,
    },
    /// The observations of a point are not in strict order of their keyframes.
    #[error("point {point} lists keyframe {keyframe} twice or out of order")]
    ObservationOrder {
        /// The point.
        point: PointId,
        /// The keyframe.
        keyframe: KeyframeId,
    },
    /// A point has too few observations for its age.
    #[error("point {point}, created by keyframe {created_by}, has only {n_observations} observations")]
    TooFewObservations {
        /// The point.
        point: PointId,
        /// Its creator.
        created_by: KeyframeId,
        /// How many it has.
        n_observations: usize,
    },
    /// A point was created by a keyframe that never existed.
    #[error("point {point} was created by keyframe {created_by}, which never existed")]
    Creator {
        /// The point.
        point: PointId,
        /// Its creator.
        created_by: KeyframeId,
    },
    /// The reference keyframe of a point does not observe it.
    #[error("point {point} is not observed by its reference keyframe {reference}")]
    Reference {
        /// The point.
        point: PointId,
        /// Its reference.
        reference: KeyframeId,
    },
    /// A covisibility weight is not the number of shared points.
    #[error("keyframes {keyframe} and {other} share {counted} points, stored are {stored}")]
    Covisibility {
        /// The keyframe that stores the weight.
        keyframe: KeyframeId,
        /// The other one.
        other: KeyframeId,
        /// The weight, 0 if there is no entry.
        stored: u32,
        /// The number of shared points.
        counted: u32,
    },
    /// A covisibility list is not in strict order (weight descending, id ascending), names a keyframe twice, or has a
    /// weight of zero.
    #[error("covisible keyframe {other} of {keyframe} is out of order, there twice or of weight zero")]
    CovisibilityEntry {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The entry at fault.
        other: KeyframeId,
    },
    /// The keyframes without a parent are not the roots.
    #[error("keyframes without a parent are {parentless:?}, the roots are {roots:?}")]
    Roots {
        /// The roots that the map names.
        roots: Vec<KeyframeId>,
        /// The keyframes that have no parent.
        parentless: Vec<KeyframeId>,
    },
    /// Parent and child do not agree.
    #[error("keyframe {child} has parent {parent:?}, but keyframe {other} {}", if *.listed { "lists it as a child" } else { "does not list it as a child" })]
    ParentChild {
        /// The child.
        child: KeyframeId,
        /// Its parent.
        parent: Option<KeyframeId>,
        /// The keyframe that disagrees.
        other: KeyframeId,
        /// Whether that one lists the child.
        listed: bool,
    },
    /// Going from parent to parent does not lead to a root.
    #[error("keyframe {keyframe} is on or behind a cycle of the spanning tree")]
    Cycle {
        /// The keyframe.
        keyframe: KeyframeId,
    },
    /// A loop edge exists on one side only, or joins a keyframe with itself.
    #[error("loop edge from keyframe {from} to {to} has no counterpart")]
    LoopEdge {
        /// The keyframe that has it.
        from: KeyframeId,
        /// The other one.
        to: KeyframeId,
    },
    /// What is kept of a closed loop cannot be.
    #[error("what is kept of the loop from keyframe {keyframe} to {matched} cannot be")]
    ClosedLoop {
        /// The keyframe of the earlier visit.
        matched: KeyframeId,
        /// The one that saw its place again.
        keyframe: KeyframeId,
    },
    /// A list of children or loop edges is not in strict order.
    #[error("a list of keyframe {keyframe} has {entry} twice or out of order")]
    ListOrder {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The entry out of order.
        entry: KeyframeId,
    },
    /// A pose is not finite or has no rotation.
    #[error("pose of keyframe {keyframe} {defect}")]
    Pose {
        /// The keyframe.
        keyframe: KeyframeId,
        /// What is wrong.
        defect: PoseDefect,
    },
    /// The product of the scales of a keyframe, living or removed, is not a positive finite number.
    #[error("scale of keyframe {keyframe} is {scale}")]
    Scale {
        /// The keyframe.
        keyframe: KeyframeId,
        /// The scale.
        scale: f64,
    },
    /// Position, normal or distances of a point are not finite.
    #[error("a number of point {point} is not finite")]
    PointNumbers {
        /// The point.
        point: PointId,
    },
    /// The descriptor of a point is not that of its observations.
    #[error("descriptor of point {point} is stale")]
    StaleDescriptor {
        /// The point.
        point: PointId,
    },
    /// Normal or distances of a point are not those of its observations.
    #[error("normal or distance range of point {point} is stale")]
    StaleGeometry {
        /// The point.
        point: PointId,
    },
}
