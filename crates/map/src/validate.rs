//! Checks on numbers and ids that the mutations make before the first write.

use geometry::{Mat3, SE3, Vec3};

use crate::ids::Id;
use crate::{Keyframe, KeyframeId, Map, MapError, MapPoint, Observation, PointId, PoseDefect};

/// Largest admitted coordinate, meters: beyond it a number is an accident, below it squares stay finite.
pub const MAX_COORDINATE_M: f64 = 1e12;

/// Largest admitted entry of `R^T R - I`.
pub const ROTATION_TOLERANCE: f64 = 1e-6;

/// All three coordinates are numbers of a sane size.
pub(crate) fn is_sane(v: &Vec3) -> bool {
    v.iter().all(|x| x.abs() <= MAX_COORDINATE_M)
}

/// What is wrong with a pose, if anything.
pub(crate) fn pose_defect(pose: &SE3) -> Option<PoseDefect> {
    let r = pose.rotation.matrix();
    if !is_sane(&pose.translation) || !r.iter().all(|x| x.is_finite()) {
        return Some(PoseDefect::NotFinite);
    }
    let deviation = if r.determinant() > 0.0 { (r.transpose() * r - Mat3::identity()).amax() } else { 2.0 };
    (deviation > ROTATION_TOLERANCE).then_some(PoseDefect::NotRotation { deviation })
}

pub(crate) fn valid_pose(keyframe: KeyframeId, pose: &SE3) -> Result<(), MapError> {
    pose_defect(pose).map_or(Ok(()), |defect| Err(MapError::Pose { keyframe, defect }))
}

pub(crate) fn valid_position(point: PointId, position: &Vec3) -> Result<(), MapError> {
    if is_sane(position) { Ok(()) } else { Err(MapError::Position { point }) }
}

/// A scale is a positive finite number.
pub(crate) fn is_scale(scale: f64) -> bool {
    scale > 0.0 && scale.is_finite()
}

pub(crate) fn valid_scale(keyframe: KeyframeId, scale: f64) -> Result<(), MapError> {
    if is_scale(scale) { Ok(()) } else { Err(MapError::Scale { keyframe, scale }) }
}

/// The first id that occurs twice.
pub(crate) fn find_twice<T: Ord + Copy>(ids: impl Iterator<Item = T>) -> Option<T> {
    let mut sorted: Vec<T> = ids.collect();
    sorted.sort_unstable();
    sorted.windows(2).find(|w| w[0] == w[1]).map(|w| w[0])
}

impl Map {
    pub(crate) fn need_keyframe(&self, keyframe: KeyframeId) -> Result<&Keyframe, MapError> {
        self.keyframe(keyframe).ok_or(MapError::NoKeyframe { keyframe, next: self.next_keyframe_id() })
    }

    pub(crate) fn need_point(&self, point: PointId) -> Result<&MapPoint, MapError> {
        self.point(point).ok_or(MapError::NoPoint { point, next: self.next_point_id() })
    }

    /// The keyframe is there, and so is the feature, and it shows no point.
    pub(crate) fn need_free_feature(&self, observation: Observation) -> Result<(), MapError> {
        let Observation { keyframe, feature } = observation;
        let points = self.need_keyframe(keyframe)?.points();
        match points.get(feature as usize) {
            None => Err(MapError::NoFeature { keyframe, feature, n_features: points.len() }),
            Some(Some(holder)) => Err(MapError::FeatureTaken { keyframe, feature, holder: *holder }),
            Some(None) => Ok(()),
        }
    }

    /// The id was given out once, whether the keyframe is still there or not.
    pub(crate) fn need_known_keyframe(&self, keyframe: KeyframeId) -> Result<(), MapError> {
        let next = self.next_keyframe_id();
        if keyframe.index() < next.index() { Ok(()) } else { Err(MapError::NoKeyframe { keyframe, next }) }
    }

    /// The id was given out once, whether the point is still there or not.
    pub(crate) fn need_known_point(&self, point: PointId) -> Result<(), MapError> {
        let next = self.next_point_id();
        if point.index() < next.index() { Ok(()) } else { Err(MapError::NoPoint { point, next }) }
    }
}
